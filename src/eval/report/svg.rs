//! Rate–distortion curves as a picture (SVG 1.1, no script, no style sheet): one panel a mesh, psnr over the size of the file.
//!
//! Sizes are on a logarithmic axis, below in bits a vertex and above in bytes: the two differ by a factor, so that one grid
//! serves both. Each way has the same colour and mark in all panels. A mark is filled where the connectivity is that of the
//! original. Files without loss have no psnr; they stand as arrows at the upper edge.

use std::fmt::Write;

use crate::eval::curve::PSNR_WITHOUT_LOSS;
use crate::eval::same::Verdict;
use crate::eval::sweep::{Measured, MeshCurves, SweepTable, WayCurve};

/// Panels side by side, if there are that many.
const COLUMNS: usize = 2;
/// A panel with its labels.
const PANEL: [f64; 2] = [600.0, 430.0];
/// What its labels take: left, right, above, below.
const MARGINS: [f64; 4] = [62.0, 22.0, 62.0, 62.0];
/// The width of a character of the size used, on average; wide enough for most fonts.
const CHARACTER: f64 = 6.6;
/// Pixels between labels at least.
const GAP: f64 = 10.0;

/// Told apart by most people whose eyes mix up colours (after Okabe and Ito).
const COLOURS: [&str; 8] = ["#0072b2", "#d55e00", "#009e73", "#b4519a", "#c48a00", "#3a9bd8", "#6b4fa0", "#5f5f5f"];
/// Lines of the second eight ways, and of the third.
const DASHES: [&str; 3] = ["", " stroke-dasharray=\"7 4\"", " stroke-dasharray=\"2 4\""];

/// All panels, under one legend.
pub fn curves_svg(table: &SweepTable<'_>) -> String {
    let columns = table.meshes.len().clamp(1, COLUMNS);
    let rows = table.meshes.len().div_ceil(columns);
    let width = PANEL[0] * columns as f64;
    let (legend, above) = legend(&table.ways, width);
    let height = above + PANEL[1] * rows.max(1) as f64;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"12\" fill=\"#222\">\n\
         <title>Rate and distortion: psnr over the size of the file</title>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n{legend}"
    );
    for (i, mesh) in table.meshes.iter().enumerate() {
        let (x, y) = (PANEL[0] * (i % columns) as f64, above + PANEL[1] * (i / columns) as f64);
        let _ = writeln!(out, "<g transform=\"translate({x} {y})\">");
        panel(&mut out, mesh, &table.ways);
        out.push_str("</g>\n");
    }
    out.push_str("</svg>\n");
    out
}

/// Text that may stand in XML and HTML, between tags and in attributes.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // XML has no place for them.
            c if c.is_control() || c == '\u{fffe}' || c == '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

fn text_width(text: &str) -> f64 {
    CHARACTER * text.chars().count() as f64
}

/// Names of ways beside their marks, in as many rows as they need; and how high that is.
fn legend(ways: &[&str], width: f64) -> (String, f64) {
    const ROW: f64 = 20.0;
    let (left, right) = (MARGINS[0], width - MARGINS[1]);
    let (mut out, mut x, mut y) = (String::new(), left, 24.0);
    for (i, way) in ways.iter().enumerate() {
        let wide = 44.0 + text_width(way) + 2.0 * GAP;
        if x > left && x + wide > right {
            (x, y) = (left, y + ROW);
        }
        let [colour, dash] = look(i);
        let _ = writeln!(
            out,
            "<path d=\"M{x:.1} {:.1}h34\" stroke=\"{colour}\" stroke-width=\"2\"{dash}/>{}<text x=\"{:.1}\" y=\"{y:.1}\">{}</text>",
            y - 4.0,
            mark(i, x + 17.0, y - 4.0, true, ""),
            x + 42.0,
            escaped(way)
        );
        x += wide;
    }
    y += ROW;
    let _ = writeln!(
        out,
        "<text x=\"{left}\" y=\"{y:.1}\" font-size=\"11\" fill=\"#666\">Marks are filled where the connectivity is that of the original.</text>"
    );
    (out, y + 12.0)
}

