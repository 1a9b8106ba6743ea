//! Indices to decisions: which chance each has, learned from the indices around it (spec/wavelet.md, "Contexts").
//!
//! Levels go from coarse to fine, places row by row, components one after the other: normal, then tangents. What is around a place
//! says which size to expect, and a trained table what an index of that size does; contexts learn the rest. Writing and reading are
//! the same code.

use super::quantise::{Band, MAX_INDEX};
use super::trained::{AROUND, EXPECTATIONS, NODES, ODDS, WEIGHTS};
use crate::entropy::{AdaptiveBit, BitCoder, Mixer, MixerOptions, Start};

/// Contexts of a size.
const N: usize = 9;

/// Indices at all levels, each at the place of its sample in the finest image that is wanted.
pub(super) struct Field {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) indices: Vec<[i32; 3]>,
    /// The longest side of the box in steps of the level that is being coded.
    pub(super) reach: u32,
}

impl Field {
    /// The size of an index, 0 outside the image, and at most what contexts can tell apart.
    #[inline]
    fn size(&self, row: isize, column: isize, component: usize) -> i32 {
        if row < 0 || column < 0 || row >= self.height as isize || column >= self.width as isize {
            return 0;
        }
        let index = self.indices[row as usize * self.width + column as usize][component];
        (index.unsigned_abs() as i32).min(1 << 16)
    }
}

/// A place in the field.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) row: usize,
    pub(super) column: usize,
    /// The distance of samples of this level in the field.
    pub(super) stride: usize,
    pub(super) band: Band,
    /// Levels coarser than this one that are coded before it.
    pub(super) age: usize,
}

/// What has been learned of indices.
#[derive(Clone)]
pub(super) struct Contexts {
    sizes: Mixer<N, 1>,
    /// What an index of the expected size would do.
    odds: [i16; NODES],
    mantissas: [[AdaptiveBit; 32]; 2],
}

/// Nodes of a size: larger than 0, 1, 2; then the bits of what is left.
const SMALL: u32 = 3;
const LAST_NODE: usize = NODES - 1;
/// Ages that are told apart.
const AGES: usize = 6;

/// Bins of activities in 16ths: on each bound begins the next.
static BOUNDS: [i32; 17] = [3, 8, 16, 26, 38, 56, 80, 120, 192, 320, 640, 1280, 2560, 5120, 10240, 40960, 163_840];

fn bin(activity: i32) -> u32 {
    BOUNDS.iter().take_while(|&&bound| activity >= bound).count() as u32
}

/// The expected size, in half octaves from 2⁻⁹ on.
fn expectation(around: [i32; AROUND], weights: &[u32; AROUND]) -> u32 {
    let sum: u64 = around.iter().zip(weights).map(|(&size, &weight)| size as u64 * u64::from(weight)).sum();
    match sum.checked_ilog2() {
        None => 0,
        Some(octave) => {
            // Whether it is √2 or more above the power of two.
            let upper = u128::from(sum) * u128::from(sum) >= 2 << (2 * octave);
            (2 * octave + u32::from(upper)).saturating_sub(6).min(EXPECTATIONS as u32 - 1)
        }
    }
}

/// The bits of a decision whose chance to be true is `p` 65536ths.
#[cfg(feature = "encode")]
pub(super) fn price(decision: bool, p: u32) -> f64 {
    let p = if decision { p } else { (1 << 16) - p };
    16.0 - f64::from(p).log2()
}

impl Default for Contexts {
    fn default() -> Self {
        let options = MixerOptions { lines_log2: 12, rate_shift: 6, count_limit: 255 };
        let starts = [Start { contexts: [6; N], experts: [80], bias: 0 }; 2 * AGES];
        Self { sizes: Mixer::new(options, &starts), odds: [0; NODES], mantissas: [[AdaptiveBit::default(); 32]; 2] }
    }
}

impl Contexts {
    /// Codes the three indices at a place.
    pub(super) fn code<C: BitCoder>(&mut self, coder: &mut C, field: &mut Field, place: Place) {
        for component in 0..3 {
            self.choose(field, place, component);
            let at = place.row * field.width + place.column;
            let index = field.indices[at][component];
            let size = self.size(coder, index.unsigned_abs(), usize::from(component > 0));
            let negative = size > 0 && coder.code(index < 0, 1 << 15);
            field.indices[at][component] = if negative { -(size as i32) } else { size as i32 };
        }
    }

    /// Chooses the three indices at a place by what each size would cost there in bits, and learns from them.
    #[cfg(feature = "encode")]
    pub(super) fn decide<C: BitCoder>(
        &mut self,
        coder: &mut C,
        field: &mut Field,
        place: Place,
        index: impl Fn(usize, &dyn Fn(u32) -> f64) -> i32,
    ) -> [i32; 3] {
        let at = place.row * field.width + place.column;
        for component in 0..3 {
            self.choose(field, place, component);
            let tangent = usize::from(component > 0);
            let index = index(component, &|size| self.bits(size, tangent));
            field.indices[at][component] = index;
            if self.size(coder, index.unsigned_abs(), tangent) > 0 {
                coder.code(index < 0, 1 << 15);
            }
        }
        field.indices[at]
    }

