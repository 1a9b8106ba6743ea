//! The lattice on which a vertex that may slide is coded: centred at its prediction, turned with the surface.
//!
//! Along the predicted normal its step is one, or less where edges are short; across it as much more as the surface around
//! is flat: there a vertex may be moved without moving the surface. spec/surface.md, "Sliding vertices".

use super::super::stretch::Sliding;
use super::super::topology::turn;
use super::Scene;
use super::features::View;
use super::ring::Ring;
use super::vector::Vector;
use crate::mesh::half_edge::{next, prev};

/// Positions are whole numbers of this part of a step.
pub(in crate::surface) const PARTS: f64 = 16.0;

/// Without a limit of its own, a step across the normal is √2 to the power of this times longer, at most.
pub(in crate::surface) const LONGEST_STRETCH: u8 = 8;

/// √2 to the power of 0 ..= 8: how many times longer than the normal step the others may be.
const STRETCHES: [f64; 9] = [
    1.0,
    std::f64::consts::SQRT_2,
    2.0,
    2.0 * std::f64::consts::SQRT_2,
    4.0,
    4.0 * std::f64::consts::SQRT_2,
    8.0,
    8.0 * std::f64::consts::SQRT_2,
    16.0,
];

/// The fourth root of 2: half-way, as a factor, from one stretch to the next.
const HALF_WAY: f64 = 1.189_207_115_002_721;

/// A step across the normal is no longer than this share of the edges around.
const LONGEST: f64 = 0.3;
/// Nor, where short edges make the normal step finer, is that one.
const HIGHEST: f64 = 0.25;
/// What is added to the squared angle of the surface.
const FLATTEST: f64 = 1e-6;

/// Half-edges looked at around a vertex, at most.
const TURNS: usize = 64;

/// Axes and steps of the lattice of one vertex.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    /// Where all three indices are 0.
    pub(super) centre: Vector,
    /// Two axes across the normal, and the normal.
    pub(super) axes: [Vector; 3],
    /// The step along each axis.
    pub(super) steps: [f64; 3],
    /// How flat the surface is, in octaves of the step.
    pub(super) flatness: u32,
}

impl Frame {
    /// The lattice of a vertex without gates; and where nothing better is known.
    pub(super) fn plain() -> Self {
        let axes = [Vector([1.0, 0.0, 0.0]), Vector([0.0, 1.0, 0.0]), Vector([0.0, 0.0, 1.0])];
        Self { centre: Vector::ZERO, axes, steps: [1.0; 3], flatness: 0 }
    }

    /// The lattice of a vertex that is seen so, still without its centre.
    pub(super) fn new(scene: &Scene<'_>, ring: &Ring, view: &View, v: u32, sliding: &Sliding<'_>) -> Self {
        let mut this = Self::plain();
        let (Some(first), Some(last)) = (ring.gates.first(), ring.gates.last()) else { return this };
        let normal = if view.normal.length() > 0.5 { view.normal } else { this.axes[2] };
        let mut x = (scene.at(last.b) - scene.at(first.a)).tangential(normal);
        if !(x.length() > 1e-6) {
            let any = if normal[0].abs() < 0.6 { this.axes[0] } else { this.axes[1] };
            x = any.tangential(normal);
        }
        x = x * (1.0 / x.length());
        this.axes = [x, normal.cross(x), normal];
        let mut step = 1.0;
        if sliding.fine {
            // Half as long, by √2, as long as it is above the limit, half-way rounded; an eighth at least.
            let mut halvings = 0;
            while halvings < 6 && HIGHEST * view.length < step / HALF_WAY {
                halvings += 1;
                step = 1.0 / STRETCHES[halvings];
            }
        }
        let bend = bend(scene, ring, normal, v);
        let wanted = (1.0 / (bend + FLATTEST).sqrt()).min(LONGEST * view.length / step);
        let stretch = (1..=usize::from(sliding.longest).min(STRETCHES.len() - 1))
            .take_while(|&i| wanted >= STRETCHES[i - 1] * HALF_WAY)
            .count();
        this.steps = [step * STRETCHES[stretch], step * STRETCHES[stretch], step];
        this.flatness = stretch as u32;
        this
    }

    /// Where a point lies on one axis, in steps.
    #[inline]
    pub(super) fn coordinate(&self, point: Vector, axis: usize) -> f64 {
        (point - self.centre).dot(self.axes[axis]) / self.steps[axis]
    }

    /// The position of three indices, in [`PARTS`] of a step, inside the box.
    #[inline]
    pub(super) fn position(&self, indices: [i64; 3], extent: [i32; 3]) -> [i32; 3] {
        let mut point = self.centre;
        for axis in 0..3 {
            point += self.axes[axis] * (self.steps[axis] * indices[axis] as f64);
        }
        [0, 1, 2].map(|i| snap(point[i], extent[i]))
    }
}

/// The nearest of the [`PARTS`] of a step that lie in the box.
#[inline]
pub(in crate::surface) fn snap(x: f64, extent: i32) -> i32 {
    // `as` takes anything that is no number to 0, and what is too large to the ends.
    ((x * PARTS + 0.5).floor() as i64).clamp(0, extent.into()) as i32
}

/// The mean squared sine of the angles between `normal` and the known faces around the known neighbours.
fn bend(scene: &Scene<'_>, ring: &Ring, normal: Vector, v: u32) -> f64 {
    let (mut off, mut all) = (0.0, 0.0);
    for &a in &ring.known {
        let start = scene.outgoing[a as usize];
        let mut h = start;
        for _ in 0..TURNS {
            let (b, c) = (scene.surface.from(next(h)), scene.surface.from(prev(h)));
            if b != v && c != v && scene.order.is_known(b) && scene.order.is_known(c) {
                let m = (scene.at(b) - scene.at(a)).cross(scene.at(c) - scene.at(a));
                let size = m.length();
                if size > 1e-9 {
                    let along = m.dot(normal);
                    off += size - along * along / size;
                    all += size;
                }
            }
            h = turn(&scene.surface.opposite, h);
            if h == start {
                break;
            }
        }
    }
    if all > 0.0 { (off / all).max(0.0) } else { 0.5 }
}
