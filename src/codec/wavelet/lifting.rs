//! The transform: 13/7 lifting (Deslauriers and Dubuc) of a rectangle of points, and how it goes on behind the border
//! (spec/wavelet.md, "Transform").
//!
//! ```text
//! predict   d ← d − 9/16 (a₋₁ + a₊₁) + 1/16 (a₋₃ + a₊₃)      samples at odd places
//! update    a ← a + 9/32 (d₋₁ + d₊₁) − 1/32 (d₋₃ + d₊₃)      samples at even places
//! ```
//!
//! Along rows first, then along columns. Behind the border of a disk the samples are mirrored at the last one. An orbifold
//! goes on with itself, turned by half a turn about the middle of the side. All sums are symmetric, so that glued samples
//! stay the same bit for bit.

use crate::plane::{Gluing, Shape};

/// A rectangle of points that is being transformed: samples, or coarse samples and details side by side.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    pub(super) shape: Shape,
    pub(super) gluing: Gluing,
    pub(super) points: Vec<[f64; 3]>,
}

/// How often an image can be halved so that every image on the way can still be glued.
pub(super) fn most_levels(mut shape: Shape, gluing: Gluing) -> u8 {
    let may = |n: usize| if gluing == Gluing::Open { n > 2 } else { n > 3 && (n - 1).is_multiple_of(4) };
    let mut levels = 0;
    while may(shape.width()) && may(shape.height()) {
        shape = shape.halved();
        levels += 1;
    }
    levels
}

/// The sample that stands at place `i` of a line of `n` (2 or more), and whether the way there was through an odd number
/// of mirrors.
#[inline]
pub(super) fn reach(mut i: isize, n: usize) -> (usize, bool) {
    let (last, mut turned) = (n as isize - 1, false);
    while i < 0 || i > last {
        i = if i < 0 { -i } else { 2 * last - i };
        turned = !turned;
    }
    (i as usize, turned)
}

/// The four neighbours of a sample on a line that a lifting step looks at: two at distance 1, two at distance 3.
struct Site {
    at: usize,
    neighbours: [(usize, bool); 4],
}

fn sites(n: usize, parity: usize) -> Vec<Site> {
    let site = |at: usize| Site { at, neighbours: [-1, 1, -3, 3].map(|d| reach(at as isize + d, n)) };
    (parity..n).step_by(2).map(site).collect()
}

impl Grid {
    /// From samples to coarse samples (at even rows and columns) and details.
    pub(super) fn analyse(&mut self) {
        for along_rows in [true, false] {
            self.step(along_rows, 1, -9.0 / 16.0, 1.0 / 16.0);
            self.step(along_rows, 0, 9.0 / 32.0, -1.0 / 32.0);
        }
    }

    /// And back.
    pub(super) fn synthesise(&mut self) {
        for along_rows in [false, true] {
            self.step(along_rows, 0, -9.0 / 32.0, 1.0 / 32.0);
            self.step(along_rows, 1, 9.0 / 16.0, -1.0 / 16.0);
        }
    }

    fn step(&mut self, along_rows: bool, parity: usize, near: f64, far: f64) {
        let (width, height) = (self.shape.width(), self.shape.height());
        let glued = self.gluing != Gluing::Open;
        let lifted = |own: [f64; 3], [a, b, c, d]: [[f64; 3]; 4]| {
            [0, 1, 2].map(|i| own[i] + (near * (a[i] + b[i]) + far * (c[i] + d[i])))
        };
        if along_rows {
            let sites = sites(width, parity);
            for row in 0..height {
                let turned_row = if glued { height - 1 - row } else { row };
                for Site { at, neighbours } in &sites {
                    let of = neighbours.map(|(i, turned)| self.points[if turned { turned_row } else { row } * width + i]);
                    let own = row * width + at;
                    self.points[own] = lifted(self.points[own], of);
                }
            }
        } else {
            for Site { at, neighbours } in &sites(height, parity) {
                for column in 0..width {
                    let turned_column = if glued { width - 1 - column } else { column };
                    let of = neighbours.map(|(i, turned)| self.points[i * width + if turned { turned_column } else { column }]);
                    let own = at * width + column;
                    self.points[own] = lifted(self.points[own], of);
                }
            }
        }
    }

