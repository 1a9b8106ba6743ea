//! Side by side with `opj_compress`: bytes, psnr and seconds of both, on the same planes in one run.
//!
//! ```text
//! GIMC_PLANES=FOLDER cargo test --release --lib side_by_side -- --ignored --nocapture
//! ```
//!
//! FOLDER holds PPM or PGM pictures of up to 16 bits, such as position planes; two synthetic images come with it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use super::*;

/// The least time of so many runs counts. That of `opj_compress` has the start of a process and reading a file in it.
const RUNS: usize = 3;

/// A binary PPM or PGM picture; the deepest sample's bits are its maximum's.
fn read_pnm(path: &Path) -> Planes {
    let bytes = std::fs::read(path).unwrap();
    let mut words = Vec::new();
    let mut at = 0;
    while words.len() < 4 {
        let end = at + bytes[at..].iter().position(u8::is_ascii_whitespace).unwrap();
        words.push(std::str::from_utf8(&bytes[at..end]).unwrap().to_owned());
        at = end + 1;
    }
    let components = if words[0] == "P6" { 3 } else { 1 };
    let [width, height, most] = [1, 2, 3].map(|i| words[i].parse::<u32>().unwrap());
    let shape = Shape::new(width, height).unwrap();
    let size = if most > 255 { 2 } else { 1 };
    let samples: Vec<i32> = bytes[at..].chunks_exact(size).map(|s| s.iter().fold(0, |n, &b| n << 8 | i32::from(b))).collect();
    let depth = (u32::BITS - most.leading_zeros()) as u8;
    let plane = |i| Plane::new(shape, depth, samples.iter().skip(i).step_by(components).copied().collect()).unwrap();
    Planes::new((0..components).map(plane).collect()).unwrap()
}

fn write_pnm(planes: &Planes, path: &Path) {
    let kind = if planes.len() == 3 { "P6" } else { "P5" };
    let most = (1u32 << planes[0].depth()) - 1;
    let mut bytes = format!("{kind}\n{} {}\n{most}\n", planes.shape().width(), planes.shape().height()).into_bytes();
    for at in 0..planes.shape().pixels() {
        for plane in planes.iter() {
            let sample = plane.samples()[at] as u16;
            if most > 255 { bytes.extend(sample.to_be_bytes()) } else { bytes.push(sample as u8) }
        }
    }
    std::fs::write(path, bytes).unwrap();
}

/// `opj_compress` with these arguments: its codestream and its seconds.
fn opj(folder: &Path, planes: &Planes, arguments: &[&str]) -> Option<(Vec<u8>, f64)> {
    let (input, output) = (folder.join("in.ppm"), folder.join("out.j2k"));
    write_pnm(planes, &input);
    let mut least = f64::INFINITY;
    for _ in 0..RUNS {
        let start = Instant::now();
        let run = Command::new("opj_compress").arg("-i").arg(&input).arg("-o").arg(&output).args(arguments).output();
        assert!(run.ok()?.status.success(), "opj_compress {arguments:?}");
        least = least.min(start.elapsed().as_secs_f64());
    }
    Some((std::fs::read(output).unwrap(), least))
}

/// Our own encoder: its stream and its seconds with one thread and with two.
fn ours(planes: &Planes, settings: &Settings) -> (Encoded, [f64; 2]) {
    let timed = |threads| {
        let run = || {
            let start = Instant::now();
            let stream = encoded(planes, settings);
            (stream, start.elapsed().as_secs_f64())
        };
        let runs = crate::par::with_threads(threads, || (0..RUNS).map(|_| run()).collect::<Vec<_>>()).unwrap();
        let least = runs.iter().map(|r| r.1).fold(f64::INFINITY, f64::min);
        (runs.into_iter().next().unwrap().0, least)
    };
    let ((stream, one), (same, two)) = (timed(1), timed(2));
    assert!(stream == same, "two threads make other bytes");
    (stream, [one, two])
}

fn images() -> Vec<(String, Planes)> {
    let mut found = vec![
        ("synthetic smooth".to_owned(), planes::smooth(Shape::new(640, 480).unwrap(), &[12, 12, 12], 1)),
        ("synthetic stretched".to_owned(), planes::stretched(Shape::new(500, 700).unwrap(), &[12, 12, 12], 2)),
    ];
    let Some(folder) = std::env::var_os("GIMC_PLANES") else {
        println!("GIMC_PLANES is not set: only the synthetic images");
        return found;
    };
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    found.extend(files.iter().map(|f| (f.file_name().unwrap().to_string_lossy().into_owned(), read_pnm(f))));
    found
}

#[test]
#[ignore = "a minute or two, and needs opj_compress"]
fn side_by_side_with_opj_compress() {
    let folder = std::env::temp_dir().join(format!("gimc-side-by-side-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    println!(
        "{:22} {:>11} {:>9} {:>9} {:>7} {:>7} {:>7} {:>15}",
        "image", "", "opj", "ours", "", "opj", "ours", "seconds: opj 1 2"
    );
    let mut failed = Vec::new();
    for (name, planes) in images() {
        let resolutions = (partition::most_levels(planes.shape()).min(5) + 1).to_string();
        let common = ["-mct", "0", "-n", &resolutions, "-b", "64,64"];
        let Some((theirs, opj_seconds)) = opj(&folder, &planes, &common) else {
            println!("skipped: opj_compress is not installed");
            break;
        };
        let (stream, [one, two]) = ours(&planes, &Settings::default());
        let share = stream.bytes.len() as f64 / theirs.len() as f64 - 1.0;
        println!(
            "{name:22} {:>11} {:>9} {:>9} {:>6.2}% {:>7} {:>7} {opj_seconds:>7.3} {one:.3} {two:.3}",
            "lossless",
            theirs.len(),
            stream.bytes.len(),
            100.0 * share,
            "",
            ""
        );
        if share > 0.005 {
            failed.push(format!("{name}: {:.2} % more bytes", 100.0 * share));
        }
        for ratio in ["8", "16", "32", "64"] {
            let (theirs, opj_seconds) = opj(&folder, &planes, &[&common[..], &["-I", "-r", ratio]].concat()).unwrap();
            let settings = Settings {
                transform: Transform::Irreversible97,
                quality: Quality::Bytes(theirs.len() as u64),
                ..Settings::default()
            };
            let (stream, [one, two]) = ours(&planes, &settings);
            // Each by the same decoder.
            let (a, b) = (psnr(&planes, &judges::openjpeg(&theirs)), psnr(&planes, &judges::openjpeg(&stream.bytes)));
            println!(
                "{name:22} {:>11} {:>9} {:>9} {:>7} {a:>7.2} {b:>7.2} {opj_seconds:>7.3} {one:.3} {two:.3}",
                format!("9/7 1:{ratio}"),
                theirs.len(),
                stream.bytes.len(),
                ""
            );
            if b < a - 0.1 {
                failed.push(format!("{name} 1:{ratio}: {b:.2} dB, not {a:.2}"));
            }
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(failed.is_empty(), "{failed:#?}");
}
