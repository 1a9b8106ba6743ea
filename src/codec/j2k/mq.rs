//! The MQ arithmetic encoder (Annex C), and where its codeword may be cut.
//!
//! The encoder narrows an interval; any codeword inside the last interval decodes to the same decisions. A decoder
//! that runs out of bytes goes on with ones. So after any decision the codeword may be cut to the shortest prefix that,
//! followed by ones, still lies below the upper end of the interval of that moment ([`UpperEnd`]). That is an exact
//! test, not an estimate, and needs only five bytes per coding pass.

/// A row of Table C.2 for one value of the more probable symbol.
#[derive(Clone, Copy)]
struct Transition {
    /// Qe: the width of the less probable symbol's interval.
    qe: u32,
    /// The state after a more probable symbol.
    nmps: u8,
    /// The state after a less probable symbol.
    nlps: u8,
}

/// Table C.2: Qe, NMPS, NLPS, SWITCH.
const STATES: [(u32, u8, u8, u8); 47] = [
    (0x5601, 1, 1, 1),
    (0x3401, 2, 6, 0),
    (0x1801, 3, 9, 0),
    (0x0ac1, 4, 12, 0),
    (0x0521, 5, 29, 0),
    (0x0221, 38, 33, 0),
    (0x5601, 7, 6, 1),
    (0x5401, 8, 14, 0),
    (0x4801, 9, 14, 0),
    (0x3801, 10, 14, 0),
    (0x3001, 11, 17, 0),
    (0x2401, 12, 18, 0),
    (0x1c01, 13, 20, 0),
    (0x1601, 29, 21, 0),
    (0x5601, 15, 14, 1),
    (0x5401, 16, 14, 0),
    (0x5101, 17, 15, 0),
    (0x4801, 18, 16, 0),
    (0x3801, 19, 17, 0),
    (0x3401, 20, 18, 0),
    (0x3001, 21, 19, 0),
    (0x2801, 22, 19, 0),
    (0x2401, 23, 20, 0),
    (0x2201, 24, 21, 0),
    (0x1c01, 25, 22, 0),
    (0x1801, 26, 23, 0),
    (0x1601, 27, 24, 0),
    (0x1401, 28, 25, 0),
    (0x1201, 29, 26, 0),
    (0x1101, 30, 27, 0),
    (0x0ac1, 31, 28, 0),
    (0x09c1, 32, 29, 0),
    (0x08a1, 33, 30, 0),
    (0x0521, 34, 31, 0),
    (0x0441, 35, 32, 0),
    (0x02a1, 36, 33, 0),
    (0x0221, 37, 34, 0),
    (0x0141, 38, 35, 0),
    (0x0111, 39, 36, 0),
    (0x0085, 40, 37, 0),
    (0x0049, 41, 38, 0),
    (0x0025, 42, 39, 0),
    (0x0015, 43, 40, 0),
    (0x0009, 44, 41, 0),
    (0x0005, 45, 42, 0),
    (0x0001, 45, 43, 0),
    (0x5601, 46, 46, 0),
];

/// [`STATES`] with the more probable symbol folded into the lowest bit of the state; filled up to a power of two so
/// that a masked index needs no check.
const TRANSITIONS: [Transition; 128] = {
    let mut table = [Transition { qe: 0, nmps: 0, nlps: 0 }; 128];
    let mut i = 0;
    while i < 2 * STATES.len() {
        let (qe, nmps, nlps, switch) = STATES[i / 2];
        let mps = (i % 2) as u8;
        table[i] = Transition { qe, nmps: 2 * nmps + mps, nlps: 2 * nlps + (mps ^ switch) };
        i += 1;
    }
    table
};

/// How many contexts the coding passes use (Table D.1 to D.4); the array is filled up to a power of two.
const CONTEXTS: usize = 32;

/// The registers of C.2.1 and the bytes so far.
pub(super) struct MqEncoder {
    a: u32,
    c: u32,
    ct: u32,
    contexts: [u8; CONTEXTS],
    /// Byte 0 stands for the byte before the first one (BPST − 1) and never changes.
    bytes: Vec<u8>,
}

