//! Sparse linear systems: where the entries of a matrix are, and solvers for it.
//!
//! A thin door to `faer`, which no other room names. A [`Pattern`] says once which entries a matrix has; values are then
//! filled in as often as wanted, and what a solver learns from the pattern alone (the order of elimination) is kept.

mod cg;
mod cholesky;
mod general;
mod pattern;
#[cfg(test)]
mod tests;

pub(crate) use cg::{Conjugate, conjugate_gradients};
pub(crate) use cholesky::Cholesky;
pub(crate) use general::General;
pub(crate) use pattern::{NOWHERE, Pattern};

use crate::error::{Error, Result};

/// The greatest `|b − A x|` over the greatest `|b|` that passes for solved.
const SOLVED: f64 = 1e-6;

/// The largest entry of `b − A x` relative to the largest of `b`, for each right side; an error where it is not small.
fn check(what: &'static str, residual: f64, scale: f64) -> Result<()> {
    let relative = residual / scale.max(f64::MIN_POSITIVE);
    if residual == 0.0 || relative <= SOLVED {
        return Ok(());
    }
    Err(Error::NoConvergence { what, after: 1, residual: relative })
}
