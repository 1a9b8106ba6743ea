//! A plane of one bit a pixel: adaptive bits in the context of ten pixels before (spec/format.md, "Holes").
//!
//! ```text
//!     · 3 2 1 ·
//!     8 7 6 5 4        the pixel, and the ten before it whose bits make its context
//!     10 9 ?
//! ```
//!
//! Holes are round more often than not, and small: the bits start as if a few disks had been coded before.

use std::sync::OnceLock;

use crate::entropy::{AdaptiveBit, BitCoder, BitReader};
use crate::error::Result;
use crate::limits::Budget;
use crate::plane::{Mask, Shape};

/// Columns and rows from a pixel to those of its context.
const CONTEXT: [(isize, usize); 10] = [(1, 2), (0, 2), (-1, 2), (2, 1), (1, 1), (0, 1), (-1, 1), (-2, 1), (-1, 0), (-2, 0)];

/// The bytes of a mask.
#[cfg(feature = "encode")]
pub(crate) fn write(mask: &Mask) -> Vec<u8> {
    let mut coder = crate::entropy::BitWriter::default();
    code(&mut coder, &mut mask.clone());
    coder.finish()
}

/// Memory and steps that reading a mask takes at most.
pub(crate) fn cost(shape: Shape) -> (u64, u64) {
    let pixels = shape.pixels() as u64;
    (pixels / 8 + (1 << 13), STEPS_TO_START + pixels.saturating_mul(CONTEXT.len() as u64))
}

/// The mask of some bytes; any bytes are one.
pub(crate) fn read(bytes: &[u8], shape: Shape, budget: &mut Budget) -> Result<Mask> {
    budget.check_pixels(shape.pixels() as u64)?;
    let (memory, work) = cost(shape);
    budget.reserve(memory)?;
    budget.spend(work)?;
    let mut mask = Mask::from_fn(shape, |_, _| false);
    code(&mut BitReader::new(bytes), &mut mask);
    Ok(mask)
}

/// Steps of learning the disks.
const STEPS_TO_START: u64 = 10 * 42 * (FIELD * FIELD) as u64;

/// Radii of the disks that are learned first, in quarters of a pixel, and the places of their middles within one.
const RADII: [i32; 7] = [7, 11, 18, 29, 47, 76, 123];
const MIDDLES: [(i32, i32); 3] = [(0, 0), (2, 1), (1, 3)];
/// Pixels a side around each.
const FIELD: i32 = 72;
/// How many answers a bit counts: while it learns the disks, and then.
const FEW: u32 = 24;
const MANY: u32 = 1023;

/// The bits of all contexts once they have seen the disks, and the same disks as holes in a full plane; made once.
fn models() -> Vec<AdaptiveBit> {
    static STARTED: OnceLock<Vec<AdaptiveBit>> = OnceLock::new();
    STARTED.get_or_init(started).clone()
}

fn started() -> Vec<AdaptiveBit> {
    let mut models = vec![AdaptiveBit::default(); 1 << CONTEXT.len()];
    let Ok(shape) = Shape::new(FIELD as u32, FIELD as u32) else { return models };
    for inside in [true, false] {
        for radius in RADII {
            for (x, y) in MIDDLES {
                let far = |at: usize, offset: i32| 4 * at as i32 - 2 * FIELD + offset;
                let disk = |row: usize, column: usize| far(row, y).pow(2) + far(column, x).pow(2) < radius * radius;
                let mask = Mask::from_fn(shape, |row, column| disk(row, column) == inside);
                for row in 0..shape.height() {
                    for column in 0..shape.width() {
                        models[context(&mask, row, column)].learn(mask.contains(row, column), FEW);
                    }
                }
            }
        }
    }
    models
}

/// The ten pixels before, as a number; pixels outside are 0.
fn context(mask: &Mask, row: usize, column: usize) -> usize {
    let bit = |(right, up): (isize, usize)| {
        let inside = column.checked_add_signed(right).filter(|&c| c < mask.shape().width() && up <= row);
        inside.is_some_and(|column| mask.contains(row - up, column))
    };
    CONTEXT.into_iter().fold(0, |context, at| context << 1 | usize::from(bit(at)))
}

fn code<C: BitCoder>(coder: &mut C, mask: &mut Mask) {
    let mut models = models();
    for row in 0..mask.shape().height() {
        for column in 0..mask.shape().width() {
            let model = &mut models[context(mask, row, column)];
            let set = coder.code(mask.contains(row, column), model.p().clamp(1, 65535));
            model.learn(set, MANY);
            mask.set(row, column, set);
        }
    }
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;
    use crate::limits::Limits;

    #[allow(clippy::unwrap_used)]
    fn back(mask: &Mask) -> (usize, Mask) {
        let bytes = write(mask);
        (bytes.len(), read(&bytes, mask.shape(), &mut Budget::new(Limits::default())).unwrap())
    }

    #[test]
    fn masks_come_back_and_round_ones_cost_little() {
        let shape = Shape::new(128, 100).unwrap();
        let disk = Mask::from_fn(shape, |r, c| (r as f64 - 40.0).powi(2) + (c as f64 - 50.0).powi(2) < 500.0);
        let mut state = 1_u64;
        let noise = Mask::from_fn(shape, |_, _| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 63 == 1
        });
        let (size, same) = back(&disk);
        assert!(same == disk && size < 40, "{size}");
        let (size, same) = back(&noise);
        assert!(same == noise && size > 1400, "{size}");
        let one = Mask::from_fn(Shape::new(1, 1).unwrap(), |_, _| true);
        assert_eq!(back(&one).1, one);
    }

    #[test]
    fn any_bytes_are_a_mask_and_limits_hold() {
        let shape = Shape::new(33, 7).unwrap();
        for bytes in [&[][..], &[0xff; 3], &[7; 100]] {
            assert_eq!(read(bytes, shape, &mut Budget::new(Limits::default())).unwrap().shape(), shape);
        }
        assert!(read(&[], shape, &mut Budget::new(Limits::default().pixels(230))).is_err());
        assert!(read(&[], shape, &mut Budget::new(Limits::default().work(100))).is_err());
    }
}
