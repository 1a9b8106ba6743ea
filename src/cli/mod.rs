//! The program `gimc`: a thin skin over the library.
//!
//! One command a file. Results go to stdout, everything else to stderr. Exit codes: 0 done; 1 refused (the mesh, the file, a
//! limit, or a check found what it was told not to find); 2 wrong use.

mod attributes;
mod compare;
mod completions;
mod decode;
mod encode;
mod failure;
mod gim;
mod info;
mod input;
mod inspect;
mod output;
mod progress;
mod resize;
mod roi;
mod sweep;
mod table;
mod verify;
mod view;

use std::process::ExitCode;
use std::time::Duration;

use clap::error::ErrorKind;
use clap::{Args, Parser, Subcommand};
use gimc::{Limits, Task};

use failure::Failure;

/// What a command answers: an exit code, or why not.
type Outcome = Result<ExitCode, Failure>;

/// Store triangle meshes compactly: connectivity exact, positions within a certified bound.
#[derive(Debug, Parser)]
#[command(name = "gimc", version, arg_required_else_help = true, propagate_version = true)]
#[command(after_help = "A FILE may be - for stdin or stdout.\n\
    Exit codes: 0 done; 1 the mesh, the file or a limit was refused, or a check failed; 2 wrong use.")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
#[allow(clippy::large_enum_variant)] // there is one, once
enum Command {
    Encode(Box<encode::Encode>),
    Decode(decode::Decode),
    Info(info::Info),
    Verify(verify::Verify),
    Inspect(inspect::Inspect),
    Compare(compare::Compare),
    View(view::View),
    Resize(resize::Resize),
    Sweep(sweep::Sweep),
    Completions(completions::Completions),
}

/// Flags that every command has.
#[derive(Debug, Clone, Args)]
struct Common {
    /// Print one JSON object on stdout, and nothing else there.
    #[arg(long, help_heading = "Everywhere")]
    json: bool,
    /// No progress, summaries or warnings on stderr; errors stay.
    #[arg(long, short, help_heading = "Everywhere")]
    quiet: bool,
    /// Threads to use at most [default: all cores]. The result does not depend on it.
    #[arg(long, value_name = "N", default_value = "0", hide_default_value = true, help_heading = "Everywhere")]
    threads: usize,
    /// Give up after this many seconds.
    #[arg(long, value_name = "SECONDS", value_parser = positive, help_heading = "Everywhere")]
    deadline: Option<f64>,
}

/// What a decoder may spend.
#[derive(Debug, Clone, Args)]
struct LimitFlags {
    /// Memory to decode with at most, in bytes; K, M and G stand for powers of 1024.
    #[arg(long, value_name = "BYTES", value_parser = amount, help_heading = "Limits")]
    limit_memory: Option<u64>,
    /// Vertices to accept at most.
    #[arg(long, value_name = "N", value_parser = amount, help_heading = "Limits")]
    limit_vertices: Option<u64>,
    /// Steps of work to do at most.
    #[arg(long, value_name = "N", value_parser = amount, help_heading = "Limits")]
    limit_work: Option<u64>,
}

impl LimitFlags {
    fn limits(&self) -> Limits {
        let mut limits = Limits::default();
        limits.memory = self.limit_memory.unwrap_or(limits.memory);
        limits.vertices = self.limit_vertices.unwrap_or(limits.vertices);
        limits.work = self.limit_work.unwrap_or(limits.work);
        limits
    }
}

impl Common {
    /// Runs `f` with the threads, deadline and progress bar asked for.
    fn run<T: Send>(&self, what: &str, f: impl FnOnce(Task<'_>) -> gimc::Result<T> + Send) -> gimc::Result<T> {
        let bar = progress::Bar::new(what, self.quiet);
        let report = |share| bar.report(share);
        let mut task = Task::default().with_progress(&report);
        if let Some(seconds) = self.deadline {
            task = task.with_deadline(Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX));
        }
        gimc::with_threads(self.threads, || f(task))?
    }

    /// Says something beside the result, unless told to be quiet.
    fn say(&self, text: impl AsRef<str>) {
        if !self.quiet {
            eprintln!("{}", text.as_ref());
        }
    }

    fn notes(&self, file: &str, notes: &[String]) {
        notes.iter().for_each(|note| self.say(format!("gimc: {file}: note: {note}")));
    }
}

/// A positive number.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("a positive number is expected".into()),
    }
}

/// A count, such as `1000` or `64M`.
fn amount(text: &str) -> Result<u64, String> {
    let (digits, shift) = match text.char_indices().last() {
        Some((i, 'k' | 'K')) => (&text[..i], 10),
        Some((i, 'm' | 'M')) => (&text[..i], 20),
        Some((i, 'g' | 'G')) => (&text[..i], 30),
        _ => (text, 0),
    };
    let n: u64 = digits.parse().map_err(|_| "a whole number is expected, such as 1000 or 64M")?;
    n.checked_mul(1 << shift).ok_or_else(|| "the number is too large".into())
}

/// Parses, runs, and turns the outcome into an exit code.
pub(crate) fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    let outcome = match cli.command {
        Command::Encode(c) => c.run(),
        Command::Decode(c) => c.run(),
        Command::Info(c) => c.run(),
        Command::Verify(c) => c.run(),
        Command::Inspect(c) => c.run(),
        Command::Compare(c) => c.run(),
        Command::View(c) => c.run(),
        Command::Resize(c) => c.run(),
        Command::Sweep(c) => c.run(),
        Command::Completions(c) => c.run(),
    };
    outcome.unwrap_or_else(|failure| failure.report())
}

/// Help goes to stdout; a wrong use is one line, and a hint.
fn usage(error: &clap::Error) -> ExitCode {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            // A closed pipe is no failure.
            let _ = error.print();
            ExitCode::SUCCESS
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = error.print();
            ExitCode::from(2)
        }
        _ => misuse(error).report(),
    }
}

/// What the parser of arguments found.
fn misuse(error: &clap::Error) -> Failure {
    let text = error.render().to_string();
    let mut lines = text.lines().map(str::trim).filter(|l| !l.is_empty());
    let first = lines.next().unwrap_or("wrong use").trim_start_matches("error: ");
    let usage = text.lines().find_map(|l| l.trim().strip_prefix("Usage: "));
    // Some first lines announce a list: of missing arguments, or of possible values.
    let after = text.lines().skip(1).map(str::trim).take_while(|l| !l.is_empty());
    let listed: Vec<&str> = after.filter(|l| first.ends_with(':') || l.starts_with("[possible values")).collect();
    let listed = listed.join(", ");
    let hint = usage.map(|usage| {
        match text.lines().find_map(|l| l.trim().strip_prefix("tip: ")).filter(|t| !t.contains("as a value")) {
            Some(tip) => format!("{tip}; usage: {usage}"),
            None => format!("usage: {usage}"),
        }
    });
    Failure::Use { text: format!("{first} {listed}").trim().to_owned(), hint }
}
