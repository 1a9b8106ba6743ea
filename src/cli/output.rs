//! Writing files whole or not at all.
//!
//! Output goes to a temporary file beside the target, which is renamed when it is complete. What stood there before is
//! replaced only then. Devices and pipes are written directly.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::failure::Failure;

/// How an output argument is called in messages.
pub(super) fn name(file: &Path) -> String {
    if is_stdout(file) { "stdout".into() } else { file.display().to_string() }
}

/// Whether the argument stands for stdout.
pub(super) fn is_stdout(file: &Path) -> bool {
    file == Path::new("-")
}

/// Lets `fill` write what goes to `file`.
pub(super) fn write<T>(file: &Path, fill: impl FnOnce(&mut dyn Write) -> gimc::Result<T>) -> Result<T, Failure> {
    attempt(file, fill).map_err(|e| Failure::in_file(&name(file), e))
}

/// The same for callers that name the file themselves.
pub(super) fn attempt<T>(file: &Path, fill: impl FnOnce(&mut dyn Write) -> gimc::Result<T>) -> gimc::Result<T> {
    if is_stdout(file) {
        return direct(io::stdout().lock(), fill);
    }
    // A link stays a link: what it points to is replaced.
    let target = fs::canonicalize(file).unwrap_or_else(|_| file.to_owned());
    let before = fs::metadata(&target).ok();
    if before.as_ref().is_some_and(|m| !m.is_file() && !m.is_dir()) {
        return direct(OpenOptions::new().write(true).open(&target)?, fill);
    }
    if before.as_ref().is_some_and(fs::Metadata::is_dir) {
        return Err(io::Error::from(io::ErrorKind::IsADirectory).into());
    }
    let temporary = Temporary::beside(&target)?;
    let result = direct(&temporary.file, fill)?;
    if let Some(before) = before {
        temporary.file.set_permissions(before.permissions())?;
    }
    temporary.become_file(&target)?;
    Ok(result)
}

fn direct<T>(out: impl Write, fill: impl FnOnce(&mut dyn Write) -> gimc::Result<T>) -> gimc::Result<T> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let result = fill(&mut out)?;
    out.flush()?;
    Ok(result)
}

/// Prints a result on stdout.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    write(Path::new("-"), |out| Ok(out.write_all(text.as_bytes())?))
}

/// A file that disappears unless it becomes the target.
struct Temporary {
    file: File,
    path: PathBuf,
    keep: bool,
}

impl Temporary {
    fn beside(target: &Path) -> io::Result<Self> {
        let name = target.file_name().ok_or(io::ErrorKind::InvalidInput)?.to_string_lossy();
        // Another process has another number; a file left by a dead one is passed over.
        for attempt in 0.. {
            let path = target.with_file_name(format!(".{name}.{}-{attempt}.tmp", std::process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok(Self { file, path, keep: false }),
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists && attempt < 100 => {}
                Err(e) => return Err(e),
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    fn become_file(mut self, target: &Path) -> io::Result<()> {
        fs::rename(&self.path, target)?;
        self.keep = true;
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.keep {
            // Nothing more can be done if it cannot be removed.
            let _ = fs::remove_file(&self.path);
        }
    }
}
