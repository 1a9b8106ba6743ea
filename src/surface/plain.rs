//! Positions in integers alone: parallelograms predict, contexts of neighbours' errors code the rest.
//!
//! The prediction of a vertex is the mean of the parallelograms a + b − c over its gates (see
//! [`order`](super::order)); without a gate, the middle of a known edge opposite, or a known neighbour.
//! spec/surface.md, "Positions, fast".

use super::order::Order;
use super::stretch::Stretch;
use super::topology::turn;
use crate::entropy::{BitCoder, Residuals, hash};
use crate::error::{Error, Place, Result};
use crate::mesh::half_edge::{next, prev};
use crate::task::Task;

/// Contexts a residual.
const CONTEXTS: usize = 5;

/// The offset of a point that is not known.
const ABSENT: u32 = 15;

/// A vertex without known neighbours has no size to go by.
const NO_SIZE: u32 = 31;

/// What the known neighbours of a vertex say about it.
struct Forecast {
    /// The predicted position.
    position: [i32; 3],
    /// Half octaves of the neighbours' mean error.
    size: u32,
    /// The ends of the first gate and the second end of the last; the vertices across the first and
    /// the last gate; their parallelograms.
    landmarks: Option<[[i32; 3]; 7]>,
}

/// Memory that coding a stretch of so many vertices takes.
pub(super) fn memory(vertices: usize) -> u64 {
    vertices as u64 * (4 + Order::BYTES) + Residuals::<CONTEXTS>::memory(vertices)
}

/// Codes the positions of a stretch of vertices, in the order that [`Order`] finds.
///
/// `positions` holds them, from the first vertex of the stretch on: a writer's are read, a reader's are filled in.
pub(super) fn code<C: BitCoder>(coder: &mut C, stretch: Stretch<'_>, positions: &mut [[i32; 3]], task: Task<'_>) -> Result<()> {
    let Stretch { range, extent, .. } = stretch.clone();
    let first = range.start;
    let mut residuals = Residuals::<CONTEXTS>::new(range.len());
    let mut errors = vec![0_u32; range.len()];
    let mut order = Order::new(stretch.surface, stretch.outgoing, range);
    let mut count = 0_usize;
    while let Some(v) = order.next() {
        let forecast = forecast(&stretch, &order, positions, &errors, v);
        let i = (v - first) as usize;
        let mut total = 0_u32;
        for axis in 0..3 {
            let predicted = forecast.position[axis];
            let contexts = contexts(&forecast, axis, total);
            let residual = residuals.code(coder, positions[i][axis].wrapping_sub(predicted), axis, contexts);
            positions[i][axis] = predicted.wrapping_add(residual);
            if !(0..=extent[axis]).contains(&positions[i][axis]) {
                return Err(Error::malformed(Place::Whole, format!("a coordinate of vertex {v} is outside the box")));
            }
            total = total.saturating_add(residual.unsigned_abs());
        }
        errors[i] = total;
        order.learn(v);
        count += 1;
        if count.is_multiple_of(1 << 14) {
            if coder.is_exhausted() {
                break;
            }
            task.step(count as f64 / positions.len() as f64)?;
        }
    }
    if coder.is_exhausted() {
        return Err(Error::malformed(Place::Whole, format!("positions after {count} vertices: the stream ends too soon")));
    }
    Ok(())
}

fn forecast(stretch: &Stretch<'_>, order: &Order<'_>, positions: &[[i32; 3]], errors: &[u32], v: u32) -> Forecast {
    let Stretch { surface, outgoing, extent, .. } = stretch;
    let first = stretch.range.start;
    let at = |v: u32| positions[(v - first) as usize];
    let (mut gates, mut sum) = (0_i64, [0_i64; 3]);
    let (mut ring, mut error_sum, mut beside) = (0_u32, 0_u64, None);
    let (mut edge, mut landmarks) = (None, None::<[[i32; 3]; 7]>);
    let start = outgoing[v as usize];
    let mut h = start;
    loop {
        let across = next(h);
        let (a, b) = (surface.from(across), surface.from(prev(h)));
        if order.is_known(a) {
            ring += 1;
            error_sum += u64::from(errors[(a - first) as usize]);
            beside = Some(a);
            if order.is_known(b) {
                let c = surface.apex(surface.opposite[across as usize]);
                if order.is_known(c) {
                    let (pa, pb, pc) = (at(a), at(b), at(c));
                    let corner = [0, 1, 2].map(|q| pa[q].wrapping_add(pb[q]).wrapping_sub(pc[q]));
                    (0..3).for_each(|q| sum[q] += i64::from(corner[q]));
                    gates += 1;
                    landmarks = match landmarks {
                        None => Some([pa, pb, pb, pc, pc, corner, corner]),
                        Some([a, b, _, c, _, g, _]) => Some([a, b, pb, c, pc, g, corner]),
                    };
                } else {
                    edge = Some([a, b]);
                }
            }
        }
        h = turn(&surface.opposite, h);
        if h == start {
            break;
        }
    }
    let position = match (gates, edge, beside) {
        (0, Some([a, b]), _) => [0, 1, 2].map(|q| (at(a)[q] + at(b)[q]) >> 1),
        (0, None, Some(a)) => at(a),
        (0, None, None) => extent.map(|e| e / 2),
        // The mean, rounded to nearest.
        _ => sum.map(|s| (2 * s + gates).div_euclid(2 * gates) as i32),
    };
    Forecast {
        position: [0, 1, 2].map(|q| position[q].clamp(0, extent[q])),
        size: if ring > 0 { half_octaves((2 * error_sum / u64::from(ring)) as u32) } else { NO_SIZE },
        landmarks,
    }
}

/// The contexts of one coordinate: how large errors are around here and on the axes before, and where
/// the coordinates of points nearby lie, counted from the prediction (equal coordinates repeat).
#[inline]
fn contexts(forecast: &Forecast, axis: usize, total: u32) -> [u32; CONTEXTS] {
    let predicted = forecast.position[axis];
    let offset = |p: [i32; 3]| (p[axis].wrapping_sub(predicted).clamp(-7, 7) + 7) as u32;
    let q = axis as u32;
    let size = forecast.size;
    let before = if axis == 0 { 0 } else { (1 + half_octaves(total) / 2).min(7) };
    let [a, b, d, c, e, g, f] = forecast.landmarks.map_or([ABSENT; 7], |points| points.map(offset));
    [
        (q * 32 + size) * 8 + before,
        ((q * 16 + a) * 16 + b) * 16 + d,
        hash(((q * 16 + g) * 16 + f) * 32 + size, 0),
        hash(((q * 16 + g) * 16 + f) * 256 + a * 16 + b, 1),
        hash(((q * 16 + g) * 16 + c) * 16 + e, 2),
    ]
}

/// 2 log₂(n + 1), rounded down to whole and half octaves; at most 31.
#[inline]
fn half_octaves(n: u32) -> u32 {
    let n = n.saturating_add(1);
    let octave = n.ilog2();
    let half = if octave > 0 { n >> (octave - 1) & 1 } else { 0 };
    (2 * octave + half).min(31)
}
