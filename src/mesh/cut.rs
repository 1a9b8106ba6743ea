//! Cutting surfaces open: paths, the cut graph of a handlebody, and the cut itself.
//!
//! Distances are counted in edges, so that the same cuts come out wherever the same triangles are
//! seen, whatever happened to the positions.

use std::collections::VecDeque;

use super::half_edge::{HalfEdges, NONE, next, prev};

/// A tree of shortest paths, counted in edges.
#[derive(Debug)]
pub(crate) struct Paths {
    /// The half-edge that leads to a vertex from its parent; [`NONE`] at the root and where the root is not reached.
    arrive: Vec<u32>,
    /// All vertices that the root reaches, the nearest first.
    pub(crate) order: Vec<u32>,
}

impl Paths {
    /// All shortest paths from `root`. O(half-edges).
    pub(crate) fn from(mesh: &HalfEdges, root: u32) -> Self {
        let mut arrive = vec![NONE; mesh.vertices()];
        let mut reached = vec![false; mesh.vertices()];
        reached[root as usize] = true;
        let mut order = vec![root];
        let mut i = 0;
        while let Some(&v) = order.get(i) {
            i += 1;
            for h in mesh.fan(v) {
                // The last edge of a boundary fan has a half-edge in the other direction only; it leads
                // along the boundary, and is left out of the tree unless it is met from its other end.
                let w = mesh.to(h);
                if !std::mem::replace(&mut reached[w as usize], true) {
                    arrive[w as usize] = h;
                    order.push(w);
                }
            }
        }
        Self { arrive, order }
    }

    /// The half-edges from the root to `v`, the last first.
    pub(crate) fn back_from<'a>(&'a self, mesh: &'a HalfEdges, v: u32) -> impl Iterator<Item = u32> + 'a {
        let arrive = move |v: u32| Some(self.arrive[v as usize]).filter(|&h| h != NONE);
        std::iter::successors(arrive(v), move |&h| arrive(mesh.from(h)))
    }
}

/// Half-edges along which a surface is cut; both sides of an edge are marked.
#[derive(Debug, Clone)]
pub(crate) struct CutGraph {
    marked: Vec<bool>,
}

impl CutGraph {
    /// No cut.
    pub(crate) fn empty(mesh: &HalfEdges) -> Self {
        Self { marked: vec![false; 3 * mesh.triangles().len()] }
    }

    /// Marks an edge by either of its half-edges.
    pub(crate) fn mark(&mut self, mesh: &HalfEdges, h: u32) {
        self.set(mesh, h, true);
    }

    /// Marks an edge and the paths from its ends back to the root of a tree, as far as they are not `on_path` already.
    pub(crate) fn mark_loop<P: Iterator<Item = u32>>(
        &mut self,
        mesh: &HalfEdges,
        h: u32,
        on_path: &mut [bool],
        back_from: impl Fn(u32) -> P,
    ) {
        self.mark(mesh, h);
        for v in [mesh.from(h), mesh.to(h)] {
            for g in back_from(v) {
                if std::mem::replace(&mut on_path[mesh.to(g) as usize], true) {
                    break;
                }
                self.mark(mesh, g);
            }
        }
    }

    fn set(&mut self, mesh: &HalfEdges, h: u32, marked: bool) {
        self.marked[h as usize] = marked;
        if let Some(g) = mesh.opposite(h) {
            self.marked[g as usize] = marked;
        }
    }

    /// Whether an edge is cut.
    pub(crate) fn has(&self, h: u32) -> bool {
        self.marked[h as usize]
    }

    /// The cut that opens a closed connected surface of genus g to a disk: 2g loops through `root`
    /// (tree and cotree), less the dead ends, save that the graph stays connected to `root` if `keep_root`.
    ///
    /// On a sphere the graph has no edge. O(half-edges).
    pub(crate) fn of_closed(mesh: &HalfEdges, root: u32, keep_root: bool) -> Self {
        let paths = Paths::from(mesh, root);
        let mut tree = Self::empty(mesh);
        for &v in &paths.order {
            if let Some(h) = paths.back_from(mesh, v).next() {
                tree.mark(mesh, h);
            }
        }
        let crossed = Self::dual_tree(mesh, &tree);
        let mut cut = Self::empty(mesh);
        let mut on_path = vec![false; mesh.vertices()];
        for h in 0..tree.marked.len() as u32 {
            if tree.has(h) || crossed.has(h) || mesh.opposite(h).is_some_and(|g| g < h) {
                continue;
            }
            cut.mark_loop(mesh, h, &mut on_path, |v| paths.back_from(mesh, v));
        }
        cut.prune(mesh, keep_root.then_some(root));
        cut
    }

