//! A progress bar on stderr, where that is a terminal.

use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Not before this: a bar that only flashes helps nobody.
const PATIENCE: Duration = Duration::from_millis(400);
const EVERY: Duration = Duration::from_millis(80);
const WIDTH: usize = 30;

/// The bar of one call.
#[derive(Debug)]
pub(super) struct Bar {
    what: String,
    start: Instant,
    /// When it was last drawn; `None` when no bar is wanted.
    drawn: Option<Mutex<Instant>>,
}

impl Bar {
    pub(super) fn new(what: &str, quiet: bool) -> Self {
        let start = Instant::now();
        let wanted = !quiet && std::io::stderr().is_terminal();
        Self { what: what.to_owned(), start, drawn: wanted.then(|| Mutex::new(start)) }
    }

    /// Shows the share done, 0 to 1.
    pub(super) fn report(&self, share: f64) {
        let Some(Ok(mut drawn)) = self.drawn.as_ref().map(Mutex::try_lock) else { return };
        let now = Instant::now();
        if now - self.start < PATIENCE || now - *drawn < EVERY {
            return;
        }
        *drawn = now;
        let done = (share.clamp(0.0, 1.0) * WIDTH as f64) as usize;
        let bar = format!("{}{}", "#".repeat(done), ".".repeat(WIDTH - done));
        let seconds = (now - self.start).as_secs_f64();
        let left = if share > 0.02 { format!(", {:.0} s left", seconds * (1.0 - share) / share) } else { String::new() };
        // A terminal that has gone is no reason to stop.
        let _ = write!(std::io::stderr(), "\r\x1b[2K{} [{bar}] {:.0} %{left}", self.what, 100.0 * share);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if self.drawn.as_ref().is_some_and(|d| d.lock().is_ok_and(|drawn| *drawn > self.start)) {
            let _ = write!(std::io::stderr(), "\r\x1b[2K");
        }
    }
}
