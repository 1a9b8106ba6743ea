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

/// Calls `f(0)`, `f(1)`, … `f(n − 1)`, begun in that order and at most `jobs` of them at a time.
///
/// Unlike [`map`], for few and long pieces of work that are parallel inside: they share the threads of the caller.
#[cfg(feature = "encode")]
pub(crate) fn side_by_side(jobs: usize, n: usize, f: impl Fn(usize) + Sync) {
    #[cfg(feature = "parallel")]
    if jobs.min(n) > 1 {
        let jobs = jobs.min(n);
        let threads = (rayon::current_num_threads() / jobs).max(1);
        let next = std::sync::atomic::AtomicUsize::new(0);
        let work = || {
            loop {
                let i = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                if i >= n {
                    return;
                }
                f(i);
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..jobs {
                // Where the system gives no pool, the work is done in the common one.
                scope.spawn(|| match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
                    Ok(pool) => pool.install(work),
                    Err(_) => work(),
                });
            }
        });
        return;
    }
    let _ = jobs;
    (0..n).for_each(f);
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
