//! Our side of `against_draco`: encodes and decodes one mesh, and prints bytes, seconds and memory as JSON.
//!
//! `side MESH BITS EFFORT THREADS REPS [DUMP.ply]`. Times are the least of REPS runs, without file access. Memory is the rise of
//! the peak of this process above what it held with the mesh loaded. DUMP gets the vertices and triangles that are coded.

use std::time::Instant;

use gimc::eval::Json;
use gimc::{Decoder, Effort, EncodeOptions, Format, Mesh};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, bits, effort, threads, reps, dump @ ..] = arguments.as_slice() else {
        return Err("use: side MESH BITS EFFORT THREADS REPS [DUMP.ply]".into());
    };
    let effort = match effort.as_str() {
        "fast" => Effort::Fast,
        "default" => Effort::Default,
        "best" => Effort::Best,
        _ => return Err("EFFORT is fast, default or best".into()),
    };
    let mesh = used(&Mesh::open(file)?);
    if let [dump] = dump {
        mesh.write(Format::Ply, std::fs::File::create(dump)?)?;
    }
    let options = EncodeOptions::cgim().bits(bits.parse()?).effort(effort);
    let reps: usize = reps.parse()?;
    let json = gimc::with_threads(threads.parse()?, || measure(&mesh, &options, reps))??;
    println!("{json}");
    Ok(())
}

fn measure(mesh: &Mesh, options: &EncodeOptions, reps: usize) -> gimc::Result<Json> {
    let before = peak();
    let (bytes, encode_s) = best_of(reps, || options.encode(mesh))?;
    let encode_memory = peak().saturating_sub(before);
    let (back, decode_s) = best_of(reps, || Decoder::new(&bytes)?.decode())?;
    Ok(Json::object([
        ("vertices", mesh.positions.len().into()),
        ("faces", back.faces.len().into()),
        ("bytes", bytes.len().into()),
        ("encode_s", encode_s.into()),
        ("decode_s", decode_s.into()),
        ("encode_memory", encode_memory.into()),
        ("decode_memory", Decoder::new(&bytes)?.info().memory.into()),
    ]))
}

fn best_of<T>(reps: usize, f: impl Fn() -> gimc::Result<T>) -> gimc::Result<(T, f64)> {
    let timed = || {
        let start = Instant::now();
        f().map(|result| (result, start.elapsed().as_secs_f64()))
    };
    let mut best = timed()?;
    for _ in 1..reps {
        let next = timed()?;
        if next.1 < best.1 {
            best = next;
        }
    }
    Ok(best)
}

/// The triangles and the vertices that they use, as peers get them.
fn used(mesh: &Mesh) -> Mesh {
    let triangles = mesh.faces.triangles();
    let mut number = vec![u32::MAX; mesh.positions.len()];
    triangles.iter().flatten().for_each(|&v| number[v as usize] = 0);
    let mut positions = Vec::new();
    for (v, p) in mesh.positions.iter().enumerate() {
        if number[v] == 0 {
            number[v] = positions.len() as u32;
            positions.push(*p);
        }
    }
    Mesh::from_triangles(positions, triangles.iter().map(|t| t.map(|v| number[v as usize])))
}

/// The most memory this process has held, in bytes; 0 where the system does not tell.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    line.and_then(|l| l.trim().trim_end_matches(" kB").parse::<u64>().ok()).map_or(0, |kb| kb << 10)
}