    /// A spanning tree of the triangles over edges that are not in `tree`; marks the edges that it crosses.
    fn dual_tree(mesh: &HalfEdges, tree: &Self) -> Self {
        let mut crossed = Self::empty(mesh);
        let mut seen = vec![false; mesh.triangles().len()];
        let mut queue = VecDeque::new();
        for seed in 0..seen.len() {
            if std::mem::replace(&mut seen[seed], true) {
                continue;
            }
            queue.push_back(seed as u32);
            while let Some(f) = queue.pop_front() {
                for h in 3 * f..3 * f + 3 {
                    let Some(g) = mesh.opposite(h).filter(|_| !tree.has(h)) else { continue };
                    if !std::mem::replace(&mut seen[g as usize / 3], true) {
                        crossed.mark(mesh, h);
                        queue.push_back(g / 3);
                    }
                }
            }
        }
        crossed
    }

    /// Unmarks edges that end nowhere, except at `keep`.
    pub(crate) fn prune(&mut self, mesh: &HalfEdges, keep: Option<u32>) {
        let mut degree = vec![0_u32; mesh.vertices()];
        for h in 0..self.marked.len() as u32 {
            degree[mesh.from(h) as usize] += u32::from(self.has(h));
        }
        let ends = |degree: &[u32], v: u32| degree[v as usize] == 1 && Some(v) != keep;
        let mut queue: VecDeque<u32> = (0..mesh.vertices() as u32).filter(|&v| ends(&degree, v)).collect();
        while let Some(v) = queue.pop_front() {
            let Some(h) = mesh.fan(v).find(|&h| self.has(h)) else { continue };
            let w = mesh.to(h);
            self.set(mesh, h, false);
            degree[v as usize] -= 1;
            degree[w as usize] -= 1;
            if ends(&degree, w) {
                queue.push_back(w);
            }
        }
    }

    /// The surface cut open, and for each of its vertices the one that it was. Triangles and half-edges keep their numbers.
    pub(crate) fn open(&self, mesh: &HalfEdges) -> (HalfEdges, Vec<u32>) {
        let count = self.marked.len() as u32;
        let opposite: Vec<u32> = (0..count).map(|h| mesh.opposite(h).filter(|_| !self.has(h)).unwrap_or(NONE)).collect();
        let mut triangles = vec![[NONE; 3]; mesh.triangles().len()];
        let mut origin = Vec::with_capacity(mesh.vertices());
        for first in 0..count {
            if triangles[first as usize / 3][first as usize % 3] != NONE {
                continue;
            }
            let copy = origin.len() as u32;
            origin.push(mesh.from(first));
            let mut give = |h: u32| triangles[h as usize / 3][h as usize % 3] = copy;
            let mut h = first;
            let closed = loop {
                give(h);
                h = opposite[prev(h) as usize];
                if h == first || h == NONE {
                    break h == first;
                }
            };
            if !closed {
                let mut h = opposite[first as usize];
                while h != NONE {
                    give(next(h));
                    h = opposite[next(h) as usize];
                }
            }
        }
        (HalfEdges::from_parts(triangles, opposite, origin.len()), origin)
    }
}

/// The part of a mesh that keeps the triangles `f` with `keep(f)`: the part, and for each of its vertices the one that it was.
///
/// The caller sees to it that the triangles left around each vertex form one fan.
pub(crate) fn part(mesh: &HalfEdges, keep: impl Fn(u32) -> bool) -> (HalfEdges, Vec<u32>) {
    let mut new_triangle = vec![NONE; mesh.triangles().len()];
    let mut new_vertex = vec![NONE; mesh.vertices()];
    let (mut kept, mut triangles) = (Vec::new(), Vec::new());
    for f in (0..mesh.triangles().len() as u32).filter(|&f| keep(f)) {
        new_triangle[f as usize] = kept.len() as u32;
        kept.push(f);
        mesh.triangles()[f as usize].iter().for_each(|&v| new_vertex[v as usize] = 0);
    }
    let origin: Vec<u32> = (0..mesh.vertices() as u32).filter(|&v| new_vertex[v as usize] == 0).collect();
    for (new, &old) in origin.iter().enumerate() {
        new_vertex[old as usize] = new as u32;
    }
    let mut opposite = Vec::with_capacity(3 * kept.len());
    for &f in &kept {
        triangles.push(mesh.triangles()[f as usize].map(|v| new_vertex[v as usize]));
        opposite.extend((3 * f..3 * f + 3).map(|h| match mesh.opposite(h) {
            Some(g) if new_triangle[g as usize / 3] != NONE => 3 * new_triangle[g as usize / 3] + g % 3,
            _ => NONE,
        }));
    }
    let vertices = origin.len();
    (HalfEdges::from_parts(triangles, opposite, vertices), origin)
}
