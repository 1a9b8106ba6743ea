//! Which index a coefficient gets: not the nearest, but the one whose error and bits together cost least (rate–distortion
//! optimised quantisation; an encoder's affair, any indices decode).
//!
//! What an index costs in bits is asked of the very contexts that will code it, in the order in which they will: places are
//! decided one after the other, and each decision teaches the contexts. Contexts see what was decided before and not what
//! comes after; an index whose neighbours on all sides are small makes theirs dearer too, so that its bits count a little more.

use super::Layout;
use super::contexts::{Contexts, Field, Place, price};
use super::lifting::Grid;
use super::quantise::{Band, MAX_INDEX, value};
use crate::entropy::BitCoder;
use crate::plane::Gluing;

/// The square of a step that a bit is worth, along the normal and the tangents. Theory says 0.115 of all errors that are of
/// equal weight; but where a surface has lost its details, the errors of neighbours add up, which those of rounding do not.
const A_BIT: [f64; 3] = [0.06, 0.03, 0.03];
/// By this share more if nothing is around.
const ALONE: f64 = 0.4;
/// As much around, in steps, and the bits count as they are.
const COMPANY: f64 = 4.0;
/// And by no more than this share less.
const LEAST: f64 = 0.5;

/// Counts the bits of decisions instead of writing them.
#[derive(Default)]
struct Counter {
    bits: f64,
}

impl BitCoder for Counter {
    const WRITES: bool = true;

    fn code(&mut self, decision: bool, p: u32) -> bool {
        self.bits += price(decision, p);
        decision
    }

    fn is_exhausted(&self) -> bool {
        false
    }
}

/// Decides level after level, the coarsest first.
pub(super) struct Decider {
    layout: Layout,
    /// About where the image lies.
    bounds: [[f64; 3]; 2],
    field: Field,
    contexts: Contexts,
}

impl Decider {
    pub(super) fn new(layout: Layout, bounds: [[f64; 3]; 2]) -> Self {
        let (width, height) = (layout.shape.width(), layout.shape.height());
        let field = Field { width, height, indices: vec![[0; 3]; width * height], reach: 0 };
        Self { layout, bounds, field, contexts: Contexts::default() }
    }

    /// Indices of the details of a level, given in steps; 0 for coarse samples, and for those that are glued to others. `None`
    /// if one is too large.
    pub(super) fn indices(&mut self, shares: &Grid, level: u8) -> Option<Vec<[i32; 3]>> {
        let width = shares.shape.width();
        let mut made = vec![[0; 3]; shares.points.len()];
        let band = |at: usize| Band::of(at / width, at % width);
        let details = (0..made.len()).filter(|&at| band(at).is_some()).flat_map(|at| shares.points[at]);
        let largest = details.fold(0.0_f64, |most, share| if share.is_nan() { share } else { most.max(share.abs()) });
        if !(largest <= f64::from(MAX_INDEX)) {
            return None;
        }
        if largest < 0.5 {
            return Some(made);
        }
        let (before, mut counter, mut saved) = (self.contexts.clone(), Counter::default(), 0.0);
        self.field.reach = self.layout.reach(self.bounds, level);
        let age = usize::from(self.layout.levels - 1 - level);
        let stride = 1_usize << level;
        for at in 0..made.len() {
            let (row, column) = (at / width, at % width);
            let Some(band) = band(at).filter(|_| stands_alone(shares, row, column)) else { continue };
            let place = Place { row: row * stride, column: column * stride, stride, band, age };
            made[at] = self.contexts.decide(&mut counter, &mut self.field, place, |component, bits| {
                let share = shares.points[at][component];
                let nearest = (share.abs() + 0.5).floor();
                if nearest == 0.0 {
                    return 0;
                }
                let alone = (1.0 - around(shares, row, column, component) / COMPANY).max(-LEAST / ALONE);
                let a_bit = A_BIT[component] * (1.0 + ALONE * alone);
                let size = cheapest(share.abs(), nearest as i32, |size| a_bit * bits(size));
                if share < 0.0 { -size } else { size }
            });
            let without = |i: usize| shares.points[at][i].powi(2) - (shares.points[at][i] - value(made[at][i], 1.0)).powi(2);
            saved += (0..3).map(without).sum::<f64>();
        }
        // Whether the level as a whole is worth its bits.
        if saved < A_BIT[0] * counter.bits {
            self.contexts = before;
            for at in (0..made.len()).filter(|&at| band(at).is_some()) {
                made[at] = [0; 3];
                self.field.indices[(at / width * stride) * self.field.width + at % width * stride] = [0; 3];
            }
        }
        Some(made)
    }
}

/// The size for a share that is nearest to `nearest`: that, one less, or none.
fn cheapest(share: f64, nearest: i32, price: impl Fn(u32) -> f64) -> i32 {
    let cost = |size: i32| (share - value(size, 1.0)).powi(2) + price(size as u32);
    let mut best = (nearest, cost(nearest));
    for size in [nearest - 1, 0] {
        // No chance is so small that its bits outweigh more than two steps.
        if size < best.0 && nearest - size <= 2 {
            let cost = cost(size);
            if cost < best.1 {
                best = (size, cost);
            }
        }
    }
    best.0
}

/// How large the eight neighbours of the same band are, in steps, each 3 at most.
fn around(shares: &Grid, row: usize, column: usize, component: usize) -> f64 {
    const AROUND: [(isize, isize); 8] = [(-2, -2), (-2, 0), (-2, 2), (0, -2), (0, 2), (2, -2), (2, 0), (2, 2)];
    let size = |(dr, dc): (isize, isize)| {
        let (Some(r), Some(c)) = (row.checked_add_signed(dr), column.checked_add_signed(dc)) else { return 0.0 };
        if r >= shares.shape.height() || c >= shares.shape.width() {
            return 0.0;
        }
        (shares.points[r * shares.shape.width() + c][component].abs() + 0.5).floor().min(3.0)
    };
    AROUND.into_iter().map(size).sum()
}

/// Whether a sample is one that others are glued to, or glued to none.
#[inline]
fn stands_alone(shares: &Grid, row: usize, column: usize) -> bool {
    shares.gluing == Gluing::Open || shares.gluing.representative(shares.shape, row, column) == (row, column)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_costs_no_bits_goes_to_the_nearest_and_what_costs_too_many_goes_down() {
        assert_eq!(cheapest(1.6, 2, |_| 0.0), 2);
        assert_eq!(cheapest(1.6, 2, |size| 0.5 * f64::from(size)), 1);
        assert_eq!(cheapest(1.6, 2, |size| if size > 0 { 4.0 } else { 0.0 }), 0);
        // Never further than two steps.
        assert_eq!(cheapest(7.0, 7, |size| 100.0 * f64::from(size)), 6);
    }

    #[test]
    fn a_counter_counts_what_chances_are_worth() {
        let mut counter = Counter::default();
        for (decision, p) in [(true, 1 << 15), (false, 1 << 15), (true, 1 << 12), (false, 3 << 14)] {
            assert_eq!(counter.code(decision, p), decision);
        }
        assert!((counter.bits - (1.0 + 1.0 + 4.0 + 2.0)).abs() < 1e-12);
    }
}
