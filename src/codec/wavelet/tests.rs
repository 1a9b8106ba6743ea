//! The codec as a whole.

#![allow(clippy::unwrap_used)] // what a test does not expect should fail it

use super::*;
use crate::limits::Limits;
use crate::plane::bounding_box;

/// A bumpy surface: an orbifold of one piece with itself, or a sheet.
pub(super) fn surface(width: usize, height: usize, gluing: Gluing) -> GeometryImage {
    let wave = |x: f64| {
        // A smooth function of period 1 from + and × alone.
        let t = 2.0 * (x - x.floor()) - 1.0;
        4.0 * t * (1.0 - t.abs())
    };
    let at = |p: usize| {
        let (u, v) = ((p % width) as f64 / (width - 1) as f64, (p / width) as f64 / (height - 1) as f64);
        match gluing {
            Gluing::Open => [u, v, 0.2 * wave(1.5 * u + 0.3) * wave(v) + 0.02 * wave(7.0 * u + 3.0 * v)],
            _ => {
                // Turned about the middle of a side, (u, v) becomes (−u, 1 − v) or (1 − u, −v): with these the functions below agree.
                let (a, b) = (wave(u + v / 2.0 + 0.25), wave(v - u / 2.0));
                let even = wave(u + 0.25) * wave(v + 0.25);
                [
                    even + 0.2 * a * a,
                    wave(u) * wave(v) * 0.7 + 0.1 * b * b,
                    wave(u + 0.25) * wave(u + 0.25) + 0.3 * wave(v) * wave(v),
                ]
            }
        }
    };
    GeometryImage::new(width, height, gluing, (0..width * height).map(at).collect()).unwrap()
}

const SHAPES: [(usize, usize, Gluing); 7] = [
    (65, 65, Gluing::Orbifold),
    (33, 97, Gluing::Orbifold),
    (9, 9, Gluing::Orbifold),
    (65, 65, Gluing::Open),
    (50, 37, Gluing::Open),
    (4, 30, Gluing::Open),
    (2, 2, Gluing::Open),
];

fn coded(image: &GeometryImage, step: f64) -> (Vec<u8>, GeometryImage, Layout, [[f64; 3]; 2]) {
    let layout = Layout::new(image.shape(), image.gluing(), step);
    let (quantised, decoded) = quantise(image, layout.clone(), &Task::default()).unwrap();
    let bounds = bounding_box(decoded.points().iter().copied()).unwrap();
    (write(&quantised, bounds).unwrap(), decoded, layout, bounds)
}

fn decoded(bytes: &[u8], layout: &Layout, bounds: [[f64; 3]; 2], level: u8) -> Result<GeometryImage> {
    decode(bytes, layout, bounds, level, &mut Budget::new(Limits::default()), &Task::default())
}

#[test]
fn a_decoder_finds_bit_for_bit_what_the_encoder_foresaw() {
    for (width, height, gluing) in SHAPES {
        let image = surface(width, height, gluing);
        for step in [0.5, 0.03, 1e-3, 1e-7] {
            let (bytes, foreseen, layout, bounds) = coded(&image, step);
            let found = decoded(&bytes, &layout, bounds, 0).unwrap();
            let bits = |image: &GeometryImage| image.points().iter().map(|p| p.map(f64::to_bits)).collect::<Vec<_>>();
            assert!(bits(&found) == bits(&foreseen), "{width} x {height} {gluing:?}, step {step}");
        }
    }
}

#[test]
fn the_error_follows_the_step_and_the_bytes_grow_as_it_shrinks() {
    for (width, height, gluing) in SHAPES {
        let image = surface(width, height, gluing);
        let mut last = 0;
        for step in [0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4, 1e-6] {
            let (bytes, found, ..) = coded(&image, step);
            let square = |(p, q): (&[f64; 3], &[f64; 3])| (0..3).map(|i| (p[i] - q[i]) * (p[i] - q[i])).sum::<f64>();
            let sum: f64 = image.points().iter().zip(found.points()).map(square).sum();
            let rms = (sum / image.points().len() as f64).sqrt();
            assert!(rms < step, "{width} x {height} {gluing:?}, step {step}: rms {rms}");
            assert!(bytes.len() >= last, "{width} x {height} {gluing:?}, step {step}: {} bytes after {last}", bytes.len());
            last = bytes.len();
        }
    }
}

