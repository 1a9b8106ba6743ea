//! The closed surface that is walked: the triangles of a mesh, with every hole filled by a fan.
//!
//! A hole is filled by one more vertex (a *hole vertex*), joined to its whole boundary loop, so that
//! the walk meets no boundary. Faces at hole vertices are no faces of the mesh.

use crate::error::Result;
use crate::mesh::half_edge::prev;
use crate::mesh::{HalfEdges, NONE};

/// A closed oriented surface, in the order in which a walk met its vertices and faces.
///
/// Half-edge `3f + c` runs from corner `c` of face `f` to the next corner, as in [`HalfEdges`].
#[derive(Debug, Default)]
pub(crate) struct Surface {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) opposite: Vec<u32>,
    /// Faces around each vertex.
    pub(super) valence: Vec<u32>,
    /// Whether each vertex fills a hole.
    pub(super) is_hole: Vec<bool>,
}

impl Surface {
    #[inline]
    pub(super) fn from(&self, h: u32) -> u32 {
        self.triangles[h as usize / 3][h as usize % 3]
    }

    /// The vertex of `h`'s face that is not on `h`.
    #[inline]
    pub(super) fn apex(&self, h: u32) -> u32 {
        self.from(prev(h))
    }

    /// An outgoing half-edge of every vertex.
    pub(super) fn outgoing(&self) -> Vec<u32> {
        let mut outgoing = vec![0; self.valence.len()];
        for (h, &v) in self.triangles.iter().flatten().enumerate() {
            outgoing[v as usize] = h as u32;
        }
        outgoing
    }

    /// The faces of the mesh, and how they hang together.
    pub(crate) fn skin(&self) -> Skin {
        let mut moved = vec![NONE; self.triangles.len()];
        let faces = self.real_faces();
        for (new, &old) in faces.iter().enumerate() {
            moved[old as usize] = new as u32;
        }
        let opposite = faces
            .iter()
            .flat_map(|&f| 3 * f..3 * f + 3)
            .map(|h| {
                let g = self.opposite[h as usize];
                if moved[g as usize / 3] == NONE { NONE } else { 3 * moved[g as usize / 3] + g % 3 }
            })
            .collect();
        Skin { triangles: self.real_triangles(), opposite }
    }

    /// The faces that are faces of the mesh.
    pub(crate) fn real_faces(&self) -> Vec<u32> {
        let is_real = |f: &u32| self.triangles[*f as usize].iter().all(|&v| !self.is_hole[v as usize]);
        (0..self.triangles.len() as u32).filter(is_real).collect()
    }

    /// The faces of the mesh, its vertices numbered in the order in which they were met.
    pub(crate) fn real_triangles(&self) -> Vec<[u32; 3]> {
        let mut number = 0;
        let numbers: Vec<u32> = self
            .is_hole
            .iter()
            .map(|&hole| {
                number += u32::from(!hole);
                number - u32::from(!hole)
            })
            .collect();
        self.triangles
            .iter()
            .filter(|t| t.iter().all(|&v| !self.is_hole[v as usize]))
            .map(|t| t.map(|v| numbers[v as usize]))
            .collect()
    }
}

/// A surface without the faces that fill its holes.
#[derive(Debug, Default)]
pub(crate) struct Skin {
    /// The vertices of each face, numbered as they were met, those that fill holes left out.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// [`NONE`] where there is a hole.
    pub(crate) opposite: Vec<u32>,
}

impl Skin {
    /// Bytes a face of the surface.
    pub(crate) const BYTES_A_FACE: u64 = 80;

    /// Triangles of which only the corners matter.
    pub(crate) fn plain(triangles: Vec<[u32; 3]>) -> Self {
        Self { triangles, opposite: Vec::new() }
    }

    /// The skin of triangles that are an oriented manifold.
    ///
    /// # Errors
    /// If they are none.
    pub(crate) fn of_triangles(vertices: usize, triangles: Vec<[u32; 3]>) -> Result<Self> {
        let mesh = HalfEdges::new(vertices, triangles)?;
        let opposite = (0..3 * mesh.triangles().len() as u32).map(|h| mesh.opposite(h).unwrap_or(NONE)).collect();
        Ok(Self { triangles: mesh.triangles().to_vec(), opposite })
    }

    #[inline]
    pub(super) fn from(&self, h: u32) -> u32 {
        self.triangles[h as usize / 3][h as usize % 3]
    }

    /// Which vertices lie on the boundary.
    pub(super) fn boundary_vertices(&self, vertices: usize) -> Vec<bool> {
        let mut is_on = vec![false; vertices];
        for h in (0..self.opposite.len() as u32).filter(|&h| self.opposite[h as usize] == NONE) {
            is_on[self.from(h) as usize] = true;
        }
        is_on
    }
}

/// What a header says of a surface before it is walked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Census {
    /// Vertices of the mesh.
    pub(crate) vertices: u32,
    /// Holes, each filled by one vertex more.
    pub(crate) holes: u32,
    /// Connected components.
    pub(crate) components: u32,
    /// Handles of all components together (the sum of their genera).
    pub(crate) handles: u32,
}

