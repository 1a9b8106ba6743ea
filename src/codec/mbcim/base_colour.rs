//! Base colours: one for each vertex, predicted from the colours that they meet (spec/mbcim.md, "Base colours").
//!
//! N + W − NW, the prediction of raster images, is the parallelogram of two half-cells. Here it is
//! taken wherever two half-cells share a side and all but one of their four colours are known, and
//! colours are coded in the order in which most such parallelograms are complete. The residuals are
//! mixed from contexts: how large errors are nearby, how large they were on the axes before, and
//! where the known colours lie.

use std::collections::VecDeque;

use super::meeting::Meetings;
use crate::entropy::{BitCoder, Residuals, hash};
use crate::error::{Error, Place, Result};
use crate::task::Task;

/// Contexts a residual.
const CONTEXTS: usize = 6;
/// More parallelograms than this make no difference to the order.
const GATE_CAP: usize = 7;
/// A colour that meets none that is known has no size to go by.
const NO_SIZE: u32 = 31;

/// Memory and steps a colour.
pub(crate) const BYTES: u64 = 64;
pub(crate) const STEPS: u64 = 64;

/// The order in which colours are coded.
struct Order {
    known: Vec<bool>,
    gates: Vec<u8>,
    /// By gates; cleaned when they are read.
    waiting: Vec<VecDeque<u32>>,
    highest: usize,
    next_seed: usize,
}

impl Order {
    fn new(colours: usize) -> Self {
        Self {
            known: vec![false; colours],
            gates: vec![0; colours],
            waiting: vec![VecDeque::new(); GATE_CAP + 1],
            highest: 0,
            next_seed: 0,
        }
    }

    fn next(&mut self) -> Option<u32> {
        loop {
            while let Some(c) = self.waiting[self.highest].pop_front() {
                if !self.known[c as usize] && usize::from(self.gates[c as usize]) == self.highest {
                    return Some(c);
                }
            }
            if self.highest > 0 {
                self.highest -= 1;
                continue;
            }
            while self.known.get(self.next_seed) == Some(&true) {
                self.next_seed += 1;
            }
            return (self.next_seed < self.known.len()).then_some(self.next_seed as u32);
        }
    }

    fn learn(&mut self, meetings: &Meetings<'_>, colour: u32) {
        self.known[colour as usize] = true;
        for &corner in meetings.around(colour) {
            let [a, b] = meetings.side(corner);
            match (self.known[a as usize], self.known[b as usize]) {
                (true, true) => {
                    let cell = corner / 3 * 3;
                    for side in cell..cell + 3 {
                        if let Some(c) = meetings.beyond(side) {
                            self.wait(c, 1);
                        }
                    }
                }
                (true, false) => self.wait(b, 0),
                (false, true) => self.wait(a, 0),
                (false, false) => {}
            }
        }
    }

    fn wait(&mut self, colour: u32, more: u8) {
        if self.known[colour as usize] {
            return;
        }
        let gates = &mut self.gates[colour as usize];
        let before = *gates;
        *gates = (before + more).min(GATE_CAP as u8);
        if *gates != before || before == 0 {
            self.waiting[usize::from(*gates)].push_back(colour);
            self.highest = self.highest.max(usize::from(*gates));
        }
    }
}

/// What the known colours say about one.
struct Forecast {
    colour: [i32; 3],
    /// 0 from nothing, 1 from neighbours, then 1 + parallelograms, at most 4.
    class: u32,
    size: u32,
    ring: u32,
    /// The side of the first parallelogram, and the first and the last one.
    nearby: Option<[[i32; 3]; 4]>,
}

/// Codes `colours` (a writer's are read, a reader's filled in); component `i` of each lies in `0..=extent[i]`.
pub(crate) fn code<C: BitCoder>(
    coder: &mut C,
    meetings: &Meetings<'_>,
    extent: [i32; 3],
    colours: &mut [[i32; 3]],
    task: Task<'_>,
) -> Result<()> {
    let mut residuals = Residuals::<CONTEXTS>::new(colours.len());
    let mut errors = vec![0_u32; colours.len()];
    let mut order = Order::new(meetings.colours());
    let mut count = 0_usize;
    while let Some(c) = order.next() {
        let forecast = forecast(meetings, &order.known, colours, &errors, extent, c);
        let colour = &mut colours[c as usize];
        let mut total = 0_u32;
        let mut last = [0; 2];
        for axis in 0..3 {
            let predicted = forecast.colour[axis];
            let contexts = contexts(&forecast, axis, total, last);
            let residual = residuals.code(coder, colour[axis].wrapping_sub(predicted), axis, contexts);
            colour[axis] = predicted.wrapping_add(residual);
            if !(0..=extent[axis]).contains(&colour[axis]) {
                return Err(Error::malformed(Place::Whole, format!("base colour {c} is outside its box")));
            }
            total = total.saturating_add(residual.unsigned_abs());
            last = [residual, last[0]];
        }
        errors[c as usize] = total;
        order.learn(meetings, c);
        count += 1;
        if count.is_multiple_of(1 << 14) {
            if coder.is_exhausted() {
                break;
            }
            task.step(count as f64 / colours.len() as f64)?;
        }
    }
    if coder.is_exhausted() {
        return Err(Error::malformed(Place::Whole, format!("the base colours end too soon, after {count}")));
    }
    Ok(())
}

