//! Residuals of base colours, as binary decisions in many contexts.
//!
//! Is it 0? is it positive? Then m = |residual| as its bit length in unary, and its bits below the highest, highest
//! first. All but the lower bits are mixed from the contexts.

use crate::entropy::{AdaptiveBit, BitCoder, Mixer, MixerOptions, Start};

/// Bit lengths that have decisions of their own; longer ones share the last.
const LENGTHS: usize = 14;
/// No residual is longer.
const MAX_LENGTH: u32 = 31;

/// Codes residuals with `N` contexts.
#[derive(Debug)]
pub(super) struct Residuals<const N: usize> {
    mixer: Mixer<N, 0>,
    /// By axis, length, and the bit before: the two bits below the highest.
    high: Vec<[AdaptiveBit; 3]>,
}

impl<const N: usize> Residuals<N> {
    pub(super) fn new(colours: usize) -> Self {
        let options = MixerOptions { lines_log2: colours.max(1).ilog2().clamp(6, 14), rate_shift: 5, count_limit: 60 };
        Self { mixer: Mixer::new(options, &[Start::even(25); 3]), high: vec![[AdaptiveBit::default(); 3]; 3 * LENGTHS] }
    }

    /// Codes the residual of one component.
    #[inline]
    pub(super) fn code<C: BitCoder>(&mut self, coder: &mut C, residual: i32, axis: usize, contexts: [u32; N]) -> i32 {
        self.mixer.choose(contexts, axis);
        if self.mixer.code(coder, residual == 0, 0, []) {
            return 0;
        }
        let positive = self.mixer.code(coder, residual > 0, 1, []);
        let magnitude = residual.unsigned_abs().max(1);
        let wanted = magnitude.ilog2();
        let mut length = 0;
        while length < MAX_LENGTH && !self.mixer.code(coder, length == wanted, 2 + (length as usize).min(LENGTHS - 1), []) {
            length += 1;
        }
        let high = &mut self.high[axis * LENGTHS + (length as usize).min(LENGTHS - 1)];
        let mut value = 1_u32;
        for depth in 0..length {
            let bit = magnitude >> (length - 1 - depth) & 1 != 0;
            let bit = match depth {
                0 => high[0].code(coder, bit),
                1 => high[1 + (value & 1) as usize].code(coder, bit),
                _ => coder.code(bit, 1 << 15),
            };
            value = value << 1 | u32::from(bit);
        }
        let magnitude = value.min(i32::MAX as u32) as i32;
        if positive { magnitude } else { -magnitude }
    }
}
