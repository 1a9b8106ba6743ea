//! `gimc inspect MESH`: the doctor.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use gimc::eval::Json;
use gimc::{Format, Inspection};

use super::failure::Failure;
use super::table::{Table, point, thousands};
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
        let found = self.common.run("inspecting", |_| mesh.inspect()).map_err(|e| Failure::in_file(&file, e))?;
        output::print(&if self.common.json { json(&found) } else { text(&found) })?;
        Ok(ExitCode::SUCCESS)
    }
}

fn json(found: &Inspection) -> String {
    let count = |n: Option<usize>| n.map_or(Json::Null, Json::from);
    let json = Json::object([
        ("vertices", found.vertices.into()),
        ("faces", found.faces.into()),
        ("edges", found.edges.into()),
        ("polygons", Json::object(found.polygons.iter().map(|&(corners, faces)| (corners.to_string(), faces.into())))),
        ("components", found.components.into()),
        ("boundary_loops", count(found.boundary_loops)),
        ("boundary_edges", found.boundary_edges.into()),
        ("genus", count(found.genus)),
        ("manifold", found.is_manifold().into()),
        ("closed", found.is_closed().into()),
        ("non_manifold_edges", found.non_manifold_edges.into()),
        ("non_manifold_vertices", found.non_manifold_vertices.into()),
        ("flipped_edges", found.flipped_edges.into()),
        ("degenerate_faces", found.degenerate_faces.into()),
        ("duplicate_faces", found.duplicate_faces.into()),
        ("flat_faces", found.flat_faces.into()),
        ("isolated_vertices", found.isolated_vertices.into()),
        ("duplicate_positions", found.duplicate_positions.into()),
        ("non_finite_vertices", found.non_finite_vertices.into()),
        ("box", found.bounds.map_or(Json::Null, |b| Json::list(b.map(Json::list)))),
        ("cgim", found.obstacle.map_or_else(|| true.into(), |why| why.to_string().as_str().into())),
    ]);
    format!("{json}\n")
}

/// `1 edge`, `2 edges`.
fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{} {}", thousands(n as u64), if n == 1 { one } else { many })
}

fn text(found: &Inspection) -> String {
    let mut table = Table::default();
    table.row("vertices", thousands(found.vertices as u64));
    let kinds = kinds(&found.polygons);
    table.row("faces", format!("{}{kinds}", thousands(found.faces as u64)));
    table.row("edges", thousands(found.edges as u64));
    table.row("components", thousands(found.components as u64));
    let unknown = "not defined here: see below".to_owned();
    let count = |n: Option<usize>| n.map_or(unknown.clone(), |n| thousands(n as u64));
    table.row("boundary loops", count(found.boundary_loops));
    table.row("genus", count(found.genus));
    if let Some([low, high]) = found.bounds {
        table.row("box", format!("{}  to  {}", point(low), point(high)));
    }
    let faults = [
        (found.non_manifold_edges, "edge has", "edges have", "more than two faces"),
        (found.non_manifold_vertices, "vertex joins", "vertices join", "several fans of faces"),
        (
            found.flipped_edges,
            "edge is",
            "edges are",
            "walked twice in the same direction: the faces disagree about the outside",
        ),
        (found.degenerate_faces, "face has", "faces have", "fewer than three different corners"),
        (found.duplicate_faces, "face has", "faces have", "the same vertices as an earlier face"),
        (found.flat_faces, "face has", "faces have", "no area"),
        (found.isolated_vertices, "vertex is", "vertices are", "used by no face"),
        (found.duplicate_positions, "vertex is", "vertices are", "at the same place as an earlier vertex"),
        (found.non_finite_vertices, "vertex has", "vertices have", "a coordinate that is not a finite number"),
    ];
    let mut text = table.to_string();
    text.push('\n');
    let before = text.len();
    for (n, one, many, what) in faults.into_iter().filter(|f| f.0 > 0) {
        text.push_str(&format!("{} {what}\n", counted(n, one, many)));
    }
    if text.len() == before {
        text.push_str("no faults found\n");
    }
    let state = match (found.is_manifold(), found.is_closed()) {
        (_, true) => "a closed oriented manifold",
        (true, false) => "an oriented manifold with boundary",
        _ => "not an oriented manifold",
    };
    text.push_str(&format!("\nThis is {state}.\n"));
    text.push_str(&match found.obstacle {
        None => "Method cgim takes it as it is.\n".to_owned(),
        Some(why) => format!("Method cgim does not take it: {why}.\n"),
    });
    text
}

/// `, 12 triangles, 3 quads, 4 of 5 to 8 corners`; nothing where all are triangles.
fn kinds(polygons: &[(usize, usize)]) -> String {
    if let [] | [(3, _)] = polygons {
        return String::new();
    }
    let of = |range: std::ops::RangeInclusive<usize>| polygons.iter().filter(move |p| range.contains(&p.0));
    let mut text = String::new();
    for (range, name) in [(0..=2, "without area"), (3..=3, "triangles"), (4..=4, "quads"), (5..=usize::MAX, "polygons")] {
        let (faces, most) = of(range).fold((0, 0), |(n, m), p| (n + p.1, m.max(p.0)));
        if faces > 0 {
            text.push_str(&format!(", {} {name}", thousands(faces as u64)));
            if name == "polygons" {
                text.push_str(&format!(" of up to {most} corners"));
            }
        }
    }
    text
}
