//! Residuals of attributes: as those of positions ([`super::super::residual`]), but of up to 64 bits.

use crate::entropy::{AdaptiveBit, BitCoder, Mixer, MixerOptions, Start};

/// Contexts.
pub(super) const CONTEXTS: usize = 6;
/// Components with models of their own; later ones share the last.
pub(super) const SETS: usize = 4;
/// Classes that have decisions of their own; later ones share the last.
const CLASSES: usize = 14;
const LAST_CLASS: u32 = 63;

#[derive(Debug)]
pub(super) struct Residuals {
    mixer: Mixer<CONTEXTS, 0>,
    high: Vec<[AdaptiveBit; 3]>,
}

impl Residuals {
    pub(super) fn new(elements: usize) -> Self {
        let options = MixerOptions { lines_log2: (elements.max(1).ilog2()).clamp(6, 14), rate_shift: 5, count_limit: 120 };
        Self { mixer: Mixer::new(options, &[Start::even(25); SETS]), high: vec![[AdaptiveBit::default(); 3]; SETS * CLASSES] }
    }

    /// Codes a residual of one component.
    pub(super) fn code<C: BitCoder>(
        &mut self,
        coder: &mut C,
        residual: i64,
        component: usize,
        contexts: [u32; CONTEXTS],
    ) -> i64 {
        let set = component.min(SETS - 1);
        self.mixer.choose(contexts, set);
        if self.mixer.code(coder, residual == 0, 0, []) {
            return 0;
        }
        let positive = self.mixer.code(coder, residual > 0, 1, []);
        let bits = residual.unsigned_abs().max(1);
        let wanted = bits.ilog2();
        let mut class = 0;
        while class < LAST_CLASS && !self.mixer.code(coder, class == wanted, 2 + (class as usize).min(CLASSES - 1), []) {
            class += 1;
        }
        // |residual| has its highest bit at `class`; the bits below follow.
        let high = &mut self.high[set * CLASSES + (class as usize).min(CLASSES - 1)];
        let mut value = 1_u64;
        for depth in 0..class.min(2) {
            let bit = bits >> (class - 1 - depth) & 1 != 0;
            let node = if depth == 0 { 0 } else { 1 + (value & 1) as usize };
            value = value << 1 | u64::from(high[node].code(coder, bit));
        }
        let mut plain = class.saturating_sub(2);
        while plain > 0 {
            let some = plain.min(16);
            plain -= some;
            value = value << some | u64::from(coder.raw((bits >> plain & ((1 << some) - 1)) as u32, some));
        }
        if positive { value as i64 } else { (value as i64).wrapping_neg() }
    }
}

/// A residual in few words: 0, or its sign and the length of its bits.
pub(super) fn class(residual: i64) -> i32 {
    let length = 64 - residual.unsigned_abs().leading_zeros() as i32;
    if residual < 0 { -length } else { length }
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::super::super::super::entropy::{BitReader, BitWriter};
    use super::*;

    #[test]
    fn any_residual_comes_back() {
        let all = [0, 1, -1, 2, -7, 100, -65_536, i64::from(i32::MAX), i64::MAX, i64::MIN, i64::MIN + 1, 5, 0];
        let (mut writer, mut model) = (BitWriter::default(), Residuals::new(100));
        all.iter().enumerate().for_each(|(i, &r)| {
            model.code(&mut writer, r, i % 5, [i as u32 % 3; CONTEXTS]);
        });
        let bytes = writer.finish();
        let (mut reader, mut model) = (BitReader::new(&bytes), Residuals::new(100));
        for (i, &r) in all.iter().enumerate() {
            assert_eq!(model.code(&mut reader, 0, i % 5, [i as u32 % 3; CONTEXTS]), r);
        }
    }
}
