//! The coarsest samples: few, and each worth many bits (spec/wavelet.md, "Coarse samples").

use super::quantise::MAX_INDEX;
use crate::entropy::{AdaptiveBit, BitCoder};
use crate::error::{Error, Place, Result};
use crate::plane::{Gluing, Shape};

/// Bits of the range of an axis that are not coded plainly.
const MODELLED: u32 = 3;
/// No writer needs more steps of 2^plain than this.
const MOST: u32 = 1 << 12;

/// Codes the indices of the coarsest samples, which lie about where `low` and `high` (in steps) say.
pub(super) fn code<C: BitCoder>(
    coder: &mut C,
    shape: Shape,
    gluing: Gluing,
    [low, high]: [[i32; 3]; 2],
    indices: &mut [[i32; 3]],
) -> Result<()> {
    let width = shape.width();
    let mut model = [AdaptiveBit::default(); 20];
    for axis in 0..3 {
        let range = (i64::from(high[axis]) - i64::from(low[axis])).unsigned_abs() + 1;
        let plain = (64 - range.leading_zeros()).saturating_sub(MODELLED).min(30);
        for at in 0..indices.len() {
            let (row, column) = (at / width, at % width);
            let of = gluing.representative(shape, row, column);
            if of != (row, column) {
                indices[at] = indices[of.0 * width + of.1];
                continue;
            }
            let west = (column > 0).then(|| i64::from(indices[at - 1][axis]));
            let north = (row > 0).then(|| i64::from(indices[at - width][axis]));
            let guess = match (west, north) {
                (Some(a), Some(b)) => (a + b) >> 1,
                (Some(a), None) | (None, Some(a)) => a,
                (None, None) => (i64::from(low[axis]) + i64::from(high[axis])) >> 1,
            };
            let off = i64::from(indices[at][axis]) - guess;
            let size = off.unsigned_abs().min(u64::from(u32::MAX)) as u32;
            let mut steps = 0;
            while model[(steps as usize).min(19)].code(coder, size >> plain > steps) {
                steps += 1;
                if steps > MOST {
                    return Err(Error::malformed(Place::Whole, "a coarse sample far outside the box"));
                }
            }
            let size = u64::from(steps) << plain | u64::from(coder.raw(size, plain));
            let negative = size > 0 && coder.code(off < 0, 1 << 15);
            let index = guess + if negative { -(size as i64) } else { size as i64 };
            if index.abs() > i64::from(MAX_INDEX) {
                return Err(Error::malformed(Place::Whole, format!("a coarse sample at {index}, beyond {MAX_INDEX} steps")));
            }
            indices[at][axis] = index as i32;
        }
    }
    Ok(())
}
