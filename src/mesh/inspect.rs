//! What a mesh is like, sound or not: parts, boundaries, handles, and every kind of fault.
//!
//! Takes any polygons. Polygons count by their edges, not by the triangles that they would be cut into. Around each
//! vertex the faces are sorted into fans; where a vertex has several, it counts as several vertices for boundary loops and
//! for the genus, as if it had been split.

use std::collections::HashMap;

use super::Mesh;
use crate::error::MeshDefect;
use crate::mesh::HalfEdges;

/// What [`Mesh::inspect`] found. Counts of faults are 0 in a sound mesh.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Inspection {
    /// Vertices, unused ones included.
    pub vertices: usize,
    /// Faces.
    pub faces: usize,
    /// Faces by their number of corners, as (corners, faces).
    pub polygons: Vec<(usize, usize)>,
    /// Edges, each counted once.
    pub edges: usize,
    /// Parts that share no vertex.
    pub components: usize,
    /// Closed chains of boundary edges; `None` where edges or orientation are at fault.
    pub boundary_loops: Option<usize>,
    /// Handles of all components together; `None` where edges or orientation are at fault.
    pub genus: Option<usize>,
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Edges with more than two faces.
    pub non_manifold_edges: usize,
    /// Vertices whose faces form more than one fan.
    pub non_manifold_vertices: usize,
    /// Edges that two faces walk in the same direction: they disagree about which side is outside.
    pub flipped_edges: usize,
    /// Faces of fewer than three corners, or that name a vertex twice.
    pub degenerate_faces: usize,
    /// Faces with the same vertices as an earlier face.
    pub duplicate_faces: usize,
    /// Faces without area whose vertices differ.
    pub flat_faces: usize,
    /// Vertices that no face uses.
    pub isolated_vertices: usize,
    /// Vertices at the same place as an earlier vertex.
    pub duplicate_positions: usize,
    /// Vertices with a coordinate that is not a finite number.
    pub non_finite_vertices: usize,
    /// The lowest and the highest corner of the box of all finite vertices.
    pub bounds: Option<[[f64; 3]; 2]>,
    /// Why method `cgim` does not take the mesh as it is; `None` if it does.
    pub obstacle: Option<MeshDefect>,
}

impl Inspection {
    /// Whether every edge has at most two faces that agree, and every vertex one fan.
    pub fn is_manifold(&self) -> bool {
        self.non_manifold_edges + self.non_manifold_vertices + self.flipped_edges + self.degenerate_faces == 0
    }

    /// Whether the mesh is manifold and has no boundary.
    pub fn is_closed(&self) -> bool {
        self.is_manifold() && self.faces > 0 && self.boundary_edges == 0
    }
}

/// A side of a face: the edge it lies on, by its ends in rising order, and the corner it starts from.
type Side = (u32, u32, usize);

