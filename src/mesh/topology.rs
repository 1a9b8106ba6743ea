//! The doctor: what a mesh is like, sound or not.
//!
//! Counts parts, boundaries and handles, finds every kind of fault with the first places where it
//! occurs, and says it in plain words. It takes any mesh, however broken, and never fails.
//!
//! Polygons count by their edges, not by the triangles they would be cut into. Faces that cannot be part
//! of a surface (fewer than three corners, one vertex named twice, vertices that do not exist) are counted
//! as faults and left out of everything else. Around each vertex, faces are sorted into fans; where a vertex has
//! several, it counts as several vertices for boundary loops and for the genus, as if it had been split.

use std::collections::BTreeMap;
use std::fmt;

use glam::DVec3;

use super::{Corners, HalfEdges, Mesh, Repair, Repaired, Union};
use crate::error::{Error, MeshDefect};

/// So many places of each fault are listed.
const PLACES: usize = 10;

/// How often something occurs, and the first places.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Places<T> {
    /// How often.
    pub count: usize,
    /// The first places, at most ten, in rising order.
    pub first: Vec<T>,
}

impl<T: Ord> Places<T> {
    fn new(mut all: Vec<T>) -> Self {
        let count = all.len();
        all.sort_unstable();
        all.truncate(PLACES);
        Self { count, first: all }
    }
}

/// What [`Mesh::inspect`] found. Counts of faults are 0 in a sound mesh.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Inspection {
    /// Vertices, unused ones included.
    pub vertices: usize,
    /// Faces.
    pub faces: usize,
    /// Triangles, once polygons are cut into fans.
    pub triangles: usize,
    /// Faces by their number of corners, as (corners, faces).
    pub polygons: Vec<(usize, usize)>,
    /// Edges, each counted once.
    pub edges: usize,
    /// Parts that share no vertex.
    pub components: usize,
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Chains of boundary edges that close.
    pub boundary_loops: usize,
    /// Handles of all components together; `None` where an edge has more than two faces or the surface has one side only.
    pub genus: Option<usize>,
    /// Vertices − edges + faces, of the vertices that a face uses.
    pub euler: i64,
    /// Whether the faces can all be turned so that neighbours agree about the outside.
    pub orientable: bool,
    /// How many faces at least have to be turned for that, if it is possible.
    pub faces_to_turn: usize,
    /// The lowest and the highest corner of the box of all finite vertices.
    pub bounds: Option<[[f64; 3]; 2]>,
    /// The diagonal of that box, 0 without one.
    pub diagonal: f64,
    /// Edges with more than two faces.
    pub non_manifold_edges: Places<[u32; 2]>,
    /// Vertices whose faces form more than one fan.
    pub non_manifold_vertices: Places<u32>,
    /// Edges that two faces walk in the same direction: they disagree about which side is outside.
    pub flipped_edges: Places<[u32; 2]>,
    /// Faces of fewer than three corners, or that name a vertex twice.
    pub degenerate_faces: Places<u32>,
    /// Faces with a vertex that does not exist.
    pub broken_faces: Places<u32>,
    /// Faces with the same vertices as an earlier face.
    pub duplicate_faces: Places<u32>,
    /// Faces without area whose vertices differ.
    pub flat_faces: Places<u32>,
    /// Triangles without area among those that all other faces would be cut into.
    pub flat_triangles: usize,
    /// Vertices that no face uses.
    pub isolated_vertices: Places<u32>,
    /// Vertices at the same place as an earlier vertex.
    pub duplicate_positions: Places<u32>,
    /// Vertices with a coordinate that is not a finite number.
    pub non_finite_vertices: Places<u32>,
    /// Why the faces, cut into fans of triangles, are not an oriented manifold of finite triangles; `None` if they are.
    pub obstacle: Option<MeshDefect>,
    /// What [`Mesh::repaired`] would do, with nothing asked for beside.
    pub repaired: Repaired,
}

