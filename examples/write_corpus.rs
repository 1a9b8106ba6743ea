//! Writes `corpus/files` and `corpus/expected.txt` anew: run it when the bytes of the format change on purpose.
//!
//! `cargo run --release --example write_corpus`

use std::fmt::Write;
use std::path::Path;

use gimc::{Codec, Decoder, Effort, EncodeOptions, GimChoices, Grid, Mesh, Metric, Roi, RoiPlace};
use trials::seal::{self, Chunk};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    for folder in ["valid", "invalid"] {
        std::fs::create_dir_all(corpus.join("files").join(folder))?;
    }
    let mut expected = String::from("# Written by `cargo run --release --example write_corpus`; see README.md.\n");
    let mut sound = Vec::new();
    for (name, mesh, options) in valid(&corpus)? {
        let bytes = options.encode(&mesh)?;
        let decoded = Decoder::new(&bytes)?.decode()?;
        writeln!(expected, "valid/{name}.gimc {} bytes, mesh {:016x}", bytes.len(), trials::fingerprint(&decoded))?;
        std::fs::write(corpus.join(format!("files/valid/{name}.gimc")), &bytes)?;
        sound = bytes;
    }
    for (name, bytes) in invalid(&sound) {
        let Err(why) = Decoder::new(&bytes).and_then(|d| d.decode()) else {
            return Err(format!("{name} was meant to be refused").into());
        };
        writeln!(expected, "invalid/{name}.gimc {why}")?;
        std::fs::write(corpus.join(format!("files/invalid/{name}.gimc")), bytes)?;
    }
    std::fs::write(corpus.join("expected.txt"), expected)?;
    Ok(())
}

/// Every way to choose the accuracy, every effort, every codec whose bytes are ours alone, every kind of mesh; the smallest last.
fn valid(corpus: &Path) -> Result<Vec<(&'static str, Mesh, EncodeOptions)>, Failure> {
    let open = |name: &str| Mesh::open(corpus.join("meshes").join(name));
    let triangle = Mesh::from_triangles(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]], [[0, 1, 2]]);
    let mut double = open("sphere.ply")?;
    double.positions.iter_mut().flatten().for_each(|x| *x = (*x + 1.0) / 3.0);
    double.precision = gimc::Scalar::F64;
    // Three faces at an edge, one turned over, one twice, and a vertex of none.
    let around = [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [-1.0, 0.5, 0.0], [-1.0, -0.5, 0.0], [3.0; 3]];
    let fan = Mesh::from_triangles(around.to_vec(), [[0, 1, 2], [0, 1, 3], [1, 0, 4], [1, 0, 4]]);
    let cgim = EncodeOptions::cgim;
    let gim = |side, codec| {
        let mut choices = GimChoices::quality();
        choices.grid = Grid::Side(side);
        EncodeOptions::gim().codec(codec).gim_choices(choices)
    };
    let staged = |options: EncodeOptions, stages: &[u8]| {
        let mut choices = gimc::ImageChoices::default();
        choices.stages = stages.to_vec();
        options.image(choices)
    };
    let at_one_end = Roi::new(RoiPlace::Box([[0.5, -9.0, -9.0], [9.0; 3]]));
    Ok(vec![
        ("bumpy_sphere-8-fast", open("bumpy_sphere.ply")?, cgim().bits(8).effort(Effort::Fast)),
        ("torus_with_holes-11", open("torus_with_holes.ply")?, cgim().bits(11)),
        ("terrain-step-fast", open("terrain.ply")?, cgim().step(2.0).effort(Effort::Fast)),
        ("genus_5-error-best", open("genus_5.ply")?, cgim().error(0.01).effort(Effort::Best)),
        ("block-14", open("block.ply")?, cgim().bits(14)),
        ("components-relative", open("components.ply")?, cgim().error_relative(1e-3)),
        ("sphere-gim-wavelet", open("sphere.ply")?, gim(17, Codec::Wavelet).step(0.02)),
        ("sphere-gim-j2k", open("sphere.ply")?, gim(9, Codec::J2k).step(0.05)),
        ("terrain-gim-wavelet", open("terrain.ply")?, gim(33, Codec::Wavelet).step(2.0)),
        ("terrain-gim-raw", open("terrain.ply")?, gim(12, Codec::Raw).bits(10)),
        ("terrain-gim-exr", open("terrain.ply")?, gim(9, Codec::Exr).bits(14)),
        ("torus_with_holes-gim", open("torus_with_holes.ply")?, gim(33, Codec::Wavelet).step(0.05)),
        ("genus_5-gim", open("genus_5.ply")?, gim(129, Codec::Wavelet).step(0.1)),
        ("components-gim", open("components.ply")?, gim(17, Codec::Wavelet).step(0.1)),
        ("bumpy_sphere-gim-roi", open("bumpy_sphere.ply")?, gim(33, Codec::Wavelet).step(0.02).roi(at_one_end.clone())),
        ("bumpy_sphere-8-roi", open("bumpy_sphere.ply")?, cgim().bits(8).roi(at_one_end.bits(12))),
        ("sphere-lattice", open("sphere.ply")?, cgim().lattice([-1.5, 0.25, 0.0], 0.01)),
        ("sphere-double-20", double, cgim().bits(20)),
        ("sphere-1-fast", open("sphere.ply")?, cgim().bits(1).effort(Effort::Fast)),
        ("bumpy_sphere-11-staged", open("bumpy_sphere.ply")?, staged(cgim().bits(11), &[2, 3])),
        ("torus_with_holes-10-mbcim-staged", open("torus_with_holes.ply")?, staged(cgim().bits(10).codec(Codec::Mbcim), &[3])),
        ("torus_with_holes-surface", open("torus_with_holes.ply")?, cgim().step(0.02).metric(Metric::Surface)),
        ("block-surface-best", open("block.ply")?, cgim().bits(9).metric(Metric::Surface).effort(Effort::Best)),
        ("components-8-raw", open("components.ply")?, cgim().bits(8).codec(Codec::Raw)),
        ("genus_5-9-j2k", open("genus_5.ply")?, cgim().bits(9).codec(Codec::J2k)),
        ("block-12-any-order", open("block.ply")?, cgim().bits(12).keep_order(true)),
        ("fan-6", fan, cgim().bits(6)),
        ("triangle-4-fast", triangle, cgim().bits(4).effort(Effort::Fast)),
    ])
}

