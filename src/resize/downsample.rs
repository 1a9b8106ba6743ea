//! Regular down-sampling (paper 004, III-A: RDS): the new samples lie evenly in the old image.

use super::bicubic::Spline;
use super::field::Field;
use crate::plane::GeometryImage;

/// How the old samples are asked.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Interpolation {
    Nearest,
    Bilinear,
    Bicubic,
}

/// The points of an image at even places; O(samples).
pub(crate) fn downsample(image: &GeometryImage, width: usize, height: usize, by: Interpolation) -> Vec<[f64; 3]> {
    let even = |at: usize, to: usize, from: usize| at as f64 * (from - 1) as f64 / (to - 1) as f64;
    let places = Field::from_fn(width, height, |u, v| [even(u, width, image.width()), even(v, height, image.height())]);
    evaluate(image, &places, by)
}

/// The points of an image at places with fractions.
pub(crate) fn evaluate(image: &GeometryImage, places: &Field<[f64; 2]>, by: Interpolation) -> Vec<[f64; 3]> {
    match by {
        Interpolation::Nearest => {
            // Ties go to the even sample, so that both halves of a glued border take the same one.
            let near = |at: f64| at.round_ties_even() as usize;
            places.values.iter().map(|&[x, y]| image.point(near(y), near(x))).collect()
        }
        Interpolation::Bilinear => {
            let cell = |at: f64, side: usize| {
                let first = (at as usize).min(side - 2);
                (first, at - first as f64)
            };
            let point = |&[x, y]: &[f64; 2]| {
                let ((column, across), (row, down)) = (cell(x, image.width()), cell(y, image.height()));
                let mix = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|i| a[i] + t * (b[i] - a[i]));
                let line = |row: usize| mix(image.point(row, column), image.point(row, column + 1), across);
                mix(line(row), line(row + 1), down)
            };
            places.values.iter().map(point).collect()
        }
        Interpolation::Bicubic => {
            let spline = Spline::new(image);
            places.values.iter().map(|&place| spline.at(place)).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_images::{bump, rough};
    use super::*;
    use crate::plane::Gluing;

    const ALL: [Interpolation; 3] = [Interpolation::Nearest, Interpolation::Bilinear, Interpolation::Bicubic];

    #[test]
    fn every_second_sample_is_taken_as_it_is() {
        let image = rough(17, 9, Gluing::Open);
        for by in ALL {
            let points = downsample(&image, 9, 5, by);
            for (p, point) in points.iter().enumerate() {
                let wanted = image.point(2 * (p / 9), 2 * (p % 9));
                assert!((0..3).all(|i| (point[i] - wanted[i]).abs() < 1e-9), "{by:?}: {point:?} and {wanted:?}");
            }
        }
    }

    #[test]
    fn a_plane_is_met_exactly_by_all_but_the_nearest_sample() {
        let image = bump(20, 20, 0.0);
        for by in &ALL[1..] {
            for (p, point) in downsample(&image, 7, 5, *by).iter().enumerate() {
                let wanted = [(p % 7) as f64 / 6.0, (p / 7) as f64 / 4.0, 0.0];
                assert!((0..3).all(|i| (point[i] - wanted[i]).abs() < 1e-12));
            }
        }
    }
}
