//! A certified bound of the directed Hausdorff distance, by branch and bound over triangles.
//!
//! The distance to one fixed triangle is a convex function, so over a piece of surface it is greatest
//! at a corner of the piece; and the distance to a whole surface is at most that to any of its
//! triangles, and changes no faster than one moves. Each piece gets the least of these bounds.
//! Pieces whose bound is not above the greatest distance seen (by more than a small share of it) are done.
//! The others are cut along the sides of the prism over the triangle closest to their middle: what lies
//! inside is then bounded by that triangle, which ends at once where surfaces are parallel or coincide.
//! Where no side crosses (and now and then in any case) a piece is halved across its longest edge, so that
//! pieces shrink; needles as fast as equilateral triangles. Bounds hold up to the rounding of f64, about 1e-15 of the larger box.
//!
//! M. Guthe, P. Borodin, R. Klein, *Fast and accurate Hausdorff distance calculation between meshes*
//! (2005) bound pieces in the same way; they keep a voxel grid where we keep a tree.

use glam::DVec3;

use super::directed::{ROUNDING, Surface, measured};
use crate::error::{Error, Result};
use crate::geom::{Triangle, distance2};
use crate::par;
use crate::task::Task;

/// The promise of `measures.md`: bound − value ≤ 1e-3 of the value …
const PROMISED: f64 = 1e-3;

/// … and what is aimed at as long as it costs little. Most surfaces touch their greatest distance at a
/// few points, and these few are soon bounded; surfaces at an even distance from each other touch it everywhere.
const AIMED: f64 = 1e-5;

/// Searches in the tree that may go into the aim: so many for each triangle …
const AIM_A_TRIANGLE: usize = 8;

/// … and so many more.
const AIM_MORE: usize = 500_000;

/// Pieces handled side by side before the greatest distance seen is brought up to date.
const ROUND: usize = 1 << 14;

/// Searches in the tree after which the bound is given as it stands: so many for each triangle …
const SEARCHES_A_TRIANGLE: usize = 64;

/// … and so many more.
const SEARCHES_MORE: usize = 20_000_000;

/// What is known of a greatest distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    /// Some point is this far away.
    pub(crate) lower: f64,
    /// No point is farther than this.
    pub(crate) upper: f64,
    /// Searches in the tree that it took.
    pub(crate) searches: usize,
}

/// Cuts in a row after which a piece is halved.
const CUTS: u8 = 3;

/// A cut must leave this share of the piece's length on both sides.
const SLIVER: f64 = 1e-7;

/// A triangle of the source or a part of one, with what is closest to its corners.
#[derive(Debug, Clone, Copy)]
struct Piece {
    corners: Triangle,
    distances: [f64; 3],
    nearest: [u32; 3],
    /// What is closest to the middle, once that was asked.
    over: u32,
    /// Which corners are still to be measured.
    new: [bool; 3],
    /// Cuts since the last halving.
    cuts: u8,
    bound: f64,
}

/// Bounds the greatest distance of a point of `from` to the surface `to`. Neither may be empty.
///
/// `seen` is a distance that is known to occur (in either direction, if both are wanted): pieces below it need no work.
///
/// # Errors
/// Only if the task is over.
pub(crate) fn certify(from: &Surface, to: &Surface, seen: f64, task: &Task<'_>) -> Result<Bounds> {
    let allowed = from.triangles().len().saturating_mul(SEARCHES_A_TRIANGLE).saturating_add(SEARCHES_MORE);
    let triangles = from.triangles();
    let aim = triangles.len().saturating_mul(AIM_A_TRIANGLE).saturating_add(AIM_MORE);
    let mut state = State { open: Vec::new(), lower: seen, upper: 0.0, searches: 0, aim };
    for start in (0..triangles.len()).step_by(ROUND) {
        let round = &triangles[start..triangles.len().min(start + ROUND)];
        state.advance(round.iter().map(|&t| Piece::whole(t)).collect(), to, task)?;
    }
    while !state.open.is_empty() && state.searches < allowed {
        // The last pieces first: they are the smallest, so that few wait at a time.
        let round = state.open.split_off(state.open.len().saturating_sub(ROUND));
        let mut parts = Vec::with_capacity(2 * round.len());
        for piece in round {
            if !state.finish(&piece) && !piece.cut(to, &mut parts) {
                parts.extend(piece.halves());
            }
        }
        state.advance(parts, to, task)?;
    }
    let left = state.open.iter().fold(0.0, |u: f64, p| u.max(p.bound));
    Ok(Bounds { lower: state.lower, upper: state.upper.max(left).max(state.lower), searches: state.searches })
}