impl Mesh {
    /// Examines the mesh. O(n log n).
    pub fn inspect(&self) -> Inspection {
        let vertices = self.positions.len();
        let broken = |f: &[u32]| f.iter().any(|&v| v as usize >= vertices);
        let sound: Vec<bool> = self.faces.iter().map(|f| !broken(f) && !is_degenerate(f)).collect();
        let corners = Corners::of(vertices, &self.faces, |f| sound[f]);
        let faces_where = |wanted: &dyn Fn(usize, &[u32]) -> bool| {
            Places::new(self.faces.iter().enumerate().filter(|&(i, f)| wanted(i, f)).map(|(i, _)| i as u32).collect())
        };
        let mut used = vec![false; vertices];
        self.faces.corners().iter().for_each(|&v| used.get_mut(v as usize).into_iter().for_each(|u| *u = true));
        let vertices_where =
            |wanted: &dyn Fn(usize) -> bool| Places::new((0..vertices).filter(|&v| wanted(v)).map(|v| v as u32).collect());
        let finite = |v: usize| self.positions[v].iter().all(|x| x.is_finite());
        let bounds = crate::plane::bounding_box(self.positions.iter().filter(|p| p.iter().all(|x| x.is_finite())).copied());
        let flat = |t: [u32; 3]| self.is_flat(t);
        let surface = Surface::new(&corners, vertices);
        Inspection {
            vertices,
            faces: self.faces.len(),
            triangles: self.faces.iter().map(|f| f.len().saturating_sub(2)).sum(),
            polygons: self
                .faces
                .iter()
                .fold(BTreeMap::new(), |mut n, f| {
                    *n.entry(f.len()).or_insert(0) += 1;
                    n
                })
                .into_iter()
                .collect(),
            edges: corners.edges().len(),
            components: surface.components,
            boundary_edges: surface.boundary_edges,
            boundary_loops: surface.boundary_loops,
            genus: surface.genus,
            euler: surface.used as i64 - corners.edges().len() as i64 + corners.face_count() as i64,
            orientable: surface.faces_to_turn.is_some(),
            faces_to_turn: surface.faces_to_turn.unwrap_or(0),
            bounds,
            diagonal: bounds.map_or(0.0, |[lo, hi]| DVec3::from(lo).distance(DVec3::from(hi))),
            non_manifold_edges: Places::new(surface.crowded),
            non_manifold_vertices: vertices_where(&|v| surface.fans[v] > 1),
            flipped_edges: Places::new(surface.flipped),
            degenerate_faces: faces_where(&|_, f| !broken(f) && is_degenerate(f)),
            broken_faces: faces_where(&|_, f| broken(f)),
            duplicate_faces: self.duplicate_faces(&corners),
            flat_faces: faces_where(&|i, f| sound[i] && fan(f).all(flat)),
            flat_triangles: self.faces.iter().zip(&sound).filter(|x| *x.1).flat_map(|x| fan(x.0)).filter(|&t| flat(t)).count(),
            isolated_vertices: vertices_where(&|v| !used[v]),
            duplicate_positions: self.duplicate_positions(),
            non_finite_vertices: vertices_where(&|v| !finite(v)),
            obstacle: self.obstacle(),
            repaired: self.repaired(&Repair::default()).1,
        }
    }

    /// Whether a triangle of finite corners has no area.
    fn is_flat(&self, t: [u32; 3]) -> bool {
        let [a, b, c] = t.map(|v| DVec3::from(self.positions[v as usize]));
        (b - a).cross(c - a) == DVec3::ZERO
    }

    fn duplicate_faces(&self, corners: &Corners) -> Places<u32> {
        let mut keys: Vec<(Vec<u32>, u32)> = (0..corners.face_count() as u32)
            .map(|f| {
                let mut key = corners.of_face(f).to_vec();
                key.sort_unstable();
                (key, corners.number(f))
            })
            .collect();
        keys.sort_unstable();
        Places::new(keys.chunk_by(|x, y| x.0 == y.0).flat_map(|same| &same[1..]).map(|x| x.1).collect())
    }

