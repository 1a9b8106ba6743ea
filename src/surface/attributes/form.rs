//! Numbers as integers and back.

use super::octahedral::Octahedron;
use crate::mesh::Scalar;

/// How the numbers of an attribute become integers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Form {
    /// They are integers.
    Integer,
    /// Lattice points: `low[i] + step · q`.
    Lattice {
        /// The lowest number of each component.
        low: Vec<f64>,
        /// The distance of lattice points.
        step: f64,
    },
    /// Unit vectors, as lattice points on an octahedron with 2^bits points from one end of its map to the other.
    Octahedral {
        /// log₂ of these points.
        bits: u32,
    },
    /// The bits of floats, in the order of their values.
    Exact,
}

/// Lattice coordinates of attributes are below 2 to the power of this.
pub(crate) const MAX_BITS: u32 = 30;

/// Octahedra have 2 to at most this power of points.
pub(crate) const MAX_NORMAL_BITS: u32 = 20;

impl Form {
    /// Integers for `width` numbers.
    pub(crate) fn components(&self, width: usize) -> usize {
        if let Self::Octahedral { .. } = self { 3 } else { width }
    }

    /// A value as integers.
    #[cfg(feature = "encode")]
    pub(crate) fn integers(&self, value: &[f64], scalar: Scalar, out: &mut Vec<i64>) {
        match self {
            Self::Octahedral { bits } => {
                let v = [0, 1, 2].map(|i| value.get(i).copied().unwrap_or(0.0));
                out.extend(Octahedron::new(*bits).closest(v));
            }
            _ => out.extend(value.iter().enumerate().map(|(i, &x)| self.nearest(x, i, scalar))),
        }
    }

    /// The numbers that integers stand for.
    pub(crate) fn numbers(&self, integers: &[i64], scalar: Scalar, out: &mut Vec<f64>) {
        match self {
            Self::Octahedral { bits } => {
                let v = Octahedron::new(*bits).vector([integers[0], integers[1], integers[2]]);
                out.extend(v.map(|x| scalar.nearest(x)));
            }
            Self::Exact => out.extend(integers.iter().map(|&q| from_ordered(q, scalar))),
            Self::Integer => out.extend(integers.iter().map(|&q| scalar.nearest(q as f64))),
            Self::Lattice { low, step } => {
                out.extend(integers.iter().zip(low).map(|(&q, low)| scalar.nearest(low + step * q as f64)));
            }
        }
    }

    /// What a guess is made of: a number whose steps are all alike.
    #[inline]
    pub(super) fn real(&self, q: i64, scalar: Scalar) -> f64 {
        if *self == Self::Exact { from_ordered(q, scalar) } else { q as f64 }
    }

    /// The integer for a guess.
    #[inline]
    pub(super) fn guessed(&self, x: f64, scalar: Scalar) -> i64 {
        let x = if x.is_finite() { x } else { 0.0 };
        if *self == Self::Exact {
            to_ordered(x, scalar)
        } else {
            (x + 0.5).floor().clamp(-((1_u64 << 40) as f64), (1_u64 << 40) as f64) as i64
        }
    }

    #[cfg(feature = "encode")]
    fn nearest(&self, x: f64, component: usize, scalar: Scalar) -> i64 {
        match self {
            Self::Lattice { low, step } => ((x - low[component]) / step + 0.5).floor() as i64,
            Self::Exact => to_ordered(x, scalar),
            _ => scalar.nearest(x) as i64,
        }
    }
}

/// The bits of a float as an integer, so that integers are in the order of the floats; −0 is −1.
pub(crate) fn to_ordered(x: f64, scalar: Scalar) -> i64 {
    if scalar == Scalar::F64 {
        let bits = x.to_bits() as i64;
        if bits < 0 { bits ^ i64::MAX } else { bits }
    } else {
        let bits = (x as f32).to_bits() as i32;
        i64::from(if bits < 0 { bits ^ i32::MAX } else { bits })
    }
}

/// The float again.
pub(crate) fn from_ordered(q: i64, scalar: Scalar) -> f64 {
    if scalar == Scalar::F64 {
        f64::from_bits((if q < 0 { q ^ i64::MAX } else { q }) as u64)
    } else {
        let q = q.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
        f64::from(f32::from_bits((if q < 0 { q ^ i32::MAX } else { q }) as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ordered_integers_rise_with_floats_and_come_back_bit_by_bit() {
        let tiny = f64::from(f32::from_bits(1));
        let rising = [f64::NEG_INFINITY, -3.5, -tiny, -0.0, 0.0, tiny, 1.0, 1.5, f64::INFINITY];
        for scalar in [Scalar::F32, Scalar::F64] {
            assert!(rising.windows(2).all(|w| to_ordered(w[0], scalar) < to_ordered(w[1], scalar)));
            assert!(rising.iter().all(|&x| from_ordered(to_ordered(x, scalar), scalar).to_bits() == x.to_bits()));
        }
        assert_eq!((to_ordered(0.0, Scalar::F32), to_ordered(-0.0, Scalar::F32)), (0, -1));
    }
}
