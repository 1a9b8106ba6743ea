//! `gimc resize IN OUT`

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::{ArgGroup, Args, ValueEnum};
use gimc::eval::{self, Json};
use gimc::{Codec, Decoder, EncodeOptions, Encoded, GeometryImage, GimChoices, Mesh, ResizeMethod, ResizeOptions, Resized};

use super::failure::Failure;
use super::table::{number, thousands};
use super::{Common, LimitFlags, Outcome, input, output, positive};

/// Make a geometry image smaller or larger, keeping what matters (content-aware), or as the usual methods do.
///
/// The input is a file that holds a geometry image, or a mesh that becomes one first: a disk or a closed surface of genus 0.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("target").required(true).args(["to", "psnr", "lod", "metro"]))]
pub(super) struct Resize {
    /// A file with a geometry image, or a mesh.
    input: PathBuf,
    /// The file to make; with --metro a CSV file, and a picture beside it.
    out: PathBuf,
    /// Columns and rows of the result, such as 80x80.
    #[arg(long, value_name = "WxH", value_parser = size, help_heading = "Target")]
    to: Option<[usize; 2]>,
    /// The smallest size whose surface reaches this psnr against the input's, in dB.
    #[arg(long, value_name = "DB", value_parser = positive, help_heading = "Target")]
    psnr: Option<f64>,
    /// One file for each share of the sides, such as 0.5,0.25,0.125; OUT-WxH.gimc are their names.
    #[arg(long, value_name = "LIST", value_parser = positive, value_delimiter = ',', help_heading = "Target")]
    lod: Vec<f64>,
    /// Measure every method at these shares of the sides as METRO does, and write a table (CSV) and a picture (SVG).
    #[arg(long, value_name = "LIST", value_parser = positive, value_delimiter = ',', num_args = 0..=1,
        default_missing_value = "0.8,0.6,0.4,0.3,0.2", help_heading = "Target")]
    metro: Vec<f64>,
    /// How.
    #[arg(long, value_enum, default_value = "content")]
    by: By,
    /// The share of the positions in the saliency, against that of the normals, 0 to 1 [default: 0.4; 0.5 for baselines and as
    /// printed].
    #[arg(long, value_name = "A")]
    alpha: Option<f64>,
    /// content: also end a step where as many samples are left as have more saliency than this (equation 6).
    #[arg(long, value_name = "L")]
    lambda: Option<f64>,
    /// content: in so many steps [default: as many as a limit of 20 % a step needs].
    #[arg(long, value_name = "N")]
    steps: Option<usize>,
    /// As the paper is printed: no limit of a step, folds and all.
    #[arg(long)]
    literal: bool,
    /// Of a mesh: samples a side of the image that is made first [default: 65 to 1025, about four samples a vertex].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=16384), help_heading = "The files")]
    grid: Option<u32>,
    /// How the result is stored.
    #[arg(long, value_enum, default_value = "wavelet", help_heading = "The files")]
    codec: StoredBy,
    /// How exactly: a step of the longest side of the box / (2^Q - 1).
    #[arg(long, value_name = "Q", value_parser = clap::value_parser!(u32).range(1..=24), default_value = "16",
        help_heading = "The files")]
    bits: u32,
    #[command(flatten)]
    limits: LimitFlags,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum By {
    /// What matters keeps its samples (paper 004).
    Content,
    /// Even places, cubic between samples (regular down-sampling, RDS).
    #[value(alias = "rds")]
    Bicubic,
    /// Even places, linear between samples.
    Bilinear,
    /// Even places, the nearest sample.
    Nearest,
    /// Seam carving (SC).
    Seam,
    /// One warp, samples averaged (VR).
    Direct,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum StoredBy {
    /// Wavelet coefficients: the smallest files.
    Wavelet,
    /// A JPEG 2000 codestream.
    J2k,
    /// Planes without compression.
    Raw,
    /// An OpenEXR picture.
    Exr,
}

/// `80x80`, or `80` for a square.
fn size(text: &str) -> Result<[usize; 2], String> {
    let (width, height) = text.split_once(['x', 'X']).unwrap_or((text, text));
    match (width.parse(), height.parse()) {
        (Ok(width), Ok(height)) => Ok([width, height]),
        _ => Err("two whole numbers with an x between are expected, such as 80x60".into()),
    }
}

/// What is resized, and what the result is measured against.
struct Source {
    image: GeometryImage,
    original: Mesh,
    history: String,
}

/// A result on its way to its file.
struct Made {
    path: PathBuf,
    resized: Resized,
    encoded: Encoded,
}

impl Resize {
    pub(super) fn run(self) -> Outcome {
        if self.common.json && output::is_stdout(&self.out) {
            return Err(Failure::wrong_use("--json and the file cannot both go to stdout", None));
        }
        if output::is_stdout(&self.out) && (self.lod.len() > 1 || !self.metro.is_empty()) {
            return Err(Failure::wrong_use("several files cannot go to stdout", None));
        }
        let options = self.options();
        options.check().map_err(|e| Failure::wrong_use(e.to_string(), None))?;
        let file = input::name(&self.input);
        let start = Instant::now();
        let source = self.source()?;
        if !self.metro.is_empty() {
            return self.compare_all(&source, &file);
        }
        let sizes = match (self.to, self.psnr) {
            (Some(size), _) => vec![size],
            (None, Some(_)) => Vec::new(),
            (None, None) => self.lod.iter().map(|&share| eval::scaled_size(&source.image, share)).collect(),
        };
        let made = self.common.run("resizing", |task| {
            let mut resized = Vec::new();
            for &[width, height] in &sizes {
                resized.push(options.resize(&source.image, width, height, &task)?);
            }
            if let Some(psnr) = self.psnr {
                resized.push(eval::resize_to_psnr(&source.image, &options, Some(&source.original), psnr, &task)?.0);
            }
            resized
                .into_iter()
                .map(|resized| self.encode(&source, &options, resized, task))
                .collect::<gimc::Result<Vec<Made>>>()
        });
        let made = made.map_err(|e| Failure::in_file(&file, e))?;
        for made in &made {
            output::write(&made.path, |out| Ok(out.write_all(&made.encoded.bytes)?))?;
        }
        let seconds = start.elapsed().as_secs_f64();
        if self.common.json {
            let mut lines = made.iter().map(|made| json(made, &options));
            let object = match lines.len() {
                1 => lines.next().unwrap_or(Json::Null),
                _ => Json::object([("levels", Json::list(lines)), ("seconds", seconds.into())]),
            };
            output::print(&format!("{object}\n"))?;
        } else {
            made.iter().for_each(|made| self.common.say(said(made, &source)));
        }
        Ok(ExitCode::SUCCESS)
    }

    fn options(&self) -> ResizeOptions {
        let mut options = ResizeOptions::new(match self.by {
            By::Content => ResizeMethod::Content,
            By::Bicubic => ResizeMethod::Bicubic,
            By::Bilinear => ResizeMethod::Bilinear,
            By::Nearest => ResizeMethod::Nearest,
            By::Seam => ResizeMethod::Seam,
            By::Direct => ResizeMethod::Direct,
        });
        (options.alpha, options.lambda, options.steps) = (self.alpha, self.lambda, self.steps);
        options.literal(self.literal).limits(self.limits.limits())
    }

    fn source(&self) -> Result<Source, Failure> {
        let file = input::name(&self.input);
        let bytes = input::bytes(&self.input)?;
        let limits = self.limits.limits();
        if bytes.starts_with(b"gimc") {
            if self.grid.is_some() {
                return Err(Failure::wrong_use("--grid is for meshes; the file has its image already", None));
            }
            let read = self.common.run("reading", |task| {
                let decoder = Decoder::with_limits(&bytes, limits)?;
                let image = decoder.geometry_image_with(task)?;
                let mut original = eval::surface_of(&image);
                original.precision = decoder.info().precision;
                let history = decoder.info().history.clone().map_or(String::new(), |history| history + "; ");
                Ok(Source { original, image, history })
            });
            return read.map_err(|e| Failure::in_file(&file, e));
        }
        let (mesh, notes) = input::mesh_of(&self.input, &bytes, None)?;
        self.common.notes(&file, &notes);
        let side = self.grid.map_or_else(|| eval::usual_side(&mesh), |side| side as usize);
        let image =
            self.common.run("sampling", |task| eval::image_of(&mesh, side, &task)).map_err(|e| Failure::in_file(&file, e))?;
        Ok(Source { image, original: mesh, history: format!("sampled {side} x {side}; ") })
    }

    fn encode(&self, source: &Source, options: &ResizeOptions, resized: Resized, task: gimc::Task<'_>) -> gimc::Result<Made> {
        let mut choices = GimChoices::default();
        choices.history = Some(format!("{}{}", source.history, options.history(&source.image, &resized)));
        let stored = EncodeOptions::gim().bits(self.bits).gim_choices(choices).codec(match self.codec {
            StoredBy::Wavelet => Codec::Wavelet,
            StoredBy::J2k => Codec::J2k,
            StoredBy::Raw => Codec::Raw,
            StoredBy::Exr => Codec::Exr,
        });
        let encoded = stored.encode_image(&resized.image, Some(&source.original), task)?;
        let path = if self.lod.is_empty() { self.out.clone() } else { named(&self.out, &resized.image) };
        Ok(Made { path, resized, encoded })
    }

    fn compare_all(&self, source: &Source, file: &str) -> Outcome {
        let sizes: Vec<[usize; 2]> = self.metro.iter().map(|&share| eval::scaled_size(&source.image, share)).collect();
        let table = self.common.run("comparing", |task| eval::resize_table(&source.image, &sizes, &task));
        let table = table.map_err(|e| Failure::in_file(file, e))?;
        let name = self.input.file_stem().map_or_else(|| file.to_owned(), |stem| stem.to_string_lossy().into_owned());
        let title =
            format!("{name}, {} x {} samples: distance to the whole image", source.image.width(), source.image.height());
        let (csv, svg) = (table.to_csv(), table.to_svg(&title));
        output::write(&self.out, |out| Ok(out.write_all(csv.as_bytes())?))?;
        output::write(&self.out.with_extension("svg"), |out| Ok(out.write_all(svg.as_bytes())?))?;
        if self.common.json {
            let points = table.points.iter().map(|p| {
                Json::object([
                    ("method", p.method.as_str().into()),
                    ("width", p.size[0].into()),
                    ("height", p.size[1].into()),
                    ("triangles", p.triangles.into()),
                    ("mean", p.mean.into()),
                    ("rms_max", p.rms_max.into()),
                    ("hausdorff", p.hausdorff.into()),
                    ("psnr", p.psnr.into()),
                    ("psnr_rms_max", p.psnr_rms_max().into()),
                    ("folded", p.folded.into()),
                ])
            });
            output::print(&format!("{}\n", Json::object([("points", Json::list(points))])))?;
        } else {
            output::print(&csv)?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// `small.gimc` of 80 × 60 samples is `small-80x60.gimc`.
fn named(out: &Path, image: &GeometryImage) -> PathBuf {
    let stem = out.file_stem().map_or(String::new(), |stem| stem.to_string_lossy().into_owned());
    let extension = out.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
    out.with_file_name(format!("{stem}-{}x{}{extension}", image.width(), image.height()))
}

fn said(made: &Made, source: &Source) -> String {
    let (image, info) = (&made.resized.image, &made.encoded.info);
    let folded = match made.resized.folded {
        0 => String::new(),
        n => format!(", {n} cells folded"),
    };
    format!(
        "{}: {} x {} samples from {} x {}, {} triangles, {} bytes, {}, within {}{folded}",
        output::name(&made.path),
        image.width(),
        image.height(),
        source.image.width(),
        source.image.height(),
        thousands(info.faces),
        thousands(made.encoded.bytes.len() as u64),
        info.psnr.map_or("psnr unknown".into(), |psnr| format!("{psnr:.2} dB")),
        number(info.bound),
    )
}

fn json(made: &Made, options: &ResizeOptions) -> Json {
    let (image, info) = (&made.resized.image, &made.encoded.info);
    Json::object([
        ("file", output::name(&made.path).into()),
        ("method", options.method.name().into()),
        ("literal", options.literal.into()),
        ("width", image.width().into()),
        ("height", image.height().into()),
        ("alpha", options.effective_alpha().into()),
        ("lambda", options.effective_lambda().into()),
        ("steps", Json::list(made.resized.sizes.iter().map(|&size| Json::list(size)))),
        ("folded", made.resized.folded.into()),
        ("vertices", info.vertices.into()),
        ("faces", info.faces.into()),
        ("bytes", made.encoded.bytes.len().into()),
        ("psnr", info.psnr.into()),
        ("bound", info.bound.into()),
        ("history", info.history.clone().into()),
    ])
}