    fn duplicate_positions(&self) -> Places<u32> {
        // −0 and 0 are the same place; what is not a number is at no place.
        let place = |(v, p): (usize, &[f64; 3])| (p.map(|x| (x + 0.0).to_bits()), v as u32);
        let numbers = self.positions.iter().enumerate().filter(|(_, p)| p.iter().all(|x| !x.is_nan()));
        let mut keys: Vec<([u64; 3], u32)> = numbers.map(place).collect();
        keys.sort_unstable();
        Places::new(keys.chunk_by(|x, y| x.0 == y.0).flat_map(|same| &same[1..]).map(|x| x.1).collect())
    }

    fn obstacle(&self) -> Option<MeshDefect> {
        let triangles = self.faces.triangles();
        if triangles.is_empty() {
            return Some(MeshDefect::Empty);
        }
        match self.check().and_then(|()| HalfEdges::new(self.positions.len(), triangles).map(|_| ())) {
            // Half-edges count triangles; a report counts faces.
            Err(Error::Mesh(MeshDefect::Degenerate { face })) => {
                let mut ends = self.faces.iter().scan(0, |end, f| {
                    *end += f.len().saturating_sub(2);
                    Some(*end)
                });
                let face = ends.position(|end| end > face as usize).map_or(face, |f| f as u32);
                Some(MeshDefect::Degenerate { face })
            }
            Err(Error::Mesh(defect)) => Some(defect),
            _ => None,
        }
    }
}

/// Fewer than three corners, or a vertex named twice.
fn is_degenerate(face: &[u32]) -> bool {
    let mut sorted = face.to_vec();
    sorted.sort_unstable();
    sorted.len() < 3 || sorted.windows(2).any(|pair| pair[0] == pair[1])
}

/// The triangles of a face.
fn fan(face: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    face[1..].windows(2).map(|edge| [face[0], edge[0], edge[1]])
}

/// What the sound faces make up together.
struct Surface {
    used: usize,
    components: usize,
    boundary_edges: usize,
    boundary_loops: usize,
    genus: Option<usize>,
    /// `None` if no way of turning makes all neighbours agree.
    faces_to_turn: Option<usize>,
    crowded: Vec<[u32; 2]>,
    flipped: Vec<[u32; 2]>,
    /// For each vertex the number of fans of faces around it.
    fans: Vec<u32>,
}

impl Surface {
    fn new(corners: &Corners, vertices: usize) -> Self {
        let faces = corners.face_count();
        // Corners of one fan; vertices of one component; faces over edges of two; the same with a side of the face each,
        // where neighbours that agree join equal sides: face `f` as it is and, at `f + faces`, turned.
        let mut fans = Union::new(corners.len());
        let mut components = Union::new(vertices);
        let mut pieces = Union::new(faces);
        let mut sides = Union::new(2 * faces);
        let (mut crowded, mut flipped, mut boundary) = (Vec::new(), Vec::new(), Vec::new());
        for edge in corners.edges() {
            let c = edge[0];
            let (v, w) = (corners.vertex(c), corners.vertex(corners.next(c)));
            components.join(v, w);
            for &d in &edge[1..] {
                let (at_v, at_w) = if corners.vertex(d) == v { (d, corners.next(d)) } else { (corners.next(d), d) };
                fans.join(c, at_v);
                fans.join(corners.next(c), at_w);
            }
            let ends = [v.min(w), v.max(w)];
            match *edge {
                [_] => boundary.push(c),
                [_, d] => {
                    let (f, g, turned) = (corners.face(c), corners.face(d), faces as u32);
                    pieces.join(f, g);
                    let alike = corners.run_alike(c, d);
                    if alike {
                        flipped.push(ends);
                    }
                    let across = if alike { [(f, g + turned), (f + turned, g)] } else { [(f, g), (f + turned, g + turned)] };
                    across.into_iter().for_each(|(x, y)| sides.join(x, y));
                }
                _ => crowded.push(ends),
            }
        }

        // Boundary edges that end in one fan follow each other around a loop.
        let (fan_of, fan_count) = fans.numbered();
        let mut loops = Union::new(boundary.len());
        let mut at_fan = vec![None; fan_count];
        for (i, &c) in boundary.iter().enumerate() {
            for end in [c, corners.next(c)] {
                match &mut at_fan[fan_of[end as usize] as usize] {
                    Some(other) => loops.join(*other, i as u32),
                    empty => *empty = Some(i as u32),
                }
            }
        }
        let (_, boundary_loops) = loops.numbered();

        let mut fans = vec![0; vertices];
        let mut counted = vec![false; fan_count];
        for (c, &fan) in fan_of.iter().enumerate() {
            if !std::mem::replace(&mut counted[fan as usize], true) {
                fans[corners.vertex(c as u32) as usize] += 1;
            }
        }
        let used = fans.iter().filter(|&&n| n > 0).count();
        let (_, sets) = components.numbered();
        let faces_to_turn = faces_to_turn(sides, faces);
        let (_, pieces) = pieces.numbered();
        let split = fan_count as i64 - corners.edges().len() as i64 + faces as i64;
        let twice = 2 * pieces as i64 - split - boundary_loops as i64;
        let defined = crowded.is_empty() && faces_to_turn.is_some() && twice >= 0 && twice % 2 == 0;
        Self {
            used,
            components: sets - (vertices - used),
            boundary_edges: boundary.len(),
            boundary_loops,
            genus: defined.then_some(twice as usize / 2),
            faces_to_turn,
            crowded,
            flipped,
            fans,
        }
    }
}

