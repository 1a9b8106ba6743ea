//! Wearing a mesh: collapsing and flipping edges until its valences look like those of a real one.
//!
//! Half-edge `3f + c` runs from corner `c` of triangle `f` to the next corner. Every edit keeps the mesh an oriented
//! manifold of the same topology: collapses obey the link condition (Dey, Edelsbrunner, Guha, Nekhayev 1999), where all
//! boundary loops count as joined to one more vertex, and flips never make an edge that exists.

use crate::Shape;
use crate::random::Random;

const NONE: u32 = u32::MAX;

pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The unit normal of every vertex, triangles weighted by area.
pub fn normals(shape: &Shape) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; shape.positions.len()];
    for t in &shape.triangles {
        let [a, b, c] = t.map(|v| shape.positions[v as usize]);
        let n = cross(sub(b, a), sub(c, a));
        for &v in t {
            sums[v as usize].iter_mut().zip(n).for_each(|(s, x)| *s += x);
        }
    }
    for s in &mut sums {
        let length = dot(*s, *s).sqrt();
        *s = if length > 0.0 { s.map(|x| x / length) } else { [0.0, 0.0, 1.0] };
    }
    sums
}

/// Drops triangles until around every vertex the triangles form one fan.
pub fn fans_only(mut shape: Shape) -> Shape {
    loop {
        let (opposite, _) = glue(&shape);
        // A vertex that begins two boundary stretches has two fans.
        let mut starts = vec![0_u32; shape.positions.len()];
        for (h, &o) in opposite.iter().enumerate() {
            if o == NONE {
                starts[shape.triangles[h / 3][h % 3] as usize] += 1;
            }
        }
        if starts.iter().all(|&n| n <= 1) {
            return shape.compacted();
        }
        shape.triangles.retain(|t| t.iter().all(|&v| starts[v as usize] <= 1));
    }
}

/// `shape` with edges collapsed down to about `faces` triangles, valences evened out, and then a `share` of edges flipped.
pub fn worn(shape: Shape, faces: usize, share: f64, seed: u64) -> Shape {
    let mut random = Random::new(seed);
    let mut mesh = Editable::new(shape);
    mesh.collapse_to(faces, &mut random);
    mesh.even_out();
    mesh.flip_some(share, true, &mut random);
    mesh.finish()
}

fn glue(shape: &Shape) -> (Vec<u32>, Vec<u32>) {
    let count = 3 * shape.triangles.len() as u32;
    let end = |h: u32, c: u32| shape.triangles[h as usize / 3][(h as usize % 3 + c as usize) % 3];
    let mut sorted: Vec<(u32, u32, u32)> =
        (0..count).map(|h| (end(h, 0).min(end(h, 1)), end(h, 0).max(end(h, 1)), h)).collect();
    sorted.sort_unstable();
    let mut opposite = vec![NONE; count as usize];
    for pair in sorted.windows(2) {
        if (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1) {
            opposite[pair[0].2 as usize] = pair[1].2;
            opposite[pair[1].2 as usize] = pair[0].2;
        }
    }
    let mut outgoing = vec![NONE; shape.positions.len()];
    for h in 0..count {
        let v = end(h, 0) as usize;
        if outgoing[v] == NONE || opposite[h as usize] == NONE {
            outgoing[v] = h;
        }
    }
    (opposite, outgoing)
}

fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

/// A manifold mesh while it is edited.
#[derive(Debug, Clone)]
pub struct Editable {
    shape: Shape,
    opposite: Vec<u32>,
    outgoing: Vec<u32>,
    dead: Vec<bool>,
    alive: usize,
}

impl Editable {
    /// Starts from a manifold mesh.
    pub fn new(shape: Shape) -> Self {
        let (opposite, outgoing) = glue(&shape);
        Self { dead: vec![false; shape.triangles.len()], alive: shape.triangles.len(), shape, opposite, outgoing }
    }

