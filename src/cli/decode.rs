//! `gimc decode IN MESH`

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use gimc::eval::Json;
use gimc::picture::{VertexImage, grid};
use gimc::{Decoder, Format};

use super::failure::Failure;
use super::table::{number, thousands};
use super::{Common, LimitFlags, Outcome, input, output};

/// Decode a file to a mesh.
#[derive(Debug, Args)]
pub(super) struct Decode {
    /// The file to decode.
    input: PathBuf,
    /// The mesh to make: obj, ply, off, stl or glb by its extension.
    mesh: PathBuf,
    /// Decode the base and so many stages beside it [default: all].
    #[arg(long, value_name = "S")]
    stage: Option<usize>,
    /// Decode a geometry image only to a coarser level: each halves its sides [default: 0, all of it].
    #[arg(long, value_name = "L")]
    level: Option<u8>,
    /// Also write the planes of the image into this folder: positions and normals as PNG; of an image of vertices also its
    /// index, of a geometry image also geometry.exr; several images are numbered.
    #[arg(long, value_name = "DIR")]
    planes: Option<PathBuf>,
    /// The format of the mesh: obj, ply, off, stl, glb [default: by extension; ply on stdout].
    #[arg(long, value_name = "FORMAT", value_parser = input::format)]
    format: Option<Format>,
    #[command(flatten)]
    limits: LimitFlags,
    #[command(flatten)]
    common: Common,
}

impl Decode {
    fn format(&self) -> Result<Format, Failure> {
        let stdout = output::is_stdout(&self.mesh).then_some(Format::Ply);
        self.format.or(stdout).or_else(|| Format::from_path(&self.mesh)).ok_or_else(|| {
            let text = format!("{}: the extension is none of obj, ply, off, stl, glb", self.mesh.display());
            Failure::wrong_use(text, Some("`--format ply` says what to write".into()))
        })
    }

    pub(super) fn run(self) -> Outcome {
        if self.common.json && output::is_stdout(&self.mesh) {
            return Err(Failure::wrong_use("--json and the mesh cannot both go to stdout", None));
        }
        let format = self.format()?;
        let start = Instant::now();
        let bytes = input::bytes(&self.input)?;
        let limits = self.limits.limits();
        let decoded = self.common.run("decoding", |task| {
            let decoder = Decoder::with_limits(&bytes, limits)?.stages(self.stage.unwrap_or(usize::MAX));
            let decoder = decoder.level(self.level.unwrap_or(0));
            if self.planes.is_none() {
                return Ok((decoder.decode_with(task)?, decoder.info().clone(), Vec::new()));
            }
            if decoder.info().method == "gim" {
                let images = decoder.geometry_images_with(task)?;
                let mut pictures = Vec::new();
                for (i, image) in images.iter().enumerate() {
                    // Several are numbered.
                    let name = |name: &str, end: &str| match images.len() {
                        1 => format!("{name}.{end}"),
                        _ => format!("{name}-{}.{end}", i + 1),
                    };
                    pictures.push((name("positions", "png"), grid::points_png(image)?));
                    pictures.push((name("normals", "png"), grid::normals_png(image)?));
                    pictures.push((name("geometry", "exr"), image.to_exr()?));
                }
                return Ok((decoder.decode_with(task)?, decoder.info().clone(), pictures));
            }
            let image = VertexImage::of_file(&decoder, task)?;
            let pictures = vec![
                ("positions.png".to_string(), image.positions_png()?),
                ("normals.png".to_string(), image.normals_png()?),
                ("index.png".to_string(), image.index_png()?),
            ];
            Ok((image.mesh, decoder.info().clone(), pictures))
        });
        let (mesh, info, pictures) = decoded.map_err(|e| Failure::in_file(&input::name(&self.input), e))?;
        if let Some(folder) = &self.planes {
            std::fs::create_dir_all(folder).map_err(|e| Failure::in_file(&folder.display().to_string(), e.into()))?;
            for (name, picture) in &pictures {
                output::write(&folder.join(name), |out| Ok(out.write_all(picture)?))?;
            }
        }
        let notes = output::write(&self.mesh, |out| mesh.write(format, out))?;
        let file = output::name(&self.mesh);
        self.common.notes(&file, &notes);
        let seconds = start.elapsed().as_secs_f64();
        // What the file promises is of all of it.
        let whole = info.bound.is_finite() && self.level.is_none_or(|level| level == 0 || info.levels == 0);
        if self.common.json {
            let json = Json::object([
                ("level", u32::from(self.level.unwrap_or(0).min(info.levels)).into()),
                ("vertices", mesh.positions.len().into()),
                ("faces", mesh.faces.len().into()),
                ("method", info.method.into()),
                ("codec", info.codec.into()),
                ("format", format.name().into()),
                ("bound", if whole { info.bound.into() } else { Json::Null }),
                ("connectivity_exact", info.connectivity_exact.into()),
                ("seconds", seconds.into()),
            ]);
            output::print(&format!("{json}\n"))?;
        } else {
            let (v, f) = (thousands(mesh.positions.len() as u64), thousands(mesh.faces.len() as u64));
            if !info.connectivity_exact && info.method == "cgim" {
                self.common
                    .notes(&file, &["the connectivity is not that of the original: the cluster phase did not find it".into()]);
            }
            let within = if whole { format!("within {}; ", number(info.bound)) } else { String::new() };
            self.common.say(format!("{file}: {v} vertices, {f} faces; {within}{seconds:.2} s"));
        }
        Ok(ExitCode::SUCCESS)
    }
}
