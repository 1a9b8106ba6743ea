//! `gimc verify IN [MESH]`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use gimc::Format;
use gimc::eval::{self, Json, Verification};

use super::failure::Failure;
use super::table::Table;
use super::{Common, LimitFlags, Outcome, input, output};

/// Check a file: structure, checksums, a full decode, and the mesh it gives; with the original, also what the file promises.
#[derive(Debug, Args)]
pub(super) struct Verify {
    /// The file.
    input: PathBuf,
    /// The mesh that it was made from.
    mesh: Option<PathBuf>,
    /// The format of the mesh: obj, ply, off, stl, glb [default: by extension or content].
    #[arg(long, value_name = "FORMAT", value_parser = input::format)]
    format: Option<Format>,
    #[command(flatten)]
    limits: LimitFlags,
    #[command(flatten)]
    common: Common,
}

impl Verify {
    pub(super) fn run(self) -> Outcome {
        let file = input::name(&self.input);
        if self.mesh.as_deref() == Some(&self.input) && file == "stdin" {
            return Err(Failure::wrong_use("only one of the file and the mesh can come from stdin", None));
        }
        let bytes = input::bytes(&self.input)?;
        let original = match &self.mesh {
            Some(mesh) => Some(input::mesh(mesh, self.format)?.0),
            None => None,
        };
        let limits = self.limits.limits();
        let found = self
            .common
            .run("verifying", |task| eval::verify(&bytes, limits, original.as_ref(), task))
            .map_err(|e| Failure::in_file(&file, e))?;
        output::print(&if self.common.json { json(&found) } else { text(&found) })?;
        match found.first_failure() {
            None => Ok(ExitCode::SUCCESS),
            Some((name, why)) => Err(Failure::Refused { text: format!("{file}: {name}: {why}"), hint: None }),
        }
    }
}

fn json(found: &Verification) -> String {
    let checks = found.checks.iter().map(|check| {
        let (passed, said) = match &check.outcome {
            Ok(said) => (true, said),
            Err(said) => (false, said),
        };
        Json::object([("name", check.name.into()), ("passed", passed.into()), ("found", said.as_str().into())])
    });
    format!("{}\n", Json::object([("passed", found.passed().into()), ("checks", Json::list(checks))]))
}

fn text(found: &Verification) -> String {
    let mut table = Table::default();
    for check in &found.checks {
        match &check.outcome {
            Ok(said) => table.row(check.name, format!("ok: {said}")),
            Err(said) => table.row(check.name, format!("FAILED: {said}")),
        }
    }
    table.to_string()
}