fn forecast(
    meetings: &Meetings<'_>,
    known: &[bool],
    colours: &[[i32; 3]],
    errors: &[u32],
    extent: [i32; 3],
    colour: u32,
) -> Forecast {
    let at = |c: u32| colours[c as usize];
    let is_known = |c: u32| known[c as usize];
    let (mut gates, mut sum) = (0_i64, [0_i64; 3]);
    let (mut ring, mut error_sum) = (0_u32, 0_u64);
    let (mut edge, mut beside) = (None, None);
    let mut nearby: Option<[[i32; 3]; 4]> = None;
    for &corner in meetings.around(colour) {
        let [a, b] = meetings.side(corner);
        for c in [a, b].into_iter().filter(|&c| is_known(c)) {
            // Every neighbour is met twice, save at the ends of an open fan.
            ring += 1;
            error_sum += u64::from(errors[c as usize]);
            beside = Some(c);
        }
        if is_known(a) && is_known(b) {
            match meetings.beyond(corner).filter(|&c| is_known(c)) {
                Some(c) => {
                    let (pa, pb, pc) = (at(a), at(b), at(c));
                    let gate = [0, 1, 2].map(|i| pa[i].wrapping_add(pb[i]).wrapping_sub(pc[i]));
                    (0..3).for_each(|i| sum[i] += i64::from(gate[i]));
                    gates += 1;
                    nearby = Some(nearby.map_or([pa, pb, gate, gate], |n| [n[0], n[1], n[2], gate]));
                }
                None => edge = Some([a, b]),
            }
        }
    }
    let predicted = match (gates, edge, beside) {
        (0, Some([a, b]), _) => [0, 1, 2].map(|i| (at(a)[i] + at(b)[i]) >> 1),
        (0, None, Some(c)) => at(c),
        (0, None, None) => extent.map(|e| e / 2),
        _ => sum.map(|s| (2 * s + gates).div_euclid(2 * gates) as i32),
    };
    Forecast {
        colour: [0, 1, 2].map(|i| predicted[i].clamp(0, extent[i])),
        class: if gates > 0 { 1 + gates.min(3) as u32 } else { u32::from(beside.is_some()) },
        size: if ring > 0 { half_octaves((2 * error_sum / u64::from(ring)) as u32) } else { NO_SIZE },
        ring: ring / 2,
        nearby,
    }
}

#[inline]
fn contexts(forecast: &Forecast, axis: usize, total: u32, last: [i32; 2]) -> [u32; CONTEXTS] {
    let predicted = forecast.colour[axis];
    let near = |x: i32| (x.wrapping_sub(predicted).clamp(-7, 7) + 7) as u32;
    let q = axis as u32;
    let size = forecast.size;
    let before = if axis == 0 { 0 } else { (1 + half_octaves(total) / 2).min(7) };
    let [a, b, g, f] = forecast.nearby.map_or([15; 4], |n| n.map(|p| near(p[axis])));
    [
        (q * 32 + size) * 8 + before,
        ((q * 8 + before) * 8 + forecast.class) * 16 + forecast.ring.min(15),
        ((q * 10 + signed_size(last[0])) * 10 + signed_size(last[1])) * 16 + size / 2,
        (q * 16 + a) * 16 + b,
        hash(((q * 16 + g) * 16 + f) * 32 + size, 0),
        hash(((q * 16 + a) * 16 + g) * 16 + f, before),
    ]
}

/// 2 log₂(n + 1), rounded down to whole and half octaves; at most 31.
fn half_octaves(n: u32) -> u32 {
    let n = n.saturating_add(1);
    let octave = n.ilog2();
    let half = if octave > 0 { n >> (octave - 1) & 1 } else { 0 };
    (2 * octave + half).min(31)
}

/// A residual in nine classes.
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
