//! `gimc info IN`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use gimc::Decoder;
use gimc::eval::Json;

use super::encode::effort_name;
use super::failure::Failure;
use super::table::{Table, number, point, thousands};
use super::{Common, Outcome, input, output};

/// Say what a file holds, without decoding it.
#[derive(Debug, Args)]
pub(super) struct Info {
    /// The file.
    input: PathBuf,
    #[command(flatten)]
    common: Common,
}

impl Info {
    pub(super) fn run(self) -> Outcome {
        let file = input::name(&self.input);
        let bytes = input::bytes(&self.input)?;
        let info =
            self.common.run("reading", |_| Ok(Decoder::new(&bytes)?.info().clone())).map_err(|e| Failure::in_file(&file, e))?;
        let bpv = 8.0 * bytes.len() as f64 / f64::from(info.vertices.max(1));
        output::print(&if self.common.json { json(&info, bytes.len(), bpv) } else { text(&info, &file, bytes.len(), bpv) })?;
        Ok(ExitCode::SUCCESS)
    }
}

fn json(info: &gimc::Info, bytes: usize, bpv: f64) -> String {
    let json = Json::object([
        ("version", u32::from(info.version).into()),
        ("method", info.method.into()),
        ("codec", info.codec.into()),
        ("metric", info.metric.into()),
        ("effort", effort_name(info.effort).into()),
        ("vertices", info.vertices.into()),
        ("faces", info.faces.into()),
        ("bytes", bytes.into()),
        ("bpv", bpv.into()),
        ("box", Json::list(info.bounds.iter().map(|&p| Json::list(p)))),
        ("origin", Json::list(info.origin)),
        ("step", info.step.into()),
        ("bits", info.bits.map_or(Json::Null, Json::from)),
        ("exact", info.exact.into()),
        ("bound", info.bound.into()),
        ("psnr", info.psnr.map_or(Json::Null, Json::from)),
        ("levels", u32::from(info.levels).into()),
        ("gluing", info.gluing.map_or(Json::Null, |gluing| gluing_name(gluing).into())),
        ("images", info.images.into()),
        ("seams", info.seams.into()),
        ("holes", info.has_holes.into()),
        ("history", info.history.as_deref().map_or(Json::Null, Json::from)),
        ("rows", info.image.map_or(Json::Null, |[rows, _]| rows.into())),
        ("columns", info.image.map_or(Json::Null, |[_, columns]| columns.into())),
        ("boundaries", info.boundaries.map_or(Json::Null, Json::from)),
        ("connectivity_exact", info.connectivity_exact.into()),
        ("layers", info.layers.map_or(Json::Null, |n| u32::from(n).into())),
        ("normal_bits", u32::from(info.normal_bits).into()),
        ("roi", info.roi.as_ref().map_or(Json::Null, roi)),
        ("stages", Json::list(info.stages.iter().map(|&bits| u32::from(bits)))),
        ("stages_present", info.stages_present.into()),
        ("precision", precision(info).into()),
        ("parts", Json::object(info.parts.iter().map(|&(name, bytes)| (name, bytes.into())))),
        (
            "chunks",
            Json::list(info.chunks.iter().map(|c| Json::object([("tag", c.tag.as_str().into()), ("bytes", c.bytes.into())]))),
        ),
        ("attributes", Json::list(info.attributes.iter().map(attribute))),
        ("memory", info.memory.into()),
        ("work", info.work.into()),
    ]);
    format!("{json}\n")
}

fn roi(roi: &gimc::RoiInfo) -> Json {
    Json::object([
        ("bytes", roi.bytes.into()),
        ("psnr", roi.psnr.map_or(Json::Null, Json::from)),
        ("coarser", u32::from(roi.coarser).into()),
        ("bits", roi.bits.map_or(Json::Null, Json::from)),
    ])
}

fn attribute(attribute: &gimc::AttributeInfo) -> Json {
    Json::object([
        ("name", attribute.name.as_str().into()),
        ("kind", attribute.kind.into()),
        ("on", attribute.on.into()),
        ("width", attribute.width.into()),
        ("accuracy", attribute.accuracy.as_str().into()),
        ("bytes", attribute.bytes.into()),
    ])
}

fn precision(info: &gimc::Info) -> &'static str {
    if info.precision == gimc::Scalar::F64 { "f64" } else { "f32" }
}

