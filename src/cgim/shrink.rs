//! Smaller matrices (CGIM §5.1, Algorithm 2, lines 31–40).
//!
//! The paper removes a row or a column where the edge set stays the same without it. Here the
//! alignment is repeated on the rows that the matrix has, then on its columns, then from the other
//! end of both. No triangle can be lost or won that way, whereas removal guarded by the edge set
//! can turn one over (`spec/readings.md`, removable rows).

use super::align::{Contact, align};
use super::vmatrix::VMatrix;

/// Rounds of the four passes, at most: few save much, many save little more.
const ROUNDS: usize = 12;

/// Takes columns and rows out of the matrix until nothing changes. The triangles stay the same.
pub(crate) fn shrink(mut matrix: VMatrix, contact: Contact) -> VMatrix {
    for round in 0..ROUNDS {
        let before = matrix.entries().len();
        matrix = fewer_columns(&matrix, contact);
        matrix = fewer_columns(&matrix.transposed(), contact).transposed();
        matrix = fewer_columns(&matrix.half_turned(), contact).half_turned();
        matrix = fewer_columns(&matrix.half_turned().transposed(), contact).transposed().half_turned();
        // Less than a hundredth is not worth another round.
        if (before - matrix.entries().len()) * 100 <= before && round > 1 {
            break;
        }
    }
    matrix
}

fn fewer_columns(matrix: &VMatrix, contact: Contact) -> VMatrix {
    align(&matrix.levels(), contact)
}
