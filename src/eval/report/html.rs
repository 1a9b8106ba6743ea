//! A sweep as one page: curves, delta rates and all points. It needs nothing but itself: no script, style, font or picture
//! from elsewhere; without script it only lacks the sorting of the table.

use std::fmt::Write;

use super::csv::note;
use super::svg::{curves_svg, decibels, escaped};
use crate::eval::curve::BdRate;
use crate::eval::same::Verdict;
use crate::eval::sweep::{SweepPoint, SweepTable};

const STYLE: &str = "body{font:15px/1.45 sans-serif;margin:2em auto;max-width:1240px;padding:0 1em;color:#222;background:#fff}\
svg{max-width:100%;height:auto}table{border-collapse:collapse;font-size:13px;margin:.6em 0}\
th,td{padding:.25em .6em;border-bottom:1px solid #ddd;text-align:right;white-space:nowrap}\
th{border-bottom:2px solid #999;vertical-align:bottom}.t{text-align:left}.wrap{white-space:normal;min-width:16em}\
.wide{overflow-x:auto}#points th{cursor:pointer}#points th:hover{background:#eee}code{font-size:12px}\
.no{color:#a33}.best{font-weight:bold}.less{color:#0a6b3d}.more{color:#a33}";

/// Sorts by the column that was clicked, the other way round at the second click; numbers by `data-v`, empty ones last.
const SCRIPT: &str = "document.querySelectorAll('#points th').forEach((h,i)=>h.addEventListener('click',()=>{\
const b=document.querySelector('#points tbody'),d=h.dataset.d=h.dataset.d==='1'?'-1':'1',\
v=r=>r.cells[i].dataset.v??r.cells[i].textContent;\
[...b.rows].sort((p,q)=>{const x=v(p),y=v(q);if(x===''||y==='')return (x==='')-(y==='');\
const n=x-y;return d*(Number.isNaN(n)?x.localeCompare(y):n)}).forEach(r=>b.append(r))}));";

/// The page; `points` are those of the table, in the order in which they are to be listed.
pub fn report_html(table: &SweepTable<'_>, points: &[SweepPoint]) -> String {
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>Rate and distortion</title>\n<style>{STYLE}</style>\n\
         </head>\n<body>\n<h1>Rate and distortion</h1>\n"
    );
    let refused = points.iter().filter(|p| p.result.is_err()).count();
    let _ = writeln!(
        out,
        "<p>{} points of {} meshes in {} ways; {refused} refused. psnr = 20 log<sub>10</sub>(diagonal of the box / rms distance of the \
         surfaces, both directions pooled); the bytes are those of the whole file.</p>\n<h2>Curves</h2>\n{}",
        points.len(),
        table.meshes.len(),
        table.ways.len(),
        curves_svg(table)
    );
    delta_rates(&mut out, table);
    all_points(&mut out, table, points);
    let _ = writeln!(out, "<script>{SCRIPT}</script>\n</body>\n</html>");
    out
}

