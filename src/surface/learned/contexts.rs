//! The contexts of a coordinate.
//!
//! Densities know how far off a prediction tends to be; contexts know what densities do not: that
//! scans, grids and CAD models repeat coordinates. So most of them are made of *offsets*: where the
//! coordinates of known points nearby, and simple extrapolations of them, lie on the lattice (or in
//! the palette), counted from the expected value.

use super::Scene;
use super::density::{Logistic, SCALE};
use super::frame::Frame;
use super::math::ln;
use super::ring::{Gate, Ring};
use super::vector::Vector;
use super::window::Window;
use crate::entropy::hash;

/// Contexts of effort `default`.
pub(super) const LEAN: usize = 12;
/// Contexts of effort `best`.
pub(super) const ALL: usize = 18;

/// Offsets go as far as this.
const FARTHEST: i64 = 7;
/// The offset of a point that is not known.
const ABSENT: u32 = 15;

/// Points around a vertex whose coordinates may occur again.
pub(super) struct Landmarks {
    /// The ends of the first gate, and the second end of the last.
    ends: Option<[Vector; 3]>,
    /// At the first and at the last gate: the parallelogram; the vertices behind the face across; and
    /// the straight lines on from those through the gate's ends.
    gates: [Landmark; 2],
}

#[derive(Default)]
struct Landmark {
    parallelogram: Option<Vector>,
    behind: [Option<Vector>; 2],
    straight: [Option<Vector>; 2],
}

impl Landmarks {
    pub(super) fn new(scene: &Scene<'_>, ring: &Ring) -> Self {
        let (Some(first), Some(last)) = (ring.gates.first(), ring.gates.last()) else {
            return Self { ends: None, gates: Default::default() };
        };
        let landmark = |g: &Gate| {
            let behind = scene.sides(g.across).map(|h| scene.known_apex(h));
            let through = [g.a, g.b].map(|v| scene.at(v) * 2.0);
            Landmark {
                parallelogram: Some(scene.parallelogram(g)),
                straight: [0, 1].map(|i| behind[i].map(|p| through[i] - p)),
                behind,
            }
        };
        Self { ends: Some([first.a, first.b, last.b].map(|v| scene.at(v))), gates: [landmark(first), landmark(last)] }
    }
}

/// What is known when one coordinate is coded.
pub(super) struct Moment<'a> {
    /// The forecast's second mean, whatever the coordinates before.
    pub(super) base: f64,
    /// The lattice of the vertex, where vertices slide.
    pub(super) frame: Option<&'a Frame>,
    pub(super) landmarks: &'a Landmarks,
    /// What the coordinate can be.
    pub(super) window: Window<'a>,
    pub(super) axis: usize,
    /// The place of the axis in the order of axes.
    pub(super) rank: usize,
    /// The index of the expected value.
    pub(super) centre: i64,
    /// The forecast's means, given the coordinates before.
    pub(super) means: [f64; 3],
    /// The standard deviation to expect.
    pub(super) deviation: f64,
    /// How far the coordinates before were off, in standard deviations.
    pub(super) surprise: f64,
    /// The last two residuals of any axis, and the last of this.
    pub(super) last: [i64; 2],
    pub(super) last_of_axis: i64,
}

