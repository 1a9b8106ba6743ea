//! Failures as one line on stderr, a hint where there is one, and an exit code.

use std::io;
use std::process::ExitCode;

use gimc::Error;

/// Why a command did not do what it was asked.
#[derive(Debug)]
pub(super) enum Failure {
    /// The mesh, the file or a limit was refused: exit code 1.
    Refused {
        /// The file and what was found.
        text: String,
        /// What might help.
        hint: Option<String>,
    },
    /// The command was called wrongly: exit code 2.
    Use {
        /// What was found and what was expected.
        text: String,
        /// What might help.
        hint: Option<String>,
    },
    /// Whoever read our output has gone, which is no fault of ours.
    ReaderGone,
}

impl Failure {
    /// An error that happened in `file`.
    pub(super) fn in_file(file: &str, error: Error) -> Self {
        let hint = error.hint().map(|hint| hint.replace("MESH", file));
        let error = match error {
            Error::InFile { source, .. } => *source,
            other => other,
        };
        let text = match &error {
            Error::Io(e) if e.kind() == io::ErrorKind::BrokenPipe && file == "stdout" => return Self::ReaderGone,
            Error::Io(e) => said(e),
            Error::Cancelled => "stopped: the deadline passed".into(),
            other => other.to_string(),
        };
        Self::Refused { text: format!("{file}: {text}"), hint }
    }

    /// A wrong use.
    pub(super) fn wrong_use(text: impl Into<String>, hint: Option<String>) -> Self {
        Self::Use { text: text.into(), hint }
    }

    /// Prints the failure and gives its exit code.
    pub(super) fn report(self) -> ExitCode {
        let (code, text, hint) = match self {
            Self::Refused { text, hint } => (1, text, hint),
            Self::Use { text, hint } => (2, text, hint),
            Self::ReaderGone => return ExitCode::SUCCESS,
        };
        // A line break in a file name must not break the line.
        eprintln!("gimc: {}", text.replace(['\n', '\r'], " "));
        if let Some(hint) = hint {
            eprintln!("hint: {hint}");
        }
        ExitCode::from(code)
    }
}

/// What the operating system said, without its number.
fn said(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        _ => {
            let text = error.to_string();
            text.split(" (os error").next().unwrap_or(&text).to_lowercase()
        }
    }
}
