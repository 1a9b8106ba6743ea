//! Systems that are not symmetric, by LU factors.

use faer::MatMut;
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};

use super::Pattern;
use super::cholesky::view;
use crate::error::{Error, Result};

/// A pattern, and in which order its columns are eliminated.
#[derive(Debug)]
pub(crate) struct General {
    pattern: Pattern,
    symbolic: SymbolicLu<usize>,
}

impl General {
    /// Analyses a pattern with a full diagonal.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub(crate) fn new(pattern: Pattern) -> Result<Self> {
        let symbolic = SymbolicLu::try_new(view(&pattern)).map_err(|_| failed(0.0))?;
        Ok(Self { pattern, symbolic })
    }

    /// The pattern.
    pub(crate) fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Solves `A x = b` for several right sides, one after the other in `b`; `b` becomes `x`.
    ///
    /// # Errors
    /// If the matrix is singular, or what is found does not solve the system.
    pub(crate) fn solve(&self, values: &[f64], b: &mut [f64]) -> Result<()> {
        let side = self.pattern.side();
        if side == 0 {
            return Ok(());
        }
        let matrix = SparseColMatRef::new(view(&self.pattern), values);
        let factor = Lu::try_new_with_symbolic(self.symbolic.clone(), matrix).map_err(|_| failed(f64::INFINITY))?;
        let given = b.to_vec();
        let columns = b.len() / side;
        let target = MatMut::from_column_major_slice_mut(&mut *b, side, columns);
        faer::linalg::solvers::SolveCore::solve_in_place_with_conj(&factor, faer::Conj::No, target);
        for (x, b) in b.chunks_exact(side).zip(given.chunks_exact(side)) {
            let (residual, scale) = self.pattern.residual(values, x, b, false);
            super::check(WHAT, residual, scale)?;
        }
        Ok(())
    }
}

const WHAT: &str = "a sparse system";

fn failed(residual: f64) -> Error {
    Error::NoConvergence { what: WHAT, after: 0, residual }
}
