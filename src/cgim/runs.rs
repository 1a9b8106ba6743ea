//! Runs: maximal stretches of one vertex along a row or a column (CGIM §5.2).
//!
//! The paper stores "the number of different elements" of each row and column beside a lossy image. What a
//! decoder needs is how often the element *changes*: a vertex may leave a column and come back
//! (`spec/readings.md`, runs).

use super::vmatrix::VMatrix;
use crate::plane::{Block, RunCounts};

/// How often the vertex changes along each row, and within each block along each column.
pub(crate) fn run_counts(matrix: &VMatrix, blocks: &[Block]) -> RunCounts {
    let changes = |row: &[u32]| row.windows(2).filter(|w| w[0] != w[1]).count() as u32;
    let mut counts = RunCounts { rows: (0..matrix.rows()).map(|i| changes(matrix.row(i))).collect(), columns: Vec::new() };
    let mut first = 0;
    for block in blocks {
        let end = first + block.rows as usize;
        let mut columns = vec![0; matrix.columns()];
        for i in first + 1..end {
            for (count, (above, below)) in columns.iter_mut().zip(matrix.row(i - 1).iter().zip(matrix.row(i))) {
                *count += u32::from(above != below);
            }
        }
        counts.columns.extend(columns);
        first = end;
    }
    counts
}
