//! Coefficient bit modelling (Annex D): a code-block becomes coding passes.
//!
//! A code-block is coded from its highest non-zero bit-plane down. Each plane has three passes (the first only the
//! last of them): significance propagation visits zeros that have a non-zero neighbour, magnitude refinement the
//! coefficients that are already known to be non-zero, and cleanup the rest. Which of the 19 contexts a decision is
//! coded in depends on the neighbours that are known to be non-zero at that moment.
//!
//! The scan goes down stripes of four rows, column by column ([`Stripes`]); one word a column holds what is known of
//! its four coefficients and of the fourteen around them, so that most columns are passed over after one look.

use super::mq::{MqEncoder, UpperEnd};
use super::partition::Orientation;

/// The sign of a coefficient as [`Stripes`] hold it; the magnitude is in the other bits.
const SIGN: u32 = 1 << 31;
/// The most bit-planes that all decoders take.
pub(super) const MAX_PLANES: u32 = 30;

/// The run-length context and the uniform one (Table D.5); zero coding uses 0 to 8.
const RUN_LENGTH: u8 = 17;
const UNIFORM: u8 = 18;
/// Initial states (Table D.7).
const INITIAL: [(u8, u8); 3] = [(0, 4), (RUN_LENGTH, 3), (UNIFORM, 46)];

/// A code-block's samples to be coded, four rows of a column side by side, with a border of zeros all round.
pub(super) struct Stripes {
    width: usize,
    height: usize,
    /// Sign and magnitude.
    values: Vec<u32>,
    /// What the magnitudes were before quantisation, in steps; empty where no distortion is asked for.
    exact: Vec<f32>,
}

impl Stripes {
    /// A block of zeros; `measured` if distortions will be asked for.
    pub(super) fn new(width: usize, height: usize, measured: bool) -> Self {
        let n = (width + 2) * (height.div_ceil(4) + 2) * 4;
        Self { width, height, values: vec![0; n], exact: vec![0.0; if measured { n } else { 0 }] }
    }

    fn index(&self, row: usize, column: usize) -> usize {
        ((row / 4 + 1) * (self.width + 2) + column + 1) * 4 + row % 4
    }

    /// Sets a coefficient: its quantised magnitude, and the exact one in steps.
    #[inline]
    pub(super) fn set(&mut self, row: usize, column: usize, negative: bool, magnitude: u32, exact: f32) {
        let i = self.index(row, column);
        self.values[i] = magnitude | if negative { SIGN } else { 0 };
        if let Some(e) = self.exact.get_mut(i) {
            *e = exact;
        }
    }
}

/// One coding pass of a code-block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pass {
    /// Bytes of the codeword that decode this pass and all before it.
    pub(super) length: usize,
    /// The bit-plane, 0 for the lowest.
    pub(super) plane: u32,
    /// By how much this pass lowers the sum of squared errors, in steps squared.
    pub(super) gain: f64,
}

/// A code-block after coding.
#[derive(Debug, Default)]
pub(super) struct CodedBlock {
    /// Bit-planes with passes.
    pub(super) planes: u32,
    pub(super) passes: Vec<Pass>,
    /// The codeword of all passes.
    pub(super) bytes: Vec<u8>,
    /// The sum of squared errors of a block that is not sent at all, in steps squared.
    pub(super) energy: f64,
}

/// How a code-block is coded.
#[derive(Clone, Copy)]
pub(super) struct BlockStyle {
    pub(super) orientation: Orientation,
    /// Whether the lowest plane of all gives the coefficient exactly.
    pub(super) reversible: bool,
    /// Magnitudes of at least 2^`shift` are those of a region of interest (Annex H); 0 without one.
    pub(super) shift: u32,
}

