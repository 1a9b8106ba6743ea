//! The files of the corpus, sorted by what should happen: decode, be refused, do no harm.
//!
//! `corpus/expected.txt` has a line for each; `cargo run --release --example write_corpus` writes it, and the files, anew.

use gimc::{Decoder, Effort, EncodeOptions, Mesh};

use crate::corpus;

/// The lines of `expected.txt` for one folder: file, what is expected.
fn expected(folder: &str) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(corpus::path("expected.txt")).unwrap();
    let lines = text.lines().filter_map(|l| l.strip_prefix(folder)?.strip_prefix('/')?.split_once(' '));
    let found: Vec<(String, String)> = lines.map(|(file, what)| (file.to_owned(), what.to_owned())).collect();
    assert!(!found.is_empty(), "no lines for {folder}");
    found
}

fn files(folder: &str) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(corpus::path("files").join(folder)) else { return vec![] };
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.retain(|name| name != "README.md");
    names.sort();
    names
}

fn read(folder: &str, file: &str) -> Vec<u8> {
    std::fs::read(corpus::path("files").join(folder).join(file)).unwrap()
}

#[test]
fn every_valid_file_decodes_to_the_mesh_it_always_decoded_to() {
    for (file, what) in expected("valid") {
        let bytes = read("valid", &file);
        let mesh = Decoder::new(&bytes).and_then(|d| d.decode()).unwrap_or_else(|e| panic!("{file}: {e}"));
        let found = format!("{} bytes, mesh {:016x}", bytes.len(), trials::fingerprint(&mesh));
        assert_eq!(found, what, "{file}");
    }
}

#[test]
fn every_invalid_file_is_refused_with_its_own_words() {
    for (file, what) in expected("invalid") {
        let bytes = read("invalid", &file);
        match Decoder::new(&bytes).and_then(|d| d.decode()) {
            Ok(_) => panic!("{file} was not refused"),
            Err(why) => assert_eq!(why.to_string(), what, "{file}"),
        }
    }
}

#[test]
fn every_file_of_the_corpus_is_listed() {
    for folder in ["valid", "invalid"] {
        let mut listed: Vec<String> = expected(folder).into_iter().map(|line| line.0).collect();
        listed.sort();
        assert_eq!(files(folder), listed, "{folder}");
    }
}

#[test]
fn what_once_crashed_something_does_no_harm() {
    for file in files("crashers") {
        let bytes = read("crashers", &file);
        drop(trials::decode(&bytes));
        if let Some(format) = file.rsplit('.').next().and_then(gimc::Format::from_name) {
            trials::read(&bytes, format);
        }
    }
}

#[test]
fn the_encoder_still_makes_the_valid_files() {
    let open = |name: &str| Mesh::open(corpus::path("meshes").join(name)).unwrap();
    for (file, mesh, options) in [
        ("bumpy_sphere-8-fast.gimc", "bumpy_sphere.ply", EncodeOptions::cgim().bits(8).effort(Effort::Fast)),
        ("torus_with_holes-11.gimc", "torus_with_holes.ply", EncodeOptions::cgim().bits(11)),
        ("genus_5-error-best.gimc", "genus_5.ply", EncodeOptions::cgim().error(0.01).effort(Effort::Best)),
    ] {
        assert!(
            options.encode(&open(mesh)).unwrap() == read("valid", file),
            "{file}: run the example write_corpus if that is meant"
        );
    }
}