struct State {
    open: Vec<Piece>,
    /// The greatest distance seen.
    lower: f64,
    /// The greatest bound of a piece that is done.
    upper: f64,
    searches: usize,
    /// Searches up to which [`AIMED`] is wanted and not only [`PROMISED`].
    aim: usize,
}

impl State {
    /// The bound up to which a piece is done.
    fn enough(&self) -> f64 {
        let gap = if self.searches < self.aim { AIMED } else { PROMISED };
        (self.lower * (1.0 + gap)).max(ROUNDING)
    }

    /// Whether nothing more needs to be known of a piece; its bound is then taken note of.
    fn finish(&mut self, piece: &Piece) -> bool {
        let done = piece.bound <= self.enough();
        if done {
            self.upper = self.upper.max(piece.bound);
        }
        done
    }

    /// Measures and bounds pieces; those that are not done stay open.
    fn advance(&mut self, pieces: Vec<Piece>, to: &Surface, task: &Task<'_>) -> Result<()> {
        const CHUNK: usize = 256;
        if task.is_over() {
            return Err(Error::Cancelled);
        }
        let enough = self.enough();
        let parts = par::map(pieces.len().div_ceil(CHUNK), |chunk| {
            let mut pieces = pieces[chunk * CHUNK..pieces.len().min((chunk + 1) * CHUNK)].to_vec();
            let (mut seen, mut searches, mut hint) = (0.0_f64, 0, 0);
            for piece in &mut pieces {
                searches += piece.measure(to, &mut hint);
                piece.bound_by_corners(to);
                if piece.bound > enough {
                    seen = seen.max(piece.bound_by_middle(to));
                    searches += 1;
                }
                seen = piece.distances.into_iter().fold(seen, f64::max);
            }
            (pieces, seen, searches)
        });
        for (_, seen, searches) in &parts {
            self.lower = self.lower.max(*seen);
            self.searches += searches;
        }
        for piece in parts.into_iter().flat_map(|p| p.0) {
            if !self.finish(&piece) {
                self.open.push(piece);
            }
        }
        Ok(())
    }
}

impl Piece {
    const UNKNOWN: u32 = u32::MAX;

    /// A whole triangle, of which nothing is known yet.
    fn whole(corners: Triangle) -> Self {
        Self {
            corners,
            distances: [0.0; 3],
            nearest: [Self::UNKNOWN; 3],
            over: Self::UNKNOWN,
            new: [true; 3],
            cuts: 0,
            bound: f64::INFINITY,
        }
    }

    /// The part between three points; `new` ones are to be measured, the others are corners `old` of this piece.
    fn part(&self, corners: [(DVec3, Option<usize>); 3], cuts: u8) -> Self {
        let known = corners.map(|(_, old)| old);
        Self {
            corners: corners.map(|(p, _)| p),
            distances: known.map(|old| old.map_or(0.0, |k| self.distances[k])),
            // What is over the middle is likely to be near a new corner.
            nearest: known.map(|old| old.map_or(self.over, |k| self.nearest[k])),
            over: self.over,
            new: known.map(|old| old.is_none()),
            cuts,
            bound: self.bound,
        }
    }

    /// The two halves across the longest edge.
    fn halves(&self) -> [Self; 2] {
        let length2 = |e: usize| self.corners[e].distance_squared(self.corners[(e + 1) % 3]);
        let e = (0..3).fold(0, |longest, e| if length2(e) > length2(longest) { e } else { longest });
        let (i, j, k) = (e, (e + 1) % 3, (e + 2) % 3);
        let middle = (self.corners[i] * 0.5 + self.corners[j] * 0.5, None);
        let [a, b, c] = [i, j, k].map(|x| (self.corners[x], Some(x)));
        [self.part([a, middle, c], 0), self.part([middle, b, c], 0)]
    }

