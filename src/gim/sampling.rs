//! Where in the square samples are taken.

/// How samples are spread over the square.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Sampling {
    /// At equal distances.
    #[default]
    Regular,
}

/// `n` lines at equal distances from 0 to 1.
pub(super) fn regular(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64 / (n - 1) as f64).collect()
}
