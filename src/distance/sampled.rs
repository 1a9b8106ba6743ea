//! Directed distances from points spread evenly over a surface (`measures.md`: `rms`, `rms_max`, `normal_rms`).
//!
//! The points are uniform by area and stratified: the whole area, laid out in tree order, is cut into
//! as many equal parts as there are points, and each part gets one; where in its triangle a point lies
//! follows an evenly filling sequence. A point depends on seed and number alone, so that any number
//! of threads draws the same points.

use glam::DVec3;

use super::directed::{Surface, measured};
use crate::error::{Error, Result};
use crate::geom::Triangle;
use crate::par;
use crate::task::Task;

/// Points that one piece of work measures, one after the other, each a hint to the next.
const CHUNK: usize = 4096;

/// How many points, and which.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SampleOptions {
    pub(crate) samples: usize,
    pub(crate) seed: u64,
}

/// Sums over the points of one direction, in the units of the frame.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Sampled {
    /// Points measured.
    pub(crate) samples: usize,
    /// Sum of distances.
    pub(crate) sum: f64,
    /// Sum of squared distances.
    pub(crate) sum2: f64,
    /// The greatest distance of a point, vertices included.
    pub(crate) max: f64,
    /// Points where both surfaces have a normal.
    pub(crate) angles: usize,
    /// Sum over those of the squared angle between the normals, in square degrees.
    pub(crate) angle2: f64,
}

impl Sampled {
    fn add(&mut self, other: Self) {
        self.samples += other.samples;
        self.sum += other.sum;
        self.sum2 += other.sum2;
        self.max = self.max.max(other.max);
        self.angles += other.angles;
        self.angle2 += other.angle2;
    }
}

/// A number in `[0, 1)` that depends on nothing but its arguments (SplitMix64's finaliser).
fn random(seed: u64, point: u64, which: u64) -> f64 {
    let mut x = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (point * 4 + which).wrapping_mul(0xd1b5_4a32_d192_ed03);
    for _ in 0..2 {
        x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^= x >> 31;
    }
    (x >> 11) as f64 / (1_u64 << 53) as f64
}

/// The `i`-th of a sequence that fills the unit square evenly, every stretch of it too (M. Roberts' R2:
/// multiples of the inverse powers of the plastic number).
fn spread(shift: [f64; 2], i: usize) -> [f64; 2] {
    const STEP: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
    [0, 1].map(|k| (shift[k] + STEP[k] * i as f64).fract())
}

/// Twice the area, along the normal.
fn normal([a, b, c]: Triangle) -> DVec3 {
    (b - a).cross(c - a)
}

/// The angle between two directions in degrees, exact to rounding also where it is small.
fn degrees_between(m: DVec3, n: DVec3) -> f64 {
    let (m, n) = (m.normalize_or_zero(), n.normalize_or_zero());
    m.cross(n).length().atan2(m.dot(n)).to_degrees()
}

/// Measures `from → to` at evenly spread points of `from`, and for the greatest distance also at its vertices.
/// Neither may be empty.
///
/// # Errors
/// Only if the task is over.
pub(crate) fn sample(from: &Surface, to: &Surface, options: SampleOptions, task: &Task<'_>) -> Result<Sampled> {
    let mut sums = sample_spread(from, to, options, task)?;
    sums.max = sums.max.max(greatest_at_vertices(from, to));
    if task.is_over() {
        return Err(Error::Cancelled);
    }
    Ok(sums)
}

/// The same at the evenly spread points alone.
///
/// # Errors
/// Only if the task is over.
pub(crate) fn sample_spread(from: &Surface, to: &Surface, options: SampleOptions, task: &Task<'_>) -> Result<Sampled> {
    let triangles = from.triangles();
    let mut total = 0.0;
    // Where each triangle's share of the whole area ends.
    let ends: Vec<f64> = triangles
        .iter()
        .map(|&t| {
            total += normal(t).length();
            total
        })
        .collect();
    let n = options.samples;
    let chunks = n.div_ceil(CHUNK);
    let shift = [random(options.seed, u64::MAX >> 2, 0), random(options.seed, u64::MAX >> 2, 1)];
    let parts = par::map(chunks, |chunk| {
        let mut sums = Sampled::default();
        let (first, last) = (chunk * CHUNK, n.min((chunk + 1) * CHUNK));
        if task.is_over() {
            return sums;
        }
        let place = |i: usize| (i as f64 + random(options.seed, i as u64, 0)) / n as f64 * total;
        let mut at = ends.partition_point(|&end| end <= place(first)).min(triangles.len() - 1);
        let mut hint = 0;
        for i in first..last {
            if total > 0.0 {
                while at + 1 < triangles.len() && ends[at] <= place(i) {
                    at += 1;
                }
            } else {
                at = i % triangles.len();
            }
            let t = triangles[at];
            let [r, s] = spread(shift, i);
            let r = r.sqrt();
            let p = t[0] * (1.0 - r) + t[1] * (r * (1.0 - s)) + t[2] * (r * s);
            let hit = to.closest(p, hint);
            hint = hit.slot;
            let d = measured(hit);
            sums.sum += d;
            sums.sum2 += d * d;
            sums.max = sums.max.max(d);
            let (m, n) = (normal(t), normal(to.triangles()[hit.slot as usize]));
            if m != DVec3::ZERO && n != DVec3::ZERO {
                sums.angles += 1;
                sums.angle2 += degrees_between(m, n).powi(2);
            }
        }
        sums.samples = last - first;
        sums
    });
    let mut sums = Sampled::default();
    for part in parts {
        sums.add(part);
    }
    if task.is_over() {
        return Err(Error::Cancelled);
    }
    Ok(sums)
}

/// The greatest distance of a vertex of `from`.
fn greatest_at_vertices(from: &Surface, to: &Surface) -> f64 {
    let vertices = from.vertices();
    let greatest = par::map(vertices.len().div_ceil(CHUNK), |chunk| {
        let (first, last) = (chunk * CHUNK, vertices.len().min((chunk + 1) * CHUNK));
        let (mut max, mut hint) = (0.0_f64, 0);
        for &p in &vertices[first..last] {
            let hit = to.closest(p, hint);
            hint = hit.slot;
            max = max.max(measured(hit));
        }
        max
    });
    greatest.into_iter().fold(0.0, f64::max)
}
