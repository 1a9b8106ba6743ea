//! Watching and stopping a long call.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::error::{Error, Result};

/// Progress, cancel flag and deadline of one call, handed down by value.
///
/// The outer loops of long calls ask it; the default asks for nothing and never stops.
#[derive(Clone, Copy, Default)]
pub struct Task<'a> {
    progress: Option<&'a (dyn Fn(f64) + Sync)>,
    cancel: Option<&'a AtomicBool>,
    deadline: Option<Instant>,
}

impl<'a> Task<'a> {
    /// Calls `report` now and then with the share done, 0 to 1.
    pub fn with_progress(mut self, report: &'a (dyn Fn(f64) + Sync)) -> Self {
        self.progress = Some(report);
        self
    }

    /// Stops with [`Error::Cancelled`] soon after `flag` becomes true.
    pub fn with_cancel(mut self, flag: &'a AtomicBool) -> Self {
        self.cancel = Some(flag);
        self
    }

    /// Ends searches early, and stops everything else with [`Error::Cancelled`], after `time` from now.
    pub fn with_deadline(mut self, time: Duration) -> Self {
        self.deadline = Instant::now().checked_add(time);
        self
    }

    /// The same task for a part of the work, whose shares are not the whole's.
    #[cfg(feature = "encode")]
    pub(crate) fn without_progress(&self) -> Self {
        Self { progress: None, ..*self }
    }

    /// Says that `share` (0 to 1) is done; an error if the caller wants no more.
    pub(crate) fn step(&self, share: f64) -> Result<()> {
        if let Some(report) = self.progress {
            report(share);
        }
        if self.is_over() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Whether the caller wants no more.
    pub fn is_over(&self) -> bool {
        self.cancel.is_some_and(|flag| flag.load(Ordering::Relaxed)) || self.deadline.is_some_and(|end| Instant::now() >= end)
    }
}

impl std::fmt::Debug for Task<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Task").field("cancel", &self.cancel).field("deadline", &self.deadline).finish_non_exhaustive()
    }
}
