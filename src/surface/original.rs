//! The writer's guide: the surface as it is, half-edge by half-edge.

use super::topology::Filled;
use super::walk::{Guide, Node};
use crate::mesh::half_edge::{NONE, next, prev};

/// Answers a [`walk`](super::walk::walk) from the mesh itself, and remembers in which order its vertices were met.
pub(super) struct Original<'a> {
    mesh: &'a Filled,
    is_walked: Vec<bool>,
    is_met: Vec<bool>,
    /// The node that stands at each half-edge of the front; stale where the half-edge has been walked.
    node_at: Vec<u32>,
    first_unwalked: usize,
    /// The vertices of the mesh in the order in which they were met, those that fill holes left out.
    pub(super) order: Vec<u32>,
    /// For each face walked, the half-edge of the mesh that became its first.
    pub(super) faces: Vec<u32>,
}

impl<'a> Original<'a> {
    pub(super) fn new(mesh: &'a Filled) -> Self {
        Self {
            mesh,
            is_walked: vec![false; mesh.faces()],
            is_met: vec![false; mesh.valence.len()],
            node_at: vec![NONE; 3 * mesh.faces()],
            first_unwalked: 0,
            order: Vec::with_capacity(mesh.census.vertices as usize),
            faces: Vec::with_capacity(mesh.faces()),
        }
    }

    /// Whether the face beyond `h` is walked: then `h` is on the front.
    fn is_front(&self, h: u32) -> bool {
        self.is_walked[self.mesh.opposite(h) as usize / 3]
    }
}

impl Guide for Original<'_> {
    fn seed(&mut self) -> u32 {
        while self.is_walked[self.first_unwalked] {
            self.first_unwalked += 1;
        }
        3 * self.first_unwalked as u32
    }

    fn across(&self, h: u32) -> u32 {
        self.mesh.opposite(h)
    }

    fn is_new(&self, h: u32) -> bool {
        !self.is_met[self.mesh.apex(h) as usize]
    }

    fn meet(&mut self, h: u32) -> (u32, bool) {
        let v = self.mesh.from(h);
        self.is_met[v as usize] = true;
        let is_hole = v >= self.mesh.first_hole;
        if !is_hole {
            self.order.push(v);
        }
        (self.mesh.valence[v as usize], is_hole)
    }

    fn mark(&mut self, h: u32) {
        self.is_walked[h as usize / 3] = true;
        self.faces.push(h);
    }

    fn pin(&mut self, h: u32, node: u32) {
        self.node_at[h as usize] = node;
    }

    /// Turns both ways about the apex, in step, until one way meets the front: the cost is that of
    /// the smaller side. The node stands at the front half-edge that leaves the apex, at the
    /// clockwise end of its unwalked faces.
    fn target(&self, h: u32, nodes: &[Node]) -> (u32, u32) {
        let (mut leaving, mut entering) = (prev(h), next(h));
        for between in 0.. {
            leaving = next(self.mesh.opposite(leaving));
            if self.is_front(leaving) {
                return (self.node_at[leaving as usize], between);
            }
            entering = prev(self.mesh.opposite(entering));
            if self.is_front(entering) {
                let node = nodes[self.node_at[entering as usize] as usize].after;
                return (node, nodes[node as usize].free - 2 - between);
            }
        }
        (NONE, 0)
    }
}