/// Colour and dashes of a way.
fn look(way: usize) -> [&'static str; 2] {
    [COLOURS[way % COLOURS.len()], DASHES[way / COLOURS.len() % DASHES.len()]]
}

/// The mark of a way, with a title that shows when it is pointed at.
fn mark(way: usize, x: f64, y: f64, filled: bool, title: &str) -> String {
    let shape = match way % 5 {
        0 => "m-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z",
        1 => "m-3.7 -3.7h7.4v7.4h-7.4z",
        2 => "m0 -5l5 5l-5 5l-5 -5z",
        3 => "m0 -5l4.6 8.4h-9.2z",
        _ => "m0 5l4.6 -8.4h-9.2z",
    };
    let colour = look(way)[0];
    let fill = if filled { colour } else { "#fff" };
    let title = if title.is_empty() { String::new() } else { format!("<title>{}</title>", escaped(title)) };
    format!("<path d=\"M{x:.1} {y:.1}{shape}\" fill=\"{fill}\" stroke=\"{colour}\" stroke-width=\"1.5\">{title}</path>")
}

/// Where bytes and psnr lie in a panel.
struct Axes {
    /// Decimal logarithms of the least and the greatest number of bytes.
    log_bytes: [f64; 2],
    psnr: [f64; 2],
}

impl Axes {
    /// Around all points, with some air.
    fn around<'a>(points: impl Iterator<Item = &'a Measured>) -> Option<Self> {
        let around = |values: &[f64], least: f64| {
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let air = ((least - (high - low)) / 2.0).max(0.05 * (high - low));
            (low <= high).then_some([low - air, high + air])
        };
        let points: Vec<&Measured> = points.collect();
        let logs: Vec<f64> = points.iter().map(|m| (m.bytes.max(1) as f64).log10()).collect();
        let psnrs: Vec<f64> = points.iter().map(|m| m.psnr).filter(|&psnr| psnr < PSNR_WITHOUT_LOSS).collect();
        // An axis of less than a factor of two, or of six decibels, would show noise.
        Some(Self { log_bytes: around(&logs, 0.3)?, psnr: around(&psnrs, 6.0).unwrap_or([0.0, 100.0]) })
    }

    fn x(&self, log_bytes: f64) -> f64 {
        let [low, high] = self.log_bytes;
        MARGINS[0] + (log_bytes - low) / (high - low) * (PANEL[0] - MARGINS[0] - MARGINS[1])
    }

    fn y(&self, psnr: f64) -> f64 {
        let [low, high] = self.psnr;
        MARGINS[2] + (high - psnr) / (high - low) * (PANEL[1] - MARGINS[2] - MARGINS[3])
    }

    fn of(&self, m: &Measured) -> [f64; 2] {
        let y = if m.psnr < PSNR_WITHOUT_LOSS { self.y(m.psnr) } else { MARGINS[2] };
        [self.x((m.bytes.max(1) as f64).log10()), y]
    }
}

