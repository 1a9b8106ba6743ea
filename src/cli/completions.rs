//! `gimc completions SHELL`

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{Cli, Outcome, output};

/// Print a script that completes commands and flags in a shell.
#[derive(Debug, Args)]
pub(super) struct Completions {
    /// For which shell.
    shell: Shell,
}

impl Completions {
    pub(super) fn run(self) -> Outcome {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "gimc", &mut script);
        output::write("-".as_ref(), |out| Ok(out.write_all(&script)?))?;
        Ok(std::process::ExitCode::SUCCESS)
    }
}
