//! Logistic mixing of many adaptive models (M. Mahoney, "Adaptive weighing of context models for
//! lossless data compression", 2005), in integers.
//!
//! Each of `N` contexts has a table of *lines*; a line holds 16 adaptive bits, one for each *node*
//! (binary decision) of the value that is being coded, so that a value costs one memory access a
//! context and not one a decision. For a decision, the bits' log-odds xᵢ are the inputs:
//!
//! ```text
//! p  = squash(Σ wᵢ xᵢ)            the mixed chance
//! wᵢ ← wᵢ + η · (decision − p) · xᵢ   down the gradient of the coding cost
//! ```
//!
//! with one set of weights a (*set*, node). A fresh bit has x = 0: it has no say yet. `E` further
//! inputs (*experts*) may be given as log-odds. The last input is constant.

use super::logistic::{LIMIT, squash, stretch};
use super::model::AdaptiveBit;
use super::range::BitCoder;

/// Nodes a line.
pub(crate) const NODES: usize = 16;

/// Weights are held in 65536ths.
const ONE: i32 = 1 << 16;

/// The constant input, in 256ths.
const BIAS: i32 = 256;

/// How a [`Mixer`] learns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MixerOptions {
    /// log₂ of the lines a context.
    pub(crate) lines_log2: u32,
    /// η is 2 to the power of minus this (with the scales of inputs and errors taken out).
    pub(crate) rate_shift: u32,
    /// Answers that an adaptive bit counts before it forgets.
    pub(crate) count_limit: u32,
}

/// The weights that a set starts with, in hundredths.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start<const N: usize, const E: usize> {
    /// Of the contexts.
    pub(crate) contexts: [i32; N],
    /// Of the experts.
    pub(crate) experts: [i32; E],
    /// Of the constant input.
    pub(crate) bias: i32,
}

impl<const N: usize> Start<N, 0> {
    /// The same weight for every context.
    pub(crate) fn even(hundredths: i32) -> Self {
        Self { contexts: [hundredths; N], experts: [], bias: 0 }
    }
}

/// Mixes `N` contexts and `E` experts.
#[derive(Debug, Clone)]
pub(crate) struct Mixer<const N: usize, const E: usize> {
    options: MixerOptions,
    lines: Vec<[AdaptiveBit; NODES]>,
    weights: Vec<Weights<N, E>>,
    /// The line of each context, and the set, of the value that is being coded.
    chosen: [u32; N],
    set: usize,
}

#[derive(Debug, Clone, Copy)]
struct Weights<const N: usize, const E: usize> {
    contexts: [i32; N],
    experts: [i32; E],
    bias: i32,
    /// How often these weights were used, up to the last entry of [`HASTE`].
    uses: u32,
}

/// By how much more than later, in 16ths, weights learn from their first decisions: 1 + a / (1 + n / 16).
static HASTE: [i32; 256] = haste();

const fn haste() -> [i32; 256] {
    let mut table = [0; 256];
    let mut n = 0;
    while n < table.len() {
        table[n] = 16 + (16 * 16 * 4) / (16 + n as i32);
        n += 1;
    }
    table
}

impl<const N: usize, const E: usize> Mixer<N, E> {
    /// The memory that the lines take, 2 to the power of `lines_log2` for each context.
    pub(crate) fn memory(lines_log2: u32) -> u64 {
        ((N * size_of::<[AdaptiveBit; NODES]>()) as u64) << lines_log2
    }

    /// One set of weights for every `start`.
    pub(crate) fn new(options: MixerOptions, starts: &[Start<N, E>]) -> Self {
        let fixed = |hundredths: i32| hundredths * ONE / 100;
        let weights = starts.iter().flat_map(|start| {
            let contexts = start.contexts.map(fixed);
            std::iter::repeat_n(
                Weights { contexts, experts: start.experts.map(fixed), bias: fixed(start.bias), uses: 0 },
                NODES,
            )
        });
        Self {
            options,
            lines: vec![[AdaptiveBit::default(); NODES]; N << options.lines_log2],
            weights: weights.collect(),
            chosen: [0; N],
            set: 0,
        }
    }

    /// Starts a value: its context hashes, and which weights to use.
    #[inline]
    pub(crate) fn choose(&mut self, contexts: [u32; N], set: usize) {
        let log2 = self.options.lines_log2;
        for (i, context) in contexts.into_iter().enumerate() {
            self.chosen[i] = ((i as u32) << log2) + (hash(context, i as u32 + 1) >> (32 - log2));
        }
        self.set = set * NODES;
    }

    /// The chance, in 65536ths, that a decision of the value is true; nothing is learned.
    pub(crate) fn chance(&self, node: usize, experts: [i32; E]) -> u32 {
        self.mixed(node, experts).1
    }

    /// The inputs that the contexts give, and what all inputs together say.
    #[inline]
    fn mixed(&self, node: usize, experts: [i32; E]) -> ([i32; N], u32) {
        let weights = &self.weights[self.set + node];
        let mut inputs = [0; N];
        let mut dot = i64::from(weights.bias) * i64::from(BIAS);
        for i in 0..N {
            let bit = self.lines[self.chosen[i] as usize][node];
            inputs[i] = if bit.is_fresh() { 0 } else { stretch(bit.p()) };
            dot += i64::from(weights.contexts[i]) * i64::from(inputs[i]);
        }
        for i in 0..E {
            dot += i64::from(weights.experts[i]) * i64::from(experts[i]);
        }
        (inputs, squash((dot >> 16).clamp(-i64::from(LIMIT), i64::from(LIMIT)) as i32))
    }

