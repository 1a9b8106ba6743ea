//! Rates, qualities and layers.

use super::*;
use planes::{noise, smooth, stretched};

#[test]
fn truncated_reversible_streams_decode_to_the_same_samples_everywhere() {
    for (i, shape) in [Shape::new(122, 197).unwrap(), Shape::new(300, 33).unwrap()].into_iter().enumerate() {
        for planes in [smooth(shape, &[12, 12, 12], 4), stretched(shape, &[16], 5), noise(shape, &[7], 6)] {
            for bpp in [0.2, 1.0, 4.0] {
                let settings = Settings { quality: Quality::BitsPerPixel(bpp), ..Settings::default() };
                let stream = encoded(&planes, &settings);
                let found = decoded(&stream);
                assert_same(&judges::openjpeg(&stream.bytes), &found, 0, "jpeg2k");
                if i == 0 {
                    for (name, other) in judges::commands(&stream.bytes, planes.len()) {
                        assert_same(&other, &found, 0, name);
                    }
                }
            }
        }
    }
}

#[test]
fn irreversible_streams_decode_within_one_everywhere() {
    for planes in [smooth(Shape::new(122, 197).unwrap(), &[12, 10], 4), noise(Shape::new(65, 64).unwrap(), &[8], 6)] {
        for bpp in [0.5, 3.0, 20.0] {
            let settings =
                Settings { transform: Transform::Irreversible97, quality: Quality::BitsPerPixel(bpp), ..Settings::default() };
            let stream = encoded(&planes, &settings);
            let found = decoded(&stream);
            assert_same(&judges::openjpeg(&stream.bytes), &found, 1, "jpeg2k");
            for (name, other) in judges::commands(&stream.bytes, planes.len()) {
                assert_same(&other, &found, 1, name);
            }
        }
    }
}

#[test]
fn a_rate_is_kept_to_within_one_percent_below() {
    let planes = smooth(Shape::new(500, 300).unwrap(), &[12, 12, 12], 4);
    for transform in [Transform::Reversible53, Transform::Irreversible97] {
        for layers in [1, 5] {
            for bytes in [3_000, 20_000, 60_000] {
                let settings = Settings { transform, layers, quality: Quality::Bytes(bytes), ..Settings::default() };
                let found = encoded(&planes, &settings).bytes.len() as u64;
                assert!(found <= bytes && found * 100 >= bytes * 99, "{found} bytes of {bytes}");
            }
        }
    }
}

#[test]
fn a_psnr_is_reached_and_hardly_exceeded() {
    for planes in [stretched(Shape::new(300, 200).unwrap(), &[12, 12, 12], 4), noise(Shape::new(400, 300).unwrap(), &[10], 4)] {
        for transform in [Transform::Reversible53, Transform::Irreversible97] {
            for wanted in [50.0, 56.0, 60.0] {
                let settings = Settings { transform, quality: Quality::Psnr(wanted), ..Settings::default() };
                let found = psnr(&planes, &decoded(&encoded(&planes, &settings)));
                assert!(found >= wanted && found < wanted + 0.5, "{found} dB for {wanted} ({transform:?})");
            }
        }
    }
}

#[test]
fn a_psnr_beyond_rounding_is_reached_without_a_loss() {
    let planes = smooth(Shape::new(64, 64).unwrap(), &[8], 4);
    for transform in [Transform::Reversible53, Transform::Irreversible97] {
        let settings = Settings { transform, quality: Quality::Psnr(120.0), ..Settings::default() };
        assert_same(&decoded(&encoded(&planes, &settings)), &planes, 0, "hayro-jpeg2000");
    }
}

#[test]
fn every_prefix_of_the_layers_decodes_everywhere_and_each_is_better() {
    let planes = smooth(Shape::new(222, 111).unwrap(), &[12, 12], 4);
    let lossless = Settings { layers: 6, ..Settings::default() };
    let lossy =
        Settings { transform: Transform::Irreversible97, layers: 4, quality: Quality::Bytes(20_000), ..Settings::default() };
    for (settings, tolerance) in [(lossless, 0), (lossy, 1)] {
        let whole = encoded(&planes, &settings);
        let mut last = 0.0;
        for layers in 1..=settings.layers {
            let part = whole.first_layers(layers).unwrap();
            let found = decoded(&part);
            assert_same(&judges::openjpeg(&part.bytes), &found, tolerance, "jpeg2k");
            for (name, other) in judges::commands(&part.bytes, planes.len()) {
                assert_same(&other, &found, tolerance, name);
            }
            let quality = psnr(&planes, &found);
            assert!(quality > last, "{quality} dB after {last}");
            last = quality;
        }
    }
}

