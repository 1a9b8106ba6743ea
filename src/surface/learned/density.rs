//! Logistic densities as experts: what a guess of centre and width says about one binary decision.

use super::math::{exp, ln};

/// The width of a logistic density of standard deviation 1 (√3 / π).
pub(super) const SCALE: f64 = 0.551_3;

/// A logistic density.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Logistic {
    pub(super) centre: f64,
    pub(super) width: f64,
}

/// The largest log-odds that an expert claims.
const SUREST: f64 = 12.0;

impl Logistic {
    /// The chance of a value beyond `edge`: above it, or below it where `up` is −1.
    #[inline]
    pub(super) fn beyond(&self, edge: f64, up: f64) -> f64 {
        1.0 / (1.0 + exp(up * (edge - self.centre) / self.width))
    }
}

/// The log-odds of two chances, in 256ths.
#[inline]
pub(super) fn log_odds(yes: f64, no: f64) -> i32 {
    let odds = ln(yes.max(1e-300)) - ln(no.max(1e-300));
    (odds.clamp(-SUREST, SUREST) * 256.0).floor() as i32
}