    /// The samples at even rows and columns.
    pub(super) fn coarse(&self) -> Self {
        let (width, height) = (self.shape.width(), self.shape.height());
        let rows = (0..height).step_by(2);
        let points = rows.flat_map(|row| (0..width).step_by(2).map(move |column| self.points[row * width + column]));
        Self { shape: self.shape.halved(), gluing: self.gluing, points: points.collect() }
    }

    /// Puts samples at the even rows and columns of a grid that is twice as wide and high.
    pub(super) fn put_coarse(&mut self, coarse: &Self) {
        let (width, coarse_width) = (self.shape.width(), coarse.shape.width());
        for (at, point) in coarse.points.iter().enumerate() {
            self.points[2 * (at / coarse_width) * width + 2 * (at % coarse_width)] = *point;
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::codec::wavelet) fn random(width: usize, height: usize, gluing: Gluing, seed: u64) -> Grid {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let points = (0..width * height).map(|_| [next(), next(), next()]).collect();
        let image = crate::plane::GeometryImage::new(width, height, gluing, points).unwrap();
        Grid { shape: image.shape(), gluing, points: image.points().to_vec() }
    }

    const SHAPES: [(usize, usize, Gluing); 9] = [
        (2, 2, Gluing::Open),
        (3, 7, Gluing::Open),
        (6, 5, Gluing::Open),
        (33, 20, Gluing::Open),
        (64, 65, Gluing::Open),
        (5, 5, Gluing::Orbifold),
        (9, 5, Gluing::Orbifold),
        (33, 33, Gluing::Orbifold),
        (97, 13, Gluing::Orbifold),
    ];

    #[test]
    fn what_was_transformed_comes_back_as_it_was() {
        for (width, height, gluing) in SHAPES {
            let original = random(width, height, gluing, 7);
            let mut grid = original.clone();
            grid.analyse();
            assert_ne!(grid, original);
            grid.synthesise();
            for (a, b) in original.points.iter().zip(&grid.points) {
                assert!(
                    (0..3).all(|i| (a[i] - b[i]).abs() < 3e-15),
                    "{width} x {height}, {gluing:?}: {a:?} came back as {b:?}"
                );
            }
        }
    }

    #[test]
    fn glued_samples_stay_the_same_bit_for_bit_through_all_levels_and_back() {
        for (width, height, gluing) in SHAPES.into_iter().filter(|s| s.2 == Gluing::Orbifold) {
            let same = |grid: &Grid, what: &str| {
                let shape = grid.shape;
                for (at, point) in grid.points.iter().enumerate() {
                    let (row, column) = gluing.representative(shape, at / shape.width(), at % shape.width());
                    let of = grid.points[row * shape.width() + column];
                    assert_eq!(point.map(f64::to_bits), of.map(f64::to_bits), "{what} {width} x {height}, sample {at}");
                }
            };
            let mut grid = random(width, height, gluing, 3);
            for _ in 0..most_levels(grid.shape, gluing) {
                grid.analyse();
                same(&grid, "details of");
                let mut back = grid.clone();
                back.synthesise();
                same(&back, "samples of");
                grid = grid.coarse();
            }
        }
    }

    #[test]
    fn a_cubic_surface_has_no_details_away_from_its_border() {
        let at = |x: usize, y: usize| {
            let (x, y) = (x as f64 / 8.0, y as f64 / 8.0);
            [x, y, x * x * x - 2.0 * x * y * y + y * y * y + 1.0]
        };
        let points = (0..33 * 33).map(|p| at(p % 33, p / 33)).collect();
        let mut grid = Grid { shape: Shape::new(33, 33).unwrap(), gluing: Gluing::Open, points };
        grid.analyse();
        for row in 8..25 {
            for column in (8..25).filter(|column| row % 2 == 1 || column % 2 == 1) {
                assert!(grid.points[row * 33 + column].iter().all(|x| x.abs() < 1e-13), "row {row}, column {column}");
            }
        }
    }

    #[test]
    fn levels_end_where_an_image_could_no_longer_be_glued() {
        let levels = |w, h, gluing| most_levels(Shape::new(w, h).unwrap(), gluing);
        assert_eq!(levels(257, 257, Gluing::Orbifold), 7);
        assert_eq!(levels(193, 193, Gluing::Orbifold), 5);
        assert_eq!(levels(193, 35, Gluing::Orbifold), 0);
        assert_eq!(levels(257, 257, Gluing::Open), 8);
        assert_eq!(levels(2, 100, Gluing::Open), 0);
    }
}
