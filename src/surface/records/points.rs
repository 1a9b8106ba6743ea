//! The lattice points of vertices that no face of the surface uses, in Morton order: the gaps between them.
//!
//! The order of such vertices means nothing, and sorting them saves log₂ n! bits.

use super::error;
use crate::entropy::{AdaptiveBit, BitCoder};
use crate::error::Result;
use crate::limits::Budget;

/// Bits of a coordinate.
const BITS: usize = 30;

/// Where a point stands in Morton order.
pub(crate) fn key(point: [i32; 3]) -> u128 {
    (0..BITS).rev().fold(0, |key, bit| (0..3).fold(key, |key, axis| key << 1 | (point[axis] >> bit & 1) as u128))
}

fn point(key: u128) -> [i32; 3] {
    let mut point = [0; 3];
    for bit in 0..BITS {
        for (axis, x) in point.iter_mut().enumerate() {
            *x |= ((key >> (3 * bit + 2 - axis) & 1) as i32) << bit;
        }
    }
    point
}

/// Appends the points.
pub(super) fn code<C: BitCoder>(
    coder: &mut C,
    extent: [i32; 3],
    count: u32,
    known: &[[i32; 3]],
    positions: &mut Vec<[i32; 3]>,
    budget: &mut Budget,
) -> Result<()> {
    // The gap's length in bits, given that of the gap before in coarse classes; then its highest bit but one.
    let mut lengths = [[AdaptiveBit::default(); 3 * BITS + 1]; 8];
    let mut high = [AdaptiveBit::default(); 3 * BITS + 1];
    let (mut last, mut class) = (0_u128, 0);
    for i in 0..count as usize {
        budget.spend(2)?;
        let gap = known.get(i).map_or(0, |&p| key(p).saturating_sub(last));
        let wanted = 128 - gap.leading_zeros() as usize;
        let mut length = 0;
        while length < 3 * BITS && lengths[class][length].code(coder, length < wanted) {
            length += 1;
        }
        let mut value = u128::from(length > 0);
        for bit in (0..length.saturating_sub(1)).rev() {
            let is_set = gap >> bit & 1 != 0;
            let is_set = if bit + 2 == length { high[length].code(coder, is_set) } else { coder.code(is_set, 1 << 15) };
            value = value << 1 | u128::from(is_set);
        }
        class = (length * 7).div_ceil(3 * BITS);
        last += value;
        let p = point(last);
        if last >> (3 * BITS) != 0 || (0..3).any(|axis| p[axis] > extent[axis]) {
            return Err(error("a vertex outside the box"));
        }
        if coder.is_exhausted() {
            return Err(error("the stream ends too soon"));
        }
        positions.push(p);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn keys_and_points_are_one_to_one(p in proptest::array::uniform3(0..1_i32 << BITS)) {
            prop_assert_eq!(point(key(p)), p);
        }
    }
}