    /// The mesh as it is now.
    pub fn finish(self) -> Shape {
        let mut dead = self.dead.into_iter();
        let mut shape = self.shape;
        shape.triangles.retain(|_| dead.next() == Some(false));
        shape.compacted()
    }

    fn from(&self, h: u32) -> u32 {
        self.shape.triangles[h as usize / 3][h as usize % 3]
    }

    fn to(&self, h: u32) -> u32 {
        self.from(next(h))
    }

    fn opp(&self, h: u32) -> u32 {
        self.opposite[h as usize]
    }

    fn position(&self, v: u32) -> [f64; 3] {
        self.shape.positions[v as usize]
    }

    fn fan(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.outgoing[v as usize];
        std::iter::successors((first != NONE).then_some(first), move |&h| {
            let g = self.opp(prev(h));
            (g != NONE && g != first).then_some(g)
        })
    }

    fn on_boundary(&self, v: u32) -> bool {
        self.opp(self.outgoing[v as usize]) == NONE
    }

    /// The neighbours of `v`; on the boundary the vertex beyond it is one, called [`NONE`].
    fn ring(&self, v: u32, ring: &mut Vec<u32>) {
        ring.clear();
        let mut last = NONE;
        for h in self.fan(v) {
            ring.push(self.to(h));
            last = h;
        }
        if self.on_boundary(v) {
            ring.push(self.from(prev(last)));
            ring.push(NONE);
        }
    }

    fn normal(&self, t: [u32; 3]) -> [f64; 3] {
        let [a, b, c] = t.map(|v| self.position(v));
        cross(sub(b, a), sub(c, a))
    }

