//! The specification holds: the dump in its text, its vectors, and the bytes of larger meshes.
//!
//! `GIMC_BLESS=1 cargo test --test it spec` writes `spec/vectors/` anew after a change of the format that is meant.
//! The dump in `spec/format.md` is mended by hand: the failing test prints the bytes.

use std::path::{Path, PathBuf};

use gimc::{Decoder, Effort, EncodeOptions, Mesh, Metric};

const EFFORTS: [(&str, Effort); 3] = [("fast", Effort::Fast), ("default", Effort::Default), ("best", Effort::Best)];

/// The original of all small examples.
fn tetrahedron() -> Mesh {
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut mesh = Mesh::from_triangles(positions, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    mesh.precision = gimc::Scalar::F32;
    mesh
}

/// A bent sheet of 7 × 7 vertices, whose inner ones may slide and are filtered.
fn slid_sheet() -> Mesh {
    let at = |i: u32| [f64::from(i % 7), f64::from(i / 7), 0.125 * f64::from((i % 7) * (i / 7))];
    let faces = (0..36).flat_map(|i| {
        let a = i % 6 + i / 6 * 7;
        [[a, a + 1, a + 8], [a, a + 8, a + 7]]
    });
    let mut mesh = Mesh::from_triangles((0..49).map(at).collect(), faces);
    mesh.precision = gimc::Scalar::F32;
    mesh
}

fn encode(mesh: &Mesh, bits: u32, effort: Effort) -> Vec<u8> {
    EncodeOptions::cgim().bits(bits).effort(effort).encode(mesh).unwrap()
}

fn spec(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("spec").join(name)
}

/// The text of a file, or, where it is to be written anew, `made`.
fn kept(name: &str, made: &[u8]) -> Vec<u8> {
    if std::env::var_os("GIMC_BLESS").is_some() {
        std::fs::write(spec(name), made).unwrap();
    }
    std::fs::read(spec(name)).expect(name)
}

/// FNV-1a of 64 bits. (A CRC-32 would be the same for any content: the chunks end with theirs.)
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// `v x y z` and `f a b c` lines, the vertices counted from 0.
fn as_text(mesh: &Mesh) -> String {
    let vertices = mesh.positions.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = mesh.faces.triangles();
    vertices.chain(faces.iter().map(|[a, b, c]| format!("f {a} {b} {c}\n"))).collect()
}

/// What stands between a line "```kind" and the next "```".
fn block(text: &str, kind: &str) -> String {
    let start = text.find(&format!("```{kind}\n")).expect(kind) + kind.len() + 4;
    text[start..].split("```").next().unwrap().to_owned()
}

#[test]
fn the_dump_in_the_text_is_what_the_encoder_writes_and_decodes_to_the_stated_mesh() {
    let text = std::fs::read_to_string(spec("format.md")).unwrap();
    let bytes: Vec<u8> = block(&text, "hex")
        .lines()
        .flat_map(|line| line.split('|').next().unwrap_or_default().split_whitespace())
        .map(|hex| u8::from_str_radix(hex, 16).expect(hex))
        .collect();
    let made = encode(&tetrahedron(), 8, Effort::Fast);
    assert_eq!(bytes, made, "the encoder writes {made:02x?}");
    assert_eq!(as_text(&Decoder::new(&bytes).unwrap().decode().unwrap()), block(&text, "mesh"));
}

#[test]
fn every_vector_is_what_the_encoder_writes_and_decodes_to_the_text_beside_it() {
    for (name, effort) in EFFORTS {
        let made = encode(&tetrahedron(), 8, effort);
        let bytes = kept(&format!("vectors/tetrahedron_{name}.gimc"), &made);
        assert_eq!(bytes, made, "{name}");
        let mesh = as_text(&Decoder::new(&bytes).unwrap().decode().unwrap());
        let text = kept(&format!("vectors/tetrahedron_{name}.txt"), mesh.as_bytes());
        assert_eq!(String::from_utf8(text).unwrap(), mesh, "{name}");
    }
    let mesh = slid_sheet();
    let made = EncodeOptions::cgim().step(0.125).metric(Metric::Surface).encode(&mesh).unwrap();
    let bytes = kept("vectors/sheet_surface.gimc", &made);
    assert_eq!(bytes, made, "the sheet");
    let decoded = as_text(&Decoder::new(&bytes).unwrap().decode().unwrap());
    let text = kept("vectors/sheet_surface.txt", decoded.as_bytes());
    assert_eq!(String::from_utf8(text).unwrap(), decoded, "the sheet");
}

/// A change of the stream that was not meant shows here, and a platform that computes otherwise.
#[test]
fn the_corpus_encodes_to_the_bytes_whose_checksums_are_on_record() {
    let mut folder: Vec<_> = std::fs::read_dir(crate::corpus::path("meshes")).unwrap().map(|e| e.unwrap().path()).collect();
    folder.sort();
    let mut table = String::new();
    for path in folder {
        let mesh = Mesh::open(&path).unwrap();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        for (effort_name, effort) in EFFORTS {
            let bytes = encode(&mesh, 11, effort);
            table += &format!("{name} 11 {effort_name} {} {:016x}\n", bytes.len(), fnv1a(&bytes));
        }
        for (effort_name, effort) in &EFFORTS[1..] {
            let options = EncodeOptions::cgim().bits(11).effort(*effort).metric(Metric::Surface);
            let bytes = options.encode(&mesh).unwrap();
            table += &format!("{name} 11 {effort_name},surface {} {:016x}\n", bytes.len(), fnv1a(&bytes));
        }
    }
    let record = String::from_utf8(kept("vectors/checksums.txt", table.as_bytes())).unwrap();
    let differ: Vec<_> = table.lines().zip(record.lines()).filter(|(a, b)| a != b).collect();
    assert!(table == record, "found and on record (mesh, bits, effort, bytes, FNV-1a): {differ:#?}");
}
