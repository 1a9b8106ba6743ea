//! Work on several cores, with the same results for any number of them.
//!
//! The only file that knows of threads: without the feature `parallel` the same calls run in order.

/// `f(0), f(1), … f(n − 1)`, in that order, computed in any order.
pub(crate) fn map<T: Send>(n: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        (0..n).into_par_iter().map(f).collect()
    }
    #[cfg(not(feature = "parallel"))]
    (0..n).map(f).collect()
}

/// Both results, computed side by side.
pub(crate) fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    #[cfg(feature = "parallel")]
    {
        rayon::join(a, b)
    }
    #[cfg(not(feature = "parallel"))]
    (a(), b())
}

/// Runs `f` with at most `threads` threads (0: as many as there are cores). Results do not depend on the number.
///
/// Without the feature `parallel`, just runs `f`.
///
/// # Errors
/// If the operating system refuses to start threads.
pub fn with_threads<T: Send>(threads: usize, f: impl FnOnce() -> T + Send) -> crate::error::Result<T> {
    #[cfg(feature = "parallel")]
    {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        Ok(pool.map_err(std::io::Error::other)?.install(f))
    }
    #[cfg(not(feature = "parallel"))]
    {
        let _ = threads;
        Ok(f())
    }
}
