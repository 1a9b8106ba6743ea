//! Images of vertices beside Table 1 of the paper: `cargo run --release --example table1 -- [--search N] MESH...`
//!
//! Prints a table in Markdown, as `docs/table1.md` has it: rows × columns of one sweep, of the same sweep with the
//! paper's own alignment and removal of rows and columns, and of the best of N trials; pixels a vertex; seconds.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::time::Instant;

use gimc::{Codec, EncodeOptions, ImageChoices, Mesh};

/// What Table 1 prints for the meshes that have the same numbers of vertices and faces.
const PRINTED: [(&str, [u32; 2], f64); 3] =
    [("foot", [423, 970], 1351.0), ("camel", [475, 897], 1716.0), ("davidhead", [841, 1751], 17280.0)];

fn image(mesh: &Mesh, search: usize, paper: bool) -> Result<([u32; 2], f64), gimc::Error> {
    let mut choices = ImageChoices::default();
    choices.search = search;
    choices.paper = paper;
    let start = Instant::now();
    let file = EncodeOptions::cgim().codec(Codec::Raw).image(choices).encode(mesh)?;
    let size = gimc::Decoder::new(&file)?.info().image.unwrap_or([0; 2]);
    Ok((size, start.elapsed().as_secs_f64()))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut search = 300;
    let mut arguments = std::env::args().skip(1);
    let mut meshes = Vec::new();
    while let Some(argument) = arguments.next() {
        if argument == "--search" {
            search = arguments.next().ok_or("--search needs a number")?.parse()?;
        } else {
            meshes.push(argument);
        }
    }
    println!(
        "| mesh | V | F | paper | seconds | one sweep | as printed | best of {search} | of the paper's area | pixels a vertex | seconds |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let mut density = Vec::new();
    for path in &meshes {
        let mesh = Mesh::open(path)?;
        let name = std::path::Path::new(path).file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let (v, f) = (mesh.positions.len(), mesh.faces.len());
        let (one, _) = image(&mesh, 1, false)?;
        let (printed, _) = image(&mesh, 1, true)?;
        let (best, seconds) = image(&mesh, search, false)?;
        let area = |[rows, columns]: [u32; 2]| f64::from(rows) * f64::from(columns);
        let known = PRINTED.iter().find(|p| p.0 == name);
        let theirs = known.map_or_else(|| "–".into(), |p| format!("{} × {}", p.1[0], p.1[1]));
        let their_seconds = known.map_or_else(|| "–".into(), |p| format!("{:.0}", p.2));
        let share = known.map_or_else(|| "–".into(), |p| format!("{:.2}", area(best) / area(p.1)));
        density.push(area(best) / v as f64);
        let size = |[rows, columns]: [u32; 2]| format!("{rows} × {columns}");
        println!(
            "| {name} | {v} | {f} | {theirs} | {their_seconds} | {} | {} | {} | {share} | {:.1} | {seconds:.1} |",
            size(one),
            size(printed),
            size(best),
            area(best) / v as f64
        );
    }
    println!("\nMean: {:.1} pixels a vertex.", density.iter().sum::<f64>() / density.len().max(1) as f64);
    Ok(())
}