/// Codes one code-block.
pub(super) fn encode(stripes: &Stripes, style: BlockStyle) -> CodedBlock {
    let highest = stripes.values.iter().fold(0, |all, v| all | v) & !SIGN;
    let energy = stripes.exact.iter().map(|&e| f64::from(e) * f64::from(e)).sum();
    if highest == 0 {
        return CodedBlock { energy, ..CodedBlock::default() };
    }
    let planes = u32::BITS - highest.leading_zeros();
    let mut coder = BlockCoder::new(stripes, style);
    let mut ends: Vec<(UpperEnd, u32, f64)> = Vec::with_capacity(3 * planes as usize);
    let measured = !stripes.exact.is_empty();
    for plane in (0..planes).rev() {
        let first = if plane + 1 == planes { 2 } else { 0 };
        for pass in first..3 {
            coder.gain = 0.0;
            match (pass, measured) {
                (0, false) => coder.significance_propagation::<false>(plane),
                (0, true) => coder.significance_propagation::<true>(plane),
                (1, false) => coder.magnitude_refinement::<false>(plane),
                (1, true) => coder.magnitude_refinement::<true>(plane),
                (_, false) => coder.cleanup::<false>(plane),
                (_, true) => coder.cleanup::<true>(plane),
            }
            ends.push((coder.mq.upper_end(), plane, coder.gain));
        }
    }
    let codeword = coder.mq.finish();
    let passes: Vec<Pass> =
        ends.iter().map(|&(end, plane, gain)| Pass { length: codeword.length(&end), plane, gain }).collect();
    let length = passes[passes.len() - 1].length;
    CodedBlock { planes, passes, bytes: codeword.into_bytes(length), energy }
}

/// What is known of a column of a stripe, in one word.
///
/// Bits 0 to 17: which coefficients are significant, three columns (left, this, right) by six rows (the row above the
/// stripe, its four rows, the row below). So `word >> 3·i & NEIGHBOURHOOD` is the 3 × 3 around coefficient `i`.
type Column = u32;
const NEIGHBOURHOOD: u32 = 0x1ff;
/// The coefficient itself, in its 3 × 3.
const CENTRE: u32 = 1 << 4;
/// Any of the eighteen.
const ANY: Column = 0x3_ffff;
/// The four coefficients of the column.
const OWN: Column = 0x1249 << 4;
/// Bit 18 + i: coefficient i was coded in the significance propagation pass of this plane.
const VISITED: u32 = 18;
const ALL_VISITED: Column = 0xf << VISITED;
/// Bit 22 + i: coefficient i was refined before.
const REFINED: u32 = 22;

struct BlockCoder<'a> {
    stripes: &'a Stripes,
    /// One word a column, with a border all round, as the values.
    columns: Vec<Column>,
    contexts: &'static [u8; 512],
    style: BlockStyle,
    mq: MqEncoder,
    gain: f64,
}

impl<'a> BlockCoder<'a> {
    fn new(stripes: &'a Stripes, style: BlockStyle) -> Self {
        Self {
            stripes,
            columns: vec![0; stripes.values.len() / 4],
            contexts: &ZERO_CODING[style.orientation as usize],
            style,
            mq: MqEncoder::new(&INITIAL, stripes.width * stripes.height),
            gain: 0.0,
        }
    }

    /// Runs over the columns in scan order: the column's index, and how many of its rows lie in the block.
    #[inline(always)]
    fn scan(&mut self, mut visit: impl FnMut(&mut Self, usize, u32)) {
        let (width, height) = (self.stripes.width, self.stripes.height);
        for stripe in 0..height.div_ceil(4) {
            let rows = (height - 4 * stripe).min(4) as u32;
            let first = (stripe + 1) * (width + 2) + 1;
            for column in first..first + width {
                visit(self, column, rows);
            }
        }
    }

    /// D.3.1.
    fn significance_propagation<const MEASURED: bool>(&mut self, plane: u32) {
        self.scan(|this, column, rows| {
            if this.columns[column] & ANY == 0 {
                return;
            }
            for i in 0..rows {
                let near = this.columns[column] >> (3 * i) & NEIGHBOURHOOD;
                if near != 0 && near & CENTRE == 0 {
                    this.zero_coding::<MEASURED>(column, i, near, plane);
                    this.columns[column] |= 1 << (VISITED + i);
                }
            }
        });
    }

    /// D.3.3.
    fn magnitude_refinement<const MEASURED: bool>(&mut self, plane: u32) {
        self.scan(|this, column, rows| {
            let word = this.columns[column];
            if word & OWN == 0 {
                return;
            }
            let mut refined = 0;
            for i in 0..rows {
                let near = word >> (3 * i) & NEIGHBOURHOOD;
                if near & CENTRE == 0 || word >> (VISITED + i) & 1 != 0 {
                    continue;
                }
                // Table D.4.
                let context = if word >> (REFINED + i) & 1 != 0 {
                    16
                } else if near & !CENTRE != 0 {
                    15
                } else {
                    14
                };
                let at = 4 * column + i as usize;
                this.mq.encode(this.stripes.values[at] >> plane & 1, context);
                refined |= 1 << (REFINED + i);
                if MEASURED {
                    this.gain += this.refinement_gain(at, plane);
                }
            }
            this.columns[column] |= refined;
        });
    }

