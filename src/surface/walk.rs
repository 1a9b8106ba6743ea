//! Connectivity: a walk over the closed surface that says how many neighbours each vertex has.
//!
//! After C. Touma and C. Gotsman, "Triangle mesh compression" (1998), with the choice of gates of
//! P. Alliez and M. Desbrun, "Valence-driven connectivity encoding" (2001), and the gate that closes
//! soonest instead of a focus vertex. spec/surface.md, "Walk", is the normative text.
//!
//! The part of the surface that is already known is bounded by *loops* of *nodes*. A node stands
//! for a vertex on a loop and for the edge to the next node, and knows how many edges of the vertex
//! are still missing on the unknown side (`free`). A step crosses one edge g → b, the *gate*, to the
//! face beyond it:
//!
//! ```text
//! new vertex   the apex was not met yet: its valence is coded
//! left, right  g or b misses no edge: the apex is the node before g or after b; nothing is coded
//! end          the loop is a triangle and misses nothing: it is the face
//! split        the apex is another node of the loop, which falls into two
//! merge        the apex is a node of another loop: the two become one (once for every handle)
//! ```
//!
//! Writer and reader are one function; what the writer knows and the reader does not comes from a
//! [`Guide`].

use super::gates::{self, GateQueue};
use super::topology::{Census, Surface};
use super::valence::{Neighbourhood, Valences};
use crate::entropy::{AdaptiveBit, BitCoder, Numbers};
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::mesh::half_edge::NONE;
use crate::task::Task;

/// What a walk asks of the one who knows the surface. A reader's guide knows nothing; then the
/// answers do not matter.
pub(super) trait Guide {
    /// The first half-edge of a face not yet walked, for a new component.
    fn seed(&mut self) -> u32 {
        NONE
    }

    /// The half-edge beyond `h`, and those after and before it in the same face.
    fn across(&self, _h: u32) -> u32 {
        NONE
    }

    /// The apex of the face on `h`, if it was not met yet.
    fn is_new(&self, _h: u32) -> bool {
        false
    }

    /// Meets the vertex that `h` starts from: its valence, and whether it fills a hole.
    fn meet(&mut self, _h: u32) -> (u32, bool) {
        (0, false)
    }

    /// Says that the face on `h` is walked.
    fn mark(&mut self, _h: u32) {}

    /// Says that `node` now stands at `h`, its half-edge on the unknown side.
    fn pin(&mut self, _h: u32, _node: u32) {}

    /// The node on whose unknown side the apex of the face on `h` lies, and how many of its missing
    /// edges come before the face (clockwise of it).
    fn target(&self, _h: u32, _nodes: &[Node]) -> (u32, u32) {
        (NONE, 0)
    }
}

/// A vertex on a loop, and the edge from it to the next.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    vertex: u32,
    before: u32,
    pub(super) after: u32,
    /// Edges of the vertex still missing on the unknown side; [`DEAD`] once the node has left its loop.
    pub(super) free: u32,
    /// The half-edge of the edge to the next node, on the known side.
    inner: u32,
    /// The same on the unknown side, in the guide's terms.
    outer: u32,
    key: u32,
}

const DEAD: u32 = u32::MAX;

/// Bytes of a face and its half-edges.
const BYTES_A_FACE: u64 = 12 + 12;
/// Bytes of a vertex of the closed surface, with two faces.
const BYTES_A_VERTEX: u64 = 2 * BYTES_A_FACE + 5 + 28 + 24;

/// The memory that a walk needs. Handles make faces that no vertex has paid for.
pub(super) fn memory(census: Census) -> u64 {
    let vertices = u64::from(census.vertices) + u64::from(census.holes);
    vertices * BYTES_A_VERTEX + census.closed_faces().saturating_sub(2 * vertices) * BYTES_A_FACE
}

/// Contexts of [`Walk::numbers`]: ranks forward and backward, shares by how much is to be shared, valences at holes.
const SHARE_CONTEXT: usize = 2;
const SHARE_CAP: usize = 30;
const HOLE_CONTEXT: usize = SHARE_CONTEXT + SHARE_CAP + 1;

pub(super) struct Walk<'a, C, G> {
    coder: &'a mut C,
    guide: &'a mut G,
    budget: &'a mut Budget,
    surface: Surface,
    nodes: Vec<Node>,
    gates: GateQueue,
    vertices_left: u32,
    holes_left: u32,
    handles_left: u32,
    /// Corners of the closed surface that no vertex has claimed yet.
    corners_left: u64,
    valences: Valences,
    split_flag: SplitFlag,
    merge_flag: AdaptiveBit,
    hole_flag: AdaptiveBit,
    backward_flag: AdaptiveBit,
    numbers: Numbers,
}

