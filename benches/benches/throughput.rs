//! Throughput of encoding, decoding, reading, and distance queries.
//!
//! `cargo bench --manifest-path benches/Cargo.toml`; `-- encode` for one group. Vertices a second, or points a second.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use gimc::eval::CompareOptions;
use gimc::{Decoder, Effort, EncodeOptions, Format, GeometryImage, Gluing, Mesh, ResizeMethod, ResizeOptions, Task};

const EFFORTS: [(&str, Effort); 3] = [("fast", Effort::Fast), ("default", Effort::Default), ("best", Effort::Best)];
const SHAPES: [&str; 3] = ["bumpy_sphere", "terrain", "block"];

fn mesh(name: &str, faces: usize) -> Mesh {
    let shape = corpus_make::by_name(name, faces, 1).expect("a shape of the generator");
    Mesh::from_triangles(shape.positions, shape.triangles)
}

fn coding(c: &mut Criterion) {
    let mut group = c.benchmark_group("encode");
    group.sample_size(10).measurement_time(Duration::from_secs(3)).warm_up_time(Duration::from_millis(500));
    for name in SHAPES {
        let mesh = mesh(name, 50_000);
        group.throughput(Throughput::Elements(mesh.positions.len() as u64));
        for (word, effort) in EFFORTS {
            let options = EncodeOptions::cgim().bits(11).effort(effort);
            group.bench_function(BenchmarkId::new(name, word), |b| b.iter(|| options.encode(black_box(&mesh)).expect("bytes")));
        }
    }
    group.finish();
    let mut group = c.benchmark_group("decode");
    group.sample_size(10).measurement_time(Duration::from_secs(3)).warm_up_time(Duration::from_millis(500));
    for name in SHAPES {
        let mesh = mesh(name, 50_000);
        group.throughput(Throughput::Elements(mesh.positions.len() as u64));
        for (word, effort) in EFFORTS {
            let bytes = EncodeOptions::cgim().bits(11).effort(effort).encode(&mesh).expect("bytes");
            let decode = || Decoder::new(black_box(&bytes)).and_then(|d| d.decode()).expect("a mesh");
            group.bench_function(BenchmarkId::new(name, word), |b| b.iter(decode));
        }
    }
    group.finish();
}

fn files(c: &mut Criterion) {
    let mut group = c.benchmark_group("read");
    group.sample_size(10).measurement_time(Duration::from_secs(2)).warm_up_time(Duration::from_millis(500));
    let mesh = mesh("terrain", 100_000);
    for format in Format::ALL {
        let mut bytes = Vec::new();
        mesh.write(format, &mut bytes).expect("a file");
        group.throughput(Throughput::Bytes(bytes.len() as u64));
        group.bench_function(format.name(), |b| b.iter(|| Mesh::read(black_box(&bytes), Some(format)).expect("a mesh")));
    }
    group.finish();
}

/// Closest points through the tree of boxes: a comparison is building two and asking them.
fn distances(c: &mut Criterion) {
    let mut group = c.benchmark_group("distance");
    group.sample_size(10).measurement_time(Duration::from_secs(4)).warm_up_time(Duration::from_millis(500));
    const POINTS: usize = 100_000;
    for name in SHAPES {
        let mesh = mesh(name, 50_000);
        let file = EncodeOptions::cgim().bits(9).effort(Effort::Fast).encode(&mesh).expect("bytes");
        let back = Decoder::new(&file).and_then(|d| d.decode()).expect("a mesh");
        let options = CompareOptions::default().samples(POINTS);
        group.throughput(Throughput::Elements(2 * POINTS as u64));
        let compare = || gimc::eval::compare(&mesh, &back, &options, &Task::default()).expect("measures");
        group.bench_function(name, |b| b.iter(compare));
    }
    group.finish();
}

/// Six warps from 500 x 500 to 150 x 150 samples, each two systems of up to 250,000 equations.
fn resizing(c: &mut Criterion) {
    let mut group = c.benchmark_group("resize");
    group.sample_size(10).measurement_time(Duration::from_secs(5)).warm_up_time(Duration::from_millis(500));
    let side = 500;
    let point = |p: usize| {
        let (x, y) = ((p % side) as f64 / (side - 1) as f64, (p / side) as f64 / (side - 1) as f64);
        let bump = |a: f64, b: f64, w: f64| (-((x - a) * (x - a) + (y - b) * (y - b)) * w).exp();
        [x, y, 0.2 * bump(0.3, 0.4, 200.0) - 0.1 * bump(0.8, 0.7, 900.0) + 0.01 * (40.0 * x).sin() * (25.0 * y * y).cos()]
    };
    let image = GeometryImage::new(side, side, Gluing::Open, (0..side * side).map(point).collect()).expect("an image");
    group.throughput(Throughput::Elements((side * side) as u64));
    for method in [ResizeMethod::Content, ResizeMethod::Direct, ResizeMethod::Bicubic] {
        let options = ResizeOptions::new(method);
        let resize = || options.resize(black_box(&image), 150, 150, &Task::default()).expect("an image");
        group.bench_function(method.name(), |b| b.iter(resize));
    }
    group.finish();
}

criterion_group!(benches, coding, files, distances, resizing);
criterion_main!(benches);
