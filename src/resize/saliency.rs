//! How much the surface changes from sample to sample (paper 004, II-A, equations (1) and (2)).
//!
//! E = α E_gim + (1 − α) E_nmp: the gradients of the geometry image and of its normal image, summed over the three
//! channels, in [0, 1]. The paper divides by the greatest value, which a single spike decides;
//! [`Energy::Robust`] divides by the 99th percentile instead (spec/readings.md).

use super::field::{Field, differences};
use crate::plane::{GeometryImage, Gluing};

/// How the two energies are brought to [0, 1].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Energy {
    /// As printed: the sum divided by its maximum.
    Paper,
    /// Each term divided by its 99th percentile, their sum by its own, cut off at 1.
    Robust,
}

/// The energy of every sample, in [0, 1]; O(samples).
pub(crate) fn saliency(image: &GeometryImage, alpha: f64, energy: Energy) -> Field<f64> {
    let (shape, gluing) = ((image.width(), image.height()), image.gluing());
    let points = normalised(image);
    let normals = normals(&points, gluing);
    let halves = normals.values.iter().map(|n| n.map(|x| (x + 1.0) / 2.0)).collect();
    let of_points = steepness(&points, gluing);
    let of_normals = steepness(&Field::new(shape.0, shape.1, halves), gluing);
    let (by_points, by_normals) = match energy {
        Energy::Paper => (alpha, 1.0 - alpha),
        Energy::Robust => (alpha / high(&of_points), (1.0 - alpha) / high(&of_normals)),
    };
    let mut sum: Vec<f64> = of_points.iter().zip(&of_normals).map(|(p, n)| by_points * p + by_normals * n).collect();
    let scale = match energy {
        Energy::Paper => positive(sum.iter().copied().fold(0.0, f64::max)),
        Energy::Robust => high(&sum),
    };
    sum.iter_mut().for_each(|e| *e = (*e / scale).min(1.0));
    Field::new(shape.0, shape.1, sum)
}

/// The points in units of their box's longest side, from its lowest corner.
fn normalised(image: &GeometryImage) -> Field<[f64; 3]> {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for p in image.points() {
        for i in 0..3 {
            low[i] = low[i].min(p[i]);
            high[i] = high[i].max(p[i]);
        }
    }
    let longest = positive((0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max));
    let points = image.points().iter().map(|p| [0, 1, 2].map(|i| (p[i] - low[i]) / longest)).collect();
    Field::new(image.width(), image.height(), points)
}

/// The normal image: cross products of the differences, of length 1, or 0 where there is no normal.
pub(crate) fn normals(points: &Field<[f64; 3]>, gluing: Gluing) -> Field<[f64; 3]> {
    Field::from_fn(points.width, points.height, |x, y| {
        let (u, v) = differences(points, gluing, x, y);
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
        n.map(|x| x / length.max(1e-30))
    })
}

/// The sum over the channels of the lengths of the gradients.
fn steepness(field: &Field<[f64; 3]>, gluing: Gluing) -> Vec<f64> {
    let mut sums = Vec::with_capacity(field.values.len());
    for y in 0..field.height {
        for x in 0..field.width {
            let (u, v) = differences(field, gluing, x, y);
            sums.push((0..3).map(|i| (u[i] * u[i] + v[i] * v[i]).sqrt()).sum());
        }
    }
    sums
}

/// The 99th percentile, between two values where it falls there; the greatest value where that is zero, and 1 where
/// all are.
fn high(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    let at = 0.99 * (values.len() - 1) as f64;
    let (below, between) = (at.floor() as usize, at.fract());
    let (_, &mut low, above) = values.select_nth_unstable_by(below, f64::total_cmp);
    let next = above.iter().copied().fold(f64::INFINITY, f64::min);
    let percentile = if between > 0.0 && next.is_finite() { low + between * (next - low) } else { low };
    if percentile > 0.0 { percentile } else { positive(above.iter().copied().fold(low, f64::max)) }
}

fn positive(x: f64) -> f64 {
    if x > 0.0 { x } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::super::test_images::{bump, pillow};
    use super::*;

    #[test]
    fn a_plane_has_the_same_energy_everywhere_and_a_bump_has_most_at_its_edge() {
        let flat = bump(21, 17, 0.0);
        let e = saliency(&flat, 0.5, Energy::Robust);
        assert!(e.values.iter().all(|&v| (v - e.values[0]).abs() < 1e-12 && v > 0.0));
        let e = saliency(&bump(41, 41, 0.4), 0.3, Energy::Robust);
        assert!(e.at(20, 20) > 5.0 * e.at(2, 2), "{} in the middle, {} in the corner", e.at(20, 20), e.at(2, 2));
    }

    #[test]
    fn energies_lie_between_0_and_1_and_only_the_robust_one_ignores_a_spike() {
        let mut points = bump(65, 65, 0.4).points().to_vec();
        let share = |image: &GeometryImage, energy| {
            let e = saliency(image, 0.5, energy);
            assert!(e.values.iter().all(|v| (0.0..=1.0).contains(v)));
            e.values.iter().sum::<f64>() / e.values.len() as f64
        };
        let before = GeometryImage::new(65, 65, Gluing::Open, points.clone()).unwrap();
        points[5 * 65 + 5][2] += 5.0;
        let after = GeometryImage::new(65, 65, Gluing::Open, points).unwrap();
        assert!(share(&after, Energy::Paper) < 0.7 * share(&before, Energy::Paper));
        assert!(share(&after, Energy::Robust) > 0.95 * share(&before, Energy::Robust));
    }

    #[test]
    fn glued_samples_have_one_normal_and_one_energy() {
        let image = pillow(17, 13);
        let normals = normals(&Field::new(17, 13, image.points().to_vec()), Gluing::Orbifold);
        let e = saliency(&image, 0.5, Energy::Robust);
        for (p, &of) in image.representatives().iter().enumerate() {
            let off: f64 = (0..3).map(|i| (normals.values[p][i] - normals.values[of as usize][i]).abs()).sum();
            assert!(off < 1e-9, "the normals of samples {p} and {of} differ by {off}");
            // Energies at a cone are one-sided, and no other sample is glued to one.
            assert!((e.values[p] - e.values[of as usize]).abs() < 1e-9);
        }
    }

    #[test]
    fn a_point_that_is_everywhere_has_no_energy() {
        let image = GeometryImage::new(5, 5, Gluing::Open, vec![[1.0, 2.0, 3.0]; 25]).unwrap();
        for energy in [Energy::Paper, Energy::Robust] {
            assert!(saliency(&image, 0.5, energy).values.iter().all(|&v| v == 0.0));
        }
    }

    #[test]
    fn the_percentile_is_that_of_sorting() {
        for n in [1, 2, 3, 50, 100, 101, 1000] {
            let values: Vec<f64> = (0..n).map(|i| ((i * 7919 + 13) % 1009) as f64 + 1.0).collect();
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            let at = 0.99 * (n - 1) as f64;
            let (i, t) = (at as usize, at.fract());
            let expected = sorted[i] + t * (sorted[(i + 1).min(n - 1)] - sorted[i]);
            assert!((high(&values) - expected).abs() < 1e-9);
        }
    }
}