#[test]
fn every_level_of_a_closed_surface_is_closed_at_every_step() {
    let image = surface(65, 65, Gluing::Orbifold);
    for step in [2.0, 0.2, 0.01, 1e-4] {
        let (bytes, _, layout, bounds) = coded(&image, step);
        for level in 0..=layout.levels {
            let found = decoded(&bytes, &layout, bounds, level).unwrap();
            assert_eq!(found.width(), 64 / (1 << level) + 1);
            let triangles = found.triangles();
            let mut edges = std::collections::HashMap::new();
            triangles.iter().for_each(|t| (0..3).for_each(|i| *edges.entry((t[i], t[(i + 1) % 3])).or_insert(0) += 1));
            assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.contains_key(&(b, a))), "step {step}, level {level}");
            let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
            vertices.sort_unstable();
            vertices.dedup();
            assert_eq!(vertices.len() + triangles.len() - edges.len() / 2, 2, "Euler number at step {step}, level {level}");
        }
    }
}

#[test]
fn levels_beyond_the_last_are_the_coarsest_and_levels_an_image_has_not_are_refused() {
    let (bytes, _, layout, bounds) = coded(&surface(33, 33, Gluing::Open), 0.01);
    assert_eq!(decoded(&bytes, &layout, bounds, 200).unwrap().width(), 5);
    for levels in [layout.levels + 3, 16, 255] {
        assert!(decoded(&bytes, &Layout { levels, ..layout.clone() }, bounds, 0).is_err());
    }
    assert!(decoded(&bytes, &Layout { step: f64::NAN, ..layout.clone() }, bounds, 0).is_err());
    assert!(quantise(&surface(33, 33, Gluing::Open), Layout { step: 1e-12, ..layout }, &Task::default()).is_err());
}

#[test]
fn damaged_bytes_and_layouts_do_no_harm() {
    let image = surface(17, 17, Gluing::Orbifold);
    let (bytes, _, layout, bounds) = coded(&image, 1e-3);
    for at in 0..bytes.len() {
        drop(decoded(&bytes[..at], &layout, bounds, 0));
        for bit in 0..8 {
            let mut changed = bytes.clone();
            changed[at] ^= 1 << bit;
            drop(decoded(&changed, &layout, bounds, 0));
        }
    }
    for step in [1e-300, 1e300, f64::MIN_POSITIVE] {
        drop(decoded(&bytes, &Layout { step, ..layout.clone() }, bounds, 0));
        drop(decoded(&bytes, &layout, [[-step; 3], [step; 3]], 0));
    }
    let wide = Layout { shape: Shape::new(1 << 20, 1 << 20).unwrap(), gluing: Gluing::Open, levels: 3, step: 1.0, zones: None };
    assert!(matches!(decoded(&bytes, &wide, bounds, 0), Err(Error::Limit { .. })));
}

#[test]
fn shrinking_leaves_the_normal_alone_and_makes_bytes_fewer() {
    let image = surface(65, 65, Gluing::Open);
    let step = 2e-3;
    let smoother = shrink(&image, step, None, 0.8, &Task::default()).unwrap();
    assert!(coded(&smoother, step).0.len() < coded(&image, step).0.len());
    let kept = shrink(&image, step, None, 0.0, &Task::default()).unwrap();
    let off = image.points().iter().zip(kept.points()).flat_map(|(p, q)| (0..3).map(move |i| (p[i] - q[i]).abs()));
    assert!(off.fold(0.0, f64::max) < 1e-12);
}
