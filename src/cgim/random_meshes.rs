//! Random triangulations that are as unpleasant as manifolds allow: ears, chords, separating triangles.

use std::collections::HashSet;

use super::rng::Random;
use crate::mesh::HalfEdges;

/// A mesh that grows by random operations, each of which keeps its topology.
pub(super) struct Growing {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) vertices: u32,
    edges: HashSet<(u32, u32)>,
}

impl Growing {
    fn new(triangles: Vec<[u32; 3]>) -> Self {
        let vertices = triangles.iter().flatten().max().map_or(0, |v| v + 1);
        let edges = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        Self { triangles, vertices, edges }
    }

    /// One triangle; grows by [`Growing::grow_disk`].
    pub(super) fn triangle() -> Self {
        Self::new(vec![[0, 1, 2]])
    }

    /// A tetrahedron.
    pub(super) fn sphere() -> Self {
        Self::new(vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    }

    /// A square of `n` by `n` vertices, glued along opposite sides.
    pub(super) fn torus(n: u32) -> Self {
        let at = |i: u32, j: u32| (i % n) * n + j % n;
        let cell = |(i, j)| [[at(i, j), at(i, j + 1), at(i + 1, j)], [at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]];
        Self::new((0..n).flat_map(|i| (0..n).map(move |j| (i, j))).flat_map(cell).collect())
    }

    pub(super) fn half_edges(&self) -> HalfEdges {
        HalfEdges::new(self.vertices as usize, self.triangles.clone()).expect("an oriented manifold")
    }

    fn add(&mut self, [a, b, c]: [u32; 3]) {
        self.triangles.push([a, b, c]);
        self.edges.extend([(a, b), (b, c), (c, a)]);
    }

    fn has_edge(&self, a: u32, b: u32) -> bool {
        self.edges.contains(&(a, b)) || self.edges.contains(&(b, a))
    }

    /// A new vertex inside a triangle: its border becomes a separating triangle.
    fn split(&mut self, random: &mut Random) {
        let f = random.below(self.triangles.len());
        let [a, b, c] = self.triangles.swap_remove(f);
        let v = self.vertices;
        self.vertices += 1;
        for t in [[a, b, v], [b, c, v], [c, a, v]] {
            self.add(t);
        }
    }

    /// The other diagonal of two triangles, where there is room for it.
    fn flip(&mut self, random: &mut Random) {
        let f = random.below(self.triangles.len());
        let mut t = self.triangles[f];
        t.rotate_left(random.below(3));
        let [a, b, c] = t;
        let Some(g) = self.triangles.iter().position(|t| (0..3).any(|i| t[i] == b && t[(i + 1) % 3] == a)) else { return };
        let Some(&d) = self.triangles[g].iter().find(|&&v| v != a && v != b) else { return };
        if c == d || self.has_edge(c, d) {
            return;
        }
        for edge in [(a, b), (b, a)] {
            self.edges.remove(&edge);
        }
        self.triangles[f] = [a, d, c];
        self.triangles[g] = [d, b, c];
        self.edges.extend([(c, d), (d, c)]);
    }

    /// `steps` random splits and flips.
    pub(super) fn grow(mut self, steps: usize, random: &mut Random) -> Self {
        for _ in 0..steps {
            if random.below(3) == 0 { self.split(random) } else { self.flip(random) }
        }
        self
    }

    /// `steps` random splits, flips, ears and closings along the boundary of a disk.
    pub(super) fn grow_disk(mut self, steps: usize, random: &mut Random) -> Self {
        let mut boundary = vec![0, 1, 2];
        for _ in 0..steps {
            let n = boundary.len();
            let i = random.below(n);
            let (a, b, c) = (boundary[i], boundary[(i + 1) % n], boundary[(i + 2) % n]);
            match random.below(5) {
                0 => self.split(random),
                1 => self.flip(random),
                2 if n > 3 && !self.has_edge(a, c) => {
                    self.add([c, b, a]);
                    boundary.remove((i + 1) % n);
                }
                _ => {
                    let v = self.vertices;
                    self.vertices += 1;
                    self.add([b, a, v]);
                    boundary.insert(i + 1, v);
                }
            }
        }
        self
    }

    /// Takes out up to `count` triangles no two of which touch.
    pub(super) fn with_holes(mut self, count: usize, random: &mut Random) -> Self {
        let boundary = |edges: &HashSet<(u32, u32)>, v: u32| edges.iter().any(|&(a, b)| a == v && !edges.contains(&(b, a)));
        for _ in 0..count {
            let f = random.below(self.triangles.len());
            let [a, b, c] = self.triangles[f];
            if [a, b, c].iter().any(|&v| boundary(&self.edges, v)) {
                continue;
            }
            self.triangles.swap_remove(f);
            for edge in [(a, b), (b, c), (c, a)] {
                self.edges.remove(&edge);
            }
        }
        self
    }
}

/// The boundary half-edges of a disk in order.
pub(super) fn boundary_of(disk: &HalfEdges) -> Vec<u32> {
    let first = (0..3 * disk.triangles().len() as u32).find(|&h| disk.opposite(h).is_none()).expect("a boundary");
    let after = |&h: &u32| disk.outgoing(disk.to(h)).filter(|&g| g != first);
    std::iter::successors(Some(first), after).collect()
}
