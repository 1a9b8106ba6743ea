//! Bicubic evaluation (paper 004, II-B): the surface through the samples that is a cubic spline along both axes.
//!
//! An open image ends as a natural spline does, without curvature across its border, so that planes stay planes.
//! An orbifold goes on beyond its border as the surface does, so the spline is as smooth there as inside.

use super::field::{Field, beyond};
use crate::plane::{GeometryImage, Gluing};

/// B-spline coefficients, with one more on every side.
pub(crate) struct Spline {
    width: usize,
    height: usize,
    coefficients: Field<[f64; 3]>,
}

impl Spline {
    /// The spline through the samples of an image; O(samples).
    pub(crate) fn new(image: &GeometryImage) -> Self {
        let points = Field::new(image.width(), image.height(), image.points().to_vec());
        let gluing = image.gluing();
        let along = filtered(&points, gluing);
        let inner = filtered(&along.transposed(), gluing).transposed();
        Self { width: points.width, height: points.height, coefficients: padded(&inner, gluing) }
    }

    /// The point at fractional column `x` and row `y`, both within the image.
    pub(crate) fn at(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let cell = |at: f64, side: usize| {
            let first = (at.max(0.0) as usize).min(side - 2);
            (first, basis((at - first as f64).clamp(0.0, 1.0)))
        };
        let ((column, across), (row, down)) = (cell(x, self.width), cell(y, self.height));
        let mut sum = [0.0; 3];
        for (j, wy) in down.into_iter().enumerate() {
            let line = &self.coefficients.row(row + j)[column..column + 4];
            for (wx, c) in across.into_iter().zip(line) {
                (0..3).for_each(|i| sum[i] += wx * wy * c[i]);
            }
        }
        sum
    }
}

/// The four cubic B-splines that are not zero, a share `t` between two knots.
fn basis(t: f64) -> [f64; 4] {
    let u = 1.0 - t;
    let middle = |t: f64| (t * t * (3.0 * t - 6.0) + 4.0) / 6.0;
    [u * u * u / 6.0, middle(t), middle(u), t * t * t / 6.0]
}

/// The B-spline coefficients of every row.
fn filtered(field: &Field<[f64; 3]>, gluing: Gluing) -> Field<[f64; 3]> {
    let (width, height) = (field.width, field.height);
    let mut out = field.clone();
    match gluing {
        Gluing::Orbifold => {
            // Beyond its end a row goes on as the row it is turned to, backwards, and so round.
            for y in 0..height.div_ceil(2) {
                let turned = height - 1 - y;
                let back = |x: usize| field.at(2 * (width - 1) - x, turned);
                let round = (0..2 * (width - 1)).map(|x| if x < width { field.at(x, y) } else { back(x) });
                let solved = periodic(&round.collect::<Vec<_>>());
                for x in 0..width {
                    out.values[y * width + x] = solved[x];
                    out.values[turned * width + x] = solved[(2 * (width - 1) - x) % (2 * (width - 1))];
                }
            }
        }
        Gluing::Open => out.values.chunks_mut(width).for_each(natural),
    }
    out
}

/// Solves (c₋ + 4c + c₊)/6 = f in place where both ends keep their value: a natural spline.
fn natural(line: &mut [[f64; 3]]) {
    let last = line.len() - 1;
    let mut upper = vec![0.0; line.len()];
    for k in 1..last {
        let pivot = 4.0 - upper[k - 1];
        upper[k] = 1.0 / pivot;
        line[k] = [0, 1, 2].map(|i| (6.0 * line[k][i] - line[k - 1][i]) / pivot);
    }
    for k in (1..last).rev() {
        line[k] = [0, 1, 2].map(|i| line[k][i] - upper[k] * line[k + 1][i]);
    }
}