impl MqEncoder {
    /// INITENC (C.2.8), with the initial states of the contexts given as (context, state); all others are in state 0.
    pub(super) fn new(initial: &[(u8, u8)], capacity: usize) -> Self {
        let mut contexts = [0; CONTEXTS];
        for &(context, state) in initial {
            contexts[usize::from(context)] = 2 * state;
        }
        let mut bytes = Vec::with_capacity(capacity + 1);
        bytes.push(0);
        Self { a: 0x8000, c: 0, ct: 12, contexts, bytes }
    }

    /// ENCODE (C.2.2 to C.2.6): one decision, 0 or 1, in a context.
    #[inline(always)]
    pub(super) fn encode(&mut self, decision: u32, context: u8) {
        let state = &mut self.contexts[usize::from(context) % CONTEXTS];
        let t = TRANSITIONS[usize::from(*state) % TRANSITIONS.len()];
        self.a -= t.qe;
        if decision == u32::from(*state & 1) {
            if self.a & 0x8000 != 0 {
                self.c += t.qe;
                return;
            }
            // The less probable symbol has the larger interval: exchange them (C.2.5).
            if self.a < t.qe {
                self.a = t.qe
            } else {
                self.c += t.qe
            }
            *state = t.nmps;
        } else {
            if self.a < t.qe {
                self.c += t.qe
            } else {
                self.a = t.qe
            }
            *state = t.nlps;
        }
        self.renormalise();
    }

    /// RENORME (C.2.6), all shifts between two bytes at once.
    #[inline(always)]
    fn renormalise(&mut self) {
        let mut shift = self.a.leading_zeros() - 16;
        self.a <<= shift;
        while shift >= self.ct {
            self.c <<= self.ct;
            shift -= self.ct;
            self.byte_out();
        }
        self.c <<= shift;
        self.ct -= shift;
    }

    /// BYTEOUT (C.2.7).
    fn byte_out(&mut self) {
        let last = self.bytes.len() - 1;
        let (carry, byte);
        (carry, byte, self.c, self.ct) = byte_out(self.bytes[last], self.c);
        self.bytes[last] += carry;
        self.bytes.push(byte);
    }

    /// The upper end of the interval after what was encoded so far.
    pub(super) fn upper_end(&self) -> UpperEnd {
        let start = self.bytes.len() - 1;
        let mut tail = [self.bytes[start]; 5];
        // The largest value inside, followed by ones: 27 bits of it are not yet in the bytes.
        let (mut c, mut ct) = (self.c + self.a - 1, self.ct);
        for i in 1..tail.len() {
            c = c << ct | ((1 << ct) - 1);
            let carry;
            (carry, tail[i], c, ct) = byte_out(tail[i - 1], c);
            tail[i - 1] += carry;
        }
        UpperEnd { start, tail }
    }

    /// FLUSH (C.2.9): the whole codeword, which [`UpperEnd::length`] shortens.
    pub(super) fn finish(mut self) -> Codeword {
        let end = self.c + self.a;
        self.c |= 0xffff;
        if self.c >= end {
            self.c -= 0x8000;
        }
        for _ in 0..2 {
            self.c <<= self.ct;
            self.byte_out();
        }
        Codeword { bytes: self.bytes }
    }
}

/// BYTEOUT on values: the carry into the last byte, the next byte, and the registers C and CT after it.
#[inline(always)]
fn byte_out(last: u8, c: u32) -> (u8, u8, u32, u32) {
    let carry = if last == 0xff { 0 } else { (c >> 27) as u8 };
    if last + carry == 0xff {
        // A byte after 0xff carries seven bits, so that no carry can ever run through it.
        let c = if carry == 1 { c & 0x07ff_ffff } else { c };
        (carry, (c >> 20) as u8, c & 0x000f_ffff, 7)
    } else {
        (carry, (c >> 19) as u8, c & 0x0007_ffff, 8)
    }
}

/// Where the interval ended at some moment: the bytes from `start` on of the largest codeword inside it. Ones follow.
#[derive(Clone, Copy)]
pub(super) struct UpperEnd {
    start: usize,
    tail: [u8; 5],
}

/// A finished codeword.
pub(super) struct Codeword {
    bytes: Vec<u8>,
}