#[test]
fn a_weighty_component_has_the_better_quality() {
    let shape = Shape::new(200, 200).unwrap();
    let planes = stretched(shape, &[12, 12], 4);
    let quality = |weights: Vec<f64>| {
        let settings = Settings { weights, quality: Quality::BitsPerPixel(1.0), ..Settings::default() };
        let found = decoded(&encoded(&planes, &settings));
        [0, 1].map(|i| {
            let one = |p: &Planes| Planes::new(vec![p[i].clone()]).unwrap();
            psnr(&one(&planes), &one(&found))
        })
    };
    let (even, uneven) = (quality(vec![]), quality(vec![1.0, 100.0]));
    assert!(uneven[1] > even[1] + 3.0 && uneven[0] < even[0] - 3.0, "{even:?} and {uneven:?}");
}

#[test]
fn weighty_pixels_have_the_better_quality() {
    let shape = Shape::new(512, 512).unwrap();
    let planes = stretched(shape, &[12], 4);
    // The left half counts a hundred times as much as the right one.
    let pixels: Vec<f32> = (0..shape.pixels()).map(|i| if i % 512 < 256 { 100.0 } else { 1.0 }).collect();
    let halves = |pixel_weights| {
        let settings = Settings { pixel_weights, levels: 3, quality: Quality::BitsPerPixel(1.0), ..Settings::default() };
        let found = decoded(&encoded(&planes, &settings));
        [0, 256].map(|left| {
            let rows = (0..512).map(|r| (&planes[0].row(r)[left..left + 256], &found[0].row(r)[left..left + 256]));
            rows.flat_map(|(a, b)| a.iter().zip(b).map(|(x, y)| f64::from(x - y).powi(2))).sum::<f64>()
        })
    };
    let (even, uneven) = (halves(None), halves(Some(&pixels)));
    assert!(uneven[0] < even[0] / 2.0 && uneven[1] > even[1], "{even:?} and {uneven:?}");
}

#[test]
fn a_payload_states_what_its_codestream_must_be() {
    let planes = stretched(Shape::new(90, 70).unwrap(), &[12, 9], 4);
    let codec = J2k { settings: Settings { layers: 3, ..Settings::default() } };
    let payload = codec.encode(&planes, &Task::default()).unwrap();
    assert_eq!(payload[..3], [1, 5, 3]);
    let decode = |payload: &[u8]| codec.decode(payload, planes.shape(), &planes.depths(), &mut budget());
    assert_same(&decode(&payload).unwrap(), &planes, 0, "the payload");
    assert_same(&judges::openjpeg(codestream(&payload).unwrap()), &planes, 0, "jpeg2k");
    for (at, value) in [(0, 0), (0, 2), (1, 4), (2, 2)] {
        let mut other = payload.clone();
        other[at] = value;
        assert!(decode(&other).is_err(), "byte {at}");
    }
    assert!(decode(&[]).is_err() && decode(&payload[..3]).is_err());
}

#[test]
fn what_the_optimisation_takes_for_the_error_is_the_error() {
    // The psnr of a truncated stream, from the gains of its passes, against that of its decoded samples.
    let planes = stretched(Shape::new(256, 256).unwrap(), &[12], 4);
    // The 5/3 kernel is further from orthogonal: errors of different sub-bands are not independent.
    for (transform, tolerance) in [(Transform::Reversible53, 0.5), (Transform::Irreversible97, 0.2)] {
        for psnr_wanted in [48.0, 58.0] {
            let (stream, measured) = super::super::target::predicted(&planes, transform, psnr_wanted);
            let found = psnr(&planes, &decoded(&stream));
            assert!((found - measured).abs() < tolerance, "{measured} dB measured, {found} dB found ({transform:?})");
        }
    }
}
