//! Quantisation (Annex E): how large a step each sub-band has, and what an error in it costs in the image.
//!
//! Reversible coefficients are integers and are not quantised; only how many bit-planes they may have is stated.
//! Irreversible ones are divided by a step that is the smaller the more an error of the sub-band spreads in the image,
//! so that one unit of quantised error costs the same everywhere.

use super::codestream::Transform;
use super::partition::{Band, Orientation};

/// Norms of the synthesis functions of one direction, for low and high coefficients of 0 to 6 decompositions: how
/// much a coefficient of 1 is worth in the image. A two-dimensional norm is the product of two of them.
///
/// The high norm after no decomposition is never used.
const NORMS_53: [[f64; 2]; 7] = [
    [1.0000000, 1.0000000],
    [1.2247449, 0.8477912],
    [1.6583124, 0.9601432],
    [2.3184046, 1.2593401],
    [3.2691742, 1.7444107],
    [4.6199297, 2.4538713],
    [6.5323713, 3.4656518],
];
const NORMS_97: [[f64; 2]; 7] = [
    [1.0000000, 1.0000000],
    [1.4021081, 0.7212614],
    [2.0303716, 0.9834713],
    [2.9011620, 1.4419623],
    [4.1152841, 2.0737602],
    [5.8245090, 2.9473243],
    [8.2387567, 4.1735883],
];

/// A quantisation step as QCD states it: 2^(R − exponent) · (1 + mantissa / 2^11), with R the dynamic range of the
/// sub-band (Equation E-3).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Step {
    pub(super) exponent: u8,
    pub(super) mantissa: u16,
}

/// How the sub-bands of one component are quantised.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Quantisation {
    /// Bit-planes above those that the exponents give room for.
    pub(super) guard: u8,
    /// One a sub-band.
    pub(super) steps: Vec<Step>,
}

impl Quantisation {
    /// Mb, the bit-planes of each sub-band (Equation E-2).
    pub(super) fn planes(&self) -> impl Iterator<Item = u32> + '_ {
        self.steps.iter().map(|s| u32::from(self.guard + s.exponent) - 1)
    }

    /// Makes room for so many bit-planes in each sub-band, with at least `least` guard bits.
    pub(super) fn with_room(mut self, planes: &[u32], least: u8) -> Self {
        let missing = self.steps.iter().zip(planes).map(|(s, &p)| (p + 1).saturating_sub(s.exponent.into()));
        self.guard = missing.max().unwrap_or(0).max(least.into()) as u8;
        self
    }
}

/// log2 of a sub-band's nominal gain (Table E.1).
fn gain(band: &Band) -> u8 {
    match band.orientation {
        Orientation::LL => 0,
        Orientation::HL | Orientation::LH => 1,
        Orientation::HH => 2,
    }
}

/// How much a coefficient of 1 in this sub-band is worth in the image: the norm of its synthesis function.
pub(super) fn norm(transform: Transform, band: &Band) -> f64 {
    let norms = match transform {
        Transform::Reversible53 => &NORMS_53,
        Transform::Irreversible97 => &NORMS_97,
    };
    let [low, high] = norms[usize::from(band.level)];
    match band.orientation {
        Orientation::LL => low * low,
        Orientation::HL | Orientation::LH => low * high,
        Orientation::HH => high * high,
    }
}

/// The steps of a component: all 1 for a reversible transform (exponents say how many bits there are), and else such
/// that a unit error costs `unit` in the image.
pub(super) fn steps(transform: Transform, bands: &[Band], depth: u8, unit: f64) -> Vec<Step> {
    let step = |band: &Band| {
        let range = i32::from(depth + gain(band));
        match transform {
            Transform::Reversible53 => Step { exponent: range as u8, mantissa: 0 },
            Transform::Irreversible97 => nearest_below(unit / norm(transform, band), range),
        }
    };
    bands.iter().map(step).collect()
}

/// The largest step of Equation E-3 that is not greater than `size`.
fn nearest_below(size: f64, range: i32) -> Step {
    let bits = size.to_bits();
    let (power, fraction) = ((bits >> 52) as i32 - 1023, bits & ((1 << 52) - 1));
    match range - power {
        exponent @ 0..=31 => Step { exponent: exponent as u8, mantissa: (fraction >> 41) as u16 },
        ..0 => Step { exponent: 0, mantissa: 0x7ff },
        _ => Step { exponent: 31, mantissa: 0 },
    }
}

/// The size of a step (Equation E-3).
pub(super) fn size(transform: Transform, step: Step, band: &Band, depth: u8) -> f64 {
    match transform {
        Transform::Reversible53 => 1.0,
        Transform::Irreversible97 => {
            let power = i32::from(depth + gain(band)) - i32::from(step.exponent);
            let scale = if power < 0 { 1.0 / f64::from(1u32 << -power) } else { f64::from(1u32 << power) };
            scale * (1.0 + f64::from(step.mantissa) / 2048.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::dwt::synthesis;
    use super::*;

    /// The norm of what one coefficient of 1, far from the ends, becomes after `level` syntheses.
    fn norm_by_synthesis(transform: Transform, level: usize, high: bool) -> f64 {
        let mut signal = vec![0.0; 32];
        signal[16] = 1.0;
        for i in 0..level {
            let zeros = vec![0.0; signal.len()];
            let high = high && i == 0;
            signal =
                synthesis::line_linear(transform, if high { &zeros } else { &signal }, if high { &signal } else { &zeros });
        }
        signal.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    #[test]
    fn the_norms_are_those_of_the_synthesis_functions() {
        for (transform, norms) in [(Transform::Reversible53, NORMS_53), (Transform::Irreversible97, NORMS_97)] {
            let found: Vec<[f64; 2]> =
                (0..7).map(|level| [false, true].map(|high| norm_by_synthesis(transform, level, high))).collect();
            for (found, stated) in found.iter().flatten().zip(norms.iter().flatten()) {
                assert!((found / stated - 1.0).abs() < 1e-5, "{found:?} and {stated:?} of {found:?}");
            }
        }
    }

    #[test]
    fn a_step_is_stated_within_one_part_in_two_thousand() {
        let band = Band { orientation: Orientation::HL, level: 1, x: 0, y: 0, width: 1, height: 1 };
        for i in 1..200 {
            let wanted = f64::from(i) * 0.037;
            let step = nearest_below(wanted, 13);
            let found = size(Transform::Irreversible97, step, &band, 12);
            assert!(found <= wanted && found > wanted * (1.0 - 1.0 / 2048.0), "{wanted} became {found}");
        }
    }
}
