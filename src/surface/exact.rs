//! Coordinates bit by bit (spec/any-mesh.md, "EXAC"): which float is meant, where the lattice point is known.
//!
//! Floats are told as integers that rise with them, so a lattice cell holds a range of integers, few far from 0 and many
//! near it. Meshes made by programs repeat coordinates: the float that was met last in the same column of the lattice is asked for first.

use std::collections::HashMap;

use super::attributes::form::{from_ordered, to_ordered};
use crate::entropy::{AdaptiveBit, BitCoder, BitReader};
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::mesh::Scalar;

/// Bytes of memory and steps that reading takes, a vertex.
pub(crate) const BYTES_A_VERTEX: u64 = 24 + 3 * 48;
pub(crate) const STEPS_A_VERTEX: u64 = 3 * 80;

/// Writes the floats of vertices that are near the places `near`.
#[cfg(feature = "encode")]
pub(crate) fn write(near: &[[f64; 3]], exact: impl Fn(usize) -> [f64; 3], scalar: Scalar) -> Result<Vec<u8>> {
    let mut coder = crate::entropy::BitWriter::default();
    code(&mut coder, near, exact, scalar)?;
    Ok(coder.finish())
}

/// Reads what [`write`] wrote.
pub(crate) fn read(bytes: &[u8], near: &[[f64; 3]], scalar: Scalar, budget: &mut Budget) -> Result<Vec<[f64; 3]>> {
    budget.reserve(near.len() as u64 * BYTES_A_VERTEX)?;
    budget.spend(near.len() as u64 * STEPS_A_VERTEX)?;
    code(&mut BitReader::new(bytes), near, |_| [0.0; 3], scalar)
}

fn error(why: &str) -> Error {
    Error::malformed(Place::Chunk(*b"EXAC", 0), format!("exact coordinates: {why}"))
}

fn code<C: BitCoder>(
    coder: &mut C,
    near: &[[f64; 3]],
    exact: impl Fn(usize) -> [f64; 3],
    scalar: Scalar,
) -> Result<Vec<[f64; 3]>> {
    let mut columns: [HashMap<i64, i64>; 3] = Default::default();
    let mut repeats = [[AdaptiveBit::default(); 4]; 3];
    let mut lately = [0_usize; 3];
    let mut offsets = Offsets::default();
    let mut positions = Vec::with_capacity(near.len());
    for (v, near) in near.iter().enumerate() {
        let wanted = if C::WRITES { exact(v) } else { [0.0; 3] };
        let mut position = [0.0; 3];
        for axis in 0..3 {
            let (column, wanted) = (to_ordered(near[axis], scalar), to_ordered(wanted[axis], scalar));
            let last = columns[axis].get(&column).copied();
            let mut number = None;
            if let Some(last) = last {
                let repeats = repeats[axis][lately[axis]].code(coder, last == wanted);
                lately[axis] = (2 * lately[axis] + usize::from(repeats)) & 3;
                number = repeats.then_some(last);
            }
            let number = match number {
                Some(number) => number,
                None => column.wrapping_add(offsets.code(coder, wanted.wrapping_sub(column), axis)),
            };
            columns[axis].insert(column, number);
            position[axis] = from_ordered(number, scalar);
            if !position[axis].is_finite() {
                return Err(error("a coordinate that is not a finite number"));
            }
        }
        positions.push(position);
        if coder.is_exhausted() {
            return Err(error("the stream ends too soon"));
        }
    }
    Ok(positions)
}

/// Offsets from the float of a lattice point: sign, and length in bits, by axis and the length before; three bits more; the rest as
/// it is.
#[derive(Debug)]
struct Offsets {
    length: Vec<AdaptiveBit>,
    high: Vec<AdaptiveBit>,
    sign: [AdaptiveBit; 3],
    before: [usize; 3],
}

impl Default for Offsets {
    fn default() -> Self {
        Self {
            length: vec![AdaptiveBit::default(); 3 * 65 * 65],
            high: vec![AdaptiveBit::default(); 65 * 8],
            sign: Default::default(),
            before: [0; 3],
        }
    }
}

impl Offsets {
    fn code<C: BitCoder>(&mut self, coder: &mut C, offset: i64, axis: usize) -> i64 {
        let wanted = offset.unsigned_abs();
        let wanted_length = 64 - wanted.leading_zeros() as usize;
        let row = (axis * 65 + self.before[axis]) * 65;
        // From the length before on: first whether it is longer.
        let mut length = 0;
        while length < 64 && self.length[row + length].code(coder, length < wanted_length) {
            length += 1;
        }
        self.before[axis] = length;
        if length == 0 {
            return 0;
        }
        let is_negative = self.sign[axis].code(coder, offset < 0);
        let mut value = 1_u64;
        let mut left = length as u32 - 1;
        let mut node = 1;
        while left > 0 && node < 8 {
            left -= 1;
            let bit = self.high[length * 8 + node].code(coder, wanted >> left & 1 != 0);
            node = 2 * node + usize::from(bit);
            value = value << 1 | u64::from(bit);
        }
        while left > 0 {
            let some = left.min(16);
            left -= some;
            value = value << some | u64::from(coder.raw((wanted >> left & ((1 << some) - 1)) as u32, some));
        }
        if is_negative { (value as i64).wrapping_neg() } else { value as i64 }
    }
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;

    #[test]
    fn any_finite_floats_come_back_bit_by_bit_from_any_lattice_point() {
        let odd =
            [0.0, -0.0, f64::from(f32::from_bits(1)), f64::from(-1e-30_f32), f64::from(f32::MAX), 1.5, f64::from(0.1_f32), 1.5];
        let exact: Vec<[f64; 3]> = (0..odd.len()).map(|i| [odd[i], odd[(i * 3) % 8], odd[(i * 5) % 8]]).collect();
        let close: Vec<[f64; 3]> = exact.iter().map(|p| p.map(|x| f64::from((x * 0.99) as f32))).collect();
        for near in [vec![[0.0; 3]; 8], close] {
            for (scalar, scale) in [(Scalar::F32, 1.0), (Scalar::F64, 1.0 / 3.0)] {
                let exact = |v: usize| exact[v].map(|x| x * scale);
                let bytes = write(&near, exact, scalar).unwrap();
                let back = read(&bytes, &near, scalar, &mut Budget::new(crate::Limits::default())).unwrap();
                for (v, p) in back.iter().enumerate() {
                    assert_eq!(p.map(f64::to_bits), exact(v).map(f64::to_bits));
                }
            }
        }
    }
}
