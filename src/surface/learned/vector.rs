//! Vectors of three `f64`, with a fixed order of operations.

use std::ops::{Add, AddAssign, Index, Mul, Sub};

#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(in crate::surface) struct Vector(pub(in crate::surface) [f64; 3]);

impl Vector {
    pub(in crate::surface) const ZERO: Self = Self([0.0; 3]);

    #[inline]
    pub(in crate::surface) fn dot(self, o: Self) -> f64 {
        self.0[0] * o.0[0] + self.0[1] * o.0[1] + self.0[2] * o.0[2]
    }

    #[inline]
    pub(in crate::surface) fn cross(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    #[inline]
    pub(in crate::surface) fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// The part of it across the unit vector `n`.
    #[inline]
    pub(in crate::surface) fn tangential(self, n: Self) -> Self {
        self - n * self.dot(n)
    }
}

impl Add for Vector {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self([self.0[0] + o.0[0], self.0[1] + o.0[1], self.0[2] + o.0[2]])
    }
}

impl AddAssign for Vector {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sub for Vector {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Self([self.0[0] - o.0[0], self.0[1] - o.0[1], self.0[2] - o.0[2]])
    }
}

impl Mul<f64> for Vector {
    type Output = Self;
    #[inline]
    fn mul(self, s: f64) -> Self {
        Self(self.0.map(|x| x * s))
    }
}

impl Index<usize> for Vector {
    type Output = f64;
    #[inline]
    fn index(&self, axis: usize) -> &f64 {
        &self.0[axis]
    }
}
