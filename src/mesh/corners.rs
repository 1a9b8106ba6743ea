//! Corners: how the faces of any mesh hang together, manifold or not.
//!
//! [`HalfEdges`](super::HalfEdges) is for oriented manifolds of triangles; this is for everything
//! else: polygons, edges with any number of faces, faces that disagree about the outside. Corner `c`
//! stands for itself and for the side of its face from its vertex to that of the next corner. All sides
//! between the same two vertices form one edge, in whichever direction they run.
//!
//! Faces of fewer than three corners, or that name a vertex which does not exist, are passed over; so is
//! whatever else the caller does not want.

use super::Faces;
use super::half_edge::NONE;

/// The corners of all faces that have at least three, one face after the other.
#[derive(Debug, Clone)]
pub(crate) struct Corners {
    /// The faces that count, by their numbers in the mesh.
    faces: Vec<u32>,
    /// Where each counted face starts; one more at the end.
    starts: Vec<u32>,
    vertices: Vec<u32>,
    /// The counted face of each corner.
    face: Vec<u32>,
    /// The edge that each corner's side lies on.
    edge: Vec<u32>,
    /// The corners, those of one edge together.
    by_edge: Vec<u32>,
    /// Where each edge starts in `by_edge`; one more at the end.
    edges: Vec<u32>,
}

impl Corners {
    /// Sorts the sides of all faces into edges. O(n log n).
    pub(crate) fn new(vertices: usize, faces: &Faces) -> Self {
        Self::of(vertices, faces, |_| true)
    }

    /// The same for the faces that are wanted, by their numbers.
    pub(crate) fn of(vertices: usize, faces: &Faces, wanted: impl Fn(usize) -> bool) -> Self {
        let mut this = Self {
            faces: Vec::with_capacity(faces.len()),
            starts: vec![0],
            vertices: Vec::with_capacity(faces.corners().len()),
            face: Vec::with_capacity(faces.corners().len()),
            edge: Vec::new(),
            by_edge: Vec::new(),
            edges: Vec::new(),
        };
        for (number, corners) in faces.iter().enumerate() {
            if corners.len() >= 3 && wanted(number) && corners.iter().all(|&v| (v as usize) < vertices) {
                this.face.extend(corners.iter().map(|_| this.faces.len() as u32));
                this.vertices.extend_from_slice(corners);
                this.faces.push(number as u32);
                this.starts.push(this.vertices.len() as u32);
            }
        }
        this.sort_sides();
        this
    }

    fn sort_sides(&mut self) {
        let ends = |c: u32| {
            let (a, b) = (self.vertex(c), self.vertex(self.next(c)));
            (a.min(b), a.max(b))
        };
        let mut sides: Vec<(u32, u32, u32)> = (0..self.len() as u32).map(|c| (ends(c).0, ends(c).1, c)).collect();
        sides.sort_unstable();
        let mut edge = vec![0; sides.len()];
        let mut edges = Vec::with_capacity(sides.len() / 2 + 1);
        for group in sides.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            for &(_, _, c) in group {
                edge[c as usize] = edges.len() as u32;
            }
            edges.push(group.len() as u32);
        }
        // Lengths into starts.
        let mut start = 0;
        for length in &mut edges {
            start += std::mem::replace(length, start);
        }
        edges.push(start);
        (self.edge, self.edges, self.by_edge) = (edge, edges, sides.into_iter().map(|s| s.2).collect());
    }

    /// The number of corners.
    pub(crate) fn len(&self) -> usize {
        self.vertices.len()
    }

    /// The vertex at corner `c`.
    #[inline]
    pub(crate) fn vertex(&self, c: u32) -> u32 {
        self.vertices[c as usize]
    }

    /// The vertices of all corners.
    pub(crate) fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// The counted face that corner `c` belongs to.
    #[inline]
    pub(crate) fn face(&self, c: u32) -> u32 {
        self.face[c as usize]
    }

    /// The next corner of the same face.
    #[inline]
    pub(crate) fn next(&self, c: u32) -> u32 {
        let f = self.face[c as usize] as usize;
        if c + 1 == self.starts[f + 1] { self.starts[f] } else { c + 1 }
    }

    /// The previous corner of the same face.
    #[inline]
    pub(crate) fn prev(&self, c: u32) -> u32 {
        let f = self.face[c as usize] as usize;
        if c == self.starts[f] { self.starts[f + 1] - 1 } else { c - 1 }
    }

    /// The counted faces.
    pub(crate) fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// The first corner of counted face `f`.
    #[inline]
    pub(crate) fn first(&self, f: u32) -> u32 {
        self.starts[f as usize]
    }

    /// The number that counted face `f` has in the mesh.
    pub(crate) fn number(&self, f: u32) -> u32 {
        self.faces[f as usize]
    }

    /// The vertices of counted face `f`, in order.
    pub(crate) fn of_face(&self, f: u32) -> &[u32] {
        &self.vertices[self.starts[f as usize] as usize..self.starts[f as usize + 1] as usize]
    }

    /// The edges, each with the corners of its sides.
    #[allow(dead_code)] // the doctor's report counts them
    pub(crate) fn edges(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.edges.windows(2).map(|w| &self.by_edge[w[0] as usize..w[1] as usize])
    }

    /// The corners whose sides lie on the same edge as that of `c`, `c` included.
    #[inline]
    pub(crate) fn sides(&self, c: u32) -> &[u32] {
        let e = self.edge[c as usize] as usize;
        &self.by_edge[self.edges[e] as usize..self.edges[e + 1] as usize]
    }

    /// The corner on the other side of an edge that has exactly two; [`NONE`] elsewhere.
    #[inline]
    pub(crate) fn twin(&self, c: u32) -> u32 {
        match *self.sides(c) {
            [a, b] => a ^ b ^ c,
            _ => NONE,
        }
    }

    /// Whether the sides of two corners on one edge run the same way.
    pub(crate) fn run_alike(&self, c: u32, d: u32) -> bool {
        self.vertex(c) == self.vertex(d) && self.vertex(c) != self.vertex(self.next(c))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_quads_and_a_fin_share_one_edge_three_ways() {
        let mut faces = Faces::default();
        faces.push(&[0, 1, 2, 3]);
        faces.push(&[1, 0, 4, 5]);
        faces.push(&[7, 7]);
        faces.push(&[0, 1, 6]);
        faces.push(&[0, 1, 99]);
        let corners = Corners::new(8, &faces);
        assert_eq!((corners.len(), corners.face_count(), corners.number(2)), (11, 3, 3));
        assert_eq!(corners.sides(0), &[0, 4, 8]);
        assert_eq!(corners.twin(0), NONE);
        assert!(corners.run_alike(0, 8) && !corners.run_alike(0, 4));
        assert_eq!((corners.next(3), corners.prev(0), corners.next(10), corners.prev(4)), (0, 3, 8, 7));
        assert_eq!(corners.edges().filter(|sides| sides.len() == 1).count(), 8);
        assert_eq!(corners.of_face(1), &[1, 0, 4, 5]);
    }

    #[test]
    fn two_triangles_are_each_others_twins() {
        let faces: Faces = [[0, 1, 2], [2, 1, 3]].into_iter().collect();
        let corners = Corners::new(4, &faces);
        assert_eq!((corners.twin(1), corners.twin(3), corners.twin(0)), (3, 1, NONE));
    }
}
