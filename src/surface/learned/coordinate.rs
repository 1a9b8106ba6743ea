//! One coordinate: its distance from the expected value, in steps of the lattice or of a palette.
//!
//! The decisions are those of [`Residuals`](crate::entropy::Residuals): zero, sign, class, and the bits
//! below the class. Here each of them is also judged by densities that know where the expected value
//! lies between two lattice points.

use super::density::{Logistic, log_odds};
use super::window::Window;
use crate::entropy::{BitCoder, Mixer, MixerOptions, Start, hash};

/// Nodes of a context's line, once the sign is known.
const CLASSES: usize = 8;
/// Bits of a class above this are mixed from the densities alone.
const MODELLED: u32 = 3;

/// Lines of the mixer of low bits.
const LOW_LINES_LOG2: u32 = 8;

/// Codes coordinates from `N` contexts and `E` densities.
#[derive(Debug)]
pub(super) struct Coordinates<const N: usize, const E: usize> {
    mixer: Mixer<N, E>,
    /// Bits too low for the contexts: the densities, and what was seen at this bit of this class.
    low: Mixer<1, E>,
}

impl<const N: usize, const E: usize> Coordinates<N, E> {
    /// Starts with weights for the decisions before and after the sign is known.
    pub(super) fn new(vertices: usize, [before, after]: [Start<N, E>; 2]) -> Self {
        let options = MixerOptions { lines_log2: lines_log2(vertices), rate_shift: 6, count_limit: 127 };
        let low = MixerOptions { lines_log2: LOW_LINES_LOG2, ..options };
        // One set for every axis rank.
        let sets = [before, before, before, after, after, after];
        let low_start = Start { contexts: [after.contexts[0]], experts: after.experts, bias: after.bias };
        Self { mixer: Mixer::new(options, &sets), low: Mixer::new(low, &[low_start; 3]) }
    }

    /// The memory that so many vertices need.
    pub(super) fn memory(vertices: usize) -> u64 {
        Mixer::<N, E>::memory(lines_log2(vertices)) + Mixer::<1, E>::memory(LOW_LINES_LOG2)
    }

    /// Codes `value` (an index into `window`), expected at the index `centre`.
    ///
    /// `rank` is the place of the axis in the order of axes. The result may be out of range if the stream is damaged.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn code<C: BitCoder>(
        &mut self,
        coder: &mut C,
        value: i64,
        centre: i64,
        window: Window<'_>,
        densities: &[Logistic; E],
        contexts: [u32; N],
        rank: usize,
    ) -> i64 {
        if window.is_single() {
            return centre;
        }
        let residual = value - centre;
        let [below, above] = [window.edge(centre), window.edge(centre + 1)];
        let up: [f64; E] = each(densities, |d| d.beyond(above, 1.0));
        let down: [f64; E] = each(densities, |d| d.beyond(below, -1.0));
        let zero = odds(|e| (1.0 - up[e] - down[e], up[e] + down[e]));
        self.mixer.choose(contexts, rank);
        if self.mixer.code(coder, residual == 0, 0, zero) {
            return centre;
        }
        let is_up = self.mixer.code(coder, residual > 0, 1, odds(|e| (up[e], down[e])));
        let (sign, direction) = if is_up { (1, 1.0) } else { (-1, -1.0) };
        let outer = |steps: i64| if is_up { window.edge(centre + 1 + steps) } else { window.edge(centre - steps) };

        self.mixer.choose(contexts.map(|c| hash(c, sign as u32)), 3 + rank);
        let magnitude = residual.unsigned_abs().max(1) - 1;
        let wanted = (magnitude + 1).ilog2();
        // `tail[e]` is the chance of being beyond the first 2ʲ − 1 steps; it shrinks class by class.
        let mut tail = if is_up { up } else { down };
        let mut class = 0;
        loop {
            let end = outer((2_i64 << class) - 1);
            let rest: [f64; E] = each(densities, |d| d.beyond(end, direction));
            let node = (class as usize).min(CLASSES - 1);
            if self.mixer.code(coder, class == wanted, node, odds(|e| (tail[e] - rest[e], rest[e])))
                || class >= window.last_class()
            {
                // The bits of m + 1 below its highest; each halves the interval [low, high) of steps.
                return centre + sign * self.bits(coder, magnitude + 1, class, outer, direction, densities, tail, rest, rank);
            }
            tail = rest;
            class += 1;
        }
    }

    /// The bits of m + 1 below the highest, which is bit `class`; the value m + 1.
    #[allow(clippy::too_many_arguments)]
    fn bits<C: BitCoder>(
        &mut self,
        coder: &mut C,
        wanted: u64,
        class: u32,
        outer: impl Fn(i64) -> f64,
        direction: f64,
        densities: &[Logistic; E],
        mut near: [f64; E],
        far: [f64; E],
        rank: usize,
    ) -> i64 {
        let mut far = far;
        let mut found = 1_i64;
        for i in (0..class).rev() {
            // `found` is m + 1 without its last i + 1 bits: the halves meet where the next bit turns 1.
            let half = (found * 2 + 1) << i;
            let edge = outer(half - 1);
            let middle: [f64; E] = each(densities, |d| d.beyond(edge, direction));
            let bit = wanted >> i & 1 != 0;
            let depth = class - 1 - i;
            let chances = odds(|e| (middle[e] - far[e], near[e] - middle[e]));
            let bit = if class <= MODELLED && depth < 2 {
                let node = match (class, depth) {
                    (1, _) => CLASSES,
                    (2, 0) => CLASSES + 1,
                    (2, _) => CLASSES + 2 + (found & 1) as usize,
                    (_, 0) => CLASSES + 4,
                    (_, _) => CLASSES + 5 + (found & 1) as usize,
                };
                self.mixer.code(coder, bit, node, chances)
            } else {
                self.low.choose([class << 8 | i], rank);
                self.low.code(coder, bit, (i as usize).min(15), chances)
            };
            found = found << 1 | i64::from(bit);
            if bit { near = middle } else { far = middle }
        }
        found
    }
}

/// Lines of a context: about one for every vertex.
fn lines_log2(vertices: usize) -> u32 {
    vertices.max(1).ilog2().clamp(6, 14)
}

#[inline]
fn each<const E: usize>(densities: &[Logistic; E], f: impl Fn(&Logistic) -> f64) -> [f64; E] {
    let mut out = [0.0; E];
    for e in 0..E {
        out[e] = f(&densities[e]);
    }
    out
}

#[inline]
fn odds<const E: usize>(chances: impl Fn(usize) -> (f64, f64)) -> [i32; E] {
    let mut out = [0; E];
    for (e, odds) in out.iter_mut().enumerate() {
        let (yes, no) = chances(e);
        *odds = log_odds(yes, no);
    }
    out
}