impl Moment<'_> {
    fn offset(&self, x: f64) -> u32 {
        ((self.window.nearest(x) - self.centre).clamp(-FARTHEST, FARTHEST) + FARTHEST) as u32
    }

    fn offset_of(&self, point: Option<Vector>) -> u32 {
        point.map_or(ABSENT, |p| self.offset(self.coordinate(p)))
    }

    /// Where a point lies on the axis.
    fn coordinate(&self, point: Vector) -> f64 {
        self.frame.map_or(point[self.axis], |frame| frame.coordinate(point, self.axis))
    }

    /// Where between its two edges the expected value lies, in eighths. A vertex that slides is expected in the middle:
    /// there it is how flat the surface is.
    fn fraction(&self) -> u32 {
        if let Some(frame) = self.frame {
            return frame.flatness;
        }
        let (low, high) = (self.window.edge(self.centre), self.window.edge(self.centre + 1));
        if low.is_finite() && high.is_finite() {
            ((self.means[0] - low) / (high - low) * 8.0).floor().clamp(0.0, 7.0) as u32
        } else {
            4
        }
    }

    /// The contexts, those of effort `default` first.
    pub(super) fn contexts<const N: usize>(&self) -> [u32; N] {
        let (axis, rank) = (self.axis as u32, self.rank as u32);
        let half_octave = octaves(self.deviation, 2.0);
        let fraction = self.fraction();
        let surprised = [0.25, 0.6, 1.2, 2.2].iter().filter(|&&z| self.surprise >= z).count() as u32;
        let mean = self.base;
        let half_step = ((mean - mean.floor()) * 2.0 + 0.01).floor() as u32;
        let base = self.offset(mean);
        let [a, b, d] = self.landmarks.ends.map_or([ABSENT; 3], |ends| ends.map(|p| self.offset(self.coordinate(p))));
        let [first, last] = &self.landmarks.gates;
        let [p, q] = [first, last].map(|g| self.offset_of(g.parallelogram));
        let [behind_a, behind_b] = first.behind.map(|p| self.offset_of(p));
        let [behind_c, behind_d] = last.behind.map(|p| self.offset_of(p));
        let [straight_a, straight_b] = first.straight.map(|p| self.offset_of(p));
        let [straight_c, straight_d] = last.straight.map(|p| self.offset_of(p));
        let all: [&[u32]; ALL] = [
            &[rank, fraction, surprised, octaves(self.deviation, 4.0)],
            &[axis, p, q],
            &[axis, a, b, d],
            &[axis, base, b],
            &[axis, base, half_octave],
            &[axis, a, d, half_octave],
            &[axis, behind_c, behind_d, q],
            &[axis, straight_c, straight_d, q],
            &[axis, behind_a, behind_b, p],
            &[axis, base, surprised, p, q],
            &[axis, straight_a, straight_b, p],
            &[axis, straight_a, straight_d, half_octave],
            &[axis, base, half_step],
            &[axis, magnitude(self.last_of_axis), half_octave],
            &[rank, magnitude(self.last[0]), magnitude(self.last[1]), half_octave],
            &[rank, self.offset(self.means[1]), self.offset(self.means[2]), fraction],
            &[axis, a, b, d, p, q],
            &[axis, behind_c, behind_d, half_octave],
        ];
        let mut contexts = [0; N];
        for (i, context) in contexts.iter_mut().enumerate() {
            *context = all[i].iter().fold(i as u32, |h, &part| hash(h, part));
        }
        contexts
    }

    /// The densities to expect.
    pub(super) fn densities<const E: usize>(&self) -> [Logistic; E] {
        let (means, width) = (self.means, (self.deviation * SCALE).max(0.04));
        let all = [
            Logistic { centre: means[0], width },
            Logistic { centre: means[0], width: (width * 0.5).max(0.03) },
            Logistic { centre: means[0], width: width * 2.2 },
            Logistic { centre: means[1], width: width * 1.2 },
        ];
        let mut densities = [Logistic::default(); E];
        densities.copy_from_slice(&all[..E]);
        densities
    }
}

/// log₂ x in parts of an octave, from 2⁻¹⁶ on.
fn octaves(x: f64, per_octave: f64) -> u32 {
    (ln(x + 1e-6) * std::f64::consts::LOG2_E * per_octave + 32.0).floor().clamp(0.0, 63.0) as u32
}

/// A residual in nine classes.
fn magnitude(r: i64) -> u32 {
    let size = [1, 2, 4, 8].iter().filter(|&&limit| r.abs() >= limit).count() as u32;
    if r < 0 { 4 - size } else { 4 + size }
}