/// Solves (c₋ + 4c + c₊)/6 = f on a closed line by running the two halves of the filter long enough around it.
fn periodic(line: &[[f64; 3]]) -> Vec<[f64; 3]> {
    const POLE: f64 = -0.267_949_192_431_122_7; // √3 − 2
    const WARM: usize = 32; // POLE to this power is below 1e-18
    let n = line.len();
    let start = WARM.div_ceil(n) * n;
    let mut forth = vec![[0.0; 3]; n];
    let mut state = [0.0; 3];
    for k in 0..start + n {
        state = [0, 1, 2].map(|i| line[k % n][i] + POLE * state[i]);
        forth[k % n] = state;
    }
    let mut back = vec![[0.0; 3]; n];
    let mut state = [0.0; 3];
    for k in (0..start + n).rev() {
        state = [0, 1, 2].map(|i| POLE * (state[i] - forth[k % n][i]));
        back[k % n] = state.map(|x| 6.0 * x);
    }
    back
}

/// The coefficients with those one step beyond every border.
fn padded(inner: &Field<[f64; 3]>, gluing: Gluing) -> Field<[f64; 3]> {
    let (width, height) = (inner.width, inner.height);
    Field::from_fn(width + 2, height + 2, |x, y| {
        let (x, y) = (x as isize - 1, y as isize - 1);
        if gluing == Gluing::Orbifold {
            let (x, y) = beyond(width, height, x, y);
            return inner.at(x, y);
        }
        // Straight on: c₋₁ = 2c₀ − c₁ along both axes.
        let ends = |at: isize, last: usize| match at {
            at if at < 0 => [(0, 2.0), (1, -1.0)],
            at if at as usize > last => [(last, 2.0), (last - 1, -1.0)],
            at => [(at as usize, 1.0), (at as usize, 0.0)],
        };
        let mut sum = [0.0; 3];
        for (row, wy) in ends(y, height - 1) {
            for (column, wx) in ends(x, width - 1) {
                (0..3).for_each(|i| sum[i] += wx * wy * inner.at(column, row)[i]);
            }
        }
        sum
    })
}

#[cfg(test)]
mod tests {
    use super::super::test_images::{bump, pillow, rough};
    use super::*;

    #[test]
    fn the_spline_passes_through_every_sample() {
        for image in [rough(9, 6, Gluing::Open), rough(2, 3, Gluing::Open), rough(7, 11, Gluing::Orbifold), pillow(3, 3)] {
            let spline = Spline::new(&image);
            for y in 0..image.height() {
                for x in 0..image.width() {
                    let (p, q) = (spline.at([x as f64, y as f64]), image.point(y, x));
                    assert!((0..3).all(|i| (p[i] - q[i]).abs() < 1e-9), "{x}, {y}: {p:?} and {q:?}");
                }
            }
        }
    }

    #[test]
    fn a_plane_stays_a_plane_up_to_its_border() {
        let spline = Spline::new(&bump(8, 5, 0.0));
        for k in 0..=70 {
            let at = [k as f64 / 10.0, k as f64 * 4.0 / 70.0];
            let p = spline.at(at);
            assert!((p[0] - at[0] / 7.0).abs() < 1e-12 && (p[1] - at[1] / 4.0).abs() < 1e-12 && p[2].abs() < 1e-12);
        }
    }

    #[test]
    fn both_sides_of_a_glued_border_are_one_curve_and_the_surface_is_smooth_across_it() {
        let image = rough(11, 9, Gluing::Orbifold);
        let spline = Spline::new(&image);
        for k in 0..=100 {
            let x = k as f64 / 10.0;
            let (a, b) = (spline.at([x, 0.0]), spline.at([10.0 - x, 0.0]));
            assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-9));
            // A little step across: the slope on both sides, which a kink would tell apart.
            let (near, far) = (spline.at([x, 1e-5]), spline.at([10.0 - x, 1e-5]));
            let kink = (0..3).map(|i| (near[i] + far[i] - 2.0 * a[i]).abs()).sum::<f64>();
            assert!(kink < 1e-6, "a kink of {kink} at {x}");
        }
    }
}
