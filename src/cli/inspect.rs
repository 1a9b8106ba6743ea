//! `gimc inspect MESH`: the doctor.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use gimc::Format;
use gimc::eval::Json;

use super::failure::Failure;
use super::{Common, Outcome, input, output};

/// Say what a mesh is like and what is wrong with it.
#[derive(Debug, Args)]
pub(super) struct Inspect {
    /// The mesh.
    mesh: PathBuf,
    /// The format of the mesh: obj, ply, off, stl, glb [default: by extension or content].
    #[arg(long, value_name = "FORMAT", value_parser = input::format)]
    format: Option<Format>,
    #[command(flatten)]
    common: Common,
}

impl Inspect {
    pub(super) fn run(self) -> Outcome {
        let file = input::name(&self.mesh);
        let (mesh, notes) = input::mesh(&self.mesh, self.format)?;
        self.common.notes(&file, &notes);
        let found = self.common.run("inspecting", |_| Ok(mesh.inspect())).map_err(|e| Failure::in_file(&file, e))?;
        output::print(&if self.common.json { format!("{}\n", Json::from(&found)) } else { found.to_string() })?;
        Ok(ExitCode::SUCCESS)
    }
}
