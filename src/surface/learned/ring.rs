//! What is known around a vertex: its known neighbours and its gates, in order.

use super::super::order::Order;
use super::super::topology::{Surface, turn};
use super::vector::Vector;
use crate::mesh::half_edge::{next, prev};

/// A face (v, a, b) of the vertex v whose other corners, and the apex c of the face across a – b, are known.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gate {
    pub(super) a: u32,
    pub(super) b: u32,
    pub(super) c: u32,
    /// The half-edge b → a, in the face (b, a, c).
    pub(super) across: u32,
}

/// The neighbourhood of one vertex; made once and refilled for every vertex.
#[derive(Debug, Default)]
pub(super) struct Ring {
    /// Known neighbours, counter-clockwise.
    pub(super) known: Vec<u32>,
    /// All neighbours that are vertices of the mesh.
    pub(super) all: Vec<u32>,
    /// Counter-clockwise; the first begins a stretch of neighbouring gates, if they do not go all round.
    pub(super) gates: Vec<Gate>,
    /// The last known edge opposite the vertex that has no gate.
    pub(super) edge: Option<[u32; 2]>,
}

impl Ring {
    pub(super) fn fill(&mut self, surface: &Surface, outgoing: &[u32], order: &Order<'_>, v: u32) {
        self.known.clear();
        self.all.clear();
        self.gates.clear();
        self.edge = None;
        let start = outgoing[v as usize];
        let mut h = start;
        loop {
            let (a, b) = (surface.from(next(h)), surface.from(prev(h)));
            if !surface.is_hole[a as usize] {
                self.all.push(a);
            }
            if order.is_known(a) {
                self.known.push(a);
                if order.is_known(b) {
                    let across = surface.opposite[next(h) as usize];
                    let c = surface.apex(across);
                    if order.is_known(c) {
                        self.gates.push(Gate { a, b, c, across });
                    } else {
                        self.edge = Some([a, b]);
                    }
                }
            }
            h = turn(&surface.opposite, h);
            if h == start {
                break;
            }
        }
        let count = self.gates.len();
        if let Some(first) = (0..count).find(|&i| self.gates[i].a != self.gates[(i + count - 1) % count].b) {
            self.gates.rotate_left(first);
        }
    }
}

/// Sums over what is known around each vertex, kept up to date as positions become known.
#[derive(Debug)]
pub(super) struct Sums {
    first: u32,
    /// Known neighbours, and the sum of their positions (integers, so exact).
    neighbours: Vec<(u32, Vector)>,
    /// Known faces, and the sum of their angles at the vertex.
    angles: Vec<(u32, f64)>,
}

impl Sums {
    /// Memory a vertex.
    pub(super) const BYTES: u64 = (size_of::<(u32, Vector)>() + size_of::<(u32, f64)>()) as u64;

    pub(super) fn new(range: &std::ops::Range<u32>) -> Self {
        Self { first: range.start, neighbours: vec![(0, Vector::ZERO); range.len()], angles: vec![(0, 0.0); range.len()] }
    }

    pub(super) fn neighbours(&self, v: u32) -> (u32, Vector) {
        self.neighbours[(v - self.first) as usize]
    }

    pub(super) fn angles(&self, v: u32) -> (u32, f64) {
        self.angles[(v - self.first) as usize]
    }

    /// Adds `v`, which has just become known.
    pub(super) fn learn(
        &mut self,
        surface: &Surface,
        outgoing: &[u32],
        order: &Order<'_>,
        position: impl Fn(u32) -> Vector,
        v: u32,
    ) {
        let here = position(v);
        let start = outgoing[v as usize];
        let mut h = start;
        loop {
            let (a, b) = (surface.from(next(h)), surface.from(prev(h)));
            if let Some((count, sum)) = self.neighbours.get_mut(a.wrapping_sub(self.first) as usize) {
                *count += 1;
                *sum += here;
            }
            if order.is_known(a) && order.is_known(b) {
                let corners = [(v, here), (a, position(a)), (b, position(b))];
                let sides = [0, 1, 2].map(|i| corners[(i + 1) % 3].1 - corners[i].1);
                let lengths = sides.map(Vector::length);
                for i in 0..3 {
                    // The angle at corner i is between the side that leaves it and the one that enters it.
                    let (out, back) = (i, (i + 2) % 3);
                    let cosine = -sides[out].dot(sides[back]) / (lengths[out] * lengths[back] + 1e-9);
                    let (count, sum) = &mut self.angles[(corners[i].0 - self.first) as usize];
                    *count += 1;
                    *sum += super::math::acos(cosine);
                }
            }
            h = turn(&surface.opposite, h);
            if h == start {
                break;
            }
        }
    }
}
