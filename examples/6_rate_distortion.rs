//! What quality costs: a mesh in three ways, as a table, curves and a report.
//!
//! `cargo run --release --example 6_rate_distortion -- corpus/meshes/bumpy_sphere.ply OUT_DIR`
//!
//! `gimc sweep` does the same with more ways and meshes, and other programs beside them.

#![allow(clippy::print_stdout)]

use std::path::Path;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use gimc::eval::{OwnCoder, Sweep, SweepMesh, SweepTable, curves_svg, points_csv, read_points, report_html};
use gimc::{Codec, EncodeOptions, Task};

/// Seconds since the first call.
fn clock() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [input, folder] = arguments.as_slice() else {
        return Err("use: 6_rate_distortion MESH OUT_DIR".into());
    };
    let folder = Path::new(folder);
    std::fs::create_dir_all(folder)?;
    // What an earlier run measured is not measured again.
    let table = folder.join("points.csv");
    let known = if table.exists() { read_points(&std::fs::read_to_string(&table)?)? } else { Vec::new() };
    let mut sweep = Sweep::new(vec![SweepMesh::open(input)?], known).jobs(2);
    let mut add = |way: &str, setting: String, options: EncodeOptions| {
        let command = format!("gimc encode {input} out.gimc {setting}");
        sweep.add(0, way, setting, command, Arc::new(OwnCoder::new(options, clock)));
    };
    for bits in [7, 9, 11, 13] {
        add("surface", format!("--bits {bits}"), EncodeOptions::cgim().bits(bits));
        add("mbcim", format!("--codec mbcim --bits {bits}"), EncodeOptions::cgim().codec(Codec::Mbcim).bits(bits));
    }
    for psnr in [50.0, 55.0, 60.0] {
        add("gim", format!("--method gim --psnr {psnr}"), EncodeOptions::gim().psnr(psnr));
    }
    let swept = sweep.run(&|points| Ok(std::fs::write(&table, points_csv(points.iter().copied()))?), Task::default());
    let curves = SweepTable::new(&swept.points, Some("surface"))?;
    std::fs::write(folder.join("curves.svg"), curves_svg(&curves))?;
    std::fs::write(folder.join("report.html"), report_html(&curves, &swept.points))?;
    for point in &swept.points {
        match &point.result {
            Ok(m) => println!("{:8} {:8} bytes {:7.2} dB  {}", point.way, m.bytes, m.psnr, point.setting),
            Err(why) => println!("{:8} refused: {why}", point.way),
        }
    }
    for (way, mean) in curves.ways.iter().zip(&curves.means) {
        if let Some(percent) = mean.percent {
            println!("{way}: {percent:+.1} % of the bytes of {} at equal psnr", curves.reference);
        }
    }
    swept.stopped.map_or(Ok(()), |error| Err(error.into()))
}
