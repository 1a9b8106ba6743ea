//! Lossless: every decoder returns the very samples.

use super::*;
use planes::{flat, noise, smooth, stretched};

/// Sizes at which transforms, code-blocks and tag trees have their corner cases.
const SIZES: [(u32, u32); 10] =
    [(1, 1), (1, 5), (3, 3), (2, 64), (257, 1), (64, 64), (65, 129), (122, 197), (7, 500), (400, 270)];

fn all_agree(planes: &Planes, settings: &Settings, with_commands: bool) {
    let stream = encoded(planes, settings);
    assert_same(&decoded(&stream), planes, 0, "hayro-jpeg2000");
    assert_same(&judges::openjpeg(&stream.bytes), planes, 0, "jpeg2k");
    if with_commands {
        for (name, found) in judges::commands(&stream.bytes, planes.len()) {
            assert_same(&found, planes, 0, name);
        }
    }
}

#[test]
fn every_size_and_number_of_components_comes_back_exactly() {
    for (i, (width, height)) in SIZES.into_iter().enumerate() {
        let shape = Shape::new(width, height).unwrap();
        for components in 1..=3 {
            let depths = vec![12; components];
            for planes in [noise(shape, &depths, 7), smooth(shape, &depths, 8), stretched(shape, &depths, 9)] {
                all_agree(&planes, &Settings::default(), i % 3 == components - 1);
            }
        }
    }
}

#[test]
fn every_depth_comes_back_exactly() {
    let shape = Shape::new(61, 45).unwrap();
    for depth in 1..=16 {
        for planes in
            [noise(shape, &[depth], 3), smooth(shape, &[depth; 3], 4), flat(shape, &[depth], 1.0), flat(shape, &[depth], 0.0)]
        {
            all_agree(&planes, &Settings::default(), depth % 5 == 1);
        }
    }
}

#[test]
fn components_of_different_depths_come_back_exactly() {
    let shape = Shape::new(90, 70).unwrap();
    all_agree(&noise(shape, &[12, 8, 1, 16], 3), &Settings::default(), false);
    all_agree(&smooth(shape, &[5, 16], 3), &Settings::default(), false);
}

#[test]
fn every_number_of_decompositions_and_both_block_sizes_come_back_exactly() {
    let planes = smooth(Shape::new(150, 131).unwrap(), &[11], 5);
    for levels in 0..=6 {
        for block in [5, 6] {
            all_agree(&planes, &Settings { levels, block, ..Settings::default() }, levels == 3);
        }
    }
}

#[test]
fn a_plane_wider_than_a_precinct_comes_back_exactly() {
    let planes = stretched(Shape::new(70_001, 9).unwrap(), &[10], 5);
    all_agree(&planes, &Settings { layers: 2, ..Settings::default() }, true);
}

#[test]
fn a_large_plane_comes_back_exactly() {
    all_agree(&smooth(Shape::new(1024, 1024).unwrap(), &[14], 6), &Settings::default(), true);
    all_agree(&noise(Shape::new(1024, 1024).unwrap(), &[16], 6), &Settings::default(), true);
}

#[test]
fn layers_of_a_lossless_stream_end_in_the_very_samples() {
    let planes = smooth(Shape::new(200, 150).unwrap(), &[12, 12, 12], 5);
    let settings = Settings { layers: 7, ..Settings::default() };
    all_agree(&planes, &settings, true);
    // Dividing the passes over layers costs little.
    let (one, seven) = (encoded(&planes, &Settings::default()), encoded(&planes, &settings));
    assert!(seven.bytes.len() * 100 < one.bytes.len() * 103, "{} and {} bytes", seven.bytes.len(), one.bytes.len());
}

#[test]
fn a_jp2_file_opens_in_every_decoder() {
    for depths in [&[12u8][..], &[9, 9], &[8, 8, 8], &[12, 8, 10], &[8, 8, 8, 8, 8]] {
        let planes = smooth(Shape::new(50, 40).unwrap(), depths, 2);
        let file = wrap(&encoded(&planes, &Settings::default()).bytes).unwrap();
        assert_same(&judges::openjpeg(&file), &planes, 0, "jpeg2k");
        let image = hayro_jpeg2000::Image::new(&file, &hayro_jpeg2000::DecodeSettings::default()).unwrap();
        let mut context = hayro_jpeg2000::DecoderContext::default();
        let pictures = image.decode(&mut context).unwrap();
        for (component, plane) in pictures.components().iter().zip(planes.iter()) {
            assert!(component.samples().iter().zip(plane.samples()).all(|(&a, &b)| a == b as f32));
        }
        if let Some(found) = judges::command("opj_decompress", &file, "jp2", depths.len()) {
            assert_same(&found, &planes, 0, "opj_decompress");
        }
    }
}

#[test]
fn the_bytes_are_the_same_for_any_number_of_threads() {
    let planes = smooth(Shape::new(400, 333).unwrap(), &[12, 12], 5);
    let lossy = Settings {
        transform: Transform::Irreversible97,
        quality: Quality::BitsPerPixel(2.0),
        layers: 3,
        ..Settings::default()
    };
    for settings in [Settings::default(), lossy] {
        let with = |threads| crate::par::with_threads(threads, || encoded(&planes, &settings)).unwrap();
        let one = with(1);
        assert!(with(2) == one && with(3) == one);
    }
}
