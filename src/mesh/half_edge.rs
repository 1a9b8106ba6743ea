//! Half-edges: how the triangles of an oriented manifold hang together.
//!
//! Half-edge `3f + c` runs from corner `c` of triangle `f` to the next corner. Handles are plain
//! indices: arrays can be copied, sorted and sent, and a triangle's half-edges need no storage.
//!
//! Invariants, all checked by [`HalfEdges::check`]:
//!
//! - **H1** every triangle names three different vertices, all in range;
//! - **H2** `opposite(opposite(h)) == h` wherever there is an opposite;
//! - **H3** opposite half-edges join the same two vertices, in opposite directions;
//! - **H4** the triangles around each vertex form one fan: turning about it meets them all;
//! - **H5** a vertex has at most one outgoing half-edge without opposite, and then `outgoing` is that one.

use crate::error::{MeshDefect, Result};

/// No half-edge, no vertex.
pub(crate) const NONE: u32 = u32::MAX;

/// The triangles of an oriented manifold and which half-edges are opposite each other.
#[derive(Debug, Clone)]
pub(crate) struct HalfEdges {
    triangles: Vec<[u32; 3]>,
    opposite: Vec<u32>,
    outgoing: Vec<u32>,
}

/// The next half-edge of the same triangle.
#[inline]
pub(crate) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The previous half-edge of the same triangle.
#[inline]
pub(crate) fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl HalfEdges {
    /// Glues triangles along their common edges. O(n log n).
    ///
    /// # Errors
    /// The first place where the triangles are not an oriented manifold (H1, H3 or H4 cannot hold).
    pub(crate) fn new(vertices: usize, triangles: Vec<[u32; 3]>) -> Result<Self> {
        let mut mesh = Self { opposite: vec![NONE; 3 * triangles.len()], outgoing: vec![NONE; vertices], triangles };
        mesh.check_triangles()?;
        mesh.glue()?;
        mesh.find_outgoing()?;
        Ok(mesh)
    }

    /// From parts that are known to fit, as a decoder makes them.
    #[allow(dead_code)] // decoders that rebuild a mesh use it
    pub(crate) fn from_parts(triangles: Vec<[u32; 3]>, opposite: Vec<u32>, vertices: usize) -> Self {
        let mut outgoing = vec![NONE; vertices];
        for h in 0..opposite.len() as u32 {
            let v = triangles[h as usize / 3][h as usize % 3] as usize;
            if outgoing[v] == NONE || opposite[h as usize] == NONE {
                outgoing[v] = h;
            }
        }
        Self { triangles, opposite, outgoing }
    }

    fn check_triangles(&self) -> Result<(), MeshDefect> {
        let vertices = self.outgoing.len() as u64;
        for (face, &[a, b, c]) in self.triangles.iter().enumerate() {
            let face = face as u32;
            if let Some(index) = [a, b, c].into_iter().find(|&v| u64::from(v) >= vertices) {
                return Err(MeshDefect::IndexOutOfRange { face, index: index.into(), vertices });
            }
            if a == b || b == c || c == a {
                return Err(MeshDefect::Degenerate { face });
            }
        }
        Ok(())
    }

    /// Half-edges are sorted into buckets by their smaller end, so that mates lie together.
    fn glue(&mut self) -> Result<(), MeshDefect> {
        let smaller = |mesh: &Self, h: u32| mesh.from(h).min(mesh.to(h)) as usize;
        let mut ends = vec![0_u32; self.outgoing.len() + 1];
        for h in 0..self.opposite.len() as u32 {
            ends[smaller(self, h) + 1] += 1;
        }
        for v in 1..ends.len() {
            ends[v] += ends[v - 1];
        }
        let mut buckets = vec![(0_u32, 0_u32); self.opposite.len()];
        for h in 0..self.opposite.len() as u32 {
            let slot = &mut ends[smaller(self, h)];
            buckets[*slot as usize] = (self.from(h).max(self.to(h)), h);
            *slot += 1;
        }
        // After the pass above `ends[v]` is where bucket `v` ends and bucket `v + 1` starts.
        let mut start = 0;
        for &end in &ends[..self.outgoing.len()] {
            let bucket = &mut buckets[start..end as usize];
            start = end as usize;
            bucket.sort_unstable();
            for mates in bucket.chunk_by(|x, y| x.0 == y.0) {
                let (a, b) = (self.from(mates[0].1), self.to(mates[0].1));
                match *mates {
                    [_] => {}
                    [(_, h), (_, g)] if self.from(g) == b => {
                        self.opposite[h as usize] = g;
                        self.opposite[g as usize] = h;
                    }
                    [_, _] => return Err(MeshDefect::Disoriented { a, b }),
                    _ => return Err(MeshDefect::NonManifoldEdge { a, b }),
                }
            }
        }
        Ok(())
    }

    fn find_outgoing(&mut self) -> Result<(), MeshDefect> {
        let mut degree = vec![0_u32; self.outgoing.len()];
        for h in 0..self.opposite.len() as u32 {
            let v = self.from(h) as usize;
            degree[v] += 1;
            if self.outgoing[v] == NONE || self.opposite[h as usize] == NONE {
                self.outgoing[v] = h;
            }
        }
        for (v, &degree) in degree.iter().enumerate() {
            if self.fan(v as u32).count() != degree as usize {
                return Err(MeshDefect::NonManifoldVertex { vertex: v as u32 });
            }
        }
        Ok(())
    }

    /// The number of vertices, those that no triangle uses included.
    pub(crate) fn vertices(&self) -> usize {
        self.outgoing.len()
    }

    /// The triangles.
    pub(crate) fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The vertex that `h` starts from.
    #[inline]
    pub(crate) fn from(&self, h: u32) -> u32 {
        self.triangles[h as usize / 3][h as usize % 3]
    }

    /// The vertex that `h` runs to.
    #[inline]
    pub(crate) fn to(&self, h: u32) -> u32 {
        self.from(next(h))
    }

    /// The vertex of `h`'s triangle that is not on `h`.
    #[allow(dead_code)] // the image codecs ask it
    #[inline]
    pub(crate) fn apex(&self, h: u32) -> u32 {
        self.from(prev(h))
    }

    /// The half-edge on the other side, if there is a triangle.
    #[inline]
    pub(crate) fn opposite(&self, h: u32) -> Option<u32> {
        let g = self.opposite[h as usize];
        (g != NONE).then_some(g)
    }

    /// A half-edge that starts from `v` (the one on the boundary, if there is one); `None` if no triangle uses `v`.
    #[inline]
    pub(crate) fn outgoing(&self, v: u32) -> Option<u32> {
        let h = self.outgoing[v as usize];
        (h != NONE).then_some(h)
    }

    /// Whether `v` lies on the boundary.
    #[allow(dead_code)] // floors above ask it
    pub(crate) fn is_boundary(&self, v: u32) -> bool {
        self.outgoing(v).is_some_and(|h| self.opposite(h).is_none())
    }

    /// The outgoing half-edges of `v`, counter-clockwise; from the boundary on, if there is one.
    pub(crate) fn fan(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.outgoing(v);
        std::iter::successors(first, move |&h| self.opposite(prev(h)).filter(|&g| Some(g) != first))
    }

    /// Checks H1–H5 the slow way and names the first that broke.
    #[cfg(test)]
    pub(crate) fn check(&self) -> std::result::Result<(), &'static str> {
        let count = self.triangles.iter().flatten().fold(vec![0; self.vertices()], |mut n, &v| {
            n[v as usize] += 1;
            n
        });
        for &[a, b, c] in &self.triangles {
            if a == b || b == c || c == a {
                return Err("H1: a triangle names a vertex twice");
            }
        }
        for h in 0..self.opposite.len() as u32 {
            if let Some(g) = self.opposite(h) {
                if self.opposite(g) != Some(h) {
                    return Err("H2: the opposite of the opposite is another half-edge");
                }
                if (self.from(g), self.to(g)) != (self.to(h), self.from(h)) {
                    return Err("H3: opposites do not join the same two vertices");
                }
            } else if self.outgoing(self.from(h)) != Some(h) {
                return Err("H5: an outgoing half-edge on the boundary is not the first of its fan");
            }
        }
        for v in 0..self.vertices() as u32 {
            if self.fan(v).take(count[v as usize] + 1).count() != count[v as usize] {
                return Err("H4: the triangles around a vertex are not one fan");
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    fn defect(vertices: usize, triangles: &[[u32; 3]]) -> Option<MeshDefect> {
        match HalfEdges::new(vertices, triangles.to_vec()) {
            Err(Error::Mesh(defect)) => Some(defect),
            _ => None,
        }
    }

    #[test]
    fn a_tetrahedron_and_an_open_fan_keep_all_invariants() {
        let closed = HalfEdges::new(4, vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]).unwrap();
        assert_eq!(closed.check(), Ok(()));
        assert!((0..4).all(|v| !closed.is_boundary(v) && closed.fan(v).count() == 3));
        let open = HalfEdges::new(5, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        assert_eq!(open.check(), Ok(()));
        assert_eq!(open.fan(0).map(|h| open.to(h)).collect::<Vec<_>>(), [1, 2]);
        assert_eq!(open.outgoing(4), None);
    }

    #[test]
    fn each_defect_is_named_with_its_place() {
        assert_eq!(defect(3, &[[0, 1, 1]]), Some(MeshDefect::Degenerate { face: 0 }));
        assert_eq!(defect(3, &[[0, 1, 7]]), Some(MeshDefect::IndexOutOfRange { face: 0, index: 7, vertices: 3 }));
        assert_eq!(defect(4, &[[0, 1, 2], [0, 1, 3]]), Some(MeshDefect::Disoriented { a: 0, b: 1 }));
        assert_eq!(defect(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]), Some(MeshDefect::NonManifoldEdge { a: 0, b: 1 }));
        assert_eq!(defect(5, &[[0, 1, 2], [0, 3, 4]]), Some(MeshDefect::NonManifoldVertex { vertex: 0 }));
    }
}