/// Files that must be refused, made from a sound one.
fn invalid(sound: &[u8]) -> Vec<(&'static str, Vec<u8>)> {
    let with = |change: &dyn Fn(&mut Vec<Chunk>)| seal::changed(sound, change);
    let header = seal::open(sound)[0].1.len();
    let patched = |at: usize, byte: u8| {
        let mut bytes = sound.to_vec();
        bytes[at] = byte;
        bytes
    };
    vec![
        ("empty", Vec::new()),
        ("another_signature", patched(0, b'G')),
        ("another_version", patched(4, 0xff)),
        ("cut_short", sound[..sound.len() - 1].to_vec()),
        ("checksum", patched(sound.len() - 1, sound[sound.len() - 1] ^ 1)),
        ("bytes_after_the_end", [sound, b"x"].concat()),
        ("no_header", with(&|chunks| drop(chunks.remove(0)))),
        ("header_twice", with(&|chunks| chunks.push(chunks[0].clone()))),
        ("header_not_first", with(&|chunks| chunks.reverse())),
        ("no_body", with(&|chunks| chunks.truncate(1))),
        ("unknown_critical_chunk", with(&|chunks| chunks.push((*b"XTRA", vec![1, 2, 3])))),
        ("unknown_codec", with(&|chunks| chunks[0].1[0] = 0xee)),
        ("header_with_a_byte_too_many", with(&|chunks| chunks[0].1.push(0))),
        ("header_with_a_byte_too_few", with(&|chunks| chunks[0].1.truncate(header - 1))),
        ("vertices_that_the_body_lacks", with(&|chunks| chunks[0].1[2] += 1)),
        (
            "a_bound_that_is_no_number",
            with(&|chunks| {
                let end = chunks[0].1.len();
                chunks[0].1[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
            }),
        ),
    ]
}
