//! The arithmetic coder: binary decisions with 16-bit probabilities (spec/surface.md, "Arithmetic coder").
//!
//! A range coder on 64-bit integers (G. N. N. Martin, "Range encoding", 1979) that renormalises
//! 32 bits at a time. A carry runs into bytes already written, which stay in memory for it.
//! The last bytes are cut as short as they can be: a reader sees zeros after the end.

/// One side of the coder.
pub(crate) trait BitCoder {
    /// Whether this side writes; a reader ignores the decisions that it is given.
    const WRITES: bool;

    /// Codes a decision. `p` is the chance, in 65536ths, that it is true; 1 ≤ p ≤ 65535.
    fn code(&mut self, decision: bool, p: u32) -> bool;

    /// Codes the lowest `bits` bits of a value without a model.
    fn raw(&mut self, value: u32, bits: u32) -> u32 {
        (0..bits).rev().fold(0, |read, i| read << 1 | u32::from(self.code(value >> i & 1 != 0, 1 << 15)))
    }

    /// Whether a reader has used up its bytes and goes on with invented zeros.
    fn is_exhausted(&self) -> bool;

    /// Looks on at what both sides must find alike. Nothing but tests listens.
    #[inline]
    fn watch(&mut self, _found: impl FnOnce() -> f64) {}
}

/// The range is never smaller than this.
const RENORMALISE: u64 = 1 << 32;

/// Writes decisions to bytes.
#[derive(Debug)]
#[cfg_attr(not(feature = "encode"), allow(dead_code))]
pub(crate) struct BitWriter {
    low: u64,
    range: u64,
    bytes: Vec<u8>,
}

impl Default for BitWriter {
    fn default() -> Self {
        Self { low: 0, range: u64::MAX, bytes: Vec::new() }
    }
}

impl BitCoder for BitWriter {
    const WRITES: bool = true;

    #[inline]
    fn code(&mut self, decision: bool, p: u32) -> bool {
        let split = (self.range >> 16) * u64::from(p);
        if decision {
            self.range = split;
        } else {
            let (low, carry) = self.low.overflowing_add(split);
            self.low = low;
            self.range -= split;
            if carry {
                self.carry();
            }
        }
        if self.range < RENORMALISE {
            self.bytes.extend_from_slice(&((self.low >> 32) as u32).to_be_bytes());
            self.low <<= 32;
            self.range <<= 32;
        }
        decision
    }

    fn is_exhausted(&self) -> bool {
        false
    }
}

impl BitWriter {
    #[cold]
    fn carry(&mut self) {
        for byte in self.bytes.iter_mut().rev() {
            *byte = byte.wrapping_add(1);
            if *byte != 0 {
                break;
            }
        }
    }

    /// The fewest bytes from which a reader finds the same decisions.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        // Any value of [low, low + range) will do: take the one with the most zeros at its end.
        let low = u128::from(self.low);
        let last = low + u128::from(self.range) - 1;
        let value = (0..=64).rev().map(|zeros| last >> zeros << zeros).find(|&value| value >= low).unwrap_or(last);
        if value >> 64 != 0 {
            self.carry();
        }
        self.bytes.extend_from_slice(&(value as u64).to_be_bytes());
        while self.bytes.last() == Some(&0) {
            self.bytes.pop();
        }
        self.bytes
    }
}

/// Reads the decisions that a [`BitWriter`] wrote; on other bytes it reads something, and never fails.
#[derive(Debug)]
pub(crate) struct BitReader<'a> {
    /// What is left of the window above the low end of the range.
    code: u64,
    range: u64,
    bytes: &'a [u8],
    position: usize,
}

impl<'a> BitReader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        let mut reader = Self { code: 0, range: u64::MAX, bytes, position: 0 };
        reader.code = u64::from(reader.word()) << 32 | u64::from(reader.word());
        reader
    }

    #[inline]
    fn word(&mut self) -> u32 {
        let word = match self.bytes.get(self.position..self.position + 4) {
            Some(bytes) => u32::from_be_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
            None => {
                let mut padded = [0; 4];
                let rest = self.bytes.get(self.position..).unwrap_or_default();
                padded[..rest.len()].copy_from_slice(rest);
                u32::from_be_bytes(padded)
            }
        };
        self.position += 4;
        word
    }
}

impl BitCoder for BitReader<'_> {
    const WRITES: bool = false;

    #[inline]
    fn code(&mut self, _: bool, p: u32) -> bool {
        let split = (self.range >> 16) * u64::from(p);
        let decision = self.code < split;
        if decision {
            self.range = split;
        } else {
            self.code -= split;
            self.range -= split;
        }
        if self.range < RENORMALISE {
            self.code = self.code << 32 | u64::from(self.word());
            self.range <<= 32;
        }
        decision
    }

    /// A writer leaves at most the eight bytes of its last window away.
    fn is_exhausted(&self) -> bool {
        self.position > self.bytes.len() + 16
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn decisions_come_back_whatever_was_thought_of_them(
            decisions in proptest::collection::vec((any::<bool>(), 1_u32..65536), 0..2000),
        ) {
            let mut writer = BitWriter::default();
            for &(decision, p) in &decisions {
                writer.code(decision, p);
            }
            let bytes = writer.finish();
            let mut reader = BitReader::new(&bytes);
            for &(decision, p) in &decisions {
                prop_assert_eq!(reader.code(false, p), decision);
            }
            prop_assert!(!reader.is_exhausted());
        }

        #[test]
        fn the_size_is_the_information_and_at_most_two_bytes_more(
            decisions in proptest::collection::vec((0_u32..65536, 1_u32..65536), 0..500),
        ) {
            let mut writer = BitWriter::default();
            let mut bits = 0.0;
            for &(random, p) in &decisions {
                let decision = writer.code(random < p, p);
                let chance = f64::from(if decision { p } else { 65536 - p }) / 65536.0;
                bits -= chance.log2();
            }
            prop_assert!(writer.finish().len() as f64 <= bits / 8.0 * 1.0001 + 2.0);
        }
    }

    #[test]
    fn a_carry_runs_through_full_bytes() {
        // Many improbable `false` decisions push the low end up against the top of the range.
        let decisions: Vec<(bool, u32)> = (0..400).map(|i| (i % 97 == 0, 65535 - (i % 3))).collect();
        let mut writer = BitWriter::default();
        for &(decision, p) in &decisions {
            writer.code(decision, p);
        }
        let bytes = writer.finish();
        let mut reader = BitReader::new(&bytes);
        assert!(decisions.iter().all(|&(decision, p)| reader.code(false, p) == decision));
    }
}
