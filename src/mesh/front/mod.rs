//! The front end: any list of faces as an oriented manifold of triangles, and what was done to it.
//!
//! 1. [`sort`](mod@sort): faces that name a vertex twice or have fewer than three corners stay apart (*loose* faces), faces that
//!    repeat an earlier one become *repeats* of it.
//! 2. [`orient`](super::orient::orient): faces are turned over until neighbours across edges of two faces agree.
//! 3. [`cut`]: polygons are cut into triangles along *diagonals*, never along an edge that the mesh has already.
//! 4. [`stitch`]: edges of two faces that agree are glued; of those with more, as many as leave a manifold.
//! 5. Every fan of triangles around a vertex becomes a vertex of the surface: vertices with several fans are copied.
//! 6. Polygons that hang together with nothing, and whose vertices are all used elsewhere, become loose faces too.
//!
//! No two edges of the surface join the same two of its vertices, and no vertex of it is closed by two
//! triangles, which is what the walk over the surface asks for. A sound triangle mesh passes unchanged.

mod cut;
mod sort;
mod stitch;

use super::half_edge::{HalfEdges, NONE};
use super::{Corners, Faces, orient};
use cut::Cut;
pub(crate) use sort::Repeat;

/// What the front end makes of the faces of a mesh.
#[derive(Debug)]
pub(crate) struct Front {
    /// The oriented manifold.
    pub(crate) surface: HalfEdges,
    /// The vertex of the mesh that each vertex of the surface is, or is a copy of.
    pub(crate) vertex: Vec<u32>,
    /// The face of the mesh that each triangle is a piece of.
    pub(crate) face: Vec<u32>,
    /// Whether each face of the mesh was turned over.
    pub(crate) is_flipped: Vec<bool>,
    /// Faces that have the same corners as an earlier face.
    pub(crate) repeats: Vec<Repeat>,
    /// Faces that are not part of the surface.
    pub(crate) loose: Vec<u32>,
}

impl Front {
    /// O(n log n) in corners, as long as few vertices have very many faces on edges with more than two.
    pub(crate) fn new(vertices: usize, faces: &Faces) -> Self {
        let mut sorted = sort::sort(faces);
        let mut is_flipped = vec![false; faces.len()];
        let (corners, numbers) = sorted.kept(vertices, faces);
        let mut flips = orient::orient(&corners);
        let Cut { mut triangles, mut face, mut opposite, side, uncut } = cut::cut(&corners, &flips);
        stitch::glue(&corners, &side, &triangles, &mut opposite);
        let mut vertex_at = stitch::stitch(&corners, &side, &triangles, &mut opposite);
        let strays = strays(&corners, &side, &opposite, &vertex_at, &triangles, vertices);
        if let Some(strays) = strays {
            remove(&strays, &mut triangles, &mut face, &mut opposite, &mut vertex_at);
            for f in (0..corners.face_count()).filter(|&f| strays[f]) {
                sorted.loose.push(numbers.number(&corners, f as u32));
                flips[f] = false;
            }
        }
        for f in uncut {
            sorted.loose.push(numbers.number(&corners, f));
            flips[f as usize] = false;
        }
        for (f, &flip) in flips.iter().enumerate() {
            is_flipped[numbers.number(&corners, f as u32) as usize] = flip;
        }
        face.iter_mut().for_each(|f| *f = numbers.number(&corners, *f));
        // A repeat of a face that became loose is loose itself.
        sorted.loose.sort_unstable();
        let loose = &sorted.loose;
        let (repeats, orphans): (Vec<Repeat>, Vec<Repeat>) =
            sorted.repeats.into_iter().partition(|r| loose.binary_search(&r.of).is_err());
        sorted.loose.extend(orphans.into_iter().map(|r| r.face));

        // Vertices of the surface, numbered as their corners come.
        let (mut vertex, mut number) = (Vec::new(), vec![NONE; vertex_at.len()]);
        let mut corners = triangles.as_flattened().iter().zip(&vertex_at);
        let surface: Vec<[u32; 3]> = (0..triangles.len())
            .map(|_| {
                [(); 3].map(|()| {
                    let Some((&of, &at)) = corners.next() else { return NONE };
                    if number[at as usize] == NONE {
                        number[at as usize] = vertex.len() as u32;
                        vertex.push(of);
                    }
                    number[at as usize]
                })
            })
            .collect();
        let surface = HalfEdges::from_parts(surface, opposite, vertex.len());
        Self { surface, vertex, face, is_flipped, repeats, loose: sorted.loose }
    }