/// Whether a gate with missing edges at both ends meets a node; by the missing edges around it.
struct SplitFlag {
    bits: Vec<AdaptiveBit>,
}

/// Walks the whole surface, writing or reading it.
///
/// # Errors
/// A stream that describes no closed surface of that census, or passes the limits.
pub(super) fn walk<C: BitCoder, G: Guide>(
    coder: &mut C,
    guide: &mut G,
    census: Census,
    effort: super::Effort,
    budget: &mut Budget,
    task: Task<'_>,
) -> Result<Surface> {
    let vertices = u64::from(census.vertices) + u64::from(census.holes);
    budget.check_vertices(vertices)?;
    budget.reserve(memory(census))?;
    if 3 * census.closed_faces() > u64::from(u32::MAX) {
        let why = format!("connectivity: {} faces are more than half-edges can be numbered for", census.closed_faces());
        return Err(Error::malformed(Place::Whole, why));
    }
    let mut walk = Walk {
        coder,
        guide,
        budget,
        surface: Surface::default(),
        nodes: Vec::new(),
        gates: GateQueue::default(),
        vertices_left: census.vertices,
        holes_left: census.holes,
        handles_left: census.handles,
        corners_left: 3 * census.closed_faces(),
        valences: Valences::new(effort, vertices),
        split_flag: SplitFlag { bits: vec![AdaptiveBit::default(); SplitFlag::CONTEXTS] },
        merge_flag: AdaptiveBit::default(),
        hole_flag: AdaptiveBit::default(),
        backward_flag: AdaptiveBit::default(),
        numbers: Numbers::new(HOLE_CONTEXT + 1),
    };
    for _ in 0..census.components {
        walk.seed()?;
        let mut steps = 0_u32;
        while let Some(gate) = walk.next_gate() {
            walk.cross(gate)?;
            steps = steps.wrapping_add(1);
            if steps.is_multiple_of(1 << 16) {
                task.step(walk.surface.valence.len() as f64 / vertices as f64)?;
            }
        }
    }
    if walk.vertices_left > 0 || walk.holes_left > 0 || walk.handles_left > 0 || walk.corners_left > 0 {
        return Err(walk.error("the walk ended before all vertices, holes, handles and faces were met"));
    }
    Ok(walk.surface)
}