    /// Cuts along the side of the prism over the triangle below that the piece sticks out of farthest. Whether it did.
    fn cut(&self, to: &Surface, parts: &mut Vec<Self>) -> bool {
        if self.cuts == CUTS || self.over == Self::UNKNOWN {
            return false;
        }
        let t = to.triangles()[self.over as usize];
        let n = (t[1] - t[0]).cross(t[2] - t[0]);
        let reach2 = self.corners.into_iter().map(|q| self.corners[0].distance_squared(q)).fold(0.0, f64::max);
        let least = SLIVER * reach2.sqrt();
        let mut best = None;
        for e in 0..3 {
            let inward = n.cross(t[(e + 1) % 3] - t[e]).normalize_or_zero();
            let heights = self.corners.map(|p| inward.dot(p - t[e]));
            let (low, high) = heights.into_iter().fold((0.0_f64, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
            if low < -least && high > least && best.is_none_or(|(lowest, _)| low < lowest) {
                best = Some((low, heights));
            }
        }
        let Some((_, heights)) = best else { return false };
        // The corner that is alone on its side; a corner on the plane itself counts as inside.
        let inside = heights.map(|h| h >= 0.0);
        let alone = (0..3).find(|&k| inside[k] != inside[(k + 1) % 3] && inside[k] != inside[(k + 2) % 3]).unwrap_or(0);
        let (i, j) = ((alone + 1) % 3, (alone + 2) % 3);
        let crossing = |k: usize| {
            let share = heights[alone] / (heights[alone] - heights[k]);
            (self.corners[alone] + (self.corners[k] - self.corners[alone]) * share, None)
        };
        let (p, q) = (crossing(i), crossing(j));
        let [a, b, c] = [alone, i, j].map(|k| (self.corners[k], Some(k)));
        let cuts = self.cuts + 1;
        parts.extend([self.part([a, p, q], cuts), self.part([p, b, c], cuts), self.part([p, c, q], cuts)]);
        true
    }

    /// Measures the corners that are new. How many there were.
    fn measure(&mut self, to: &Surface, hint: &mut u32) -> usize {
        let mut searches = 0;
        for k in 0..3 {
            if self.new[k] {
                let near = if self.nearest[k] == Self::UNKNOWN { *hint } else { self.nearest[k] };
                let hit = to.closest(self.corners[k], near);
                self.distances[k] = measured(hit);
                self.nearest[k] = hit.slot;
                self.new[k] = false;
                *hint = hit.slot;
                searches += 1;
            }
        }
        searches
    }

    /// The bound that one triangle of the other surface gives: the farthest corner from it.
    fn bound_by(&self, slot: u32, to: &Surface) -> f64 {
        let t = to.triangles()[slot as usize];
        self.corners.into_iter().map(|p| distance2(p, t)).fold(0.0, f64::max).sqrt()
    }

    fn bound_by_corners(&mut self, to: &Surface) {
        for k in 0..3 {
            let p = self.corners[k];
            let reach2 = self.corners.into_iter().map(|q| p.distance_squared(q)).fold(0.0, f64::max);
            self.bound = self.bound.min(self.distances[k] + reach2.sqrt());
            if !self.nearest[..k].contains(&self.nearest[k]) {
                self.bound = self.bound.min(self.bound_by(self.nearest[k], to));
            }
        }
    }

    /// Corners often lie between several triangles of the other surface; the middle rarely does. Returns its distance.
    fn bound_by_middle(&mut self, to: &Surface) -> f64 {
        let [a, b, c] = self.corners;
        let middle = (a + b + c) / 3.0;
        let hit = to.closest(middle, self.nearest[0]);
        let d = measured(hit);
        let reach2 = self.corners.into_iter().map(|q| middle.distance_squared(q)).fold(0.0, f64::max);
        let by = self.bound_by(hit.slot, to);
        self.over = hit.slot;
        self.bound = self.bound.min(d + reach2.sqrt()).min(by);
        d
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distance::{Frame, SampleOptions, sample};
    use crate::geom::Aabb;
    use proptest::prelude::*;

    type Soup = (Vec<[f64; 3]>, Vec<[u32; 3]>);

    fn surfaces(a: &Soup, b: &Soup) -> (Surface, Surface) {
        let aabb = |s: &Soup| Aabb::of(s.0.iter().map(|&p| DVec3::from(p)));
        let frame = Frame::around(aabb(a), aabb(b));
        (Surface::new(frame, &a.0, &a.1), Surface::new(frame, &b.0, &b.1))
    }

    /// A square of `n × n` cells at height `z(x, y)`.
    fn sheet(n: u32, z: impl Fn(f64, f64) -> f64) -> Soup {
        let at = |i: u32| f64::from(i) / f64::from(n);
        let positions = (0..(n + 1) * (n + 1)).map(|k| (at(k % (n + 1)), at(k / (n + 1)))).map(|(x, y)| [x, y, z(x, y)]);
        let cells = (0..n * n).map(|k| k % n + k / n * (n + 1));
        let triangles = cells.flat_map(|k| [[k, k + 1, k + n + 2], [k, k + n + 2, k + n + 1]]);
        (positions.collect(), triangles.collect())
    }

    #[test]
    fn a_surface_is_at_distance_zero_from_itself() {
        let soup = sheet(20, |x, y| (7.0 * x).sin() * (5.0 * y).cos());
        let (a, b) = surfaces(&soup, &soup);
        let bounds = certify(&a, &b, 0.0, &Task::default()).unwrap();
        assert_eq!((bounds.lower, bounds.upper), (0.0, 0.0));
    }

    #[test]
    fn the_same_plane_cut_otherwise_is_at_distance_zero_to_rounding() {
        let (a, b) = surfaces(&sheet(7, |_, _| 0.0), &sheet(5, |_, _| 0.0));
        let bounds = certify(&a, &b, 0.0, &Task::default()).unwrap();
        assert!(bounds.upper < 1e-14, "{bounds:?}");
    }

    #[test]
    fn sheets_at_an_even_distance_are_certified_without_looking_everywhere() {
        let (a, b) = surfaces(&sheet(60, |_, _| 0.0), &sheet(47, |_, _| 0.003));
        let scale = 1.0 / Frame::around(Aabb::of([DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)]), Aabb::EMPTY).length_outside(1.0);
        let bounds = certify(&a, &b, 0.0, &Task::default()).unwrap();
        assert!((bounds.lower / scale - 0.003).abs() < 1e-12 && bounds.upper <= bounds.lower * 1.001, "{bounds:?}");
        assert!(bounds.searches < 1_500_000, "{bounds:?}");
    }

    #[test]
    fn the_greatest_distance_inside_a_face_is_found_to_the_promise() {
        // The middle of one triangle, far from all that three small ones at its corners can reach.
        let a = (vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
        let b = (vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 0, 0], [1, 1, 1], [2, 2, 2]]);
        let (a, b) = surfaces(&a, &b);
        let bounds = certify(&a, &b, 0.0, &Task::default()).unwrap();
        // The middle of the hypotenuse is 1/√2 from each corner; the frame halves nothing (reach 0.5).
        let farthest = 0.5_f64.sqrt() * 2.0;
        assert!(bounds.lower <= farthest * (1.0 + 1e-12) && farthest <= bounds.upper * (1.0 + 1e-12), "{bounds:?}");
        assert!(bounds.upper <= bounds.lower * (1.0 + PROMISED));
    }

    #[test]
    fn a_cancelled_certificate_is_an_error() {
        let (a, b) = surfaces(&sheet(3, |_, _| 0.0), &sheet(4, |x, _| x));
        let flag = std::sync::atomic::AtomicBool::new(true);
        assert!(matches!(certify(&a, &b, 0.0, &Task::default().with_cancel(&flag)), Err(Error::Cancelled)));
    }

    fn soup() -> impl Strategy<Value = Soup> {
        let coordinate = || prop_oneof![-1.0..1.0, (-2..3_i32).prop_map(f64::from)];
        let corner = [coordinate(), coordinate(), coordinate()];
        prop::collection::vec(corner, 3..12).prop_flat_map(|positions| {
            let n = positions.len() as u32;
            (Just(positions), prop::collection::vec([0..n, 0..n, 0..n], 1..12))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn no_sampled_distance_is_above_the_certified_bound((a, b) in (soup(), soup())) {
            let (a, b) = surfaces(&a, &b);
            let task = Task::default();
            let bounds = certify(&a, &b, 0.0, &task).unwrap();
            let sampled = sample(&a, &b, SampleOptions { samples: 20_000, seed: 7 }, &task).unwrap();
            prop_assert!(sampled.max <= bounds.upper + 1e-14, "{} above {bounds:?}", sampled.max);
            prop_assert!(bounds.upper <= bounds.lower * (1.0 + PROMISED) + 2.0 * ROUNDING, "{bounds:?}");
            prop_assert!(bounds.lower + 1e-14 >= sampled.max * 0.99);
        }
    }
}
