//! Planes to be coded: noise, smooth surfaces, and what a V-matrix looks like.

use super::*;

/// A xorshift generator: the same planes on every machine.
#[derive(Clone)]
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(super) fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) % n
    }
}

fn build(shape: Shape, depths: &[u8], mut sample: impl FnMut(usize, usize, usize) -> f64) -> Planes {
    let planes = depths.iter().enumerate().map(|(i, &depth)| {
        let peak = f64::from((1u32 << depth) - 1);
        let mut samples = Vec::with_capacity(shape.pixels());
        for row in 0..shape.height() {
            samples.extend((0..shape.width()).map(|column| (sample(i, row, column) * peak).round().clamp(0.0, peak) as i32));
        }
        Plane::new(shape, depth, samples).unwrap()
    });
    Planes::new(planes.collect()).unwrap()
}

/// White noise over the whole range.
pub(super) fn noise(shape: Shape, depths: &[u8], seed: u64) -> Planes {
    let mut random = Random::new(seed);
    build(shape, depths, |_, _, _| random.below(1 << 20) as f64 / f64::from((1 << 20) - 1))
}

/// A few waves, and a little noise in the lowest bits.
pub(super) fn smooth(shape: Shape, depths: &[u8], seed: u64) -> Planes {
    let mut random = Random::new(seed);
    let waves: Vec<[f64; 4]> = (0..12).map(|_| [0, 1, 2, 3].map(|_| random.below(1000) as f64 / 1000.0)).collect();
    build(shape, depths, |i, row, column| {
        let (x, y) = (column as f64 / 40.0, row as f64 / 40.0);
        let waves = waves[4 * (i % 3)..][..4].iter();
        let height: f64 = waves.map(|[a, b, c, d]| (x * a + y * b + 6.3 * c).sin() * d).sum();
        0.5 + height / 8.0 + random.below(100) as f64 / 100_000.0
    })
}

/// Stretches of one value along the rows, as the levels of a V-matrix have, over a smooth surface.
pub(super) fn stretched(shape: Shape, depths: &[u8], seed: u64) -> Planes {
    let mut random = Random::new(seed);
    let surface = smooth(shape, depths, seed);
    let mut starts: Vec<usize> = Vec::new();
    for _ in 0..shape.height() {
        let mut at = 0;
        for column in 0..shape.width() {
            if random.below(4) == 0 {
                at = column;
            }
            starts.push(at);
        }
    }
    build(shape, depths, |i, row, column| {
        let peak = f64::from((1u32 << depths[i]) - 1);
        f64::from(surface[i].row(row)[starts[row * shape.width() + column]]) / peak
    })
}

/// A plane of one value.
pub(super) fn flat(shape: Shape, depths: &[u8], value: f64) -> Planes {
    build(shape, depths, |_, _, _| value)
}