fn panel(out: &mut String, mesh: &MeshCurves<'_>, ways: &[&str]) {
    let [left, right, top, bottom] = [MARGINS[0], PANEL[0] - MARGINS[1], MARGINS[2], PANEL[1] - MARGINS[3]];
    let middle = (left + right) / 2.0;
    let title = format!("{} ({} vertices)", shortened(mesh.mesh, 60), mesh.vertices);
    let _ = writeln!(out, "<text x=\"{left}\" y=\"18\" font-size=\"14\" font-weight=\"bold\">{}</text>", escaped(&title));
    let refused = refusals(mesh, ways);
    if !refused.is_empty() {
        let y = PANEL[1] - 8.0;
        let text = shortened(&refused, ((right - left) / (CHARACTER * 11.0 / 12.0)) as usize);
        let _ = writeln!(out, "<text x=\"{left}\" y=\"{y}\" font-size=\"11\" fill=\"#a33\">{}</text>", escaped(&text));
    }
    let frame = format!("<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" ", right - left, bottom - top);
    let Some(axes) = Axes::around(mesh.ways.iter().flat_map(|curve| &curve.points).map(|(_, m)| *m)) else {
        let y = (top + bottom) / 2.0;
        let _ = writeln!(
            out,
            "{frame}fill=\"none\" stroke=\"#999\"/><text x=\"{middle}\" y=\"{y}\" text-anchor=\"middle\">no point was measured</text>"
        );
        return;
    };
    // A byte more or less, in bits a vertex.
    let shift = (8.0 / mesh.vertices.max(1) as f64).log10();
    let bits = logarithmic_ticks(axes.log_bytes.map(|log| log + shift), right - left, digits);
    for (log, label) in &bits {
        let x = axes.x(log - shift);
        let _ = writeln!(
            out,
            "<path d=\"M{x:.1} {top}V{bottom}\" stroke=\"#e4e4e4\"/><text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
            bottom + 17.0
        );
    }
    for (log, label) in &logarithmic_ticks(axes.log_bytes, right - left, bytes) {
        let x = axes.x(*log);
        let _ = writeln!(
            out,
            "<path d=\"M{x:.1} {top}v-5\" stroke=\"#999\"/><text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\" fill=\"#666\">{label}</text>",
            top - 9.0
        );
    }
    for psnr in linear_ticks(axes.psnr, bottom - top) {
        let y = axes.y(psnr);
        let _ = writeln!(
            out,
            "<path d=\"M{left} {y:.1}H{right}\" stroke=\"#e4e4e4\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            left - 7.0,
            y + 4.0,
            digits(psnr)
        );
    }
    let turn = (top + bottom) / 2.0;
    let _ = writeln!(
        out,
        "{frame}fill=\"none\" stroke=\"#999\"/>\
         <text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">bits a vertex (logarithmic)</text>\
         <text x=\"{right}\" y=\"{}\" text-anchor=\"end\" fill=\"#666\">bytes of the file</text>\
         <text x=\"0\" y=\"0\" text-anchor=\"middle\" transform=\"translate(18 {turn}) rotate(-90)\">psnr, dB</text>",
        bottom + 36.0,
        top - 27.0,
    );
    for curve in &mesh.ways {
        let [colour, dash] = look(curve.way);
        let lossy = curve.points.iter().map(|(_, m)| *m).filter(|m| m.psnr < PSNR_WITHOUT_LOSS);
        line(out, &axes, lossy, &format!("stroke=\"{colour}\" stroke-width=\"2\"{dash}"));
        for (point, m) in &curve.points {
            let [x, y] = axes.of(m);
            let title = format!(
                "{}: {}\n{} bytes, {:.2} bits a vertex, {}",
                point.way,
                point.setting,
                m.bytes,
                m.bpv,
                decibels(m.psnr)
            );
            if m.psnr >= PSNR_WITHOUT_LOSS {
                let _ = writeln!(
                    out,
                    "<path d=\"M{x:.1} {y:.1}v14m-4 -9l4 -5l4 5\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"><title>{}</title></path>",
                    escaped(&title)
                );
                continue;
            }
            let filled = m.same_connectivity == Verdict::Same;
            let _ = writeln!(out, "{}", mark(curve.way, x, y, filled, &title));
        }
    }
}

/// A psnr, or that there is none.
pub(super) fn decibels(psnr: f64) -> String {
    if psnr < PSNR_WITHOUT_LOSS { format!("{psnr:.2} dB") } else { "no loss".into() }
}

fn line<'a>(out: &mut String, axes: &Axes, points: impl Iterator<Item = &'a Measured>, style: &str) {
    let places: Vec<String> = points.map(|m| axes.of(m)).map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    if places.len() > 1 {
        let _ = writeln!(out, "<polyline points=\"{}\" fill=\"none\" stroke-linejoin=\"round\" {style}/>", places.join(" "));
    }
}

/// Which ways were refused, how often, and why the first time.
fn refusals(mesh: &MeshCurves<'_>, ways: &[&str]) -> String {
    let of_way = |curve: &WayCurve<'_>| {
        let (_, why) = curve.refused.first()?;
        let tried = curve.refused.len() + curve.points.len();
        Some(format!("{} refused {} of {tried}: {why}", ways[curve.way], curve.refused.len()))
    };
    mesh.ways.iter().filter_map(of_way).collect::<Vec<_>>().join("; ")
}

fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most { text.to_owned() } else { text.chars().take(most - 1).chain(['…']).collect() }
}