impl Codeword {
    /// The least number of bytes that, followed by ones, decodes to all that was encoded when `end` was taken.
    pub(super) fn length(&self, end: &UpperEnd) -> usize {
        // Bytes that are out already may be ones as well, but hardly more than two of them.
        let mut length = end.start.saturating_sub(2).max(1);
        while length < self.bytes.len() && !(self.may_end(length) && self.prefix_is_within(length, end)) {
            length += 1;
        }
        // Ones follow anyway, and a codeword segment must not end in 0xff.
        while length > 1 && self.bytes[length - 1] == 0xff {
            length -= 1;
        }
        length - 1
    }

    /// Whether the first `length` bytes and then ones are at least the codeword: not so where a carry came to rest in
    /// the spare bit of the byte after 0xff.
    fn may_end(&self, length: usize) -> bool {
        let mut previous = self.bytes[length - 1];
        for &byte in &self.bytes[length..] {
            let ones = next_of_ones(previous);
            if byte != ones {
                return byte < ones;
            }
            previous = byte;
        }
        true
    }

    /// Whether the first `length` bytes and then ones are at most the upper end.
    fn prefix_is_within(&self, length: usize, end: &UpperEnd) -> bool {
        // As numbers, and from a few bytes before: 07 ff 80 is as much as 08 00 00, so bytes alone do not compare.
        let before = end.start.saturating_sub(3);
        let bound = self.bytes[before..end.start].iter().chain(&end.tail);
        number_with_ones(self.bytes[before..length].iter()) <= number_with_ones(bound)
    }

    /// The bytes, without the one before the first, cut to `length`.
    pub(super) fn into_bytes(mut self, length: usize) -> Vec<u8> {
        self.bytes.truncate(length + 1);
        self.bytes.remove(0);
        self.bytes
    }
}

/// A dozen bytes of a codeword as a binary fraction, with ones after them.
fn number_with_ones<'a>(bytes: impl Iterator<Item = &'a u8>) -> u128 {
    let (mut number, mut position, mut unit) = (0, 112, 1);
    for &byte in bytes.take(12) {
        number += u128::from(byte) << position;
        unit = 1u128 << position;
        position -= if byte == 0xff { 7 } else { 8 };
    }
    number + (unit - 1)
}

/// The byte after another when all bits to come are ones.
fn next_of_ones(previous: u8) -> u8 {
    if previous == 0xff { 0x7f } else { 0xff }
}

/// The decoder of C.3, as the standard draws it, for tests only.
#[cfg(test)]
mod as_written {
    use super::STATES;

