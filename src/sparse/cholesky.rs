//! Symmetric positive definite systems, by Cholesky's factors.

use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{MatMut, Side};

use super::Pattern;
use crate::error::{Error, Result};

/// A pattern of a lower triangle, and in which order its columns are eliminated.
#[derive(Debug)]
pub(crate) struct Cholesky {
    pattern: Pattern,
    symbolic: SymbolicLlt<usize>,
}

impl Cholesky {
    /// Analyses the pattern of a lower triangle with a full diagonal.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub(crate) fn new(pattern: Pattern) -> Result<Self> {
        let symbolic = SymbolicLlt::try_new(view(&pattern), Side::Lower).map_err(|_| failed(0.0))?;
        Ok(Self { pattern, symbolic })
    }

    /// The pattern.
    pub(crate) fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Solves `A x = b` for several right sides, one after the other in `b`; `b` becomes `x`.
    ///
    /// # Errors
    /// If the matrix is not positive definite, or what is found does not solve the system.
    pub(crate) fn solve(&self, values: &[f64], b: &mut [f64]) -> Result<()> {
        let side = self.pattern.side();
        if side == 0 {
            return Ok(());
        }
        let matrix = SparseColMatRef::new(view(&self.pattern), values);
        let factor =
            Llt::try_new_with_symbolic(self.symbolic.clone(), matrix, Side::Lower).map_err(|_| failed(f64::INFINITY))?;
        let given = b.to_vec();
        let columns = b.len() / side;
        let target = MatMut::from_column_major_slice_mut(&mut *b, side, columns);
        faer::linalg::solvers::SolveCore::solve_in_place_with_conj(&factor, faer::Conj::No, target);
        for (x, b) in b.chunks_exact(side).zip(given.chunks_exact(side)) {
            let (residual, scale) = self.pattern.residual(values, x, b, true);
            super::check(WHAT, residual, scale)?;
        }
        Ok(())
    }
}

const WHAT: &str = "a sparse symmetric system";

fn failed(residual: f64) -> Error {
    Error::NoConvergence { what: WHAT, after: 0, residual }
}

pub(super) fn view(pattern: &Pattern) -> SymbolicSparseColMatRef<'_, usize> {
    SymbolicSparseColMatRef::new_checked(pattern.side(), pattern.side(), &pattern.ends, None, &pattern.rows)
}
