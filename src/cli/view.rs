//! `gimc view IN OUT.png`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use gimc::picture::{Camera, VertexImage, grid, resize, shade};
use gimc::{Decoder, GeometryImage, ResizeOptions};

use super::failure::Failure;
use super::{Common, LimitFlags, Outcome, input, output};

/// Make a picture of what a file holds.
///
/// Of a mesh file there is only the shaded view. To a .jp2 or .j2k file goes the JPEG 2000 picture itself.
#[derive(Debug, Args)]
pub(super) struct View {
    /// A file, or a mesh.
    input: PathBuf,
    /// The picture to make: PNG; or .jp2 or .j2k, the stream of a file of the codec j2k.
    out: PathBuf,
    /// What to show.
    #[arg(long, value_enum, default_value = "mesh")]
    what: What,
    /// Pixels of the shaded view.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "800x600")]
    size: (u32, u32),
    /// From where: turned about the upright axis, and raised above the horizon, in degrees.
    #[arg(long, value_name = "AZ,EL", value_parser = camera, allow_hyphen_values = true, default_value = "30,20")]
    camera: (f64, f64),
    /// Of a geometry image only a coarser level: each halves its sides.
    #[arg(long, value_name = "L")]
    level: Option<u8>,
    /// Of a file of several geometry images, which one [default: the largest].
    #[arg(long, value_name = "N")]
    chart: Option<usize>,
    /// Of a warp: the columns and rows of its target [default: half the sides].
    #[arg(long, value_name = "WxH", value_parser = size)]
    to: Option<(u32, u32)>,
    #[command(flatten)]
    limits: LimitFlags,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// The positions: red, green and blue are x, y and z.
    Geometry,
    /// The normals.
    Normals,
    /// Every vertex in a colour of its own; white where a cut doubled it.
    Index,
    /// Of a geometry image, how much the surface changes from sample to sample: what `resize` keeps.
    Saliency,
    /// Of a geometry image, its normals, black away from the region of interest; such a picture is a region for `encode --roi`.
    Roi,
    /// Of a geometry image, its grid as `resize` warps it to the size of --to.
    Warp,
    /// A shaded view of the mesh.
    Mesh,
}

/// `800x600`.
fn size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    sides
        .filter(|&(w, h)| (1..=16384).contains(&w) && (1..=16384).contains(&h))
        .ok_or_else(|| "two whole numbers up to 16384 are expected, with an x between, such as 800x600".into())
}

/// `30,20`.
fn camera(text: &str) -> Result<(f64, f64), String> {
    let angles = text.split_once(',').and_then(|(a, e)| Some((a.trim().parse().ok()?, e.trim().parse().ok()?)));
    angles
        .filter(|&(a, e): &(f64, f64)| a.is_finite() && e.is_finite())
        .ok_or_else(|| "two angles in degrees are expected, such as 30,20".into())
}

impl View {
    pub(super) fn run(self) -> Outcome {
        let file = input::name(&self.input);
        let bytes = input::bytes(&self.input)?;
        let is_mesh = !bytes.starts_with(b"gimc");
        if self.to.is_some() && self.what != What::Warp {
            return Err(Failure::wrong_use(
                "--to is the target of --what warp",
                Some("--size is that of the shaded view".into()),
            ));
        }
        if is_mesh && self.what != What::Mesh {
            return Err(Failure::wrong_use(
                format!("{file} is not a gimc file, and only those hold an image"),
                Some("`--what mesh` shows the mesh".into()),
            ));
        }
        let extension = self.out.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        let limits = self.limits.limits();
        if let Some(wrapped @ ("jp2" | "j2k" | "jpc")) = extension.as_deref() {
            let stream = self.common.run("reading", |_| {
                let decoder = Decoder::with_limits(&bytes, limits)?;
                if wrapped == "jp2" { decoder.jp2() } else { Ok(decoder.codestream()?.to_vec()) }
            });
            let stream = stream.map_err(|e| Failure::in_file(&file, e))?;
            output::write(&self.out, |out| Ok(out.write_all(&stream)?))?;
            return Ok(ExitCode::SUCCESS);
        }
        let (azimuth, elevation) = self.camera;
        let shaded = |mesh: &gimc::Mesh| shade(mesh, self.size.0, self.size.1, Camera { azimuth, elevation });
        let picture = if is_mesh {
            self.common.run("drawing", |_| {
                let mesh = gimc::Mesh::read(&bytes, gimc::Format::from_path(&self.input))?.mesh;
                mesh.check()?;
                shaded(&mesh)
            })
        } else {
            self.common.run("drawing", |task| {
                let decoder = Decoder::with_limits(&bytes, limits)?.level(self.level.unwrap_or(0));
                if self.what == What::Mesh {
                    return shaded(&decoder.decode_with(task)?);
                }
                if decoder.info().method == "gim" {
                    if self.what == What::Roi {
                        let regions = decoder.roi_samples()?;
                        let images = decoder.level(0).geometry_images_with(task)?;
                        let (image, inside) =
                            chosen(images.into_iter().zip(regions).collect(), self.chart, |(image, _)| image)?;
                        return grid::roi_png(&image, &inside);
                    }
                    let image = chosen(decoder.geometry_images_with(task)?, self.chart, |image| image)?;
                    return match self.what {
                        What::Normals => grid::normals_png(&image),
                        What::Saliency => resize::saliency_png(&image, &ResizeOptions::default()),
                        What::Warp => {
                            let half = gimc::eval::scaled_size(&image, 0.5);
                            let [width, height] = self.to.map_or(half, |(w, h)| [w as usize, h as usize]);
                            resize::warp_png(&image, &ResizeOptions::default(), width, height, task)
                        }
                        What::Index => Err(gimc::Error::Parameter(
                            "a geometry image has no index plane: every sample is a vertex of its own".into(),
                        )),
                        _ => grid::points_png(&image),
                    };
                }
                if matches!(self.what, What::Saliency | What::Warp | What::Roi) {
                    // Says that there is none.
                    decoder.geometry_image_with(task)?;
                }
                let image = VertexImage::of_file(&decoder, task)?;
                match self.what {
                    What::Geometry => image.positions_png(),
                    What::Normals => image.normals_png(),
                    _ => image.index_png(),
                }
            })
        };
        let picture = picture.map_err(|e| Failure::in_file(&file, e))?;
        output::write(&self.out, |out| Ok(out.write_all(&picture)?))?;
        Ok(ExitCode::SUCCESS)
    }
}

/// The image of a number, or the largest.
fn chosen<T>(mut images: Vec<T>, number: Option<usize>, image: impl Fn(&T) -> &GeometryImage) -> gimc::Result<T> {
    let count = images.len();
    let largest = (0..count).rev().max_by_key(|&i| image(&images[i]).points().len());
    match number.map_or(largest, |n| n.checked_sub(1)).filter(|&i| i < count) {
        Some(i) => Ok(images.swap_remove(i)),
        None => Err(gimc::Error::Parameter(format!("the file holds {count} geometry images; --chart counts from 1"))),
    }
}
