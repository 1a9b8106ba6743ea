//! Rate and distortion of the four ways to keep a mesh's connectivity:
//! `cargo run --release --example rate_distortion -- OUT_DIR MESH...`
//!
//! For each mesh `OUT_DIR/NAME.svg`, and all points in `OUT_DIR/points.csv`: bytes of the whole file, psnr as
//! `gimc compare` measures it, and whether the connectivity is exact. `surface` and `mbcim` go through lattices of 6 to
//! 14 bits, `j2k` through rates at 12 bits, with the boundaries stored (`exact`) and implied (the cluster phase).
//! Afterwards, on stdout: at which rates the cluster phase still finds every vertex.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::fmt::Write as _;
use std::path::Path;

use gimc::eval::{CompareOptions, compare};
use gimc::{Boundaries, Codec, Decoder, EncodeOptions, ImageChoices, J2kChoices, Mesh, Quality, Task};

const WAYS: [(&str, &str); 4] =
    [("surface", "#1f77b4"), ("mbcim", "#2ca02c"), ("j2k exact", "#ff7f0e"), ("j2k implied", "#d62728")];
const RATES: [f64; 7] = [0.05, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0];

struct Point {
    way: &'static str,
    setting: String,
    bytes: usize,
    psnr: f64,
    exact: bool,
}

fn options(codec: Codec) -> EncodeOptions {
    let mut image = ImageChoices::default();
    image.search = if codec == Codec::J2k { 40 } else { 1 };
    EncodeOptions::cgim().codec(codec).image(image)
}

fn j2k(quality: Quality, boundaries: Boundaries) -> EncodeOptions {
    let mut choices = J2kChoices::default();
    choices.quality = quality;
    choices.boundaries = boundaries;
    options(Codec::J2k).j2k(choices)
}

fn point(mesh: &Mesh, way: &'static str, setting: String, options: &EncodeOptions) -> Option<Point> {
    // A rate may be too low for any stream.
    let file = options.encode(mesh).ok()?;
    let decoder = Decoder::new(&file).ok()?;
    let back = decoder.decode().ok()?;
    let psnr = compare(mesh, &back, &CompareOptions::default(), &Task::default()).ok()?.psnr;
    Some(Point { way, setting, bytes: file.len(), psnr, exact: decoder.info().connectivity_exact })
}

fn points(mesh: &Mesh) -> Vec<Point> {
    let mut points = Vec::new();
    for bits in (6..=14).step_by(2) {
        for (way, codec) in [("surface", Codec::Surface), ("mbcim", Codec::Mbcim)] {
            points.extend(point(mesh, way, format!("--bits {bits}"), &options(codec).bits(bits)));
        }
    }
    for (way, boundaries) in [("j2k exact", Boundaries::Exact), ("j2k implied", Boundaries::Implied)] {
        for rate in RATES {
            let options = j2k(Quality::BitsPerPixel(rate), boundaries);
            points.extend(point(mesh, way, format!("--rate {rate}"), &options));
        }
        points.extend(point(mesh, way, "--lossless".into(), &j2k(Quality::Lossless, boundaries)));
    }
    points
}

/// One picture: bytes on a logarithmic axis, psnr upwards; rings where the connectivity is not exact.
fn svg(name: &str, points: &[Point]) -> String {
    let (width, height, left, bottom) = (720.0, 480.0, 60.0, 50.0);
    let log = |p: &Point| (p.bytes as f64).log2();
    let ends = |f: &dyn Fn(&Point) -> f64| {
        let all = points.iter().map(f);
        (all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max))
    };
    let (x0, x1) = ends(&log);
    let (y0, y1) = ends(&|p| p.psnr);
    let x = |v: f64| left + (v - x0) / (x1 - x0) * (width - left - 20.0);
    let y = |v: f64| height - bottom - (v - y0) / (y1 - y0) * (height - bottom - 40.0);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" font-family=\"sans-serif\" \
         font-size=\"12\"><rect width=\"100%\" height=\"100%\" fill=\"white\"/><text x=\"{left}\" y=\"20\" \
         font-size=\"14\">{name}: bytes of the file (logarithmic) and psnr in dB</text>"
    );
    for octave in x0.ceil() as i32..=x1.floor() as i32 {
        let at = x(octave.into());
        let kilobytes = f64::from(octave - 10).exp2();
        let _ = write!(
            out,
            "<path d=\"M{at:.1} 40V{:.1}\" stroke=\"#ddd\"/><text x=\"{at:.1}\" y=\"{:.1}\" \
             text-anchor=\"middle\">{kilobytes} K</text>",
            height - bottom,
            height - bottom + 18.0
        );
    }
    for ten in (y0 / 10.0).ceil() as i32..=(y1 / 10.0).floor() as i32 {
        let at = y(f64::from(ten) * 10.0);
        let _ = write!(
            out,
            "<path d=\"M{left} {at:.1}H{:.1}\" stroke=\"#ddd\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            width - 20.0,
            left - 6.0,
            at + 4.0,
            ten * 10
        );
    }
    for (k, (way, colour)) in WAYS.iter().enumerate() {
        let mut of_way: Vec<&Point> = points.iter().filter(|p| p.way == *way).collect();
        of_way.sort_by_key(|p| p.bytes);
        let line: String = of_way.iter().map(|p| format!("{:.1},{:.1} ", x(log(p)), y(p.psnr))).collect();
        let _ = write!(out, "<polyline points=\"{line}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>");
        for p in of_way {
            let fill = if p.exact { colour } else { "white" };
            let _ = write!(
                out,
                "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{fill}\" stroke=\"{colour}\"/>",
                x(log(p)),
                y(p.psnr)
            );
        }
        let _ = write!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{colour}\">{way}</text>",
            width - 110.0,
            height - bottom - 80.0 + 18.0 * k as f64
        );
    }
    out.push_str("</svg>\n");
    out
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let out = arguments.next().ok_or("usage: rate_distortion OUT_DIR MESH...")?;
    let out = Path::new(&out);
    std::fs::create_dir_all(out)?;
    let mut csv = String::from("mesh,way,setting,bytes,psnr,connectivity_exact\n");
    let mut breaks = String::new();
    for path in arguments {
        let mesh = Mesh::open(&path)?;
        let name = Path::new(&path).file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let points = points(&mesh);
        for p in &points {
            writeln!(csv, "{name},{},{},{},{:.2},{}", p.way, p.setting, p.bytes, p.psnr, p.exact)?;
        }
        std::fs::write(out.join(format!("{name}.svg")), svg(&name, &points))?;
        let found: Vec<_> = points.iter().filter(|p| p.way == "j2k implied" && p.exact).map(|p| p.setting.as_str()).collect();
        writeln!(breaks, "{name}: exact at {}", if found.is_empty() { "no rate".into() } else { found.join(", ") })?;
        eprintln!("{name} done");
    }
    std::fs::write(out.join("points.csv"), csv)?;
    print!("{breaks}");
    Ok(())
}
