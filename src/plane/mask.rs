//! One bit a pixel: a region of interest, or which pixels count.

use bitvec::vec::BitVec;

use super::Shape;
use crate::error::{Error, Result};

/// Which pixels of an image are inside a region.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Mask {
    shape: Shape,
    bits: BitVec,
}

impl Mask {
    /// The pixels for which `inside(row, column)` holds.
    pub(crate) fn from_fn(shape: Shape, mut inside: impl FnMut(usize, usize) -> bool) -> Self {
        let mut bits = BitVec::with_capacity(shape.pixels());
        for row in 0..shape.height() {
            bits.extend((0..shape.width()).map(|column| inside(row, column)));
        }
        Self { shape, bits }
    }

    /// A mask of the given bits, row by row.
    pub(crate) fn from_bits(shape: Shape, bits: impl IntoIterator<Item = bool>) -> Result<Self> {
        let bits: BitVec = bits.into_iter().collect();
        if bits.len() != shape.pixels() {
            return Err(Error::Parameter(format!("{} bits for a mask of {shape}", bits.len())));
        }
        Ok(Self { shape, bits })
    }

    /// Columns and rows.
    pub(crate) fn shape(&self) -> Shape {
        self.shape
    }

    /// Whether a pixel is inside.
    pub(crate) fn contains(&self, row: usize, column: usize) -> bool {
        self.bits[row * self.shape.width() + column]
    }

    /// Puts a pixel inside or outside.
    pub(crate) fn set(&mut self, row: usize, column: usize, inside: bool) {
        self.bits.set(row * self.shape.width() + column, inside);
    }

    /// How many pixels are inside.
    pub(crate) fn count(&self) -> usize {
        self.bits.count_ones()
    }

    /// All pixels, row by row.
    pub(crate) fn iter(&self) -> impl Iterator<Item = bool> + '_ {
        self.bits.iter().by_vals()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_holds_what_was_set() {
        let shape = Shape::new(5, 3).unwrap();
        let mut mask = Mask::from_fn(shape, |row, column| row == 1 && column > 2);
        assert_eq!(mask.count(), 2);
        assert!(mask.contains(1, 3) && !mask.contains(1, 2) && !mask.contains(2, 3));
        mask.set(2, 0, true);
        assert_eq!(Mask::from_bits(shape, mask.iter()).unwrap(), mask);
        assert!(Mask::from_bits(shape, [true; 14]).is_err());
    }
}
