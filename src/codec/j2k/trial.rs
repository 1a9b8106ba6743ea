//! Trials: any bytes as planes and settings, or as a codestream. They panic only where a promise was broken; the fuzz
//! targets and the tests call them.

use super::{Encoded, Profile, Quality, Settings, Transform, decode, encode, profile, psnr};
use crate::limits::{Budget, Limits};
use crate::plane::{Mask, Plane, Planes, Shape};
use crate::task::Task;

/// Bytes that decide what is tried; zeros follow the last one.
struct Choices<'a>(&'a [u8]);

impl Choices<'_> {
    fn byte(&mut self) -> u64 {
        match self.0.split_first() {
            Some((&first, rest)) => {
                self.0 = rest;
                first.into()
            }
            None => 0,
        }
    }

    fn below(&mut self, n: u64) -> u64 {
        (((self.byte() << 8) | self.byte()) * n) >> 16
    }
}

/// Planes, what was made of them, and what a decoder makes of that.
pub(super) struct Trial {
    pub(super) planes: Planes,
    pub(super) transform: Transform,
    pub(super) has_region: bool,
    pub(super) encoded: Encoded,
    pub(super) decoded: Planes,
}

/// Encodes planes with settings, both chosen by the bytes, decodes the stream, and holds it to what was asked for.
///
/// # Panics
/// If a promise is broken.
#[allow(dead_code)] // fuzzers call it
pub fn encode_and_decode(bytes: &[u8]) {
    let _ = run(bytes);
}

/// The same, for tests that ask other decoders, too; none where the settings ask for too much.
pub(super) fn run(bytes: &[u8]) -> Option<Trial> {
    let mut choices = Choices(bytes);
    let side = |choices: &mut Choices| {
        let most = if choices.below(8) == 0 { 300 } else { 40 };
        1 + choices.below(most) as u32
    };
    let shape = Shape::new(side(&mut choices), side(&mut choices)).expect("a small shape");
    let depths: Vec<u8> = (0..1 + choices.below(3)).map(|_| 1 + choices.below(16) as u8).collect();
    let transform = if choices.below(2) == 0 { Transform::Reversible53 } else { Transform::Irreversible97 };
    let quality = match choices.below(4) {
        0 if transform == Transform::Reversible53 => Quality::Lossless,
        1 => Quality::Psnr(choices.below(90) as f64),
        2 => Quality::Bytes(choices.below(1 << 14)),
        _ => Quality::BitsPerPixel(0.01 * (1 + choices.below(2000)) as f64),
    };
    let density = 1 + choices.below(60) as usize;
    let has_region = choices.below(3) == 0;
    let levels = choices.below(7) as u8;
    let block = 5 + choices.below(2) as u8;
    let layers = 1 + choices.below(5) as u8;
    let weights = depths.iter().map(|_| 0.1 * (1 + choices.below(50)) as f64).collect();
    let kind = choices.below(4);
    let seed = choices.0;
    let planes = depths.iter().enumerate().map(|(i, &depth)| plane(shape, depth, kind, i, seed));
    let planes = Planes::new(planes.collect()).expect("planes of one shape");
    let mask = Mask::from_fn(shape, |row, column| (row * 31 + column * 17) * (row + column) % density == 0);
    let settings = Settings {
        transform,
        quality,
        levels,
        block,
        layers,
        weights,
        pixel_weights: None,
        region: has_region.then_some(&mask),
    };

    let encoded = match encode(&planes, &settings, &Task::default()) {
        Ok(encoded) => encoded,
        Err(why) => {
            // Only these two things can be wrong with such settings.
            let why = why.to_string();
            assert!(why.contains("takes at least") || why.contains("bit-planes"), "{why}");
            return None;
        }
    };
    assert_eq!(profile(&encoded.bytes).expect("a stream of the profile"), encoded.profile);
    let decoded = decode(&encoded.bytes, &encoded.profile, &mut Budget::new(limits())).expect("a stream that decodes");
    match quality {
        Quality::Lossless => assert!(decoded == planes, "lossless, and samples differ"),
        Quality::Bytes(bytes) => assert!(encoded.bytes.len() as u64 <= bytes, "more bytes than asked for"),
        Quality::BitsPerPixel(bpp) => {
            assert!(encoded.bytes.len() as f64 <= bpp * shape.pixels() as f64 / 8.0, "a higher rate than asked for");
        }
        Quality::Psnr(wanted) => assert!(psnr(&planes, &decoded) >= wanted - 1e-9, "a lower psnr than asked for"),
    }
    Some(Trial { planes, transform: encoded.profile.transform, has_region, encoded, decoded })
}

/// Samples of the kind: the seed's bytes over and over, noise, a ramp, or stretches of one value.
fn plane(shape: Shape, depth: u8, kind: u64, component: usize, seed: &[u8]) -> Plane {
    let byte = |i: usize| if seed.is_empty() { 0 } else { u64::from(seed[i % seed.len()]) };
    let mut state = (0..16).fold(1 + component as u64, |s, i| s.wrapping_mul(0x100_0000_01b3) ^ byte(i)) | 1;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state >> 20
    };
    let mut last = 0;
    let samples = (0..shape.pixels()).map(|i| {
        let (row, column) = (i / shape.width(), i % shape.width());
        let value = match kind {
            0 => byte(2 * i + component) << 8 | byte(2 * i + component + 1),
            1 => random(),
            2 => (row * (3 + component) + column * 5) as u64 * (1 << depth) / 400 + random() % 2,
            _ => {
                if random() % 5 == 0 {
                    last = random();
                }
                last
            }
        };
        (value % (1 << depth)) as i32
    });
    Plane::new(shape, depth, samples.collect()).expect("samples of the depth")
}

fn limits() -> Limits {
    Limits::default().pixels(1 << 20).memory(1 << 27).work(1 << 30)
}

/// Decodes any bytes by what they say themselves, within limits.
///
/// # Panics
/// If the decoder does, or returns other planes than the header states.
pub fn decode_bytes(bytes: &[u8]) {
    if let Ok(stated) = profile(bytes) {
        decode_as(bytes, &stated);
    }
}

/// Decodes any bytes as a stream of a profile.
pub(super) fn decode_as(bytes: &[u8], stated: &Profile) {
    if let Ok(found) = decode(bytes, stated, &mut Budget::new(limits())) {
        assert_eq!((found.shape(), found.depths()), (stated.shape, stated.depths.clone()));
    }
}

/// Encodes planes chosen by the first bytes, damages the stream as the last ones say, and decodes it.
///
/// # Panics
/// As [`decode_bytes`].
pub fn decode_damaged(bytes: &[u8]) {
    let (chosen, damage) = bytes.split_at(bytes.len() / 2);
    let Some(trial) = run(chosen) else { return };
    let mut stream = trial.encoded.bytes;
    let mut choices = Choices(damage);
    while !choices.0.is_empty() && stream.len() > 1 {
        let at = choices.below(stream.len() as u64) as usize;
        match choices.byte() {
            0..8 => stream.truncate(at.max(1)),
            8..16 => {
                stream.remove(at);
            }
            value => stream[at] ^= value as u8,
        }
    }
    decode_bytes(&stream);
    decode_as(&stream, &trial.encoded.profile);
}
