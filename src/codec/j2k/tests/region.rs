//! Regions of interest: exact inside, whatever the rate outside.

use super::*;
use planes::{Random, noise, smooth, stretched};

/// A disk, a bar and scattered pixels.
fn masks(shape: Shape) -> Vec<Mask> {
    let (h, w) = (shape.height() as f64, shape.width() as f64);
    let mut random = Random::new(5);
    vec![
        Mask::from_fn(shape, |r, c| (r as f64 - h / 3.0).powi(2) + (c as f64 - w / 2.0).powi(2) < (h.min(w) / 5.0).powi(2)),
        Mask::from_fn(shape, |r, c| r > c && r < c + 4),
        Mask::from_fn(shape, |_, _| random.below(900) == 0),
    ]
}

fn differs_inside(a: &Planes, b: &Planes, mask: &Mask) -> bool {
    a.iter()
        .zip(b.iter())
        .any(|(a, b)| a.samples().iter().zip(b.samples()).zip(mask.iter()).any(|((x, y), inside)| inside && x != y))
}

#[test]
fn a_region_is_exact_in_every_decoder_while_the_rest_is_not() {
    for (i, (shape, depths)) in [((120, 90), &[12u8, 12, 12][..]), ((64, 65), &[8]), ((200, 40), &[13])].into_iter().enumerate()
    {
        let shape = Shape::new(shape.0, shape.1).unwrap();
        for planes in [smooth(shape, depths, 4), noise(shape, depths, 5), stretched(shape, depths, 6)] {
            for mask in masks(shape) {
                let region = Settings { region: Some(&mask), ..Settings::default() };
                let lossless = encoded(&planes, &region);
                let bytes = lossless.bytes.len() as u64 * 2 / 3;
                let settings = Settings { quality: Quality::Bytes(bytes), ..region };
                let stream = encoded(&planes, &settings);
                let found = decoded(&stream);
                assert!(!differs_inside(&found, &planes, &mask), "inside {shape}");
                assert!(found != planes);
                assert_same(&judges::openjpeg(&stream.bytes), &found, 0, "jpeg2k");
                if i < 2 {
                    for (name, other) in judges::commands_for_planes(&stream.bytes, planes.len(), 2 * depths[0] + 6) {
                        assert_same(&other, &found, 0, name);
                    }
                }
            }
        }
    }
}

#[test]
fn all_samples_of_a_lossless_stream_with_a_region_are_exact() {
    let shape = Shape::new(130, 77).unwrap();
    for depths in [&[12u8, 12][..], &[1], &[13]] {
        let planes = noise(shape, depths, 4);
        for mask in masks(shape) {
            let stream = encoded(&planes, &Settings { region: Some(&mask), ..Settings::default() });
            assert_same(&decoded(&stream), &planes, 0, "hayro-jpeg2000");
            assert_same(&judges::openjpeg(&stream.bytes), &planes, 0, "jpeg2k");
            for (name, found) in judges::commands_for_planes(&stream.bytes, planes.len(), 2 * depths[0] + 6) {
                assert_same(&found, &planes, 0, name);
            }
        }
    }
}

#[test]
fn a_region_is_exact_from_the_layer_on_that_has_room_for_it() {
    let shape = Shape::new(256, 200).unwrap();
    let planes = smooth(shape, &[12, 12, 12], 4);
    let mask = Mask::from_fn(shape, |r, c| (100..116).contains(&r) && (100..130).contains(&c));
    let settings = Settings { region: Some(&mask), layers: 4, ..Settings::default() };
    let whole = encoded(&planes, &settings);
    for layers in 1..=4 {
        let found = decoded(&whole.first_layers(layers).unwrap());
        assert!(!differs_inside(&found, &planes, &mask), "{layers} layers");
        assert_eq!(found == planes, layers == 4);
    }
}

#[test]
fn a_region_sharpens_an_irreversible_stream_too() {
    let shape = Shape::new(256, 200).unwrap();
    let planes = stretched(shape, &[12], 4);
    let mask = Mask::from_fn(shape, |r, c| (50..90).contains(&r) && (60..130).contains(&c));
    let settings = |region| Settings {
        transform: Transform::Irreversible97,
        quality: Quality::BitsPerPixel(1.5),
        region,
        ..Settings::default()
    };
    let worst = |found: &Planes| {
        let differences = found[0].samples().iter().zip(planes[0].samples()).zip(mask.iter());
        differences.filter(|(_, inside)| *inside).map(|((a, b), _)| (a - b).abs()).max().unwrap()
    };
    let (with, without) = (encoded(&planes, &settings(Some(&mask))), encoded(&planes, &settings(None)));
    let (with, without) = (worst(&decoded(&with)), worst(&decoded(&without)));
    assert!(with <= 3 && without > 10, "{with} and {without}");
    let stream = encoded(&planes, &settings(Some(&mask)));
    let other = judges::openjpeg(&stream.bytes);
    let difference = other[0].samples().iter().zip(decoded(&stream)[0].samples()).map(|(a, b)| (a - b).abs()).max().unwrap();
    // Half a step of a shifted coefficient is lost in some decoders.
    assert!(difference <= 4, "decoders differ by {difference}");
}

#[test]
fn a_region_of_everything_or_of_nothing_is_no_region() {
    let shape = Shape::new(50, 40).unwrap();
    let planes = smooth(shape, &[16], 4);
    let plain = encoded(&planes, &Settings::default());
    for inside in [false, true] {
        let mask = Mask::from_fn(shape, |_, _| inside);
        assert!(encoded(&planes, &Settings { region: Some(&mask), ..Settings::default() }) == plain);
    }
}

#[test]
fn a_region_that_decoders_cannot_hold_is_refused() {
    let shape = Shape::new(50, 40).unwrap();
    let mask = Mask::from_fn(shape, |r, _| r < 9);
    let settings = Settings { region: Some(&mask), ..Settings::default() };
    let why = encode(&noise(shape, &[16], 4), &settings, &Task::default()).unwrap_err().to_string();
    assert!(why.contains("bit-planes"), "{why}");
    let other = Mask::from_fn(Shape::new(40, 50).unwrap(), |r, _| r < 9);
    let settings = Settings { region: Some(&other), ..Settings::default() };
    let why = encode(&noise(shape, &[12], 4), &settings, &Task::default()).unwrap_err().to_string();
    assert_eq!(why, "a region of interest of 40 x 50 pixels for an image of 50 x 40");
}

#[test]
fn a_region_is_exact_even_if_a_component_has_nothing_outside_it() {
    let shape = Shape::new(160, 150).unwrap();
    let mask = Mask::from_fn(shape, |r, c| (40..90).contains(&r) && (50..110).contains(&c));
    let busy = noise(shape, &[10, 10], 4);
    // One component is flat, in the middle of its range, but for the inside of the region.
    let mut samples = vec![512; shape.pixels()];
    for row in 60..70 {
        samples[row * 160 + 70..][..20].copy_from_slice(&busy[1].row(row)[70..90]);
    }
    let planes = Planes::new(vec![busy[0].clone(), Plane::new(shape, 10, samples).unwrap()]).unwrap();
    let settings = Settings { region: Some(&mask), quality: Quality::Bytes(20_000), ..Settings::default() };
    let found = decoded(&encoded(&planes, &settings));
    assert!(found != planes && !differs_inside(&found, &planes, &mask));
}