    /// Whether half-edge `h` cuts a polygon, so that it is no edge of the mesh.
    pub(crate) fn is_diagonal(&self, h: u32) -> bool {
        self.surface.opposite(h).is_some_and(|g| self.face[h as usize / 3] == self.face[g as usize / 3])
    }

    /// Whether the faces are the triangles of the surface as they stand; then nothing need be recorded.
    pub(crate) fn is_plain(&self, vertices: usize, faces: &Faces) -> bool {
        faces.are_triangles()
            && self.surface.triangles().len() == faces.len()
            && self.vertex.len() == vertices
            && !self.has_copies(vertices)
            && !self.is_flipped.contains(&true)
    }

    fn has_copies(&self, vertices: usize) -> bool {
        let mut seen = vec![false; vertices];
        self.vertex.iter().any(|&v| std::mem::replace(&mut seen[v as usize], true))
    }
}

/// Polygons that are glued to nothing and share every vertex with others; `None` if there are none.
fn strays(
    corners: &Corners,
    side: &[u32],
    opposite: &[u32],
    vertex_at: &[u32],
    triangles: &[[u32; 3]],
    vertices: usize,
) -> Option<Vec<bool>> {
    let mut copies = vec![0_u8; vertices];
    let mut seen = vec![false; vertex_at.len()];
    for (&v, &at) in triangles.as_flattened().iter().zip(vertex_at) {
        if !std::mem::replace(&mut seen[at as usize], true) {
            copies[v as usize] = copies[v as usize].saturating_add(1);
        }
    }
    let mut is_stray = vec![true; corners.face_count()];
    for c in 0..corners.len() as u32 {
        let h = side[c as usize];
        if h == NONE || opposite[h as usize] != NONE || copies[corners.vertex(c) as usize] < 2 {
            is_stray[corners.face(c) as usize] = false;
        }
    }
    is_stray.contains(&true).then_some(is_stray)
}