/// A round number without needless zeros.
fn digits(x: f64) -> String {
    let decimals = (1.0 - x.abs().max(1e-300).log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A round number of bytes.
fn bytes(x: f64) -> String {
    match x {
        _ if x < 999.5 => format!("{} B", digits(x)),
        _ if x < 999.5e3 => format!("{} kB", digits(x / 1e3)),
        _ => format!("{} MB", digits(x / 1e6)),
    }
}

/// Round numbers between two decimal logarithms, as many as have room for their labels over so many pixels.
fn logarithmic_ticks(ends: [f64; 2], pixels: f64, label: impl Fn(f64) -> String) -> Vec<(f64, String)> {
    const SETS: [&[f64]; 5] = [
        &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0],
        &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
        &[1.0, 2.0, 5.0],
        &[1.0, 3.0],
        &[1.0],
    ];
    let scale = pixels / (ends[1] - ends[0]);
    let ticks = |mantissas: &[f64], every: i32| -> Vec<(f64, String)> {
        let decades = (ends[0].floor() as i32..=ends[1].ceil() as i32).filter(|decade| decade % every == 0);
        let values = decades.flat_map(|decade| mantissas.iter().map(move |m| m * 10_f64.powi(decade)));
        values.filter(|v| (ends[0]..=ends[1]).contains(&v.log10())).map(|v| (v.log10(), label(v))).collect()
    };
    let has_room = |ticks: &[(f64, String)]| {
        ticks.windows(2).all(|w| (w[1].0 - w[0].0) * scale >= (text_width(&w[0].1) + text_width(&w[1].1)) / 2.0 + GAP)
    };
    let sparser = (1..).map(|every| ticks(&[1.0], every));
    SETS.iter().map(|set| ticks(set, 1)).chain(sparser.take(40)).find(|ticks| has_room(ticks)).unwrap_or_default()
}

/// Round numbers between two ends, as many as have room above each other over so many pixels.
fn linear_ticks(ends: [f64; 2], pixels: f64) -> Vec<f64> {
    const APART: f64 = 30.0;
    let span = ends[1] - ends[0];
    let steps = (-1..10).flat_map(|decade| [1.0, 2.0, 5.0].map(|m| m * 10_f64.powi(decade)));
    let Some(step) = steps.into_iter().find(|step| step / span * pixels >= APART) else { return Vec::new() };
    ((ends[0] / step).ceil() as i64..=(ends[1] / step).floor() as i64).map(|i| i as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn text_is_escaped_for_tags_and_attributes() {
        assert_eq!(escaped("a<b>&\"c'\u{1}"), "a&lt;b&gt;&amp;&quot;c&#39;\u{fffd}");
    }

    #[test]
    fn round_numbers_read_as_people_write_them() {
        assert_eq!([0.02, 0.5, 1.0, 1.5, 20.0, 500.0].map(digits), ["0.02", "0.5", "1", "1.5", "20", "500"]);
        assert_eq!([100.0, 1000.0, 1500.0, 2e5, 1e6].map(bytes), ["100 B", "1 kB", "1.5 kB", "200 kB", "1 MB"]);
        assert_eq!(linear_ticks([52.0, 99.0], 300.0), [55.0, 60.0, 65.0, 70.0, 75.0, 80.0, 85.0, 90.0, 95.0]);
    }

    proptest! {
        #[test]
        fn labels_of_an_axis_never_overlap_and_there_are_some(low in -3.0..8.0, span in 0.3..9.0) {
            let ticks = logarithmic_ticks([low, low + span], 516.0, bytes);
            prop_assert!(ticks.len() >= 2, "{:?}", ticks);
            for pair in ticks.windows(2) {
                let apart = (pair[1].0 - pair[0].0) / span * 516.0;
                prop_assert!(apart > (text_width(&pair[0].1) + text_width(&pair[1].1)) / 2.0);
            }
            let ticks = linear_ticks([low * 20.0, low * 20.0 + span * 20.0], 306.0);
            prop_assert!(ticks.len() >= 2 && ticks.windows(2).all(|w| w[1] > w[0]), "{:?}", ticks);
        }
    }
}
