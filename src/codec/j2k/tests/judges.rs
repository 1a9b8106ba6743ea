//! Decoders to judge by: `hayro-jpeg2000`, OpenJPEG through the crate `jpeg2k`, and the installed commands
//! `opj_decompress` and `grk_decompress`.

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use super::*;

/// OpenJPEG, by the crate `jpeg2k`, in its strict mode.
pub(super) fn openjpeg(codestream: &[u8]) -> Planes {
    let parameters = jpeg2k::DecodeParameters::new().strict(true);
    let image = jpeg2k::Image::from_bytes_with(codestream, parameters).unwrap();
    let planes = image.components().iter().map(|c| {
        assert!(!c.is_signed());
        Plane::new(Shape::new(c.width(), c.height()).unwrap(), c.precision() as u8, c.data().to_vec()).unwrap()
    });
    Planes::new(planes.collect()).unwrap()
}

/// A decoder that is a command; none if it is not installed.
pub(super) fn command(name: &str, file: &[u8], extension: &str, components: usize) -> Option<Planes> {
    static COUNTER: AtomicU32 = AtomicU32::new(0);
    let unique = format!("gimc-judge-{}-{}", std::process::id(), COUNTER.fetch_add(1, Ordering::Relaxed));
    let folder = std::env::temp_dir().join(unique);
    std::fs::create_dir(&folder).unwrap();
    let input = folder.join(format!("in.{extension}"));
    std::fs::write(&input, file).unwrap();
    let run = Command::new(name).arg("-i").arg(&input).arg("-o").arg(folder.join("out.pgx")).stdin(Stdio::null()).output();
    let planes = run.ok().map(|run| {
        let said = String::from_utf8_lossy(&run.stdout).into_owned() + &String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success(), "{name} refuses the codestream: {said}");
        let plane = |i| {
            let names = [format!("out_{i}.pgx"), format!("out-{i}.pgx"), "out.pgx".to_owned()];
            let name = names.iter().map(|n| folder.join(n)).find(|p| p.exists()).unwrap();
            read_pgx(&name)
        };
        Planes::new((0..components).map(plane).collect()).unwrap()
    });
    std::fs::remove_dir_all(&folder).unwrap();
    if planes.is_none() {
        eprintln!("skipped: {name} is not installed");
    }
    planes
}

/// One component, as PGX: a line of text, then samples of one or two bytes.
fn read_pgx(path: &Path) -> Plane {
    let bytes = std::fs::read(path).unwrap();
    let end = bytes.iter().position(|&b| b == b'\n').unwrap();
    let line = std::str::from_utf8(&bytes[..end]).unwrap();
    let words: Vec<&str> = line.split_whitespace().flat_map(|w| w.split('+')).filter(|w| !w.is_empty()).collect();
    let ["PG", "ML", depth, width, height] = words[..] else { panic!("a PGX header of {line:?}") };
    let depth: u8 = depth.parse().unwrap();
    let shape = Shape::new(width.parse().unwrap(), height.parse().unwrap()).unwrap();
    let samples = bytes[end + 1..].chunks_exact(if depth > 8 { 2 } else { 1 });
    Plane::new(shape, depth, samples.map(|s| s.iter().fold(0, |n, &b| n << 8 | i32::from(b))).collect()).unwrap()
}

/// What the commands that are installed make of a codestream, by name.
pub(super) fn commands(codestream: &[u8], components: usize) -> Vec<(&'static str, Planes)> {
    ["opj_decompress", "grk_decompress"]
        .into_iter()
        .filter_map(|name| Some((name, command(name, codestream, "j2k", components)?)))
        .collect()
}

/// The same for a codestream of so many bit-planes: Grok takes fewer than the others.
pub(super) fn commands_for_planes(codestream: &[u8], components: usize, planes: u8) -> Vec<(&'static str, Planes)> {
    if planes < 25 {
        return commands(codestream, components);
    }
    command("opj_decompress", codestream, "j2k", components).map(|p| ("opj_decompress", p)).into_iter().collect()
}