/// How few faces can be turned so that all neighbours agree; `None` if a face would have to agree with its own other side.
fn faces_to_turn(sides: Union, faces: usize) -> Option<usize> {
    let (set, sets) = sides.numbered();
    let (mut as_is, mut turned) = (vec![0_usize; sets], 0);
    for f in 0..faces {
        if set[f] == set[f + faces] {
            return None;
        }
        as_is[set[f] as usize] += 1;
    }
    // Each piece shows up twice: with these faces as they are and the others turned, and the other way round.
    let mut done = vec![false; sets];
    for f in 0..faces {
        let (one, other) = (set[f] as usize, set[f + faces] as usize);
        if !std::mem::replace(&mut done[one.min(other)], true) {
            turned += as_is[one].min(as_is[other]);
        }
    }
    Some(turned)
}

impl Inspection {
    /// Whether every face is sound, every edge has at most two faces that agree, and every vertex one fan.
    pub fn is_manifold(&self) -> bool {
        let edges = self.non_manifold_edges.count + self.flipped_edges.count;
        edges + self.non_manifold_vertices.count + self.degenerate_faces.count + self.broken_faces.count == 0
    }

    /// Whether the mesh is manifold and has no boundary.
    pub fn is_closed(&self) -> bool {
        self.is_manifold() && self.faces > 0 && self.boundary_edges == 0
    }

    /// Whether method `cgim` takes the mesh as it is: it has vertices, finite ones, and its faces name no others.
    pub fn can_be_encoded(&self) -> bool {
        self.vertices > 0 && self.non_finite_vertices.count + self.broken_faces.count == 0
    }

    /// What repairing would do, a sentence without full stop for each step; nothing if there is nothing to do.
    pub fn repairs(&self) -> Vec<String> {
        self.repaired.steps()
    }