    /// Codes one decision of the value and learns from it.
    #[inline]
    pub(crate) fn code<C: BitCoder>(&mut self, coder: &mut C, decision: bool, node: usize, experts: [i32; E]) -> bool {
        let (inputs, p) = self.mixed(node, experts);
        let weights = &mut self.weights[self.set + node];
        let decision = coder.code(decision, p);

        let error = (if decision { ONE } else { 0 }) - p as i32;
        let shift = 10 + self.options.rate_shift;
        let error = (error * HASTE[weights.uses as usize]) >> 4;
        weights.uses = (weights.uses + 1).min(HASTE.len() as u32 - 1);
        for i in 0..N {
            weights.contexts[i] += ((i64::from(inputs[i]) * i64::from(error)) >> shift) as i32;
            self.lines[self.chosen[i] as usize][node].learn(decision, self.options.count_limit);
        }
        for i in 0..E {
            weights.experts[i] += ((i64::from(experts[i]) * i64::from(error)) >> shift) as i32;
        }
        weights.bias += ((i64::from(BIAS) * i64::from(error)) >> shift) as i32;
        decision
    }
}

/// A well-spread function of two words.
#[inline]
pub(crate) fn hash(a: u32, b: u32) -> u32 {
    let mut h = a.wrapping_mul(0x9E37_79B1) ^ b.wrapping_add(0x7F4A_7C15).wrapping_mul(0x85EB_CA6B);
    h ^= h >> 15;
    h = h.wrapping_mul(0x2C1B_3C6D);
    h ^= h >> 12;
    h = h.wrapping_mul(0x297A_2D39);
    h ^ h >> 15
}

#[cfg(test)]
mod tests {
    use super::super::{BitReader, BitWriter};
    use super::*;

    /// The same in `f64`, written from the formulas at the top: chances, weights, and bits that never collide.
    struct Twin {
        weights: [f64; 3],
        bits: std::collections::HashMap<(usize, u32), (f64, f64)>,
        uses: f64,
    }

    impl Twin {
        /// The bits that a decision costs.
        fn code(&mut self, decision: bool, contexts: [u32; 2]) -> f64 {
            let y = f64::from(u8::from(decision));
            let mut inputs = [0.0, 0.0, 1.0];
            for (i, &context) in contexts.iter().enumerate() {
                if let Some(&(p, _)) = self.bits.get(&(i, context)) {
                    inputs[i] = (p / (1.0 - p)).ln();
                }
            }
            let dot: f64 = (0..3).map(|i| self.weights[i] * inputs[i]).sum();
            let p = 1.0 / (1.0 + (-dot).exp());
            let rate = 256.0 / f64::from(1 << 16) * (1.0 + 4.0 * 16.0 / (16.0 + self.uses.min(255.0)));
            self.uses += 1.0;
            for i in 0..3 {
                self.weights[i] += rate * (y - p) * inputs[i];
            }
            for (i, &context) in contexts.iter().enumerate() {
                let (p, count) = self.bits.entry((i, context)).or_insert((0.5, 0.0));
                *p = (*p + (y - *p) / (*count + 1.6)).clamp(1.0 / 4096.0, 1.0 - 1.0 / 4096.0);
                *count = (*count + 1.0).min(255.0);
            }
            -(if decision { p } else { 1.0 - p }).log2()
        }
    }

    #[test]
    fn it_codes_as_well_as_its_twin_in_f64_and_reads_what_it_wrote() {
        let options = MixerOptions { lines_log2: 12, rate_shift: 6, count_limit: 255 };
        let start = [Start::<2, 0>::even(40)];
        let mut twin = Twin { weights: [0.4, 0.4, 0.0], bits: Default::default(), uses: 0.0 };
        // A source that two contexts explain, one better than the other.
        let mut state = 1_u32;
        let source: Vec<(bool, [u32; 2])> = (0..20_000)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let (a, b) = (state >> 28, state >> 24 & 3);
                let chance = 6 * a + 20 * u32::from(b == 0);
                ((state >> 8 & 127) < chance, [a, b])
            })
            .collect();
        let (mut writer, mut mixer) = (BitWriter::default(), Mixer::new(options, &start));
        let mut bits = 0.0;
        for &(decision, contexts) in &source {
            mixer.choose(contexts, 0);
            mixer.code(&mut writer, decision, 0, []);
            bits += twin.code(decision, contexts);
        }
        let bytes = writer.finish();
        let ratio = 8.0 * bytes.len() as f64 / bits;
        assert!((0.99..1.01).contains(&ratio), "{ratio} times the bits of the twin");
        let (mut reader, mut mixer) = (BitReader::new(&bytes), Mixer::new(options, &start));
        for &(decision, contexts) in &source {
            mixer.choose(contexts, 0);
            assert_eq!(mixer.code(&mut reader, false, 0, []), decision);
        }
    }
}