    /// D.3.4.
    fn cleanup<const MEASURED: bool>(&mut self, plane: u32) {
        self.scan(|this, column, rows| {
            let word = this.columns[column];
            let mut i = 0;
            if rows == 4 && word & (ANY | ALL_VISITED) == 0 {
                // Four zeros without a neighbour: whether all stay so, and else which is the first that does not.
                let values = &this.stripes.values[4 * column..][..4];
                match values.iter().position(|v| v >> plane & 1 != 0) {
                    None => return this.mq.encode(0, RUN_LENGTH),
                    Some(first) => {
                        i = first as u32;
                        this.mq.encode(1, RUN_LENGTH);
                        this.mq.encode(i >> 1, UNIFORM);
                        this.mq.encode(i & 1, UNIFORM);
                        this.becomes_significant::<MEASURED>(column, i, plane);
                        i += 1;
                    }
                }
            }
            while i < rows {
                let word = this.columns[column];
                let near = word >> (3 * i) & NEIGHBOURHOOD;
                if near & CENTRE == 0 && word >> (VISITED + i) & 1 == 0 {
                    this.zero_coding::<MEASURED>(column, i, near, plane);
                }
                i += 1;
            }
            this.columns[column] &= !ALL_VISITED;
        });
    }

    /// D.3.1: whether a coefficient becomes significant.
    #[inline(always)]
    fn zero_coding<const MEASURED: bool>(&mut self, column: usize, i: u32, near: u32, plane: u32) {
        let bit = self.stripes.values[4 * column + i as usize] >> plane & 1;
        self.mq.encode(bit, self.contexts[near as usize % 512]);
        if bit == 1 {
            self.becomes_significant::<MEASURED>(column, i, plane);
        }
    }

    /// D.3.2: the sign, and then the news to all neighbours.
    #[inline(always)]
    fn becomes_significant<const MEASURED: bool>(&mut self, column: usize, i: u32, plane: u32) {
        let across = self.stripes.width + 2;
        let values = &self.stripes.values;
        let at = 4 * column + i as usize;
        let near = self.columns[column] >> (3 * i) & NEIGHBOURHOOD;
        // The neighbours above, left, right and below: significant, and negative.
        let above = if i == 0 { 4 * (column - across) + 3 } else { at - 1 };
        let below = if i == 3 { 4 * (column + across) } else { at + 1 };
        let known = near >> 1 & 1 | near >> 2 & 2 | near >> 3 & 4 | near >> 4 & 8;
        let negative = values[above] >> 31 | values[at - 4] >> 31 << 1 | values[at + 4] >> 31 << 2 | values[below] >> 31 << 3;
        let (context, flip) = SIGN_CODING[(known | (negative & known) << 4) as usize % 256];
        self.mq.encode(values[at] >> 31 ^ u32::from(flip), context);

        let row = 3 * (i + 1);
        self.columns[column - 1] |= 1 << (row + 2);
        self.columns[column] |= 1 << (row + 1);
        self.columns[column + 1] |= 1 << row;
        if i == 0 {
            let above = column - across;
            self.columns[above - 1] |= 1 << 17;
            self.columns[above] |= 1 << 16;
            self.columns[above + 1] |= 1 << 15;
        } else if i == 3 {
            let below = column + across;
            self.columns[below - 1] |= 1 << 2;
            self.columns[below] |= 1 << 1;
            self.columns[below + 1] |= 1;
        }
        if MEASURED {
            self.gain += self.significance_gain(at, plane);
        }
    }

    /// The magnitude of a coefficient and the plane in which its bits are coded, without the shift of a region of
    /// interest; none where the plane is below the bits of a shifted coefficient.
    #[inline(always)]
    fn unshifted(&self, at: usize, plane: u32) -> Option<(u32, u32)> {
        let (magnitude, shift) = (self.stripes.values[at] & !SIGN, self.style.shift);
        if magnitude >> shift == 0 { Some((magnitude, plane)) } else { Some((magnitude >> shift, plane.checked_sub(shift)?)) }
    }

