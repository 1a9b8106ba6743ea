//! Residuals: how far a coordinate is from its prediction, as binary decisions in many contexts.
//!
//! A residual r is coded as: is it 0? is it positive? then, of m = |r| − 1, the class j with
//! 2ʲ − 1 ≤ m ≤ 2ʲ⁺¹ − 2 in unary, and the j bits of m below the class, highest first. Zero, sign and
//! class are mixed from all contexts; the two highest bits have a model by class; the rest are plain.

use super::mix::{Mixer, MixerOptions, Start};
use super::model::AdaptiveBit;
use super::range::BitCoder;

/// Classes that have decisions of their own; later ones share the last.
const CLASSES: usize = 14;
/// No residual has a class above this.
const LAST_CLASS: u32 = 31;

/// Codes residuals with `N` contexts.
#[derive(Debug)]
pub(crate) struct Residuals<const N: usize> {
    mixer: Mixer<N, 0>,
    /// By axis, class, and the bit before: the two highest bits of the magnitude.
    high: Vec<[AdaptiveBit; 3]>,
}

impl<const N: usize> Residuals<N> {
    pub(crate) fn new(vertices: usize) -> Self {
        let options = MixerOptions { lines_log2: lines_log2(vertices), rate_shift: 5, count_limit: 60 };
        Self { mixer: Mixer::new(options, &[Start::even(25); 3]), high: vec![[AdaptiveBit::default(); 3]; 3 * CLASSES] }
    }

    /// The memory that so many vertices need.
    pub(crate) fn memory(vertices: usize) -> u64 {
        Mixer::<N, 0>::memory(lines_log2(vertices))
    }

    /// Codes a residual of one axis.
    #[inline]
    pub(crate) fn code<C: BitCoder>(&mut self, coder: &mut C, residual: i32, axis: usize, contexts: [u32; N]) -> i32 {
        self.mixer.choose(contexts, axis);
        if self.mixer.code(coder, residual == 0, 0, []) {
            return 0;
        }
        let positive = self.mixer.code(coder, residual > 0, 1, []);
        let magnitude = residual.unsigned_abs().saturating_sub(1);
        let wanted = (magnitude + 1).ilog2();
        let mut class = 0;
        while class < LAST_CLASS && !self.mixer.code(coder, class == wanted, 2 + (class as usize).min(CLASSES - 1), []) {
            class += 1;
        }
        // m + 1 has its highest bit at `class`; the bits below follow.
        let bits = magnitude + 1;
        let high = &mut self.high[axis * CLASSES + (class as usize).min(CLASSES - 1)];
        let mut value = 1;
        for depth in 0..class.min(2) {
            let bit = bits >> (class - 1 - depth) & 1 != 0;
            let node = if depth == 0 { 0 } else { 1 + (value & 1) as usize };
            value = value << 1 | u32::from(high[node].code(coder, bit));
        }
        let plain = class.saturating_sub(2);
        value = value << plain | coder.raw(bits & ((1 << plain) - 1), plain);
        let magnitude = value.min(i32::MAX as u32) as i32;
        if positive { magnitude } else { -magnitude }
    }
}

/// Lines of a context: about one for every vertex.
fn lines_log2(vertices: usize) -> u32 {
    vertices.max(1).ilog2().clamp(6, 14)
}
