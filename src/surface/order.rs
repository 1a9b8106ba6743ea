//! In which order positions are coded: always the vertex that its neighbours say most about.
//!
//! A *gate* of an unknown vertex v is one of its faces whose other two vertices are known and whose
//! face across is wholly known: each gives a parallelogram that predicts v. The vertex with the most
//! gates is next; among equals, the one that got there first. O(1) amortised a half-edge.

use std::collections::VecDeque;

use super::topology::{Surface, turn};
use crate::mesh::half_edge::{next, prev};

/// More gates than this make no difference to the order.
const GATE_CAP: u8 = 15;

/// The order of the vertices `first..end`, which are coded without a look at any others.
pub(super) struct Order<'a> {
    surface: &'a Surface,
    /// An outgoing half-edge of every vertex.
    outgoing: &'a [u32],
    first: u32,
    /// Of each vertex: whether its position is known.
    known: Vec<bool>,
    gates: Vec<u8>,
    /// Bucket g + 1: vertices with g gates and at least one known edge opposite; lazily cleaned.
    waiting: Vec<VecDeque<u32>>,
    /// No bucket above this one holds anything.
    highest: usize,
    next_seed: u32,
}

impl<'a> Order<'a> {
    /// Memory a vertex at most: a face that becomes known has three vertices across wait, a vertex two faces, and a
    /// queue may hold room for as much again.
    pub(super) const BYTES: u64 = 2 + 2 * 4 * (2 * 3 + 2);

    pub(super) fn new(surface: &'a Surface, outgoing: &'a [u32], range: std::ops::Range<u32>) -> Self {
        let len = range.len();
        Self {
            surface,
            outgoing,
            first: range.start,
            known: vec![false; len],
            gates: vec![0; len],
            waiting: vec![VecDeque::new(); GATE_CAP as usize + 1],
            highest: 0,
            next_seed: range.start,
        }
    }

    /// Whether the position of `v` is known. Hole vertices, and those of other ranges, never are.
    #[inline]
    pub(super) fn is_known(&self, v: u32) -> bool {
        self.known.get(v.wrapping_sub(self.first) as usize).copied().unwrap_or(false)
    }

    /// The vertex to code next.
    pub(super) fn next(&mut self) -> Option<u32> {
        loop {
            while let Some(&v) = self.waiting[self.highest].front() {
                self.waiting[self.highest].pop_front();
                let i = (v - self.first) as usize;
                if !self.known[i] && self.gates[i] as usize == self.highest {
                    return Some(v);
                }
            }
            if self.highest > 0 {
                self.highest -= 1;
                continue;
            }
            // Nothing waits: the first unknown vertex starts afresh, then its first neighbours follow it.
            let end = self.first + self.known.len() as u32;
            while self.next_seed < end && (self.is_known(self.next_seed) || self.surface.is_hole[self.next_seed as usize]) {
                self.next_seed += 1;
            }
            return (self.next_seed < end).then_some(self.next_seed);
        }
    }

    /// Says that the position of `v` is known now.
    pub(super) fn learn(&mut self, v: u32) {
        self.known[(v - self.first) as usize] = true;
        let opposite = &self.surface.opposite;
        let start = self.outgoing[v as usize];
        let mut h = start;
        loop {
            let (a, b) = (self.surface.from(next(h)), self.surface.from(prev(h)));
            match (self.is_known(a), self.is_known(b)) {
                // The face is wholly known now: a gate for the vertices across its edges.
                (true, true) => {
                    for side in [h, next(h), prev(h)] {
                        let apex = self.surface.apex(opposite[side as usize]);
                        self.wait(apex, 1);
                    }
                }
                (true, false) => self.wait(b, 0),
                (false, true) => self.wait(a, 0),
                (false, false) => {}
            }
            h = turn(opposite, h);
            if h == start {
                break;
            }
        }
    }

    /// Gives `v` more gates and puts it where it belongs.
    #[inline]
    fn wait(&mut self, v: u32, more: u8) {
        let Some(known) = self.known.get(v.wrapping_sub(self.first) as usize) else { return };
        if *known || self.surface.is_hole[v as usize] {
            return;
        }
        let gates = &mut self.gates[(v - self.first) as usize];
        let before = *gates;
        *gates = (before + more).min(GATE_CAP);
        if *gates != before || before == 0 {
            self.waiting[*gates as usize].push_back(v);
            self.highest = self.highest.max(*gates as usize);
        }
    }
}
