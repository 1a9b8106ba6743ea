//! `gimc inspect MESH...`: the doctor.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use gimc::eval::Json;
use gimc::{Format, Inspection};

use super::failure::Failure;
use super::{Common, Outcome, input, output};

/// Say what a mesh is like and what is wrong with it.
#[derive(Debug, Args)]
pub(super) struct Inspect {
    /// The mesh, or several.
    #[arg(value_name = "MESH", required = true)]
    meshes: Vec<PathBuf>,
    /// The format of the mesh: obj, ply, off, stl, glb [default: by extension or content].
    #[arg(long, value_name = "FORMAT", value_parser = input::format)]
    format: Option<Format>,
    #[command(flatten)]
    common: Common,
}

impl Inspect {
    pub(super) fn run(self) -> Outcome {
        if let [mesh] = &self.meshes[..] {
            let (_, found) = self.inspect(mesh)?;
            output::print(&if self.common.json { format!("{}\n", Json::from(&found)) } else { found.to_string() })?;
            return Ok(ExitCode::SUCCESS);
        }
        // Of several, one that is refused does not keep the others from being seen.
        let mut code = ExitCode::SUCCESS;
        let mut all = Vec::new();
        for mesh in &self.meshes {
            match self.inspect(mesh) {
                Ok((file, found)) if self.common.json => all.push((file, Json::from(&found))),
                Ok((file, found)) => output::print(&format!("{file}\n{found}\n"))?,
                Err(failure) => code = failure.report(),
            }
        }
        if self.common.json {
            output::print(&format!("{}\n", Json::object(all)))?;
        }
        Ok(code)
    }

    fn inspect(&self, mesh: &Path) -> Result<(String, Inspection), Failure> {
        let file = input::name(mesh);
        let (mesh, notes) = input::mesh(mesh, self.format)?;
        self.common.notes(&file, &notes);
        let found = self.common.run("inspecting", |_| Ok(mesh.inspect())).map_err(|e| Failure::in_file(&file, e))?;
        Ok((file, found))
    }
}
