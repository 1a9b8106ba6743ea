//! `gimc encode MESH OUT`

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::{Args, Parser, ValueEnum};
use gimc::eval::Json;
use gimc::{Accuracy, Effort, EncodeOptions, Encoded, Format, Mesh, Repair, Task};

use super::attributes::AttributeFlags;
use super::failure::Failure;
use super::table::{number, thousands};
use super::{Common, Outcome, input, output, positive};

/// Encode a mesh.
///
/// The method cgim keeps the connectivity exactly: positions are put on a lattice, and the file states a bound on the error
/// that holds. The method gim samples the surface anew as a geometry image, in far fewer bytes; it also takes an image that was
/// made elsewhere, as an OpenEXR picture or a PNG of 16 bits (--lattice says what its samples stand for).
#[derive(Debug, Args)]
pub(super) struct Encode {
    /// The mesh: obj, ply, off, stl or glb. With the method gim also a picture: exr or png.
    mesh: PathBuf,
    /// The file to make.
    out: PathBuf,
    /// How the mesh is kept.
    #[arg(long, value_enum, default_value = "cgim")]
    method: Method,
    /// cgim: what the error is measured on. `surface` lets vertices slide along the surface: about two thirds of the bytes at
    /// the same psnr, with the connectivity as it is.
    #[arg(long, value_enum, default_value = "vertex")]
    metric: Metric,
    /// How it becomes bytes [default: surface; wavelet for the method gim].
    #[arg(long, value_enum)]
    codec: Option<Codec>,
    /// Positions on a lattice of 2^Q points along the longest side of the box, or `exact`: bit by bit [default: 12].
    #[arg(long, value_name = "Q", value_parser = bits, group = "accuracy")]
    bits: Option<Accuracy>,
    /// Positions on a lattice of this step, in the units of the mesh.
    #[arg(long, value_name = "S", value_parser = positive, group = "accuracy")]
    step: Option<f64>,
    /// No point of either surface farther than this from the other, in the units of the mesh.
    #[arg(long, value_name = "E", value_parser = positive, group = "accuracy")]
    error: Option<f64>,
    /// The same, as a share of the diagonal of the box.
    #[arg(long, value_name = "R", value_parser = positive, group = "accuracy")]
    error_rel: Option<f64>,
    /// A lattice of your own: its origin and step. Files that share one agree where they meet.
    #[arg(long, value_name = "X,Y,Z,STEP", value_parser = lattice, allow_hyphen_values = true, group = "accuracy")]
    lattice: Option<([f64; 3], f64)>,
    /// gim, and the metric surface: at most so many bytes, with the best psnr that a search finds.
    #[arg(long, value_name = "BYTES", value_parser = super::amount, group = "accuracy")]
    size: Option<u64>,
    #[command(flatten)]
    gim: super::gim::GimFlags,
    #[command(flatten)]
    roi: super::roi::RoiFlags,
    /// Trials for a small image of vertices [default: 1].
    #[arg(long, value_name = "N", help_heading = "Images of vertices", value_parser = clap::value_parser!(u32).range(1..))]
    search: Option<u32>,
    /// Where the search starts.
    #[arg(long, value_name = "S", default_value = "1", hide_default_value = true, help_heading = "Images of vertices")]
    seed: u64,
    /// The α of the paper's Algorithm 2; 0: off [default: 5, or any with --search].
    #[arg(long, value_name = "N", help_heading = "Images of vertices", value_parser = clap::value_parser!(u8).range(0..=31))]
    alpha: Option<u8>,
    /// The share of the vertices within reach that each level takes in [default: 1, or any with --search].
    #[arg(long, value_name = "SHARE", help_heading = "Images of vertices", value_parser = positive)]
    keep: Option<f64>,
    /// How the rows of the image are aligned: `paper` follows Algorithms 1 and 2 as printed, and stores that very image.
    #[arg(long, value_enum, default_value = "shortest", help_heading = "Images of vertices")]
    align: Align,
    /// raw, exr, j2k: also store an image of normals, of so many bits a sample: those of the mesh, or computed.
    #[arg(long, value_name = "Q", help_heading = "Images of vertices", value_parser = clap::value_parser!(u8).range(2..=16))]
    normals: Option<u8>,
    /// surface, mbcim: coordinates in so many stages, the later ones of two bits each.
    #[arg(long, value_name = "N", help_heading = "Images of vertices", value_parser = clap::value_parser!(u8).range(1..=12))]
    stages: Option<u8>,
    /// surface, mbcim: the bits that each stage after the first adds, with commas between.
    #[arg(long, value_name = "LIST", value_delimiter = ',', conflicts_with = "stages", help_heading = "Images of vertices")]
    stage_bits: Vec<u8>,
    /// j2k: bits for each pixel of the image, at most.
    #[arg(long, value_name = "BPP", value_parser = positive, help_heading = "JPEG 2000", group = "quality")]
    rate: Option<f64>,
    /// gim, j2k, and the metric surface: a psnr of the decoded mesh, at least, in dB [default for gim: 70].
    #[arg(long, value_name = "P", value_parser = positive, group = "quality")]
    psnr: Option<f64>,
    /// j2k: keep every sample (the default).
    #[arg(long, help_heading = "JPEG 2000", group = "quality")]
    lossless: bool,
    /// j2k: quality layers.
    #[arg(long, value_name = "N", default_value = "1", help_heading = "JPEG 2000", value_parser = clap::value_parser!(u8).range(1..=32))]
    layers: u8,
    /// j2k: how a reader knows which pixels are one vertex.
    #[arg(long, value_enum, default_value = "exact", help_heading = "JPEG 2000")]
    boundaries: Boundaries,
    /// Time for size. Every file decodes with the same decoder.
    #[arg(long, value_enum, default_value = "default")]
    effort: EffortName,
    /// Also store the order of vertices, faces and first corners; `info` states what it costs.
    #[arg(long)]
    keep_order: bool,
    #[command(flatten)]
    attributes: AttributeFlags,
    /// Repair the mesh first: weld vertices, drop degenerate and duplicate faces, turn faces so that neighbours agree.
    #[arg(long, help_heading = "Repair")]
    repair: bool,
    /// Weld vertices no farther apart than this, in the units of the mesh [default: 0, those at the same place].
    #[arg(long, value_name = "D", value_parser = positive, requires = "repair", help_heading = "Repair")]
    weld: Option<f64>,
    /// Close boundary loops of at most so many edges [default: none].
    #[arg(long, value_name = "N", requires = "repair", help_heading = "Repair")]
    close: Option<usize>,
    /// The format of the mesh: obj, ply, off, stl, glb [default: by extension or content].
    #[arg(long, value_name = "FORMAT", value_parser = input::format)]
    format: Option<Format>,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Method {
    /// Keep the connectivity.
    Cgim,
    /// Sample the surface as a geometry image: far fewer bytes.
    Gim,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Metric {
    /// The vertices: each stays within the bound.
    Vertex,
    /// The surfaces: vertices may slide along them.
    Surface,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Codec {
    /// Code the mesh by walking over its surface.
    Surface,
    /// As index map and base colours of an image of vertices.
    Mbcim,
    /// As an image of vertices, sample by sample.
    Raw,
    /// The same as an OpenEXR picture of floats.
    Exr,
    /// The same as a JPEG 2000 picture, without loss or with.
    J2k,
    /// gim: wavelet coefficients in local frames, the smallest.
    Wavelet,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Align {
    /// As few columns as can be.
    Shortest,
    /// As the paper does it.
    Paper,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Boundaries {
    /// From an index map in the file: the connectivity is exact at any rate.
    Exact,
    /// From run counts, by the paper's cluster phase: the file says whether the connectivity is exact.
    Implied,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum EffortName {
    /// Integers only, few contexts.
    Fast,
    /// A good size for a moderate time.
    Default,
    /// The smallest size.
    Best,
}

/// `exact`, or bits.
fn bits(text: &str) -> Result<Accuracy, String> {
    match text.parse() {
        _ if text == "exact" => Ok(Accuracy::Exact),
        Ok(bits) if (1..=24).contains(&bits) => Ok(Accuracy::Bits(bits)),
        _ => Err("1 to 24, or exact, is expected".into()),
    }
}

/// `x,y,z,step`.
fn lattice(text: &str) -> Result<([f64; 3], f64), String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|s| s.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match numbers.as_deref() {
        Some(&[x, y, z, step]) if step > 0.0 => Ok(([x, y, z], step)),
        _ => Err("three coordinates and a positive step are expected, with commas between".into()),
    }
}

impl Encode {
    fn check(&self) -> Result<(), Failure> {
        let is_j2k = matches!(self.codec, Some(Codec::J2k));
        if self.lossless && !is_j2k {
            return Err(Failure::wrong_use("--lossless is for the codec j2k", Some("add `--codec j2k`".into())));
        }
        Ok(())
    }

    fn options(&self) -> EncodeOptions {
        let is_gim = matches!(self.method, Method::Gim);
        let is_surface = self.metric == Metric::Surface;
        let mut options = if is_gim { EncodeOptions::gim() } else { EncodeOptions::cgim() };
        if is_surface {
            options = options.metric(gimc::Metric::Surface);
        }
        options = options.effort(match self.effort {
            EffortName::Fast => Effort::Fast,
            EffortName::Default => Effort::Default,
            EffortName::Best => Effort::Best,
        });
        let usual = options.codec;
        options = options.codec(match self.codec {
            None => usual,
            Some(Codec::Surface) => gimc::Codec::Surface,
            Some(Codec::Mbcim) => gimc::Codec::Mbcim,
            Some(Codec::Raw) => gimc::Codec::Raw,
            Some(Codec::Exr) => gimc::Codec::Exr,
            Some(Codec::J2k) => gimc::Codec::J2k,
            Some(Codec::Wavelet) => gimc::Codec::Wavelet,
        });
        options = options.gim_choices(self.gim.choices());
        let mut image = gimc::ImageChoices::default();
        image.search = self.search.map_or(image.search, |n| n as usize);
        image.seed = self.seed;
        image.alpha = self.alpha;
        image.keep = self.keep;
        image.paper = self.align == Align::Paper;
        image.normals = self.normals;
        image.stages = match self.stages {
            Some(count) => vec![2; usize::from(count) - 1],
            None => self.stage_bits.clone(),
        };
        options = options.keep_order(self.keep_order).attributes(self.attributes.choices());
        let mut j2k = gimc::J2kChoices::default();
        if let Some(bpp) = self.rate {
            j2k.quality = gimc::Quality::BitsPerPixel(bpp);
        } else if let Some(psnr) = self.psnr.filter(|_| !is_gim && !is_surface) {
            j2k.quality = gimc::Quality::Psnr(psnr);
        }
        j2k.layers = self.layers;
        if self.boundaries == Boundaries::Implied {
            j2k.boundaries = gimc::Boundaries::Implied;
        }
        options = options.image(image).j2k(j2k);
        if let Some(bits) = self.bits {
            options = options.accuracy(bits);
        } else if let Some(step) = self.step {
            options = options.step(step);
        } else if let Some(bound) = self.error {
            options = options.error(bound);
        } else if let Some(bound) = self.error_rel {
            options = options.error_relative(bound);
        } else if let Some(bytes) = self.size {
            options = options.size(bytes);
        } else if let Some((origin, step)) = self.lattice.filter(|_| !self.is_picture()) {
            options = options.lattice(origin, step);
        } else if let Some(psnr) = self.psnr.filter(|_| is_gim || is_surface) {
            options = options.psnr(psnr);
        }
        options
    }

    /// The options, with a region that may be in a file.
    fn asked(&self) -> Result<EncodeOptions, Failure> {
        let mut options = self.options();
        options.roi = self.roi.region()?;
        Ok(options)
    }

    /// What is to be repaired, if anything.
    fn repair(&self) -> Option<Repair> {
        let mut wanted = Repair::default();
        wanted.weld = self.weld.unwrap_or(0.0);
        wanted.close = self.close.unwrap_or(0);
        self.repair.then_some(wanted)
    }

    /// The mesh repaired; what was done goes to stderr.
    fn repaired(&self, file: &str, mesh: &Mesh, wanted: &Repair) -> Mesh {
        let (mesh, done) = mesh.repaired(wanted);
        let steps = done.steps();
        let nothing = steps.is_empty().then(|| "nothing to do".to_owned());
        let steps: Vec<String> = steps.into_iter().chain(nothing).map(|step| format!("repair: {step}")).collect();
        self.common.notes(file, &steps);
        mesh
    }

    /// Whether the input is a geometry image and no mesh.
    fn is_picture(&self) -> bool {
        matches!(self.method, Method::Gim) && self.format.is_none() && super::gim::is_picture(&self.mesh)
    }

    pub(super) fn run(self) -> Outcome {
        if self.common.json && output::is_stdout(&self.out) {
            return Err(Failure::wrong_use("--json and the file cannot both go to stdout", None));
        }
        self.check()?;
        let start = Instant::now();
        let file = input::name(&self.mesh);
        let options = self.asked()?;
        let (encoded, vertices) = if self.is_picture() {
            let lattice = self.lattice.map(|(origin, step)| gimc::Lattice { origin, step });
            let image = self.gim.picture(&self.mesh, lattice)?;
            let original = self.gim.original.as_deref().map(|path| input::mesh(path, self.format)).transpose()?;
            let original = original.as_ref().map(|(mesh, _)| mesh);
            let encode = |task: Task<'_>| options.encode_image(&image, original, task);
            let encoded = self.common.run("encoding", encode).map_err(|e| Failure::in_file(&file, e))?;
            let vertices = original.map_or(encoded.info.vertices as usize, |mesh| mesh.positions.len());
            (encoded, vertices)
        } else {
            self.gim.check_mesh(&file)?;
            let (mesh, notes) = input::mesh(&self.mesh, self.format)?;
            self.common.notes(&file, &notes);
            let mesh = match self.repair() {
                Some(wanted) => self.repaired(&file, &mesh, &wanted),
                None => mesh,
            };
            let encode = |task: Task<'_>| options.encode_with(&mesh, task);
            (self.common.run("encoding", encode).map_err(|e| Failure::in_file(&file, e))?, mesh.positions.len())
        };
        self.common.notes(&file, &encoded.notes);
        output::write(&self.out, |out| Ok(out.write_all(&encoded.bytes)?))?;
        let seconds = start.elapsed().as_secs_f64();
        let bpv = 8.0 * encoded.bytes.len() as f64 / vertices.max(1) as f64;
        if self.common.json {
            output::print(&format!("{}\n", json(&encoded, bpv, seconds)))?;
        } else {
            let info = &encoded.info;
            self.common.say(format!(
                "{}: {} vertices, {} faces; {} bytes, {bpv:.2} bits a vertex; within {}; {seconds:.2} s",
                output::name(&self.out),
                thousands(info.vertices),
                thousands(info.faces),
                thousands(encoded.bytes.len() as u64),
                match (info.psnr, info.roi.as_ref().and_then(|roi| roi.psnr)) {
                    (Some(psnr), Some(inside)) => {
                        format!("{}, {psnr:.2} dB, {inside:.2} dB in the region of interest", number(info.bound))
                    }
                    (Some(psnr), None) => format!("{}, {psnr:.2} dB", number(info.bound)),
                    (None, _) => number(info.bound),
                },
            ));
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Arguments of `gimc encode`, beside its files, as a sweep has them: what they ask for.
pub(super) fn asked(words: &[String]) -> Result<(EncodeOptions, Option<Repair>), Failure> {
    #[derive(Parser)]
    #[command(name = "gimc encode", no_binary_name = true)]
    struct Line {
        #[command(flatten)]
        encode: Encode,
    }
    let files = ["MESH", "OUT.gimc"].map(String::from);
    let Line { encode } = Line::try_parse_from(files.iter().chain(words)).map_err(|e| super::misuse(&e))?;
    encode.check()?;
    let Common { json, quiet, threads, deadline } = encode.common;
    if json || quiet || threads > 0 || deadline.is_some() || encode.format.is_some() {
        let text = "--json, --quiet, --threads, --deadline and --format are not for one point of a sweep";
        return Err(Failure::wrong_use(text, None));
    }
    encode.gim.check_mesh("MESH")?;
    Ok((encode.asked()?, encode.repair()))
}

/// The effort by its name on the command line.
pub(super) fn effort_name(effort: Effort) -> &'static str {
    match effort {
        Effort::Fast => "fast",
        Effort::Best => "best",
        _ => "default",
    }
}

fn json(encoded: &Encoded, bpv: f64, seconds: f64) -> Json {
    let info = &encoded.info;
    Json::object([
        ("vertices", info.vertices.into()),
        ("faces", info.faces.into()),
        ("method", info.method.into()),
        ("codec", info.codec.into()),
        ("effort", effort_name(info.effort).into()),
        ("bytes", encoded.bytes.len().into()),
        ("bpv", bpv.into()),
        ("bits", info.bits.map_or(Json::Null, Json::from)),
        ("step", info.step.into()),
        ("bound", info.bound.into()),
        ("metric", info.metric.into()),
        ("psnr", info.psnr.map_or(Json::Null, Json::from)),
        ("rows", info.image.map_or(Json::Null, |[rows, _]| rows.into())),
        ("columns", info.image.map_or(Json::Null, |[_, columns]| columns.into())),
        ("connectivity_exact", info.connectivity_exact.into()),
        ("seconds", seconds.into()),
        ("parts", Json::object(info.parts.iter().map(|&(name, bytes)| (name, bytes.into())))),
        ("notes", Json::list(encoded.notes.iter().map(String::as_str))),
    ])
}