/// One row a mesh, one column a way, and the means.
fn delta_rates(out: &mut String, table: &SweepTable<'_>) {
    let _ = writeln!(
        out,
        "<h2>Bytes at equal psnr</h2>\n<p>Bjøntegaard delta rate against <b>{}</b>: the mean change of the bytes over the psnr that both \
         curves reach. −20 % is a fifth less.</p>\n<div class=\"wide\"><table>\n<thead><tr><th class=\"t\">mesh</th>",
        escaped(table.reference)
    );
    let others: Vec<usize> = (0..table.ways.len()).filter(|&way| table.ways[way] != table.reference).collect();
    for &way in &others {
        let _ = write!(out, "<th>{}</th>", escaped(table.ways[way]));
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for mesh in &table.meshes {
        let _ = write!(out, "<tr><td class=\"t\">{}</td>", escaped(mesh.mesh));
        for &way in &others {
            let bd_rate = mesh.ways.iter().find(|curve| curve.way == way).and_then(|curve| curve.bd_rate);
            let _ = match bd_rate {
                None => write!(out, "<td>–</td>"),
                Some(found @ BdRate::Over { psnr: [low, high], .. }) => {
                    write!(out, "<td title=\"over {low:.1} to {high:.1} dB\"{}", percent_cell(found.percent()))
                }
                Some(other) => write!(out, "<td class=\"no\">{}</td>", note(other)),
            };
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n<tfoot><tr><th class=\"t\">mean (of the logarithms)</th>");
    for &way in &others {
        let mean = table.means[way];
        let _ = match mean.percent {
            Some(_) => write!(out, "<td title=\"over {} meshes\"{}", mean.meshes, percent_cell(mean.percent)),
            None => write!(out, "<td>–</td>"),
        };
    }
    out.push_str("</tr></tfoot>\n</table></div>\n");
}

/// The rest of a cell, coloured by the sign.
fn percent_cell(percent: Option<f64>) -> String {
    let percent = percent.unwrap_or(0.0);
    format!(" class=\"{}\">{} %</td>", if percent <= 0.0 { "less" } else { "more" }, signed(percent))
}

/// With its sign, and a true minus.
fn signed(x: f64) -> String {
    format!("{x:+.1}").replace('-', "−")
}

fn all_points(out: &mut String, table: &SweepTable<'_>, points: &[SweepPoint]) {
    const HEADS: [&str; 17] = [
        "mesh",
        "way",
        "setting",
        "bytes",
        "bits a vertex",
        "psnr, dB",
        "vertex psnr, dB",
        "rms",
        "rms max",
        "hausdorff",
        "bound",
        "normals, °",
        "same connectivity",
        "vertices",
        "encode, s",
        "decode, s",
        "command, or why it was refused",
    ];
    out.push_str(
        "<h2>Points</h2>\n<p>A click on a heading sorts. Bold: no other point of the mesh has both fewer bytes and more psnr. Lengths \
         are in the units of the mesh. Each command, run where the sweep was run, makes the file of its point again.</p>\n\
         <div class=\"wide\"><table id=\"points\">\n<thead><tr>",
    );
    HEADS.iter().enumerate().for_each(|(i, head)| {
        let class = if i < 3 || i == HEADS.len() - 1 { " class=\"t\"" } else { "" };
        let _ = write!(out, "<th{class}>{head}</th>");
    });
    out.push_str("</tr></thead>\n<tbody>\n");
    for point in points {
        let is_best = table.meshes.iter().any(|mesh| mesh.front.iter().any(|best| std::ptr::eq(*best, point)));
        let _ = write!(out, "<tr{}>", if is_best { " class=\"best\"" } else { "" });
        for text in [&point.mesh, &point.way, &point.setting] {
            let _ = write!(out, "<td class=\"t\">{}</td>", escaped(text));
        }
        match &point.result {
            Ok(m) => {
                let length = |x: Option<f64>| (x, x.map_or(String::new(), |x| format!("{x:.3e}")));
                let quality = |x: Option<f64>| (x, x.map_or(String::new(), |x| decibels(x).replace(" dB", "")));
                let cells = [
                    (Some(m.bytes as f64), m.bytes.to_string()),
                    (Some(m.bpv), format!("{:.3}", m.bpv)),
                    quality(Some(m.psnr)),
                    quality(m.psnr_vertex),
                    length(Some(m.rms)),
                    length(Some(m.rms_max)),
                    length(Some(m.hausdorff)),
                    length(m.bound),
                    (m.normal_rms, m.normal_rms.map_or(String::new(), |x| format!("{x:.2}"))),
                ];
                for (value, shown) in cells {
                    let value = value.map_or(String::new(), |x| format!("{x:?}"));
                    let _ = write!(out, "<td data-v=\"{value}\">{shown}</td>");
                }
                let same = match m.same_connectivity {
                    Verdict::Same => "yes",
                    Verdict::Different => "no",
                    Verdict::Undecided => "undecided",
                };
                let _ = write!(out, "<td>{same}</td><td>{}</td>", m.vertices_b);
                let [encode, decode] = m.seconds;
                let _ = write!(
                    out,
                    "<td>{encode:.3}</td><td>{decode:.3}</td><td class=\"t\"><code>{}</code></td>",
                    escaped(&point.command)
                );
            }
            Err(why) => {
                (0..HEADS.len() - 4).for_each(|_| out.push_str("<td data-v=\"\"></td>"));
                let _ = write!(
                    out,
                    "<td class=\"t wrap no\">refused: {}<br><code>{}</code></td>",
                    escaped(why),
                    escaped(&point.command)
                );
            }
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n</table></div>\n");
}
