//! Adaptive models of single bits and of small numbers.

use super::range::BitCoder;

/// How likely a decision is, learned from those before it.
///
/// The chance of `true` (22 bits) and how often it was asked (10 bits) share one word. The first
/// answers move it by halves, thirds, quarters …, later ones by a fixed share: the mean of what
/// was seen, then an exponential forgetting.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AdaptiveBit(u32);

impl Default for AdaptiveBit {
    fn default() -> Self {
        Self(1 << 31)
    }
}

const COUNT: u32 = (1 << 10) - 1;

/// 65536 / (n + 1.6): the share by which the n-th answer moves the chance.
static RATE: [u32; 1 << 10] = rates();

const fn rates() -> [u32; 1 << 10] {
    let mut rates = [0; 1 << 10];
    let mut n = 0;
    while n < rates.len() {
        rates[n] = 655_360 / (10 * n as u32 + 16);
        n += 1;
    }
    rates
}

impl AdaptiveBit {
    /// The chance of `true`, in 65536ths.
    #[inline]
    pub(crate) fn p(self) -> u32 {
        self.0 >> 16
    }

    /// Whether it has never been asked.
    #[inline]
    pub(crate) fn is_fresh(self) -> bool {
        self.0 & COUNT == 0
    }

    /// Learns an answer; counts up to `limit`, and from there on forgets.
    #[inline]
    pub(crate) fn learn(&mut self, decision: bool, limit: u32) {
        let count = self.0 & COUNT;
        let p = i64::from(self.0 >> 10);
        let target = if decision { (1 << 22) - 1 } else { 0 };
        let moved = p + (((target - p) * i64::from(RATE[count as usize])) >> 16);
        self.0 = (moved as u32) << 10 | (count + u32::from(count < limit));
    }

    /// Codes a decision and learns it.
    #[inline]
    pub(crate) fn code<C: BitCoder>(&mut self, coder: &mut C, decision: bool) -> bool {
        let decision = coder.code(decision, self.p().clamp(1, 65535));
        self.learn(decision, 255);
        decision
    }
}

/// Numbers from 0 on, small ones cheap: Exp-Golomb codes with adaptive bits, in a choice of contexts.
///
/// n + 1 is written as its bit length in unary, then its bits below the highest; the length and the
/// two bits after the highest are modelled.
#[derive(Debug, Clone)]
pub(crate) struct Numbers {
    contexts: Vec<NumberModel>,
}

#[derive(Debug, Clone)]
struct NumberModel {
    length: [AdaptiveBit; 33],
    high: [[AdaptiveBit; 4]; 33],
}

impl Numbers {
    pub(crate) fn new(contexts: usize) -> Self {
        let fresh = NumberModel { length: [AdaptiveBit::default(); 33], high: [[AdaptiveBit::default(); 4]; 33] };
        Self { contexts: vec![fresh; contexts] }
    }

    /// Codes a number below 2³² − 1 in one of the contexts.
    pub(crate) fn code<C: BitCoder>(&mut self, coder: &mut C, number: u32, context: usize) -> u32 {
        let model = &mut self.contexts[context];
        let wanted = u64::from(number) + 1;
        let wanted_length = 63 - wanted.leading_zeros();
        let mut length = 0;
        while length < 32 && model.length[length as usize].code(coder, length < wanted_length) {
            length += 1;
        }
        let mut value = 1_u64;
        for i in (0..length).rev() {
            let bit = wanted >> i & 1 != 0;
            let bit = match length - 1 - i {
                depth @ (0 | 1) => {
                    let node = if depth == 0 { 0 } else { 1 + (value & 1) as usize };
                    model.high[length as usize][node].code(coder, bit)
                }
                _ => coder.code(bit, 1 << 15),
            };
            value = value << 1 | u64::from(bit);
        }
        (value - 1).min(u32::MAX.into()) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BitReader, BitWriter};
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_come_back(numbers in proptest::collection::vec((0..u32::MAX, 0_u32..32, 0_usize..3), 0..200)) {
            let numbers: Vec<_> = numbers.into_iter().map(|(n, shift, context)| (n >> shift, context)).collect();
            let (mut writer, mut model) = (BitWriter::default(), Numbers::new(3));
            for &(n, context) in &numbers {
                model.code(&mut writer, n, context);
            }
            let bytes = writer.finish();
            let (mut reader, mut model) = (BitReader::new(&bytes), Numbers::new(3));
            for &(n, context) in &numbers {
                prop_assert_eq!(model.code(&mut reader, 0, context), n);
            }
        }
    }

    #[test]
    fn a_bit_learns_the_share_of_true() {
        let mut bit = AdaptiveBit::default();
        for i in 0..4000 {
            bit.learn(i % 5 == 0, 255);
        }
        let p = f64::from(bit.p()) / 65536.0;
        assert!((0.19..0.21).contains(&p), "{p}");
    }

    #[test]
    fn a_bit_that_never_changes_costs_next_to_nothing() {
        let (mut writer, mut bit) = (BitWriter::default(), AdaptiveBit::default());
        for _ in 0..100_000 {
            bit.code(&mut writer, true);
        }
        assert!(writer.finish().len() < 100);
    }
}