impl Mesh {
    /// Examines the mesh. O(n log n).
    ///
    /// # Errors
    /// A face that names a vertex which does not exist.
    pub fn inspect(&self) -> crate::Result<Inspection> {
        let vertices = self.positions.len();
        for (face, corners) in self.faces.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&v| v as usize >= vertices) {
                let (face, index, vertices) = (face as u32, index.into(), vertices as u64);
                return Err(MeshDefect::IndexOutOfRange { face, index, vertices }.into());
            }
        }
        let sound: Vec<usize> = (0..self.faces.len()).filter(|&f| is_sound(self.faces.get(f))).collect();
        let links = Links::new(self, &sound);
        let mut used = vec![false; vertices];
        self.faces.corners().iter().for_each(|&v| used[v as usize] = true);
        let fans = links.fans();
        let (loops, genus) = links.topology(&fans, self.components(&sound), sound.len());
        let finite = |p: &&[f64; 3]| p.iter().all(|x| x.is_finite());
        Ok(Inspection {
            vertices,
            faces: self.faces.len(),
            polygons: polygons(self),
            edges: links.edges,
            components: self.components(&sound),
            boundary_loops: loops,
            genus,
            boundary_edges: links.boundary,
            non_manifold_edges: links.crowded,
            non_manifold_vertices: fans.iter().filter(|&&n| n > 1).count(),
            flipped_edges: links.flipped,
            degenerate_faces: self.faces.len() - sound.len(),
            duplicate_faces: self.duplicate_faces(&sound),
            flat_faces: sound.iter().filter(|&&f| is_flat(self, self.faces.get(f))).count(),
            isolated_vertices: used.iter().filter(|&&u| !u).count(),
            duplicate_positions: self.duplicate_positions(),
            non_finite_vertices: self.positions.iter().filter(|p| !finite(p)).count(),
            bounds: crate::plane::bounding_box(self.positions.iter().filter(finite).copied()),
            obstacle: self.obstacle(),
        })
    }

    fn obstacle(&self) -> Option<MeshDefect> {
        let triangles = self.faces.triangles();
        if triangles.is_empty() {
            return Some(MeshDefect::Empty);
        }
        let found = self.check().and_then(|()| HalfEdges::new(self.positions.len(), triangles).map(|_| ()));
        match found {
            Err(crate::Error::Mesh(defect)) => Some(defect),
            _ => None,
        }
    }

    /// Parts that share no vertex, by union of the corners of each face.
    fn components(&self, faces: &[usize]) -> usize {
        let mut parent: Vec<u32> = (0..self.positions.len() as u32).collect();
        let mut parts = 0;
        let mut seen = vec![false; parent.len()];
        for &f in faces {
            let corners = self.faces.get(f);
            for &v in corners {
                if !std::mem::replace(&mut seen[v as usize], true) {
                    parts += 1;
                }
                let (a, b) = (root(&mut parent, corners[0]), root(&mut parent, v));
                if a != b {
                    parent[b as usize] = a;
                    parts -= 1;
                }
            }
        }
        parts
    }

    fn duplicate_faces(&self, faces: &[usize]) -> usize {
        let mut sorted: Vec<Vec<u32>> = faces.iter().map(|&f| self.faces.get(f).to_vec()).collect();
        sorted.iter_mut().for_each(|corners| corners.sort_unstable());
        sorted.sort_unstable();
        sorted.windows(2).filter(|pair| pair[0] == pair[1]).count()
    }

    fn duplicate_positions(&self) -> usize {
        // −0 and 0 are the same place.
        let mut sorted: Vec<[u64; 3]> = self.positions.iter().map(|p| p.map(|x| (x + 0.0).to_bits())).collect();
        sorted.sort_unstable();
        sorted.windows(2).filter(|pair| pair[0] == pair[1]).count()
    }
}

fn root(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        parent[v as usize] = parent[parent[v as usize] as usize];
        v = parent[v as usize];
    }
    v
}

fn polygons(mesh: &Mesh) -> Vec<(usize, usize)> {
    let mut counts = std::collections::BTreeMap::new();
    for face in mesh.faces.iter() {
        *counts.entry(face.len()).or_insert(0) += 1;
    }
    counts.into_iter().collect()
}

fn is_sound(corners: &[u32]) -> bool {
    let mut sorted = corners.to_vec();
    sorted.sort_unstable();
    sorted.len() >= 3 && sorted.windows(2).all(|pair| pair[0] != pair[1])
}

/// Whether all corners of a face lie on one line.
fn is_flat(mesh: &Mesh, corners: &[u32]) -> bool {
    let p = |i: usize| glam::DVec3::from(mesh.positions[corners[i] as usize]);
    (2..corners.len()).all(|i| (p(i - 1) - p(0)).cross(p(i) - p(0)).length_squared() == 0.0)
}

/// How faces hang together along their edges.
struct Links {
    /// Where each side goes: its face's next side.
    next: Vec<usize>,
    /// The vertex each side starts from.
    from: Vec<u32>,
    /// The one other side on the same edge, walked the other way.
    opposite: Vec<Option<usize>>,
    vertices: usize,
    edges: usize,
    boundary: usize,
    crowded: usize,
    flipped: usize,
}