    /// What a size and its sign would cost.
    #[cfg(feature = "encode")]
    fn bits(&self, size: u32, tangent: usize) -> f64 {
        let chance = |node: usize| self.sizes.chance(node, [self.odds[node].into()]);
        let mut sum = if size > 0 { 1.0 } else { 0.0 };
        for small in 0..SMALL {
            let more = size > small;
            sum += price(more, chance(small as usize));
            if !more {
                return sum;
            }
        }
        let left = size.saturating_sub(SMALL) + 1;
        let length = 31 - left.leading_zeros();
        for bits in 0..=length {
            sum += price(bits < length, chance((SMALL + bits).min(LAST_NODE as u32) as usize));
        }
        let first = length
            .checked_sub(1)
            .map_or(0.0, |bit| price(left >> bit & 1 != 0, self.mantissas[tangent][length as usize].p()) + f64::from(bit));
        sum + first
    }

    fn choose(&mut self, field: &Field, place: Place, component: usize) {
        let (row, column) = (place.row as isize, place.column as isize);
        let half = place.stride as isize;
        let stride = 2 * half;
        let at = |dr: isize, dc: isize| field.size(row + dr, column + dc, component);
        let (west, north) = (at(0, -stride), at(-stride, 0));
        let (north_west, north_east) = (at(-stride, -stride), at(-stride, stride));
        let (mut parent, mut around_parent) = (0, 0);
        if place.age > 0 {
            // The coarse sample before this place, and from there to the detail of the same band a level up.
            let double = 2 * stride;
            let (odd_row, odd_column) = match place.band {
                Band::Column => (0, stride),
                Band::Row => (stride, 0),
                Band::Both => (stride, stride),
            };
            let (r, c) = (row / double * double + odd_row, column / double * double + odd_column);
            parent = field.size(r, c, component);
            around_parent = field.size(r, c - double, component)
                + field.size(r, c + double, component)
                + field.size(r - double, c, component)
                + field.size(r + double, c, component);
        }
        let other = match place.band {
            Band::Column => at(-half, -half) + at(-half, half) + at(-half, 0),
            Band::Row => at(-half, -half) + at(-half, half) + at(0, -half),
            Band::Both => at(0, -half) + at(-half, 0),
        };
        let first = if component > 0 { field.size(row, column, 0) } else { 0 };
        let second = if component > 1 { field.size(row, column, 1) } else { 0 };
        let beside = if component > 0 { field.size(row, column - stride, 0) + field.size(row - stride, column, 0) } else { 0 };

        let tangent = u32::from(component > 0);
        let far = at(0, -2 * stride) + at(-2 * stride, 0);
        let (beyond, reach) = (north_west + north_east, field.reach as i32);
        let around = [west + north, beyond, far, parent, around_parent, other, first, second, beside, reach, 1];
        let expected = expectation(around, &WEIGHTS[usize::from(component > 0)][place.age.min(4)]);
        self.odds = ODDS[usize::from(component > 0)][expected as usize];
        let (band, age) = (place.band as u32, place.age.min(AGES - 1) as u32);
        let base = 3 * tangent + band;
        let near = 32 * (west + north) + 16 * beyond + 11 * far;
        let of_near = bin(near / 2);
        let of_parent = bin(16 * parent + 4 * around_parent);
        let of_other = bin(16 * other);
        let of_first = bin(16 * first + 8 * second + 5 * beside);
        let of_all = bin((near + 32 * parent + 8 * around_parent + 19 * other + 24 * first + 16 * second) / 4);
        let pack = |parts: [u32; 3]| parts[0] << 16 | parts[1] << 8 | parts[2];
        let contexts = [
            pack([base, of_near, of_parent]),
            pack([base, of_near, of_other]),
            pack([base, of_first, of_near]),
            pack([base, age, of_all]),
            pack([tangent, bin(16 * west), bin(16 * north)]),
            pack([tangent, age, band]),
            pack([tangent, bin(16 * parent), of_other]),
            pack([base, expected, 0]),
            pack([tangent, age, expected]),
        ];
        self.sizes.choose(contexts, (tangent as usize) * AGES + age as usize);
    }

    /// A size: up to [`SMALL`] step by step, what is beyond by its number of bits.
    fn size<C: BitCoder>(&mut self, coder: &mut C, size: u32, tangent: usize) -> u32 {
        for small in 0..SMALL {
            if !self.sizes.code(coder, size > small, small as usize, [self.odds[small as usize].into()]) {
                return small;
            }
        }
        // What is left, plus one: its length in bits, then the bits below the highest.
        let left = size.saturating_sub(SMALL) + 1;
        let length = 31 - left.leading_zeros();
        let mut bits = 0;
        while bits < MAX_INDEX.ilog2() {
            let node = (SMALL as usize + bits as usize).min(LAST_NODE);
            if !self.sizes.code(coder, length > bits, node, [self.odds[node].into()]) {
                break;
            }
            bits += 1;
        }
        let mut value = 1_u32;
        for bit in (0..bits).rev() {
            let set = left >> bit & 1 != 0;
            let is_first = bit + 1 == bits;
            let set = if is_first { self.mantissas[tangent][bits as usize].code(coder, set) } else { coder.code(set, 1 << 15) };
            value = value << 1 | u32::from(set);
        }
        (value - 1 + SMALL).min(MAX_INDEX as u32)
    }
}
