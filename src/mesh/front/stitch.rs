//! Gluing: along edges of two faces first, then along as many of the others as leave a manifold.
//!
//! After A. Guéziec, G. Taubin, F. Lazarus and B. Horn, "Cutting and stitching: converting sets of polygons to manifold
//! surfaces" (2001). Where an edge has more than two faces, all stay apart at first, and so do the fans of triangles around
//! its ends. Then two half-edges are glued wherever no two edges come to join the same two vertices by it: first those that
//! follow each other on a boundary (so that a cut closes like a zip), then any that lie on the same edge of the mesh.

use super::super::half_edge::{NONE, next, prev};
use super::super::{Corners, Union};

/// Vertices with more edges than this are not tried: the neighbours of both are compared.
const MOST_NEIGHBOURS: usize = 512;
/// Pairs of half-edges that are tried on one edge.
const TRIES: usize = 64;

/// Glues the sides of edges of two faces that agree.
pub(super) fn glue(corners: &Corners, side: &[u32], triangles: &[[u32; 3]], opposite: &mut [u32]) {
    let from = |h: u32| triangles[h as usize / 3][h as usize % 3];
    for edge in corners.edges() {
        let &[c, d] = edge else { continue };
        let (h, g) = (side[c as usize], side[d as usize]);
        if h != NONE && g != NONE && from(h) != from(g) {
            opposite[h as usize] = g;
            opposite[g as usize] = h;
        }
    }
}

/// Glues what else can be glued; the fan that each corner of a triangle belongs to, as some number below that of corners.
pub(super) fn stitch(corners: &Corners, side: &[u32], triangles: &[[u32; 3]], opposite: &mut [u32]) -> Vec<u32> {
    let fans = fans(opposite);
    let open = |c: &u32| side[*c as usize] != NONE && opposite[side[*c as usize] as usize] == NONE;
    // Edges of two faces that disagree have no half-edges that run against each other.
    let groups: Vec<&[u32]> =
        corners.edges().filter(|edge| edge.len() > 2 && edge.iter().filter(|c| open(c)).count() > 1).collect();
    if groups.is_empty() {
        return fans;
    }
    let mut seam = Seam::new(triangles, opposite, fans);
    seam.todo = groups.iter().flat_map(|edge| edge.iter()).map(|&c| side[c as usize]).filter(|&h| h != NONE).collect();
    seam.zip();
    for edge in groups {
        let halves = || edge.iter().map(|&c| side[c as usize]).filter(|&h| h != NONE);
        let mut tries = 0;
        for h in halves() {
            for g in halves() {
                if tries < TRIES && seam.is_open(h) && seam.is_open(g) && seam.from(h) < seam.from(g) {
                    tries += 1;
                    if seam.try_glue(h, g) {
                        seam.zip();
                    }
                }
            }
        }
    }
    let Seam { fans, mut sets, .. } = seam;
    fans.into_iter().map(|fan| sets.find(fan)).collect()
}

/// For each half-edge the fan of triangles around the vertex that it leaves, named after one of its half-edges.
fn fans(opposite: &[u32]) -> Vec<u32> {
    let mut fan = vec![NONE; opposite.len()];
    for first in 0..opposite.len() as u32 {
        if fan[first as usize] != NONE {
            continue;
        }
        // Both ways, as a boundary may end either.
        let mut h = first;
        while h != NONE && fan[h as usize] == NONE {
            fan[h as usize] = first;
            h = opposite[prev(h) as usize];
        }
        let mut g = opposite[first as usize];
        while g != NONE && fan[next(g) as usize] == NONE {
            fan[next(g) as usize] = first;
            g = opposite[next(g) as usize];
        }
    }
    fan
}

struct Seam<'a> {
    triangles: &'a [[u32; 3]],
    opposite: &'a mut [u32],
    fans: Vec<u32>,
    /// Fans that have become one.
    sets: Union,
    /// The boundary half-edges after and before each; only where it is one itself.
    after: Vec<u32>,
    before: Vec<u32>,
    /// Boundary half-edges that may be glued to the one after.
    todo: Vec<u32>,
}

