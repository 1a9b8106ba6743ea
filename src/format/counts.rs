//! Run counts through the arithmetic coder (spec/format.md, "Run counts").
//!
//! Each count is told by how it differs from the one before it: is it the same, more, and by how much.

#[cfg(feature = "encode")]
use crate::entropy::BitWriter;
use crate::entropy::{BitCoder, BitReader, Numbers};
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::plane::RunCounts;

/// The contexts: rows and columns, each after a small and after a large difference.
const CONTEXTS: usize = 4;

#[cfg(feature = "encode")]
pub(super) fn write(counts: &RunCounts, columns: u32) -> Vec<u8> {
    let mut coder = BitWriter::default();
    let blocks = counts.columns.len() / columns.max(1) as usize;
    let mut budget = Budget::new(crate::Limits::default().memory(u64::MAX).work(u64::MAX));
    let rows = counts.rows.len() as u32;
    let done = code(&mut coder, Some(counts), [rows, columns], blocks, &mut budget);
    debug_assert!(done.is_ok_and(|c| c == *counts), "run counts beyond their image");
    coder.finish()
}

/// The counts of `blocks` blocks with so many rows together and columns.
pub(super) fn read(stream: &[u8], [rows, columns]: [u32; 2], blocks: usize, budget: &mut Budget) -> Result<RunCounts> {
    code(&mut BitReader::new(stream), None, [rows, columns], blocks, budget)
}

fn code<C: BitCoder>(
    coder: &mut C,
    known: Option<&RunCounts>,
    [rows, columns]: [u32; 2],
    blocks: usize,
    budget: &mut Budget,
) -> Result<RunCounts> {
    let mut numbers = Numbers::new(CONTEXTS);
    let mut list = |known: Option<&[u32]>, count: usize, most: u32, context: usize| -> Result<Vec<u32>> {
        let mut counts: Vec<u32> = Vec::new();
        let (mut before, mut large) = (0_i64, 0);
        for k in 0..count {
            if k.is_multiple_of(1024) {
                if coder.is_exhausted() {
                    return Err(Error::malformed(Place::Whole, "the run counts end too soon"));
                }
                budget.reserve(8 * 1024)?;
                budget.spend(8 * 1024)?;
            }
            let difference = known.map_or(0, |c| i64::from(c[k]) - before);
            let folded = if difference < 0 { -2 * difference - 1 } else { 2 * difference };
            let folded = i64::from(numbers.code(coder, folded as u32, 2 * context + large));
            let next = before + if folded % 2 == 1 { -(folded + 1) / 2 } else { folded / 2 };
            let next = u32::try_from(next).ok().filter(|&n| n < most.max(1));
            let next = next.ok_or_else(|| Error::malformed(Place::Whole, format!("run count {k} is beyond {most} pixels")))?;
            large = usize::from(folded > 4);
            before = next.into();
            counts.push(next);
        }
        Ok(counts)
    };
    let of_rows = list(known.map(|c| &c.rows[..]), rows as usize, columns, 0)?;
    let of_columns = list(known.map(|c| &c.columns[..]), (columns as usize).saturating_mul(blocks), rows, 1)?;
    Ok(RunCounts { rows: of_rows, columns: of_columns })
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn counts_come_back(rows in 1_u32..60, columns in 1_u32..60, blocks in 1_usize..3, seed: u32) {
            let mut state = seed;
            let mut below = |n: u32| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                ((u64::from(state) * u64::from(n)) >> 32) as u32
            };
            let counts = RunCounts {
                rows: (0..rows).map(|_| below(columns)).collect(),
                columns: (0..columns as usize * blocks).map(|_| below(rows)).collect(),
            };
            let stream = write(&counts, columns);
            let budget = &mut Budget::new(crate::Limits::default());
            prop_assert_eq!(read(&stream, [rows, columns], blocks, budget).ok(), Some(counts));
        }

        #[test]
        fn any_bytes_are_counts_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..60), rows: u32, columns: u32) {
            let budget = &mut Budget::new(crate::Limits::default().memory(1 << 20).work(1 << 20));
            if let Ok(counts) = read(&bytes, [rows, columns], 2, budget) {
                prop_assert!(counts.rows.iter().all(|&c| c < columns.max(1)));
            }
        }
    }
}