fn text(info: &gimc::Info, file: &str, bytes: usize, bpv: f64) -> String {
    let mut table = Table::default();
    table.row("file", format!("{file}, version {}", info.version));
    table.row("coded as", format!("{}, {}, effort {}", info.method, info.codec, effort_name(info.effort)));
    table.row("vertices", thousands(info.vertices));
    table.row("faces", thousands(info.faces));
    table.row("bytes", format!("{}, {bpv:.3} bits a vertex", thousands(bytes as u64)));
    for (name, part) in &info.parts {
        table.row(format!("  {name}"), thousands(*part));
    }
    table.row("box", format!("{}  to  {}", point(info.bounds[0]), point(info.bounds[1])));
    let bits = info.bits.map_or(String::new(), |bits| format!(", {bits} bits"));
    table.row("step", format!("{}{bits}, from {}", number(info.step), point(info.origin)));
    if info.bound.is_finite() {
        let said = "no point of either surface is farther than this from the other";
        table.row("bound", format!("{}: {said}", number(info.bound)));
    }
    if let Some(psnr) = info.psnr {
        table.row("psnr", format!("{psnr:.2} dB"));
    }
    if info.method == "cgim" && info.metric == "surface" {
        table.row("metric", "surface: vertices may have slid along it");
    }
    let exact = if info.exact { ", bit by bit" } else { "" };
    table.row("coordinates", format!("{}{exact}", precision(info)));
    for attribute in &info.attributes {
        let gimc::AttributeInfo { name, kind, on, accuracy, bytes, .. } = attribute;
        table.row(format!("on {on}"), format!("{kind} `{name}`, {accuracy}: {} bytes", thousands(*bytes)));
    }
    if let Some([rows, columns]) = info.image {
        let others = if info.images > 1 { format!(" in the largest of {}", info.images) } else { String::new() };
        table.row("image", format!("{rows} rows, {columns} columns{others}"));
    }
    if let Some(boundaries) = info.boundaries {
        let how = if boundaries == "exact" { "an index map" } else { "the cluster phase, from run counts" };
        table.row("boundaries", format!("{boundaries}: from {how}"));
    }
    if let Some(layers) = info.layers {
        table.row("layers", layers.to_string());
    }
    if info.normal_bits > 0 {
        table.row("normals", format!("two planes of {} bits", info.normal_bits));
    }
    if let Some(gluing) = info.gluing {
        let levels = if info.levels == 0 { String::new() } else { format!(", {} coarser levels", info.levels) };
        let seams = if info.seams > 0 { format!(", {} seams", info.seams) } else { String::new() };
        let holes = if info.has_holes { ", with holes" } else { "" };
        table.row("border", format!("{}{seams}{holes}{levels}", gluing_name(gluing)));
    }
    if let Some(roi) = &info.roi {
        let psnr = roi.psnr.map_or(String::new(), |psnr| format!("{psnr:.2} dB"));
        let coarser =
            if roi.coarser > 0 { format!("steps {} times as large elsewhere", 1_u32 << roi.coarser) } else { String::new() };
        let bits = roi.bits.map_or(String::new(), |bits| format!("{bits} bits inside"));
        let said: Vec<String> = [psnr, coarser, bits].into_iter().filter(|s| !s.is_empty()).collect();
        table.row("region of interest", said.join(", "));
    }
    if let Some(history) = &info.history {
        table.row("history", history);
    }
    table.row("connectivity", if info.connectivity_exact { "that of the original" } else { "not that of the original" });
    if !info.stages.is_empty() {
        let present = format!("{} of {} here", info.stages_present, info.stages.len());
        table.row("stages", format!("of {:?} bits after the base; {present}", info.stages));
    }
    for chunk in &info.chunks {
        table.row(format!("chunk {}", chunk.tag), format!("{} bytes", thousands(chunk.bytes)));
    }
    table.row("to decode", format!("{} bytes of memory, {} steps", thousands(info.memory), thousands(info.work)));
    table.to_string()
}

/// How a geometry image is glued, by its name on the command line.
fn gluing_name(gluing: gimc::Gluing) -> &'static str {
    if gluing == gimc::Gluing::Orbifold { "orbifold" } else { "open" }
}