impl<C: BitCoder, G: Guide> Walk<'_, C, G> {
    #[cold]
    fn error(&self, why: &str) -> Error {
        let (v, f) = (self.surface.valence.len(), self.surface.triangles.len());
        Error::malformed(Place::Whole, format!("connectivity after {v} vertices and {f} faces: {why}"))
    }

    fn next_gate(&mut self) -> Option<u32> {
        let nodes = &self.nodes;
        self.gates.peek(|node, key| nodes[node as usize].key == key)
    }

    /// Starts a component with one face.
    fn seed(&mut self) -> Result<()> {
        self.nodes.clear();
        let h = self.guide.seed();
        let sides = [h, h.wrapping_add(1), h.wrapping_add(2)];
        let mut corners = [0; 3];
        for (i, &side) in sides.iter().enumerate() {
            let ends = [(i > 0).then_some(corners[0]), (i > 1).then_some(corners[1])];
            let around = Neighbourhood { ends, ..Neighbourhood::default() };
            corners[i] = self.vertex(side, around)?;
        }
        self.guide.mark(h);
        let face = self.face(corners);
        // The loop runs against the face: from corner 1 to corner 0, on to corner 2, and back.
        let [a, b, c] = corners;
        let loop_ = [(b, 0), (a, 2), (c, 1)];
        for (i, (vertex, side)) in loop_.into_iter().enumerate() {
            let free = self.surface.valence[vertex as usize] - 2;
            let outer = self.guide.across(sides[side]);
            let i = i as u32;
            self.nodes.push(Node {
                vertex,
                before: (i + 2) % 3,
                after: (i + 1) % 3,
                free,
                inner: face + side as u32,
                outer,
                key: DEAD,
            });
            self.guide.pin(outer, i);
        }
        (0..3).for_each(|i| self.update(i));
        Ok(())
    }

    /// Meets a vertex: whether it fills a hole, and its valence.
    fn vertex(&mut self, h: u32, around: Neighbourhood) -> Result<u32> {
        let (valence, is_hole) = self.guide.meet(h);
        let is_hole = self.holes_left > 0 && (self.vertices_left == 0 || self.hole_flag.code(self.coder, is_hole));
        let valence = if is_hole {
            self.holes_left -= 1;
            self.numbers.code(self.coder, valence.wrapping_sub(3), HOLE_CONTEXT).saturating_add(3)
        } else {
            self.vertices_left = match self.vertices_left.checked_sub(1) {
                Some(left) => left,
                None => return Err(self.error("one vertex more than the header says")),
            };
            self.valences.code(self.coder, valence, self.corners_left, &around, &self.surface)
        };
        self.corners_left = match self.corners_left.checked_sub(valence.into()) {
            Some(left) => left,
            None => return Err(self.error("the valences add up to more than the surface has")),
        };
        self.budget.spend(valence.into())?;
        if self.coder.is_exhausted() {
            return Err(self.error("the stream ends too soon"));
        }
        self.surface.valence.push(valence);
        self.surface.is_hole.push(is_hole);
        Ok(self.surface.valence.len() as u32 - 1)
    }

    /// Adds a face; its half-edges are the returned number and the two after it.
    fn face(&mut self, corners: [u32; 3]) -> u32 {
        let h = self.surface.opposite.len() as u32;
        self.surface.triangles.push(corners);
        self.surface.opposite.extend([NONE; 3]);
        h
    }

    fn glue(&mut self, g: u32, h: u32) {
        self.surface.opposite[g as usize] = h;
        self.surface.opposite[h as usize] = g;
    }

    fn link(&mut self, before: u32, after: u32) {
        self.nodes[before as usize].after = after;
        self.nodes[after as usize].before = before;
    }

    /// Takes one of the missing edges of a node.
    fn take_free(&mut self, node: u32) -> Result<()> {
        match self.nodes[node as usize].free.checked_sub(1) {
            Some(free) => {
                self.nodes[node as usize].free = free;
                Ok(())
            }
            None => Err(self.error("a vertex gets more edges than its valence")),
        }
    }

    /// Puts a node into the queue again if its urgency changed.
    fn update(&mut self, node: u32) {
        let n = self.nodes[node as usize];
        let is_hole = self.surface.is_hole[n.vertex as usize];
        let key = gates::key(is_hole, n.free, self.nodes[n.before as usize].free, self.nodes[n.after as usize].free);
        if key != n.key {
            self.nodes[node as usize].key = key;
            self.gates.push(key, node);
        }
    }

    fn remove(&mut self, node: u32) {
        self.nodes[node as usize].free = DEAD;
        self.nodes[node as usize].key = DEAD;
    }

    fn stand(&mut self, node: u32, inner: u32, outer: u32) {
        let n = &mut self.nodes[node as usize];
        n.inner = inner;
        n.outer = outer;
        self.guide.pin(outer, node);
    }

    /// Crosses the gate from node `g` to the next.
    fn cross(&mut self, g: u32) -> Result<()> {
        let gate = self.nodes[g as usize];
        let b = gate.after;
        let p = gate.before;
        let n = self.nodes[b as usize].after;
        let (free_g, free_b) = (gate.free, self.nodes[b as usize].free);
        let outer = gate.outer;
        self.guide.mark(outer);
        if n == g || b == g {
            return Err(self.error("a loop of fewer than three edges"));
        }
        if n == p && (free_g == 0 || free_b == 0) {
            return self.end(g, b, n);
        }
        if free_g == 0 {
            // Left: the face (g, b, p) takes g off the loop.
            let h = self.corner_face(g, b, p);
            self.glue(h, gate.inner);
            self.glue(h + 2, self.nodes[p as usize].inner);
            self.take_free(p)?;
            self.take_free(b)?;
            self.remove(g);
            self.link(p, b);
            self.stand(p, h + 1, self.guide.across(outer_next(outer)));
            let (pp, n) = (self.nodes[p as usize].before, n);
            for node in [pp, p, b, n] {
                self.update(node);
            }
        } else if free_b == 0 {
            // Right: the face (g, b, n) takes b off the loop.
            let h = self.corner_face(g, b, n);
            self.glue(h, gate.inner);
            self.glue(h + 1, self.nodes[b as usize].inner);
            self.take_free(g)?;
            self.take_free(n)?;
            self.remove(b);
            self.link(g, n);
            self.stand(g, h + 2, self.guide.across(outer_prev(outer)));
            let nn = self.nodes[n as usize].after;
            for node in [p, g, n, nn] {
                self.update(node);
            }
        } else {
            let meets_node = !self.guide.is_new(outer);
            if self.code_split(g, meets_node) {
                self.join(g)?;
            } else {
                self.grow(g)?;
            }
        }
        Ok(())
    }

    fn corner_face(&mut self, a: u32, b: u32, c: u32) -> u32 {
        let corners = [a, b, c].map(|node| self.nodes[node as usize].vertex);
        self.face(corners)
    }

    /// The last face of a loop.
    fn end(&mut self, g: u32, b: u32, n: u32) -> Result<()> {
        if [g, b, n].iter().any(|&node| self.nodes[node as usize].free != 0) {
            return Err(self.error("a loop of three edges whose vertices miss edges"));
        }
        let h = self.corner_face(g, b, n);
        for (side, node) in [g, b, n].into_iter().enumerate() {
            self.glue(h + side as u32, self.nodes[node as usize].inner);
            self.remove(node);
        }
        Ok(())
    }

    /// A new vertex beyond the gate.
    fn grow(&mut self, g: u32) -> Result<()> {
        let gate = self.nodes[g as usize];
        let (b, p) = (gate.after, gate.before);
        let after = self.nodes[b as usize];
        let n = after.after;
        let node = |i: u32| &self.nodes[i as usize];
        let around = Neighbourhood {
            ends: [Some(gate.vertex), Some(after.vertex)],
            old: Some(self.surface.apex(gate.inner)),
            beside: [Some(node(p).vertex), Some(node(n).vertex)],
            beyond: [Some(node(node(p).before).vertex), Some(node(node(n).after).vertex)],
            free: [gate.free, after.free, node(p).free, node(n).free],
        };
        let x = self.vertex(outer_prev(gate.outer), around)?;
        let h = self.face([gate.vertex, after.vertex, x]);
        self.glue(h, gate.inner);
        self.take_free(g)?;
        self.take_free(b)?;
        let node = self.nodes.len() as u32;
        let free = self.surface.valence[x as usize] - 2;
        self.nodes.push(Node { vertex: x, before: g, after: b, free, inner: NONE, outer: NONE, key: DEAD });
        self.link(g, node);
        self.link(node, b);
        self.stand(node, h + 1, self.guide.across(outer_next(gate.outer)));
        self.stand(g, h + 2, self.guide.across(outer_prev(gate.outer)));
        for i in [g, node, b, p, n] {
            self.update(i);
        }
        Ok(())
    }

    fn code_split(&mut self, g: u32, meets_node: bool) -> bool {
        let gate = self.nodes[g as usize];
        let (b, p) = (gate.after, gate.before);
        let n = self.nodes[b as usize].after;
        let (pp, nn) = (self.nodes[p as usize].before, self.nodes[n as usize].after);
        let around = [g, b, p, n, pp, nn].map(|i| self.nodes[i as usize].free);
        // How long the loop is, as far as six nodes tell: 4, 5, 6 or more.
        let length = if nn == p {
            0
        } else if nn == pp {
            1
        } else if self.nodes[nn as usize].after == pp {
            2
        } else {
            3
        };
        let at_hole = [g, b].iter().any(|&i| self.surface.is_hole[self.nodes[i as usize].vertex as usize]);
        let bit = self.split_flag.bit(around, length, at_hole);
        bit.code(self.coder, meets_node)
    }

    /// Split or merge: the apex is a node that is on a loop already.
    fn join(&mut self, g: u32) -> Result<()> {
        let gate = self.nodes[g as usize];
        let b = gate.after;
        let (target, share) = self.guide.target(gate.outer, &self.nodes);
        let place = if C::WRITES { self.find(g, target)? } else { Some((false, 0)) };
        let merges = self.handles_left > 0 && self.merge_flag.code(self.coder, place.is_none());
        let t = if merges {
            self.handles_left -= 1;
            let bits = 32 - (self.nodes.len() as u32).leading_zeros();
            self.coder.raw(target, bits)
        } else {
            let (backward, rank) = place.unwrap_or_default();
            let backward = self.backward_flag.code(self.coder, backward);
            let rank = self.numbers.code(self.coder, rank, usize::from(backward));
            if C::WRITES { target } else { self.at_rank(g, backward, rank)? }
        };
        let Some(apex) = self.nodes.get(t as usize).copied().filter(|node| node.free != DEAD) else {
            return Err(self.error("a loop is joined to a node that is on none"));
        };
        if apex.free < 2 || [g, b].contains(&t) {
            return Err(self.error("a loop is joined to a node that misses fewer than two edges"));
        }
        // The missing edges of t, less the two of this face, fall to g's side and to b's side.
        let rest = apex.free - 2;
        let share = match rest {
            0 => 0,
            _ => self.numbers.code(self.coder, share, SHARE_CONTEXT + (rest as usize).min(SHARE_CAP)),
        };
        if share > rest {
            return Err(self.error("a vertex gets more edges than its valence"));
        }
        let h = self.face([gate.vertex, self.nodes[b as usize].vertex, apex.vertex]);
        self.glue(h, gate.inner);
        self.take_free(g)?;
        self.take_free(b)?;
        // t stays on g's loop; a copy of it goes on b's.
        let copy = self.nodes.len() as u32;
        self.nodes.push(Node { free: rest - share, key: DEAD, ..apex });
        self.nodes[t as usize].free = share;
        self.link(apex.before, copy);
        self.link(copy, b);
        self.link(g, t);
        self.stand(copy, h + 1, self.guide.across(outer_next(gate.outer)));
        self.stand(g, h + 2, self.guide.across(outer_prev(gate.outer)));
        for node in [g, b, t, copy, gate.before, apex.before, apex.after, self.nodes[b as usize].after] {
            self.update(node);
        }
        Ok(())
    }

    /// Where `target` stands on the loop of `g`: (whether it is nearer backwards, its rank that way
    /// among nodes that miss edges); `None` if it is on another loop.
    ///
    /// Both ways are walked in step, so that the cost is that of the smaller part.
    fn find(&mut self, g: u32, target: u32) -> Result<Option<(bool, u32)>> {
        let gate = self.nodes[g as usize];
        let mut forward = self.nodes[self.nodes[gate.after as usize].after as usize].after;
        let mut backward = self.nodes[gate.before as usize].before;
        let (mut ahead, mut behind) = (0, 0);
        loop {
            self.budget.spend(1)?;
            if forward == target {
                return Ok(Some((false, ahead)));
            }
            if backward == target {
                return Ok(Some((true, behind)));
            }
            // Each way goes the whole loop round if need be; a target beside the gate cannot be.
            if forward == g {
                return Ok(None);
            }
            ahead += u32::from(self.nodes[forward as usize].free > 1);
            behind += u32::from(self.nodes[backward as usize].free > 1);
            forward = self.nodes[forward as usize].after;
            backward = self.nodes[backward as usize].before;
        }
    }

    /// The node that [`Walk::find`] described.
    ///
    /// The longer way is refused: it would cost a hostile stream little and a reader the square of the vertices.
    fn at_rank(&mut self, g: u32, backward: bool, mut rank: u32) -> Result<u32> {
        let gate = self.nodes[g as usize];
        let step = |node: Node| if backward { node.before } else { node.after };
        let back = |node: Node| if backward { node.after } else { node.before };
        let (p, n) = (gate.before, self.nodes[gate.after as usize].after);
        let (first, last) = if backward { (p, n) } else { (n, p) };
        let mut node = step(self.nodes[first as usize]);
        // As far from the other end of the loop as `node` is from this one.
        let mut mirror = back(self.nodes[last as usize]);
        loop {
            self.budget.spend(1)?;
            if node == g || node == gate.after {
                return Err(self.error("a split at a node beyond the end of the loop"));
            }
            if self.nodes[node as usize].free > 1 {
                if rank == 0 {
                    return Ok(node);
                }
                rank -= 1;
            }
            let next = step(self.nodes[node as usize]);
            if node == mirror || next == mirror {
                return Err(self.error("a split at a node that is nearer the other way round"));
            }
            node = next;
            mirror = back(self.nodes[mirror as usize]);
        }
    }
}

/// The half-edge after `h` in the guide's face; any number where there is no guide.
fn outer_next(h: u32) -> u32 {
    if h == NONE { NONE } else { crate::mesh::half_edge::next(h) }
}

/// The half-edge before `h` in the guide's face; any number where there is no guide.
fn outer_prev(h: u32) -> u32 {
    if h == NONE { NONE } else { crate::mesh::half_edge::prev(h) }
}

impl SplitFlag {
    const CONTEXTS: usize = 2 * 4 * 4 * 4 * 5 * 5;

    fn bit(&mut self, [g, b, p, n, pp, nn]: [u32; 6], length: usize, at_hole: bool) -> &mut AdaptiveBit {
        let cap = |free: u32, cap: u32| free.min(cap) as usize;
        let nearest = cap(p.min(n).min(pp).min(nn), 3);
        let mut context = usize::from(at_hole);
        context = context * 4 + length;
        context = context * 4 + nearest;
        context = context * 4 + cap(g.min(b), 4) - 1;
        context = context * 5 + cap(p.min(n), 4);
        context = context * 5 + cap(pp.min(nn), 4);
        &mut self.bits[context]
    }
}