/// Takes the triangles of some faces out.
fn remove(
    faces: &[bool],
    triangles: &mut Vec<[u32; 3]>,
    face: &mut Vec<u32>,
    opposite: &mut Vec<u32>,
    vertex_at: &mut Vec<u32>,
) {
    let mut left = 0_u32;
    let moved: Vec<u32> = face
        .iter()
        .map(|&f| {
            left += u32::from(!faces[f as usize]);
            left.wrapping_sub(1)
        })
        .collect();
    let is_kept = |t: usize| !faces[face[t] as usize];
    *opposite = (0..opposite.len())
        .filter(|h| is_kept(h / 3))
        .map(|h| match opposite[h] {
            NONE => NONE,
            g => 3 * moved[g as usize / 3] + g % 3,
        })
        .collect();
    *vertex_at = (0..vertex_at.len()).filter(|h| is_kept(h / 3)).map(|h| vertex_at[h]).collect();
    // Representatives may be gone: any label will do, as long as it is one a vertex.
    let mut label = std::collections::HashMap::new();
    for at in vertex_at.iter_mut() {
        let fresh = label.len() as u32;
        *at = *label.entry(*at).or_insert(fresh);
    }
    *triangles = (0..triangles.len()).filter(|&t| is_kept(t)).map(|t| triangles[t]).collect();
    face.retain(|&f| !faces[f as usize]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What the walk relies on, checked the slow way.
    fn check(vertices: usize, faces: &Faces) {
        let front = Front::new(vertices, faces);
        let surface = &front.surface;
        assert_eq!(surface.check(), Ok(()));
        let count = surface.vertices() as u32;
        let mut joined = std::collections::HashSet::new();
        for h in 0..3 * surface.triangles().len() as u32 {
            if surface.opposite(h).is_none_or(|g| h < g) {
                let (a, b) = (surface.from(h), surface.to(h));
                assert!(joined.insert((a.min(b), a.max(b))), "two edges join the same vertices");
            }
        }
        for v in 0..count {
            assert!(surface.is_boundary(v) || surface.fan(v).count() >= 3, "a vertex closed by two triangles");
        }
        // Every face is there once: loose, a repeat, or as the pieces of the surface.
        let mut pieces = vec![0; faces.len()];
        front.face.iter().for_each(|&f| pieces[f as usize] += 1);
        let mut apart = vec![0; faces.len()];
        front.loose.iter().chain(front.repeats.iter().map(|r| &r.face)).for_each(|&f| apart[f as usize] += 1);
        for (f, face) in faces.iter().enumerate() {
            let expected = if pieces[f] > 0 { (face.len() - 2, 0) } else { (0, 1) };
            assert_eq!((pieces[f], apart[f]), expected, "face {f}");
        }
        for (t, &triangle) in surface.triangles().iter().enumerate() {
            let face = faces.get(front.face[t] as usize);
            assert!(triangle.iter().all(|&v| face.contains(&front.vertex[v as usize])));
        }
        for repeat in &front.repeats {
            let cycle = |f: u32, reversed: bool| {
                let mut corners = faces.get(f as usize).to_vec();
                if reversed {
                    corners.reverse();
                }
                let least = (0..corners.len()).min_by_key(|&i| corners[i]).unwrap();
                corners.rotate_left(least);
                corners
            };
            assert_eq!(cycle(repeat.face, false), cycle(repeat.of, repeat.is_reversed));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn any_triangles_become_a_manifold(
            vertices in 1_u32..14,
            faces in proptest::collection::vec(proptest::array::uniform3(0_u32..100), 0..60),
        ) {
            let faces: Faces = faces.into_iter().map(|t| t.map(|v| v % vertices)).collect();
            check(vertices as usize, &faces);
        }

        #[test]
        fn any_polygons_become_a_manifold(
            vertices in 1_u32..16,
            polygons in proptest::collection::vec(proptest::collection::vec(0_u32..100, 0..7), 0..40),
        ) {
            let mut faces = Faces::default();
            polygons.iter().for_each(|p| faces.push(&p.iter().map(|v| v % vertices).collect::<Vec<_>>()));
            check(vertices as usize, &faces);
        }
    }

    #[test]
    fn a_sound_mesh_passes_unchanged() {
        for seed in 0..40 {
            let shape = corpus_make::any(seed, 200);
            let faces: Faces = shape.triangles.iter().copied().collect();
            let front = Front::new(shape.positions.len(), &faces);
            assert!(front.is_plain(shape.positions.len(), &faces));
            let glued = HalfEdges::new(shape.positions.len(), shape.triangles).unwrap();
            for h in 0..3 * faces.len() as u32 {
                assert_eq!(front.surface.opposite(h), glued.opposite(h));
                assert_eq!(front.vertex[front.surface.from(h) as usize], glued.from(h));
            }
        }
    }

    #[test]
    fn three_faces_on_an_edge_and_a_bow_tie_need_few_copies() {
        let copies = |triangles: &[[u32; 3]], vertices: usize| {
            Front::new(vertices, &triangles.iter().copied().collect()).vertex.len() - vertices
        };
        // Two of the three are glued; the third has copies of two vertices.
        assert_eq!(copies(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]], 5), 2);
        assert_eq!(copies(&[[0, 1, 2], [0, 3, 4]], 5), 1);
        // A strip of three sheets that meet along a line of three edges: one sheet has copies of its four vertices.
        let sheet = |at: u32| (0..3).flat_map(move |i| [[i, i + 1, at + i], [i + 1, at + i + 1, at + i]]);
        let mirrored = |at: u32| sheet(at).map(|[a, b, c]| [b, a, c]);
        let sheets: Vec<[u32; 3]> = sheet(4).chain(mirrored(8)).chain(sheet(12)).collect();
        assert_eq!(copies(&sheets, 16), 4);
    }
}