    /// What the decoder takes for a magnitude known down to a plane (Equations E-6 and E-8): the middle.
    #[inline(always)]
    fn reconstruction(&self, magnitude: u32, plane: u32) -> f64 {
        let known = f64::from(magnitude >> plane << plane);
        if plane == 0 && self.style.reversible { known } else { known + 0.5 * f64::from(1u32 << plane) }
    }

    #[inline(always)]
    fn significance_gain(&self, at: usize, plane: u32) -> f64 {
        let Some((magnitude, plane)) = self.unshifted(at, plane) else { return 0.0 };
        let exact = f64::from(self.stripes.exact[at]);
        let error = exact - self.reconstruction(magnitude, plane);
        exact * exact - error * error
    }

    #[inline(always)]
    fn refinement_gain(&self, at: usize, plane: u32) -> f64 {
        let Some((magnitude, plane)) = self.unshifted(at, plane) else { return 0.0 };
        let exact = f64::from(self.stripes.exact[at]);
        let before = exact - self.reconstruction(magnitude, plane + 1);
        let after = exact - self.reconstruction(magnitude, plane);
        before * before - after * after
    }
}

/// Table D.1 over the 3 × 3 of [`NEIGHBOURHOOD`], for each [`Orientation`].
static ZERO_CODING: [[u8; 512]; 4] = {
    let mut tables = [[0; 512]; 4];
    let mut orientation = 0;
    while orientation < 4 {
        let mut near = 0;
        while near < 512 {
            tables[orientation][near] = zero_coding_context(orientation, near as u32);
            near += 1;
        }
        orientation += 1;
    }
    tables
};

const fn zero_coding_context(orientation: usize, near: u32) -> u8 {
    let beside = (near >> 3 & 1) + (near >> 5 & 1);
    let over = (near >> 1 & 1) + (near >> 7 & 1);
    let diagonal = (near & 1) + (near >> 2 & 1) + (near >> 6 & 1) + (near >> 8 & 1);
    if orientation == Orientation::HH as usize {
        let straight = beside + over;
        return match (straight, diagonal) {
            (_, 3..) => 8,
            (1.., 2) => 7,
            (0, 2) => 6,
            (2.., 1) => 5,
            (1, 1) => 4,
            (0, 1) => 3,
            (2.., 0) => 2,
            (1, 0) => 1,
            (0, 0) => 0,
        };
    }
    // Along the structures that the band shows: down the columns where the rows were high-passed.
    let (along, across) = if orientation == Orientation::HL as usize { (over, beside) } else { (beside, over) };
    match (along, across, diagonal) {
        (2.., _, _) => 8,
        (1, 1.., _) => 7,
        (1, 0, 1..) => 6,
        (1, 0, 0) => 5,
        (0, 2.., _) => 4,
        (0, 1, _) => 3,
        (0, 0, 2..) => 2,
        (0, 0, 1) => 1,
        (0, 0, 0) => 0,
    }
}

/// Tables D.2 and D.3: context and sign flip, by which of the four neighbours (above, left, right, below) are
/// significant (bits 0 to 3) and negative (bits 4 to 7).
static SIGN_CODING: [(u8, u8); 256] = {
    let mut table = [(0, 0); 256];
    let mut i = 0;
    while i < 256 {
        let horizontal = contribution(sign_of(i, 1) + sign_of(i, 2));
        let vertical = contribution(sign_of(i, 0) + sign_of(i, 3));
        table[i] = match (horizontal, vertical) {
            (1, 1) => (13, 0),
            (1, 0) => (12, 0),
            (1, _) => (11, 0),
            (0, 1) => (10, 0),
            (0, 0) => (9, 0),
            (0, _) => (10, 1),
            (_, 1) => (11, 1),
            (_, 0) => (12, 1),
            (_, _) => (13, 1),
        };
        i += 1;
    }
    table
};

const fn sign_of(known: usize, neighbour: usize) -> i32 {
    if known >> neighbour & 1 == 0 {
        0
    } else if known >> (neighbour + 4) & 1 == 0 {
        1
    } else {
        -1
    }
}

const fn contribution(sum: i32) -> i32 {
    if sum > 1 {
        1
    } else if sum < -1 {
        -1
    } else {
        sum
    }
}