    /// Every kind of fault that occurs: how often, said in words, and the first places.
    fn faults(&self) -> Vec<(String, String)> {
        let mut faults = Vec::new();
        let list =
            |first: Vec<String>, count: usize| format!("{}{}", first.join(", "), if count > first.len() { ", …" } else { "" });
        let mut edges = |p: &Places<[u32; 2]>, one: &str, many: &str| {
            if p.count > 0 {
                let first = p.first.iter().map(|[a, b]| format!("{a}–{b}")).collect();
                faults.push((counted(p.count, one, many), list(first, p.count)));
            }
        };
        edges(&self.non_manifold_edges, "{} edge has more than two faces", "{} edges have more than two faces");
        let disagree = "in the same direction by both faces, which so disagree about the outside";
        edges(&self.flipped_edges, &format!("{{}} edge is walked {disagree}"), &format!("{{}} edges are walked {disagree}"));
        let mut single = |p: &Places<u32>, one: &str, many: &str| {
            if p.count > 0 {
                faults.push((counted(p.count, one, many), list(p.first.iter().map(u32::to_string).collect(), p.count)));
            }
        };
        let fans = "several fans of faces";
        single(&self.non_manifold_vertices, &format!("{{}} vertex joins {fans}"), &format!("{{}} vertices join {fans}"));
        let fewer = "fewer than three corners";
        single(
            &self.degenerate_faces,
            &format!("{{}} face names one vertex twice or has {fewer}"),
            &format!("{{}} faces name one vertex twice or have {fewer}"),
        );
        let missing = "a vertex that does not exist";
        single(&self.broken_faces, &format!("{{}} face names {missing}"), &format!("{{}} faces name {missing}"));
        let again = "the same vertices as an earlier face";
        single(&self.duplicate_faces, &format!("{{}} face has {again}"), &format!("{{}} faces have {again}"));
        single(&self.flat_faces, "{} face has no area", "{} faces have no area");
        single(&self.isolated_vertices, "{} vertex is used by no face", "{} vertices are used by no face");
        let place = "at the same place as an earlier vertex";
        single(&self.duplicate_positions, &format!("{{}} vertex is {place}"), &format!("{{}} vertices are {place}"));
        let number = "a coordinate that is not a finite number";
        single(&self.non_finite_vertices, &format!("{{}} vertex has {number}"), &format!("{{}} vertices have {number}"));
        faults
    }
}

/// A phrase with its number put in, `one` or `many` as it asks for.
fn counted(n: usize, one: &str, many: &str) -> String {
    (if n == 1 { one } else { many }).replace("{}", &thousands(n))
}

/// `1234567` as `1,234,567`.
fn thousands(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(c);
    }
    text
}

/// The report in plain words: what the mesh is, what is wrong with it and where, and what can be done.
impl fmt::Display for Inspection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let vertices = counted(self.vertices, "{} vertex", "{} vertices");
        writeln!(f, "{vertices}, {}{}.", counted(self.faces, "{} face", "{} faces"), self.kinds())?;
        let shape = match (self.is_manifold(), self.is_closed()) {
            _ if self.faces == 0 => "There is no surface",
            (_, true) => "The surface is a closed oriented manifold",
            (true, false) => "The surface is an oriented manifold with boundary",
            _ => "The surface is not an oriented manifold",
        };
        write!(f, "{shape}: {}", counted(self.components, "{} component", "{} components"))?;
        write!(f, ", {}", counted(self.boundary_loops, "{} boundary loop", "{} boundary loops"))?;
        match self.genus {
            Some(genus) => write!(f, ", genus {genus}")?,
            None => write!(f, ", genus not defined")?,
        }
        writeln!(f, ", {} (vertices − edges + faces = {}).", counted(self.edges, "{} edge", "{} edges"), self.euler)?;
        if !self.orientable {
            writeln!(f, "It has one side only, like a Möbius strip: no way of turning faces makes all neighbours agree.")?;
        }
        if let Some([lo, hi]) = self.bounds {
            let point = |p: [f64; 3]| format!("({}, {}, {})", p[0], p[1], p[2]);
            writeln!(f, "It lies between {} and {}, a diagonal of {:.6}.", point(lo), point(hi), self.diagonal)?;
        }
        let faults = self.faults();
        if faults.is_empty() {
            writeln!(f, "\nNo faults were found.")?;
        } else {
            writeln!(f, "\nFaults, with the first places (counted from 0):")?;
            for (what, places) in faults {
                writeln!(f, "  {what}: {places}")?;
            }
        }
        match &self.obstacle {
            None => writeln!(f, "\nEvery method takes oriented manifolds: this mesh can be encoded as it is."),
            Some(why) if self.can_be_encoded() => writeln!(
                f,
                "\nMethod cgim takes it as it is, and stores beside the surface what makes it no oriented manifold. Methods that \
                 sample the surface anew do not: {why}."
            ),
            Some(why) => writeln!(f, "\nIt cannot be encoded: {why}."),
        }?;
        match self.repairs().as_slice() {
            [] => Ok(()),
            steps => writeln!(f, "Repairing would {}.", steps.join(", ")),
        }
    }
}

