//! Points spread evenly over a surface.

use glam::DVec3;

use crate::geom::Triangle;

/// A point of a surface and the unit normal of its triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
}

/// The `i`-th of numbers in `[0, 1)` that fill it evenly, and every stretch of it (multiples of an irrational number).
fn fill(step: f64, i: usize) -> f64 {
    (0.5 + step * i as f64).fract()
}

/// `count` points, uniform by area: the area is laid out triangle after triangle and cut into equal parts with a point each.
/// Neighbours in the list are as near as the triangles are. None where there is no area.
pub(super) fn spread(triangles: &[Triangle], count: usize) -> Vec<Sample> {
    let normal = |[a, b, c]: Triangle| (b - a).cross(c - a);
    let total: f64 = triangles.iter().map(|&t| normal(t).length()).sum();
    let mut samples = Vec::with_capacity(count);
    if !(total > 0.0) {
        return samples;
    }
    let (mut at, mut end) = (0, normal(triangles[0]).length());
    for i in 0..count {
        // Inverse powers of the plastic number (M. Roberts' R2) and the golden ratio.
        let place = (i as f64 + fill(0.618_033_988_749_894_9, i)) / count as f64 * total;
        while at + 1 < triangles.len() && end <= place {
            at += 1;
            end += normal(triangles[at]).length();
        }
        let [a, b, c] = triangles[at];
        let (r, s) = (fill(0.754_877_666_246_692_7, i).sqrt(), fill(0.569_840_290_998_053_2, i));
        let point = a * (1.0 - r) + b * (r * (1.0 - s)) + c * (r * s);
        samples.push(Sample { point, normal: normal(triangles[at]).normalize_or_zero() });
    }
    samples
}
