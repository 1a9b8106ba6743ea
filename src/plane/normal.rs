//! Unit normals as two samples: the octahedral map.
//!
//! A normal is divided by the sum of its absolute components, so that it lies on an octahedron, and the lower half is
//! folded out over the upper one (Z. Cigolle et al., "Survey of efficient representations for independent unit
//! vectors", JCGT 3(2), 2014). Both coordinates then lie in −1 ..= 1 and are rounded to a whole number of steps.
//!
//! A decoder repeats the inverse exactly: only + − × ÷ and one √.

/// The samples of a unit normal, `bits` bits each; of no direction those of (0, 0, 1).
pub(crate) fn octahedral(normal: [f64; 3], bits: u8) -> [i32; 2] {
    let sum: f64 = normal.iter().map(|x| x.abs()).sum();
    let [x, y, z] = if sum > 0.0 && sum.is_finite() { normal.map(|x| x / sum) } else { [0.0, 0.0, 1.0] };
    let [x, y] = if z < 0.0 { [(1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)] } else { [x, y] };
    let half = half(bits);
    [x, y].map(|t| ((t + 1.0) * half + 0.5).clamp(0.0, 2.0 * half) as i32)
}

/// The unit normal of two samples.
pub(crate) fn from_octahedral(samples: [i32; 2], bits: u8) -> [f64; 3] {
    let [x, y] = samples.map(|s| f64::from(s) / half(bits) - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    let [x, y] = if z < 0.0 { [(1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)] } else { [x, y] };
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

/// Steps from the middle to either end: a whole number, so that the axes are met exactly.
fn half(bits: u8) -> f64 {
    f64::from((1_u32 << (bits - 1)) - 1).max(0.5)
}

fn sign(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_normal_turns_by_no_more_than_the_steps_are_wide(x in -1.0..1.0_f64, y in -1.0..1.0_f64, z in -1.0..1.0_f64, bits in 4_u8..=16) {
            let length = (x * x + y * y + z * z).sqrt();
            prop_assume!(length > 1e-3);
            let n = [x, y, z].map(|c| c / length);
            let back = from_octahedral(octahedral(n, bits), bits);
            let turned = (0..3).map(|i| (n[i] - back[i]).powi(2)).sum::<f64>().sqrt();
            prop_assert!(turned < 3.0 / f64::from(1_u32 << (bits - 1)), "{turned}");
            prop_assert!((back.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_axes_come_back_exactly() {
        for axis in 0..3 {
            for direction in [-1.0, 1.0] {
                let mut n = [0.0; 3];
                n[axis] = direction;
                for bits in [2, 8, 10, 16] {
                    assert_eq!(from_octahedral(octahedral(n, bits), bits), n, "{bits} bits");
                }
            }
        }
    }
}
