//! Value noise: random numbers on the integer lattice, blended smoothly between, summed over octaves.

use crate::random::mix;

fn at(cell: [i64; 3], seed: u64) -> f64 {
    let [x, y, z] = cell.map(|c| c as u64);
    let bits = mix(x.wrapping_mul(0x8da6_b343) ^ mix(y.wrapping_mul(0xd816_3841) ^ mix(z.wrapping_mul(0xcb1a_b31f) ^ seed)));
    (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Smooth noise in −1 … 1 with features of size 1.
pub fn value(p: [f64; 3], seed: u64) -> f64 {
    let cell = p.map(|x| x.floor() as i64);
    let t = p.map(|x| {
        let f = x - x.floor();
        f * f * f * (f * (f * 6.0 - 15.0) + 10.0)
    });
    let mut sum = 0.0;
    for corner in 0..8 {
        let bit = |axis: usize| (corner >> axis) & 1;
        let weight = |axis: usize| if bit(axis) == 1 { t[axis] } else { 1.0 - t[axis] };
        let at = at([cell[0] + bit(0), cell[1] + bit(1), cell[2] + bit(2)], seed);
        sum += weight(0) * weight(1) * weight(2) * at;
    }
    sum
}

/// `octaves` layers of [`value`], each twice as fine and `gain` times as strong as the one before.
pub fn layered(p: [f64; 3], octaves: u32, gain: f64, seed: u64) -> f64 {
    let (mut sum, mut scale, mut strength) = (0.0, 1.0, 1.0);
    for octave in 0..octaves {
        sum += strength * value(p.map(|x| x * scale), seed.wrapping_add(u64::from(octave)));
        scale *= 2.0;
        strength *= gain;
    }
    sum
}