    fn live_edges(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.opposite.len() as u32).filter(|&h| !self.dead[h as usize / 3] && (self.opp(h) == NONE || h < self.opp(h)))
    }

    /// Collapses short edges, in passes of edges that do not touch, until about `faces` triangles are left.
    pub fn collapse_to(&mut self, faces: usize, random: &mut Random) {
        let (mut ring, mut other) = (Vec::new(), Vec::new());
        while self.alive > faces {
            let mut edges: Vec<(f64, u32)> = self
                .live_edges()
                .map(|h| {
                    let d = sub(self.position(self.from(h)), self.position(self.to(h)));
                    (dot(d, d) * (0.3 + random.unit()), h)
                })
                .collect();
            edges.sort_unstable_by(|x, y| x.0.total_cmp(&y.0));
            let mut touched = vec![false; self.outgoing.len()];
            let before = self.alive;
            // The longer half stays, or a pass would leave a coarse and a fine part.
            for &(_, h) in &edges[..edges.len().div_ceil(2)] {
                if self.alive <= faces {
                    break;
                }
                let (a, b) = (self.from(h), self.to(h));
                if self.dead[h as usize / 3] || touched[a as usize] || touched[b as usize] {
                    continue;
                }
                if self.collapse(h, &mut ring, &mut other) {
                    self.ring(b, &mut ring);
                    ring.iter().filter(|&&v| v != NONE).for_each(|&v| touched[v as usize] = true);
                    touched[b as usize] = true;
                }
            }
            if self.alive == before {
                break;
            }
        }
    }

    /// Merges both ends of `h` into its end, if that keeps the topology and turns no triangle over.
    fn collapse(&mut self, h: u32, ring: &mut Vec<u32>, other: &mut Vec<u32>) -> bool {
        let (a, b, g) = (self.from(h), self.to(h), self.opp(h));
        self.ring(a, ring);
        self.ring(b, other);
        let c = self.from(prev(h));
        let d = if g == NONE { NONE } else { self.from(prev(g)) };
        let common = ring.iter().filter(|v| other.contains(v)).count();
        if common != 2 || !(other.contains(&c) && other.contains(&d) && ring.contains(&c) && ring.contains(&d)) {
            return false;
        }
        let degree = |v: u32| self.fan(v).count() + if self.on_boundary(v) { 2 } else { 0 };
        if degree(c) < 4 || (d != NONE && degree(d) < 4) {
            return false;
        }
        let (pa, pb) = (self.position(a), self.position(b));
        let target = match (self.on_boundary(a), self.on_boundary(b)) {
            (true, false) => pa,
            (false, true) => pb,
            _ => [0, 1, 2].map(|k| 0.5 * (pa[k] + pb[k])),
        };
        let (f1, f2) = (h / 3, if g == NONE { NONE } else { g / 3 });
        for v in [a, b] {
            for k in self.fan(v).filter(|k| k / 3 != f1 && k / 3 != f2) {
                let (p, q, r) = (self.position(v), self.position(self.to(k)), self.position(self.from(prev(k))));
                let (old, new) = (cross(sub(q, p), sub(r, p)), cross(sub(q, target), sub(r, target)));
                if dot(old, new) <= 0.2 * (dot(old, old) * dot(new, new)).sqrt() {
                    return false;
                }
            }
        }
        let spokes: Vec<u32> = self.fan(a).chain(self.fan(b)).filter(|k| k / 3 != f1 && k / 3 != f2).collect();
        for &k in &spokes {
            self.shape.triangles[k as usize / 3][k as usize % 3] = b;
        }
        self.shape.positions[b as usize] = target;
        self.outgoing[a as usize] = NONE;
        for (edge, apex) in [(h, c), (g, d)] {
            if edge == NONE {
                continue;
            }
            let (x, y) = (self.opp(next(edge)), self.opp(prev(edge)));
            if self.outgoing[apex as usize] / 3 == edge / 3 {
                self.outgoing[apex as usize] = x;
            }
            if x != NONE {
                self.opposite[x as usize] = y;
            }
            if y != NONE {
                self.opposite[y as usize] = x;
            }
            self.dead[edge as usize / 3] = true;
            self.alive -= 1;
        }
        self.outgoing[b as usize] = spokes.iter().copied().find(|&k| self.opp(k) == NONE).unwrap_or(spokes[0]);
        true
    }

    /// Flips every edge that brings the valences around it nearer to 6.
    pub fn even_out(&mut self) {
        let mut excess: Vec<i64> = (0..self.outgoing.len() as u32)
            .map(|v| {
                if self.outgoing[v as usize] == NONE {
                    return 0;
                }
                self.fan(v).count() as i64 - if self.on_boundary(v) { 3 } else { 6 }
            })
            .collect();
        let edges: Vec<u32> = self.live_edges().collect();
        for h in edges {
            let g = self.opp(h);
            if g == NONE {
                continue;
            }
            let (a, b, c, d) = (self.from(h), self.to(h), self.from(prev(h)), self.from(prev(g)));
            let at = |v: u32, by: i64| (excess[v as usize] + by).pow(2);
            let gain = at(a, 0) + at(b, 0) + at(c, 0) + at(d, 0) - at(a, -1) - at(b, -1) - at(c, 1) - at(d, 1);
            if gain > 0 && self.flip(h, true) {
                excess[a as usize] -= 1;
                excess[b as usize] -= 1;
                excess[c as usize] += 1;
                excess[d as usize] += 1;
            }
        }
    }

    /// Flips about a `share` of all edges; `gently` leaves those that would fold the surface.
    pub fn flip_some(&mut self, share: f64, gently: bool, random: &mut Random) {
        let edges: Vec<u32> = self.live_edges().collect();
        for h in edges {
            if random.unit() < share && self.opp(h) != NONE {
                self.flip(h, gently);
            }
        }
    }

    /// Joins the two apexes at `h` instead of its ends, if they are not joined yet.
    fn flip(&mut self, h: u32, gently: bool) -> bool {
        let g = self.opp(h);
        let (f1, f2) = (h / 3, g / 3);
        let (a, b, c, d) = (self.from(h), self.to(h), self.from(prev(h)), self.from(prev(g)));
        let mut ring = Vec::new();
        self.ring(c, &mut ring);
        if c == d || ring.contains(&d) {
            return false;
        }
        let small = |v: u32| self.fan(v).count() < if self.on_boundary(v) { 3 } else { 4 };
        if small(a) || small(b) {
            return false;
        }
        if gently {
            let (n, m) = (self.normal([a, b, c]), self.normal([b, a, d]));
            let old = [n[0] + m[0], n[1] + m[1], n[2] + m[2]];
            let thin = |t| {
                let new = self.normal(t);
                dot(new, old) <= 0.5 * (dot(new, new) * dot(old, old)).sqrt() || 16.0 * dot(new, new) < dot(old, old)
            };
            if thin([a, d, c]) || thin([d, b, c]) {
                return false;
            }
        }
        let [ad, ca, db, bc] = [next(g), prev(h), prev(g), next(h)].map(|k| self.opp(k));
        self.shape.triangles[f1 as usize] = [a, d, c];
        self.shape.triangles[f2 as usize] = [d, b, c];
        let sides = [(3 * f1, ad), (3 * f1 + 1, 3 * f2 + 2), (3 * f1 + 2, ca), (3 * f2, db), (3 * f2 + 1, bc)];
        for (k, o) in sides {
            self.opposite[k as usize] = o;
            if o != NONE {
                self.opposite[o as usize] = k;
            }
        }
        for v in [a, b, c, d] {
            let face = self.outgoing[v as usize] / 3;
            if face == f1 || face == f2 {
                let mut spokes = (3 * f1..3 * f1 + 3).chain(3 * f2..3 * f2 + 3).filter(|&k| self.from(k) == v);
                let first = spokes.next();
                self.outgoing[v as usize] =
                    first.into_iter().chain(spokes).find(|&k| self.opp(k) == NONE).or(first).unwrap_or(NONE);
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{any, by_name};

    /// Vertices − edges + triangles, after checking slowly that the mesh is an oriented manifold.
    fn euler(shape: &Shape) -> i64 {
        let mut directed = std::collections::BTreeSet::new();
        let mut edges = std::collections::BTreeSet::new();
        for &[a, b, c] in &shape.triangles {
            for (u, v) in [(a, b), (b, c), (c, a)] {
                assert_ne!(u, v, "a triangle names a vertex twice");
                assert!(directed.insert((u, v)), "two triangles walk edge {u}-{v} in the same direction");
                edges.insert((u.min(v), u.max(v)));
            }
        }
        let (opposite, outgoing) = glue(shape);
        let count = shape.triangles.len();
        let mesh = Editable { shape: shape.clone(), opposite, outgoing, dead: vec![false; count], alive: count };
        let around: usize = (0..shape.positions.len() as u32).map(|v| mesh.fan(v).count()).sum();
        assert_eq!(around, 3 * count, "a vertex has two fans");
        shape.positions.len() as i64 - edges.len() as i64 + count as i64
    }

    #[test]
    fn every_shape_is_an_oriented_manifold_of_its_topology() {
        for (name, chi) in [("bumpy_sphere", 2), ("sphere", 2), ("block", 0), ("genus", 2 - 2 * 5), ("grid", 1)] {
            for faces in [300, 3000] {
                let shape = by_name(name, faces, 9).unwrap();
                assert_eq!(euler(&shape), chi, "{name} of {faces} faces");
            }
        }
        assert_eq!(euler(&by_name("torus_with_holes", 6000, 2).unwrap()), -5);
        assert_eq!(euler(&by_name("terrain", 6000, 3).unwrap()), 1);
        for seed in 0..300 {
            euler(&any(seed, 200));
        }
    }

    #[test]
    fn one_seed_gives_one_mesh_and_two_seeds_give_two() {
        assert_eq!(any(5, 400), any(5, 400));
        assert_ne!(by_name("terrain", 900, 1), by_name("terrain", 900, 2));
    }
}