impl Census {
    /// The faces of the closed surface, by Euler's formula.
    pub(crate) fn closed_faces(&self) -> u64 {
        (2 * (u64::from(self.vertices) + u64::from(self.holes)) + 4 * u64::from(self.handles))
            .saturating_sub(4 * u64::from(self.components))
    }
}

/// A mesh with its holes filled: the surface as an encoder finds it.
#[derive(Debug)]
#[cfg(feature = "encode")]
pub(crate) struct Filled {
    triangles: Vec<[u32; 3]>,
    opposite: Vec<u32>,
    pub(super) valence: Vec<u32>,
    /// Vertices from here on fill holes.
    pub(super) first_hole: u32,
    pub(crate) census: Census,
}

#[cfg(feature = "encode")]
impl Filled {
    /// Fills every boundary loop. O(n). Vertices that no face uses are in `mesh`, but not counted.
    pub(crate) fn new(mesh: &HalfEdges) -> Self {
        let first_hole = mesh.vertices() as u32;
        let mut triangles = mesh.triangles().to_vec();
        let mut opposite: Vec<u32> = (0..3 * triangles.len() as u32).map(|h| mesh.opposite(h).unwrap_or(NONE)).collect();
        let mut hole = first_hole;
        for start in 0..opposite.len() as u32 {
            if opposite[start as usize] != NONE {
                continue;
            }
            // Along the loop, each half-edge gets a face (its end, its start, hole vertex).
            let first = triangles.len() as u32;
            let mut h = start;
            loop {
                let f = triangles.len() as u32;
                triangles.push([mesh.to(h), mesh.from(h), hole]);
                opposite[h as usize] = 3 * f;
                // The face before this one, where it came from; the first is put right below.
                opposite.extend([h, (3 * f).wrapping_sub(1), 3 * f + 4]);
                h = match mesh.outgoing(mesh.to(h)) {
                    Some(g) if g != start => g,
                    _ => break,
                };
            }
            let last = triangles.len() as u32 - 1;
            opposite[3 * first as usize + 1] = 3 * last + 2;
            opposite[3 * last as usize + 2] = 3 * first + 1;
            hole += 1;
        }
        let mut valence = vec![0; hole as usize];
        for &v in triangles.iter().flatten() {
            valence[v as usize] += 1;
        }
        let census = Census { vertices: 0, holes: hole - first_hole, components: 0, handles: 0 };
        let mut filled = Self { triangles, opposite, valence, first_hole, census };
        filled.count();
        filled
    }

    fn count(&mut self) {
        let vertices = self.valence[..self.first_hole as usize].iter().filter(|&&n| n > 0).count() as u32;
        let mut seen = vec![false; self.triangles.len()];
        let mut stack = Vec::new();
        let mut components = 0;
        for face in 0..self.triangles.len() {
            if seen[face] {
                continue;
            }
            seen[face] = true;
            components += 1;
            stack.push(face);
            while let Some(f) = stack.pop() {
                for g in &self.opposite[3 * f..3 * f + 3] {
                    let g = *g as usize / 3;
                    if !seen[g] {
                        seen[g] = true;
                        stack.push(g);
                    }
                }
            }
        }
        // V − E + F = 2 (components − handles), and 2 E = 3 F.
        let (v, f) = (i64::from(vertices + self.census.holes), self.triangles.len() as i64);
        let handles = i64::from(components) - (v - f / 2) / 2;
        self.census = Census { vertices, components, handles: handles as u32, ..self.census };
    }

    pub(super) fn faces(&self) -> usize {
        self.triangles.len()
    }

    #[inline]
    pub(super) fn from(&self, h: u32) -> u32 {
        self.triangles[h as usize / 3][h as usize % 3]
    }

    #[inline]
    pub(super) fn apex(&self, h: u32) -> u32 {
        self.from(prev(h))
    }

    #[inline]
    pub(super) fn opposite(&self, h: u32) -> u32 {
        self.opposite[h as usize]
    }
}

/// The next outgoing half-edge around the vertex that `h` starts from, counter-clockwise.
#[inline]
pub(super) fn turn(opposite: &[u32], h: u32) -> u32 {
    opposite[prev(h) as usize]
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;
    use crate::mesh::HalfEdges;
    use crate::mesh::half_edge::next;

    #[test]
    fn holes_are_filled_so_that_every_edge_has_two_faces() {
        // A square annulus: 8 vertices, 8 triangles, two loops.
        let triangles = (0..4).flat_map(|i| {
            let j = (i + 1) % 4;
            [[i, j, 4 + i], [j, 4 + j, 4 + i]]
        });
        let filled = Filled::new(&HalfEdges::new(8, triangles.collect()).unwrap());
        assert_eq!(filled.census, Census { vertices: 8, holes: 2, components: 1, handles: 0 });
        assert_eq!(filled.faces() as u64, filled.census.closed_faces());
        for h in 0..3 * filled.faces() as u32 {
            let g = filled.opposite(h);
            assert_eq!(filled.opposite(g), h);
            assert_eq!((filled.from(g), filled.from(next(g))), (filled.from(next(h)), filled.from(h)));
        }
    }
}