impl<'a> Seam<'a> {
    fn new(triangles: &'a [[u32; 3]], opposite: &'a mut [u32], fans: Vec<u32>) -> Self {
        let n = opposite.len();
        let (mut after, mut before) = (vec![NONE; n], vec![NONE; n]);
        for h in (0..n as u32).filter(|&h| opposite[h as usize] == NONE) {
            let mut g = next(h);
            while opposite[g as usize] != NONE {
                g = next(opposite[g as usize]);
            }
            after[h as usize] = g;
            before[g as usize] = h;
        }
        Self { triangles, opposite, fans, sets: Union::new(n), after, before, todo: Vec::new() }
    }

    fn is_open(&self, h: u32) -> bool {
        self.opposite[h as usize] == NONE
    }

    /// The vertex of the mesh that `h` leaves.
    fn from(&self, h: u32) -> u32 {
        self.triangles[h as usize / 3][h as usize % 3]
    }

    /// The fan that `h` leaves.
    fn fan(&mut self, h: u32) -> u32 {
        self.sets.find(self.fans[h as usize])
    }

    /// Glues half-edges to those that follow them on a boundary, as long as that works.
    fn zip(&mut self) {
        while let Some(h) = self.todo.pop() {
            for h in [h, self.before[h as usize]] {
                if h != NONE && self.is_open(h) {
                    let g = self.after[h as usize];
                    if self.from(next(g)) == self.from(h) {
                        self.try_glue(h, g);
                    }
                }
            }
        }
    }

    /// Glues two boundary half-edges that run against each other on one edge of the mesh, if the surface stays simple.
    fn try_glue(&mut self, h: u32, g: u32) -> bool {
        // h runs x → y, g runs y' → x'.
        let [x, y] = [self.fan(h), self.fan(next(h))];
        let [y2, x2] = [self.fan(g), self.fan(next(g))];
        let (p, q) = (self.before[h as usize], self.after[g as usize]);
        let (s, r) = (self.before[g as usize], self.after[h as usize]);
        // Where the boundary is so short that gluing leaves two half-edges, these are glued at once.
        let closes_x = self.fan(p) == self.fan(next(q)) && p != g && self.from(p) == self.from(next(q));
        let closes_y = self.fan(s) == self.fan(next(r)) && s != h;
        let ends = [x, x2, y, y2];
        if x != x2 {
            let skip = if closes_x { [p, q] } else { [NONE; 2] };
            if self.are_joined(h, q, [h, g, skip[0], skip[1]], ends) {
                return false;
            }
        }
        if y != y2 {
            let skip = if closes_y { [r, s] } else { [NONE; 2] };
            if self.are_joined(g, r, [h, g, skip[0], skip[1]], ends) {
                return false;
            }
        }
        self.opposite[h as usize] = g;
        self.opposite[g as usize] = h;
        self.sets.join(x, x2);
        self.sets.join(y, y2);
        for (before, after) in [(p, q), (s, r)] {
            self.after[before as usize] = after;
            self.before[after as usize] = before;
            self.todo.push(before);
        }
        true
    }

    /// Whether two open fans, given by their first half-edges on the boundary, have a neighbour in common or one among `ends`.
    /// Edges in `skip` do not count. Also where there are too many neighbours to tell.
    fn are_joined(&mut self, first: u32, other: u32, skip: [u32; 4], ends: [u32; 4]) -> bool {
        let mut neighbours = Vec::new();
        for start in [first, other] {
            let mut h = start;
            loop {
                if !skip.contains(&h) {
                    neighbours.push(self.fan(next(h)));
                }
                let back = prev(h);
                if self.is_open(back) {
                    if !skip.contains(&back) {
                        neighbours.push(self.fan(back));
                    }
                    break;
                }
                h = self.opposite[back as usize];
                if neighbours.len() > MOST_NEIGHBOURS {
                    return true;
                }
            }
        }
        neighbours.sort_unstable();
        neighbours.windows(2).any(|w| w[0] == w[1]) || neighbours.iter().any(|n| ends.contains(n))
    }
}