    pub(super) struct MqDecoder<'a> {
        bytes: &'a [u8],
        at: usize,
        a: u32,
        c: u32,
        ct: u32,
        index: [usize; 32],
        mps: [u32; 32],
    }

    impl<'a> MqDecoder<'a> {
        pub(super) fn new(bytes: &'a [u8]) -> Self {
            let mut d = Self { bytes, at: 0, a: 0, c: 0, ct: 0, index: [0; 32], mps: [0; 32] };
            d.c = u32::from(d.byte(0)) << 16;
            d.byte_in();
            d.c <<= 7;
            d.ct -= 7;
            d.a = 0x8000;
            d
        }

        fn byte(&self, at: usize) -> u8 {
            self.bytes.get(at).copied().unwrap_or(0xff)
        }

        fn byte_in(&mut self) {
            if self.byte(self.at) == 0xff {
                if self.byte(self.at + 1) > 0x8f {
                    self.c += 0xff00;
                    self.ct = 8;
                } else {
                    self.at += 1;
                    self.c += u32::from(self.byte(self.at)) << 9;
                    self.ct = 7;
                }
            } else {
                self.at += 1;
                self.c += u32::from(self.byte(self.at)) << 8;
                self.ct = 8;
            }
        }

        pub(super) fn decode(&mut self, cx: usize) -> u32 {
            let (qe, nmps, nlps, switch) = STATES[self.index[cx]];
            self.a -= qe;
            let d;
            if self.c >> 16 < qe {
                // LPS_EXCHANGE
                if self.a < qe {
                    d = self.mps[cx];
                    self.index[cx] = usize::from(nmps);
                } else {
                    d = 1 - self.mps[cx];
                    self.mps[cx] ^= u32::from(switch);
                    self.index[cx] = usize::from(nlps);
                }
                self.a = qe;
            } else {
                self.c -= qe << 16;
                if self.a & 0x8000 != 0 {
                    return self.mps[cx];
                }
                // MPS_EXCHANGE
                if self.a < qe {
                    d = 1 - self.mps[cx];
                    self.mps[cx] ^= u32::from(switch);
                    self.index[cx] = usize::from(nlps);
                } else {
                    d = self.mps[cx];
                    self.index[cx] = usize::from(nmps);
                }
            }
            while self.a & 0x8000 == 0 {
                if self.ct == 0 {
                    self.byte_in();
                }
                self.a <<= 1;
                self.c <<= 1;
                self.ct -= 1;
            }
            d
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Decisions that are mostly 0 in context 0, mostly 1 in context 1, and fair in context 2.
    fn decisions(seed: u32, n: usize) -> Vec<(u32, u8)> {
        let mut x = seed | 1;
        let mut next = || {
            x ^= x << 13;
            x ^= x >> 17;
            x ^= x << 5;
            x >> 8
        };
        (0..n)
            .map(|_| {
                let context = next() % 3;
                let decision = match context {
                    0 => u32::from(next() % 50 == 0),
                    1 => u32::from(next() % 9 != 0),
                    _ => next() % 2,
                };
                (decision, context as u8)
            })
            .collect()
    }

    fn decodes(bytes: &[u8], decisions: &[(u32, u8)]) -> bool {
        let mut decoder = as_written::MqDecoder::new(bytes);
        decisions.iter().all(|&(d, cx)| decoder.decode(usize::from(cx)) == d)
    }

    proptest! {
        // A carry into the spare bit of a stuffed byte is rare: many bytes are needed to meet one.
        #![proptest_config(ProptestConfig::with_cases(150))]

        #[test]
        fn every_prefix_decodes_from_its_own_length_and_hardly_ever_from_less(seed: u32, n in 1usize..4000) {
            let decisions = decisions(seed, n);
            let mut encoder = MqEncoder::new(&[], 16);
            let ends: Vec<UpperEnd> = decisions
                .iter()
                .map(|&(d, cx)| {
                    encoder.encode(d, cx);
                    encoder.upper_end()
                })
                .collect();
            let codeword = encoder.finish();
            let lengths: Vec<usize> = ends.iter().map(|end| codeword.length(end)).collect();
            prop_assert!(lengths.is_sorted());
            let last = lengths[n - 1];
            let shorter_may_end: Vec<bool> = lengths.iter().map(|&length| length > 0 && codeword.may_end(length)).collect();
            let bytes = codeword.into_bytes(last);
            prop_assert_eq!(bytes.len(), last);
            let mut longer = 0;
            for (i, &length) in lengths.iter().enumerate().step_by(1 + n / 200) {
                prop_assert!(decodes(&bytes[..length], &decisions[..=i]), "{} decisions from {} bytes", i + 1, length);
                longer += usize::from(shorter_may_end[i] && decodes(&bytes[..length - 1], &decisions[..=i]));
            }
            // Only where more than two bytes before the pending one are ones.
            prop_assert!(longer * 50 <= n + 50, "{} of {} lengths could be shorter", longer, n);
        }
    }

    #[test]
    fn the_encoder_agrees_with_the_test_sequence_of_the_standard() {
        // Annex C's companion, the test sequence of ITU-T T.88 (H.2): 32 bytes coded in one context.
        let input = [
            0x00u8, 0x02, 0x00, 0x51, 0x00, 0x00, 0x00, 0xc0, 0x03, 0x52, 0x87, 0x2a, 0xaa, 0xaa, 0xaa, 0xaa, 0x82, 0xc0, 0x20,
            0x00, 0xfc, 0xd7, 0x9e, 0xf6, 0xbf, 0x7f, 0xed, 0x90, 0x4f, 0x46, 0xa3, 0xbf,
        ];
        let output = [
            0x84u8, 0xc7, 0x3b, 0xfc, 0xe1, 0xa1, 0x43, 0x04, 0x02, 0x20, 0x00, 0x00, 0x41, 0x0d, 0xbb, 0x86, 0xf4, 0x31, 0x7f,
            0xff, 0x88, 0xff, 0x37, 0x47, 0x1a, 0xdb, 0x6a, 0xdf,
        ];
        let mut encoder = MqEncoder::new(&[], 40);
        for byte in input {
            for bit in (0..8).rev() {
                encoder.encode(u32::from(byte >> bit & 1), 0);
            }
        }
        let codeword = encoder.finish();
        assert_eq!(&codeword.bytes[1..], output);
    }
}
