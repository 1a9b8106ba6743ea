//! Zones: coefficients that have no part in a region of interest have coarser steps (spec/wavelet.md, "Region of interest").
//!
//! Details of a level reach a few of its samples far. Those within reach of the region keep their steps; the steps of all others
//! are 2^k times as large. Coarse samples, which everything hangs on, keep theirs.

use super::quantise::{Band, steps};
use crate::plane::{Gluing, Mask, RegionCells, Shape};

/// Samples of its own level that a detail reaches, to each side.
const REACH: usize = 3;

/// Where steps are what.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Zones {
    image: Shape,
    gluing: Gluing,
    grain: u8,
    /// How many cells of the region lie above and to the left, one more a side than there are cells.
    sums: Vec<u32>,
    columns: usize,
    /// Steps outside are so many times as large.
    coarser: f64,
}

impl Zones {
    /// Steps that are 2^`coarser` times as large away from a region.
    pub(crate) fn new(region: &RegionCells, gluing: Gluing, coarser: u8) -> Self {
        let (columns, sums) = summed(region.cells());
        let coarser = f64::from(1_u32 << coarser.min(31));
        Self { image: region.image(), gluing, grain: region.grain(), sums, columns, coarser }
    }

    /// The steps of a detail of a level, at a place in that level's image.
    pub(super) fn steps(zones: Option<&Self>, step: f64, level: u8, band: Band, [row, column]: [usize; 2]) -> [f64; 3] {
        let own = steps(step, level, band);
        match zones {
            Some(zones) if !zones.is_near(level, row, column) => own.map(|s| s * zones.coarser),
            _ => own,
        }
    }

    /// Whether a detail reaches the region.
    fn is_near(&self, level: u8, row: usize, column: usize) -> bool {
        let (height, width) = (self.image.height() as isize, self.image.width() as isize);
        let reach = (REACH << level) as isize;
        let window = |at: usize| ((at << level) as isize - reach, (at << level) as isize + reach);
        let ((top, bottom), (left, right)) = (window(row), window(column));
        if self.has_any((top, bottom), (left, right)) {
            return true;
        }
        if self.gluing != Gluing::Orbifold {
            return false;
        }
        // What lies beyond a glued side is the image again, turned about the middle of the side.
        let turned = |(from, to): (isize, isize), n: isize| (n - 1 - to, n - 1 - from);
        (top < 0 && self.has_any((1, -top), turned((left, right), width)))
            || (bottom >= height && self.has_any((2 * (height - 1) - bottom, height - 2), turned((left, right), width)))
            || (left < 0 && self.has_any(turned((top, bottom), height), (1, -left)))
            || (right >= width && self.has_any(turned((top, bottom), height), (2 * (width - 1) - right, width - 2)))
    }

    /// Whether a rectangle of samples, ends included, as far as it is inside the image, meets a cell of the region.
    fn has_any(&self, (top, bottom): (isize, isize), (left, right): (isize, isize)) -> bool {
        let (height, width) = (self.image.height() as isize, self.image.width() as isize);
        let (top, bottom, left, right) = (top.max(0), bottom.min(height - 1), left.max(0), right.min(width - 1));
        if top > bottom || left > right {
            return false;
        }
        let cell = |at: isize| at as usize >> self.grain;
        let at = |row: usize, column: usize| self.sums[row * (self.columns + 1) + column];
        let (r0, r1, c0, c1) = (cell(top), cell(bottom) + 1, cell(left), cell(right) + 1);
        at(r1, c1) + at(r0, c0) > at(r0, c1) + at(r1, c0)
    }
}

/// Columns, and sums of all cells above and to the left.
fn summed(cells: &Mask) -> (usize, Vec<u32>) {
    let (rows, columns) = (cells.shape().height(), cells.shape().width());
    let mut sums = vec![0; (rows + 1) * (columns + 1)];
    for row in 0..rows {
        let mut left = 0;
        for column in 0..columns {
            left += u32::from(cells.contains(row, column));
            sums[(row + 1) * (columns + 1) + column + 1] = sums[row * (columns + 1) + column + 1] + left;
        }
    }
    (columns, sums)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By looking at every sample within reach; `None` where gluing leads out of the image a second time.
    fn slowly(region: &RegionCells, gluing: Gluing, level: u8, row: usize, column: usize) -> bool {
        let (h, w) = (region.image().height() as isize, region.image().width() as isize);
        let reach = (REACH << level) as isize;
        let (r, c) = ((row << level) as isize, (column << level) as isize);
        (r - reach..=r + reach).any(|i| {
            (c - reach..=c + reach).any(|j| {
                let inside =
                    |i: isize, j: isize| (0..h).contains(&i) && (0..w).contains(&j) && region.has(i as usize, j as usize);
                if gluing == Gluing::Open || ((0..h).contains(&i) && (0..w).contains(&j)) {
                    return inside(i, j);
                }
                // Each side's turn, of places beyond that side.
                (i < 0 && inside(-i, w - 1 - j))
                    || (i >= h && inside(2 * (h - 1) - i, w - 1 - j))
                    || (j < 0 && inside(h - 1 - i, -j))
                    || (j >= w && inside(h - 1 - i, 2 * (w - 1) - j))
            })
        })
    }

    #[test]
    fn what_is_near_is_what_every_sample_within_reach_says() {
        for (width, height) in [(33, 33), (65, 49), (9, 17)] {
            let shape = Shape::new(width, height).unwrap();
            for seed in 0..4_usize {
                let inside = Mask::from_fn(shape, |r, c| (r * 31 + c * 17 + seed * 5) % 211 == 0);
                let region = RegionCells::around(&inside).unwrap();
                for gluing in [Gluing::Open, Gluing::Orbifold] {
                    let zones = Zones::new(&region, gluing, 2);
                    for level in 0..3 {
                        let (h, w) = (((shape.height() - 1) >> level) + 1, ((shape.width() - 1) >> level) + 1);
                        for (r, c) in (0..h).flat_map(|r| (0..w).map(move |c| (r, c))) {
                            assert_eq!(
                                zones.is_near(level, r, c),
                                slowly(&region, gluing, level, r, c),
                                "{gluing:?} {level} {r} {c}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn steps_are_larger_away_from_the_region_only() {
        let shape = Shape::new(65, 65).unwrap();
        let inside = Mask::from_fn(shape, |r, c| r < 8 && c < 8);
        let zones = Zones::new(&RegionCells::around(&inside).unwrap(), Gluing::Open, 3);
        let at = |zones, place| Zones::steps(zones, 1.0, 0, Band::Both, place)[0];
        let own = at(None, [1, 1]);
        assert_eq!([at(Some(&zones), [1, 1]), at(Some(&zones), [1, 41])], [own, 8.0 * own]);
    }
}
