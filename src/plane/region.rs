//! A region of interest of an image, in square cells of several samples: what a file says of it.

use super::{Mask, Shape};
use crate::error::{Error, Result};

/// A side of an image has this many cells at most.
const CELLS: usize = 33;

/// The cells of an image that have a part in its region of interest.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct RegionCells {
    image: Shape,
    /// A cell has 2 to this samples a side.
    grain: u8,
    cells: Mask,
}

impl RegionCells {
    /// Columns and rows of cells for an image, and the logarithm of their samples a side: as few as leave 33 cells or fewer.
    pub(crate) fn layout(image: Shape) -> Result<(Shape, u8)> {
        let (width, height) = (image.width(), image.height());
        let count = |n: usize, grain: u8| ((n.max(1) - 1) >> grain) + 1;
        let grain = (0..32).find(|&g| count(width, g) <= CELLS && count(height, g) <= CELLS).unwrap_or(32);
        Ok((Shape::new(count(width, grain) as u32, count(height, grain) as u32)?, grain))
    }

    /// Of the cells themselves.
    pub(crate) fn new(image: Shape, cells: Mask) -> Result<Self> {
        let (shape, grain) = Self::layout(image)?;
        if cells.shape() != shape {
            return Err(Error::Parameter(format!(
                "a region of {} cells in an image of {image}, {shape} expected",
                cells.shape()
            )));
        }
        Ok(Self { image, grain, cells })
    }

    /// Of the samples that are inside.
    #[cfg(feature = "encode")]
    pub(crate) fn around(inside: &Mask) -> Result<Self> {
        let (shape, grain) = Self::layout(inside.shape())?;
        let mut cells = Mask::from_fn(shape, |_, _| false);
        let width = inside.shape().width();
        for at in inside.iter().enumerate().filter(|(_, inside)| *inside).map(|(at, _)| at) {
            cells.set((at / width) >> grain, (at % width) >> grain, true);
        }
        Self::new(inside.shape(), cells)
    }

    /// The image.
    pub(crate) fn image(&self) -> Shape {
        self.image
    }

    /// The logarithm of the samples a side of a cell.
    pub(crate) fn grain(&self) -> u8 {
        self.grain
    }

    /// The cells.
    pub(crate) fn cells(&self) -> &Mask {
        &self.cells
    }

    /// Whether a sample lies in one of the cells.
    pub(crate) fn has(&self, row: usize, column: usize) -> bool {
        self.cells.contains(row >> self.grain, column >> self.grain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_hold_all_samples_inside_and_are_few() {
        for (width, height) in [(257, 257), (2, 2), (33, 34), (1025, 100), (65, 65)] {
            let shape = Shape::new(width, height).unwrap();
            let inside = Mask::from_fn(shape, |r, c| (r * 7 + c * 3) % 41 == 0 && r < 40);
            let cells = RegionCells::around(&inside).unwrap();
            assert!(cells.cells().shape().width() <= CELLS && cells.cells().shape().height() <= CELLS);
            let (w, h) = (shape.width(), shape.height());
            assert!((0..h).all(|r| (0..w).all(|c| !inside.contains(r, c) || cells.has(r, c))));
            // A cell without a sample inside is none.
            let side = 1 << cells.grain();
            for r in 0..cells.cells().shape().height() {
                for c in 0..cells.cells().shape().width() {
                    let rows = r * side..((r + 1) * side).min(h);
                    let any = rows.clone().any(|i| (c * side..((c + 1) * side).min(w)).any(|j| inside.contains(i, j)));
                    assert_eq!(cells.cells().contains(r, c), any);
                }
            }
            assert_eq!(RegionCells::new(shape, cells.cells().clone()).unwrap(), cells);
        }
    }
}