impl Inspection {
    /// `: 12 triangles, 3 quads, 4 polygons of up to 8 corners`; nothing where all are triangles.
    fn kinds(&self) -> String {
        if let [] | [(3, _)] = self.polygons[..] {
            return String::new();
        }
        let mut kinds = Vec::new();
        let mut kind = |from: usize, to: usize, one: &str, many: &str| {
            let of = self.polygons.iter().filter(|p| (from..=to).contains(&p.0));
            let (n, most) = of.fold((0, 0), |(n, most), &(corners, faces)| (n + faces, corners.max(most)));
            if n > 0 {
                kinds.push(counted(n, one, many).replace("{most}", &most.to_string()));
            }
        };
        kind(0, 2, "{} of fewer than three corners", "{} of fewer than three corners");
        kind(3, 3, "{} triangle", "{} triangles");
        kind(4, 4, "{} quad", "{} quads");
        kind(5, usize::MAX, "{} polygon of {most} corners", "{} polygons of up to {most} corners");
        format!(": {}", kinds.join(", "))
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
        mesh.inspect()
    }

    #[test]
    fn a_cube_of_quads_is_closed_and_of_genus_0() {
        let cube: [&[u32]; 6] = [&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]];
        let found = inspect(9, &cube);
        assert!(found.is_closed());
        assert_eq!((found.edges, found.components, found.boundary_loops, found.genus), (12, 1, 0, Some(0)));
        assert_eq!((found.isolated_vertices.count, found.polygons.clone()), (1, vec![(4, 6)]));
        assert_eq!((found.triangles, found.euler, found.obstacle), (12, 2, None));
    }

    #[test]
    fn a_torus_of_quads_has_one_handle_and_a_hole_in_it_one_loop() {
        let at = |i: u32, j: u32| (i % 4) * 4 + j % 4;
        let faces: Vec<[u32; 4]> =
            (0..16).map(|f| (f / 4, f % 4)).map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
        let slices: Vec<&[u32]> = faces.iter().map(|f| &f[..]).collect();
        let found = inspect(16, &slices);
        assert_eq!((found.boundary_loops, found.genus, found.euler), (0, Some(1), 0));
        let found = inspect(16, &slices[1..]);
        assert_eq!((found.boundary_loops, found.genus, found.boundary_edges), (1, Some(1), 4));
    }

    #[test]
    fn every_fault_is_counted_once_and_has_its_place() {
        let bow_tie = inspect(5, &[&[0, 1, 2], &[0, 3, 4]]);
        assert_eq!((&bow_tie.non_manifold_vertices.first[..], bow_tie.components, bow_tie.boundary_loops), (&[0][..], 1, 2));
        assert_eq!(bow_tie.genus, Some(0));
        assert_eq!(bow_tie.obstacle, Some(MeshDefect::NonManifoldVertex { vertex: 0 }));
        let fin = inspect(5, &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]]);
        assert_eq!((&fin.non_manifold_edges.first[..], fin.non_manifold_vertices.count, fin.genus), (&[[0, 1]][..], 0, None));
        let flipped = inspect(4, &[&[0, 1, 2], &[0, 1, 3]]);
        assert_eq!((&flipped.flipped_edges.first[..], flipped.non_manifold_vertices.count), (&[[0, 1]][..], 0));
        assert_eq!((flipped.genus, flipped.boundary_loops, flipped.orientable, flipped.faces_to_turn), (Some(0), 1, true, 1));
        let worn = inspect(4, &[&[0, 1, 2], &[2, 0, 1], &[1, 1, 3], &[0, 3], &[0, 1, 9]]);
        assert_eq!((&worn.duplicate_faces.first[..], &worn.degenerate_faces.first[..]), (&[1][..], &[2, 3][..]));
        assert_eq!((&worn.broken_faces.first[..], worn.components), (&[4][..], 1));
        let narrow = inspect(5, &[&[0, 1, 2, 3], &[3, 2, 2, 4]]);
        assert_eq!(narrow.obstacle, Some(MeshDefect::Degenerate { face: 1 }));
    }

    #[test]
    fn a_moebius_strip_has_one_side_one_loop_and_no_genus() {
        // Five quads around, the last of them turned over.
        let strip: Vec<[u32; 4]> = (0..5)
            .map(|i| (2 * i, 2 * i + 2))
            .map(|(a, b)| match b {
                10 => [a, 1, 0, a + 1],
                _ => [a, b, b + 1, a + 1],
            })
            .collect();
        let found = inspect(10, &strip.iter().map(|f| &f[..]).collect::<Vec<_>>());
        assert_eq!((found.orientable, found.boundary_loops, found.genus, found.euler), (false, 1, None, 0));
        assert_eq!(found.flipped_edges.count, 1);
        assert!(found.to_string().contains("one side only"), "{found}");
    }

    #[test]
    fn the_fewest_faces_are_turned_in_each_piece() {
        // Two tetrahedra; one face of the first and three of the second look inwards.
        let tetrahedron = |v: u32, inwards: usize| {
            [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].into_iter().enumerate().map(move |(i, t): (usize, [u32; 3])| {
                let [a, b, c] = t.map(|x| x + v);
                if i < inwards { [a, c, b] } else { [a, b, c] }
            })
        };
        let faces: Vec<[u32; 3]> = tetrahedron(0, 1).chain(tetrahedron(4, 3)).collect();
        let found = inspect(8, &faces.iter().map(|f| &f[..]).collect::<Vec<_>>());
        assert_eq!((found.faces_to_turn, found.flipped_edges.count, found.genus), (2, 6, Some(0)));
        assert_eq!(found.repairs(), ["turn 2 faces so that neighbours agree about the outside"]);
    }

    #[test]
    fn places_that_coincide_and_faces_without_area_are_counted() {
        let mut mesh = Mesh::from_triangles(
            vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [-0.0, 0.0, 0.0], [f64::NAN, 0.0, 0.0], [f64::NAN, 0.0, 0.0]],
            [[0, 1, 2], [0, 1, 4]],
        );
        mesh.faces.push(&[]);
        let found = mesh.inspect();
        assert_eq!((&found.flat_faces.first[..], &found.duplicate_positions.first[..]), (&[0][..], &[3][..]));
        assert_eq!((&found.non_finite_vertices.first[..], &found.isolated_vertices.first[..]), (&[4, 5][..], &[3, 5][..]));
        assert_eq!((found.bounds, found.diagonal), (Some([[0.0; 3], [2.0, 0.0, 0.0]]), 2.0));
        assert_eq!(found.flat_triangles, 1);
    }

    #[test]
    fn only_the_first_places_are_listed_and_the_count_is_of_all() {
        let found = inspect(25, &[&[0, 1, 2]]);
        assert_eq!(
            (found.isolated_vertices.count, &found.isolated_vertices.first[..]),
            (22, &[3, 4, 5, 6, 7, 8, 9, 10, 11, 12][..])
        );
        assert!(found.to_string().contains("22 vertices are used by no face: 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, …"), "{found}");
    }

    #[test]
    fn nothing_at_all_is_reported_on_too() {
        let found = Mesh::default().inspect();
        assert_eq!((found.components, found.genus, found.euler, found.bounds), (0, Some(0), 0, None));
        assert_eq!(found.obstacle, Some(MeshDefect::Empty));
        assert!(found.to_string().contains("no surface"), "{found}");
    }
}
