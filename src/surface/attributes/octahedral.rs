//! Unit vectors as lattice points of an octahedron (Meyer et al., "On floating-point normal vectors", 2010).
//!
//! A vector is stretched until |x| + |y| + |z| = n, and goes to the nearest triple of integers with that sum. All signed
//! permutations of the axes map these points to each other, so that a residual can be told from where the guess looks up.

/// The points (x, y, z) with |x| + |y| + |z| = n.
#[derive(Debug, Clone, Copy)]
pub(super) struct Octahedron {
    n: i64,
}

impl Octahedron {
    /// 2n + 2 = 2^bits: there are 2^bits − 1 points from one end of the unfolded octahedron to the other.
    pub(super) fn new(bits: u32) -> Self {
        Self { n: ((1 << bits.clamp(2, super::form::MAX_NORMAL_BITS)) >> 1) - 1 }
    }

    pub(super) fn n(self) -> i64 {
        self.n
    }

    /// The point that a vector of any length goes to; "up" if it has none.
    pub(super) fn nearest(self, v: [f64; 3]) -> [i64; 3] {
        let sum = v[0].abs() + v[1].abs() + v[2].abs();
        if !(sum > 0.0 && sum.is_finite()) {
            return [0, 0, self.n];
        }
        let n = self.n as f64;
        let round = |x: f64| (x.abs() / sum * n + 0.5).floor() as i64;
        let x = round(v[0]).min(self.n);
        let y = round(v[1]).min(self.n - x);
        let z = self.n - x - y;
        let signed = |q: i64, x: f64| if x < 0.0 { -q } else { q };
        [signed(x, v[0]), signed(y, v[1]), signed(z, v[2])]
    }

    /// Of the points around [`Octahedron::nearest`] the one in whose direction the vector points best.
    #[cfg(feature = "encode")]
    pub(super) fn closest(self, v: [f64; 3]) -> [i64; 3] {
        let q = self.nearest(v);
        let sign = |x: f64| if x < 0.0 { -1 } else { 1 };
        let mut best = (f64::NEG_INFINITY, q);
        for dx in -1..=1 {
            for dy in -1..=1 {
                let (x, y) = (q[0].abs() + dx, q[1].abs() + dy);
                if x < 0 || y < 0 || x + y > self.n {
                    continue;
                }
                let p = [x * sign(v[0]), y * sign(v[1]), (self.n - x - y) * sign(v[2])];
                let u = self.vector(p);
                let dot = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
                if dot > best.0 {
                    best = (dot, p);
                }
            }
        }
        best.1
    }

    /// The unit vector of a point.
    pub(super) fn vector(self, q: [i64; 3]) -> [f64; 3] {
        let v = q.map(|x| x as f64);
        let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        if length > 0.0 { v.map(|x| x / length) } else { [0.0, 0.0, 1.0] }
    }
}

/// A signed permutation of the axes that makes the greatest coordinate of a point the last, and positive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    axes: [usize; 3],
    is_negative: [bool; 3],
}

impl Frame {
    pub(super) fn of(point: [i64; 3]) -> Self {
        let last = (0..3).fold(2, |best, i| if point[i].abs() > point[best].abs() { i } else { best });
        let axes = [(last + 1) % 3, (last + 2) % 3, last];
        Self { axes, is_negative: axes.map(|axis| point[axis] < 0) }
    }

    /// A point as the frame sees it.
    pub(super) fn seen(&self, point: [i64; 3]) -> [i64; 3] {
        [0, 1, 2].map(|i| if self.is_negative[i] { -point[self.axes[i]] } else { point[self.axes[i]] })
    }

    /// The point that the frame sees so.
    pub(super) fn unseen(&self, seen: [i64; 3]) -> [i64; 3] {
        let mut point = [0; 3];
        for i in 0..3 {
            point[self.axes[i]] = if self.is_negative[i] { -seen[i] } else { seen[i] };
        }
        point
    }
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_its_own_nearest_and_seen_from_any_frame() {
        let octahedron = Octahedron::new(5);
        let n = octahedron.n();
        for x in -n..=n {
            for y in -(n - x.abs())..=n - x.abs() {
                for sign in [-1, 1] {
                    let point = [x, y, sign * (n - x.abs() - y.abs())];
                    let v = octahedron.vector(point);
                    assert_eq!((octahedron.nearest(v), octahedron.closest(v)), (point, point));
                    let frame = Frame::of(point);
                    let seen = frame.seen(point);
                    assert!(seen[2] >= seen[0].abs().max(seen[1].abs()));
                    assert_eq!(frame.unseen(seen), point);
                }
            }
        }
    }

    #[test]
    fn a_vector_is_off_by_little_and_by_less_the_more_bits_there_are() {
        for (bits, most) in [(8, 0.013), (10, 0.0032), (16, 0.00006)] {
            let octahedron = Octahedron::new(bits);
            for i in 0..500 {
                let (a, b) = (f64::from(i) * 0.7, f64::from(i) * 0.31);
                let v = [a.sin() * b.cos(), a.sin() * b.sin(), a.cos()];
                let u = octahedron.vector(octahedron.closest(v));
                let off = (0..3).map(|k| (u[k] - v[k]).powi(2)).sum::<f64>().sqrt();
                assert!(off < most, "{off} at {bits} bits");
            }
        }
    }
}
