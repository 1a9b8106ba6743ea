//! Positions in integers alone: parallelograms predict, contexts of neighbours' errors code the rest.
//!
//! The prediction of a vertex is the mean of the parallelograms a + b − c over its gates (see
//! [`order`](super::order)); without a gate, the middle of a known edge opposite, or a known neighbour.
//! spec/surface.md, "Positions, fast".

use super::order::Order;
use super::residual::Residuals;
use super::topology::{Surface, turn};
use crate::entropy::{BitCoder, hash};
use crate::error::{Error, Place, Result};
use crate::mesh::half_edge::{next, prev};
use crate::task::Task;

/// Contexts a residual.
const CONTEXTS: usize = 5;

/// A vertex without known neighbours has no size to go by.
const NO_SIZE: u32 = 31;

/// What the known neighbours of a vertex say about it.
struct Forecast {
    /// The predicted position.
    position: [i32; 3],
    /// How the prediction came about: 0 from nothing, 1 from a neighbour or an edge, then 1 + gates, at most 4.
    class: u32,
    /// Half octaves of the neighbours' mean error.
    size: u32,
    /// Known neighbours.
    ring: u32,
    /// The known vertices opposite: of the first gate, and of the last.
    ends: Option<[[i32; 3]; 3]>,
    /// The parallelograms of the first and the last gate.
    gates: Option<[[i32; 3]; 2]>,
}

/// Codes the positions of the vertices in `range`, in the order that [`Order`] finds.
///
/// `positions` holds them, from the first vertex of the range on: a writer's are read, a reader's
/// are filled in. Coordinate `axis` lies in `0..=extent[axis]`.
pub(super) fn code<C: BitCoder>(
    coder: &mut C,
    surface: &Surface,
    outgoing: &[u32],
    range: std::ops::Range<u32>,
    extent: [i32; 3],
    positions: &mut [[i32; 3]],
    task: Task<'_>,
) -> Result<()> {
    let first = range.start;
    let mut residuals = Residuals::<CONTEXTS>::new(range.len());
    let mut errors = vec![0_u32; range.len()];
    let mut order = Order::new(surface, outgoing, range);
    let mut count = 0_usize;
    while let Some(v) = order.next() {
        let forecast = forecast(surface, outgoing, &order, positions, &errors, first, extent, v);
        let i = (v - first) as usize;
        let mut total = 0_u32;
        let mut last = [0; 2];
        for axis in 0..3 {
            let predicted = forecast.position[axis];
            let contexts = contexts(&forecast, axis, total, last);
            let residual = residuals.code(coder, positions[i][axis].wrapping_sub(predicted), axis, contexts);
            positions[i][axis] = predicted.wrapping_add(residual);
            if !(0..=extent[axis]).contains(&positions[i][axis]) {
                return Err(Error::malformed(Place::Whole, format!("a coordinate of vertex {v} is outside the box")));
            }
            total = total.saturating_add(residual.unsigned_abs());
            last = [residual, last[0]];
        }
        errors[i] = total;
        order.learn(v);
        count += 1;
        if count % (1 << 14) == 0 {
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

#[allow(clippy::too_many_arguments)]
fn forecast(
    surface: &Surface,
    outgoing: &[u32],
    order: &Order<'_>,
    positions: &[[i32; 3]],
    errors: &[u32],
    first: u32,
    extent: [i32; 3],
    v: u32,
) -> Forecast {
    let at = |v: u32| positions[(v - first) as usize];
    let (mut gates, mut sum) = (0_i64, [0_i64; 3]);
    let (mut ring, mut error_sum, mut beside) = (0, 0_u64, None);
    let (mut edge, mut ends, mut ends_of_gates): (Option<[u32; 2]>, _, _) =
        (None, None::<[[i32; 3]; 3]>, None::<[[i32; 3]; 2]>);
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
                    ends = Some(ends.map_or([pa, pb, pb], |e| [e[0], e[1], pb]));
                    ends_of_gates = Some(ends_of_gates.map_or([corner, corner], |e| [e[0], corner]));
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
        class: if gates > 0 { 1 + gates.min(3) as u32 } else { u32::from(beside.is_some()) },
        size: if ring > 0 { half_octaves((2 * error_sum / u64::from(ring)) as u32) } else { NO_SIZE },
        ring,
        ends,
        gates: ends_of_gates,
    }
}

/// The contexts of one coordinate: how large errors are around here, how large they were on the
/// axes before, and where the lattice points of the neighbours lie (equal coordinates repeat).
#[inline]
fn contexts(forecast: &Forecast, axis: usize, total: u32, last: [i32; 2]) -> [u32; CONTEXTS] {
    let predicted = forecast.position[axis];
    let near = |x: i32| (x.wrapping_sub(predicted).clamp(-7, 7) + 7) as u32;
    let q = axis as u32;
    let size = forecast.size;
    let before = if axis == 0 { 0 } else { (1 + half_octaves(total) / 2).min(7) };
    let [a, b, d] = forecast.ends.map_or([15; 3], |e| e.map(|p| near(p[axis])));
    let [g, f] = forecast.gates.map_or([15; 2], |e| e.map(|p| near(p[axis])));
    [
        (q * 32 + size) * 8 + before,
        ((q * 8 + before) * 8 + forecast.class) * 16 + forecast.ring.min(15),
        ((q * 10 + signed_size(last[0])) * 10 + signed_size(last[1])) * 16 + size / 2,
        ((q * 16 + a) * 16 + b) * 16 + d,
        hash(((q * 16 + g) * 16 + f) * 32 + size, 0),
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

/// A residual in nine classes.
#[inline]
fn signed_size(r: i32) -> u32 {
    let size = match r.unsigned_abs() {
        0 => 0,
        1 => 1,
        2..=4 => 2,
        5..=11 => 3,
        _ => 4,
    };
    if r < 0 { 9 - size } else { size }
}