impl Links {
    fn new(mesh: &Mesh, faces: &[usize]) -> Self {
        let (mut next, mut from): (Vec<usize>, Vec<u32>) = Default::default();
        let mut sides: Vec<Side> = Vec::new();
        for &f in faces {
            let corners = mesh.faces.get(f);
            let (first, n) = (from.len(), corners.len());
            for (i, &v) in corners.iter().enumerate() {
                let w = corners[(i + 1) % n];
                sides.push((v.min(w), v.max(w), first + i));
                next.push(first + (i + 1) % n);
                from.push(v);
            }
        }
        sides.sort_unstable();
        let mut links = Self {
            opposite: vec![None; from.len()],
            vertices: mesh.positions.len(),
            next,
            from,
            edges: 0,
            boundary: 0,
            crowded: 0,
            flipped: 0,
        };
        for edge in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            links.edges += 1;
            match *edge {
                [_] => links.boundary += 1,
                [(.., s), (.., t)] if links.from[s] != links.from[t] => {
                    links.opposite[s] = Some(t);
                    links.opposite[t] = Some(s);
                }
                [_, _] => links.flipped += 1,
                _ => links.crowded += 1,
            }
        }
        links
    }

    /// For each vertex the number of fans of faces around it, counted across all edges with two faces.
    fn fans(&self) -> Vec<u32> {
        // Corners are joined across edges; what is left apart are the fans.
        let mut parent: Vec<u32> = (0..self.from.len() as u32).collect();
        for (s, opposite) in self.opposite.iter().enumerate() {
            if let Some(t) = *opposite {
                let (a, b) = (root(&mut parent, s as u32), root(&mut parent, self.next[t] as u32));
                parent[b as usize] = a;
            }
        }
        // Edges whose two faces disagree, and crowded ones, join corners as well: those faults are counted on their own.
        let mut at_edge: HashMap<(u32, u32), [usize; 2]> = HashMap::new();
        for s in (0..self.from.len()).filter(|&s| self.opposite[s].is_none()) {
            let (v, w) = (self.from[s], self.from[self.next[s]]);
            let ends = if v < w { [s, self.next[s]] } else { [self.next[s], s] };
            match at_edge.entry((v.min(w), v.max(w))) {
                std::collections::hash_map::Entry::Vacant(slot) => {
                    slot.insert(ends);
                }
                std::collections::hash_map::Entry::Occupied(slot) => {
                    for (x, y) in slot.get().iter().zip(ends) {
                        let (a, b) = (root(&mut parent, *x as u32), root(&mut parent, y as u32));
                        parent[b as usize] = a;
                    }
                }
            }
        }
        let mut fans = vec![0; self.vertices];
        for (s, &v) in self.from.iter().enumerate() {
            if root(&mut parent, s as u32) == s as u32 {
                fans[v as usize] += 1;
            }
        }
        fans
    }

    /// Boundary loops and handles.
    fn topology(&self, fans: &[u32], components: usize, faces: usize) -> (Option<usize>, Option<usize>) {
        if self.crowded + self.flipped > 0 {
            return (None, None);
        }
        let mut loops = 0;
        let mut seen = vec![false; self.from.len()];
        for start in (0..self.from.len()).filter(|&s| self.opposite[s].is_none()) {
            if seen[start] {
                continue;
            }
            loops += 1;
            let mut s = start;
            while !std::mem::replace(&mut seen[s], true) {
                // Turn about the end of `s`, through the fan, to the side on the boundary.
                s = self.next[s];
                while let Some(t) = self.opposite[s] {
                    s = self.next[t];
                }
            }
        }
        // Split vertices can take a component apart: count parts that hang together by edges.
        let parts = self.parts().max(components);
        let vertices: i64 = fans.iter().map(|&n| i64::from(n)).sum();
        let characteristic = vertices - self.edges as i64 + faces as i64;
        let twice = 2 * parts as i64 - characteristic - loops as i64;
        (Some(loops), (twice >= 0 && twice % 2 == 0).then_some(twice as usize / 2))
    }

    /// Parts whose faces hang together by edges.
    fn parts(&self) -> usize {
        let mut parent: Vec<u32> = (0..self.from.len() as u32).collect();
        let mut parts = self.from.len();
        for s in 0..self.from.len() {
            for t in std::iter::once(self.next[s]).chain(self.opposite[s]) {
                let (a, b) = (root(&mut parent, s as u32), root(&mut parent, t as u32));
                if a != b {
                    parent[b as usize] = a;
                    parts -= 1;
                }
            }
        }
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inspect(vertices: usize, faces: &[&[u32]]) -> Inspection {
        let mut mesh = Mesh::default();
        for i in 0..vertices {
            let i = i as f64;
            mesh.positions.push([i, i * i, i * i * i]);
        }
        faces.iter().for_each(|f| mesh.faces.push(f));
        mesh.inspect().unwrap()
    }

    #[test]
    fn a_cube_of_quads_is_closed_and_of_genus_0() {
        let cube: [&[u32]; 6] = [&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]];
        let found = inspect(9, &cube);
        assert!(found.is_closed());
        assert_eq!((found.edges, found.components, found.boundary_loops, found.genus), (12, 1, Some(0), Some(0)));
        assert_eq!((found.isolated_vertices, found.polygons.clone()), (1, vec![(4, 6)]));
        assert_eq!(found.obstacle, None);
    }

    #[test]
    fn a_torus_of_quads_has_one_handle_and_a_hole_in_it_one_loop() {
        let at = |i: u32, j: u32| (i % 4) * 4 + j % 4;
        let faces: Vec<[u32; 4]> =
            (0..16).map(|f| (f / 4, f % 4)).map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
        let slices: Vec<&[u32]> = faces.iter().map(|f| &f[..]).collect();
        let found = inspect(16, &slices);
        assert_eq!((found.boundary_loops, found.genus), (Some(0), Some(1)));
        let found = inspect(16, &slices[1..]);
        assert_eq!((found.boundary_loops, found.genus, found.boundary_edges), (Some(1), Some(1), 4));
    }

    #[test]
    fn every_fault_is_counted_once() {
        let bow_tie = inspect(5, &[&[0, 1, 2], &[0, 3, 4]]);
        assert_eq!((bow_tie.non_manifold_vertices, bow_tie.components, bow_tie.boundary_loops), (1, 1, Some(2)));
        assert_eq!(bow_tie.genus, Some(0));
        assert_eq!(bow_tie.obstacle, Some(MeshDefect::NonManifoldVertex { vertex: 0 }));
        let fin = inspect(5, &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]]);
        assert_eq!((fin.non_manifold_edges, fin.non_manifold_vertices, fin.genus), (1, 0, None));
        let flipped = inspect(4, &[&[0, 1, 2], &[0, 1, 3]]);
        assert_eq!((flipped.flipped_edges, flipped.non_manifold_vertices), (1, 0));
        let worn = inspect(4, &[&[0, 1, 2], &[2, 0, 1], &[1, 1, 3], &[0, 3]]);
        assert_eq!((worn.duplicate_faces, worn.degenerate_faces), (1, 2));
    }

    #[test]
    fn places_that_coincide_and_faces_without_area_are_counted() {
        let mut mesh = Mesh::from_triangles(
            vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [-0.0, 0.0, 0.0], [f64::NAN, 0.0, 0.0]],
            [[0, 1, 2]],
        );
        let found = mesh.inspect().unwrap();
        assert_eq!((found.flat_faces, found.duplicate_positions, found.non_finite_vertices), (1, 1, 1));
        assert_eq!(found.bounds, Some([[0.0; 3], [2.0, 0.0, 0.0]]));
        mesh.faces.push(&[0, 1, 9]);
        assert!(mesh.inspect().is_err());
    }
}
