//! Repairing: what a user may ask for, and what was done, change by change.
//!
//! 1. Vertices at one place (or nearer than a distance) become one; the first stays.
//! 2. Faces lose corners that repeat the one before; those left with fewer than three, or with a vertex twice, are dropped.
//! 3. Faces with the same cycle of vertices as an earlier one, either way round, are dropped.
//! 4. Faces are turned over until neighbours agree, the fewest that will do.
//! 5. If asked: boundary loops of few edges are closed by a polygon.
//!
//! Attributes and labels go with their elements; values on vertices that were welded move to corners where they differ.

use std::collections::{HashMap, HashSet};

use super::half_edge::NONE;
use super::orient::orient;
use super::{Attribute, Corners, Domain, Faces, Label, Mesh};

/// What to repair.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Repair {
    /// Vertices that are no farther apart than this become one. Default: 0, only those at the same place.
    pub weld: f64,
    /// Boundary loops of at most so many edges are closed. Default: 0, none.
    pub close: usize,
}

/// How much was repaired.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Repaired {
    /// Vertices that became others.
    pub welded: usize,
    /// Corners that were dropped because they repeated the one before.
    pub corners: usize,
    /// Faces that were dropped because too few corners were left, or a vertex came twice.
    pub degenerate: usize,
    /// Faces that were dropped because an earlier one has the same vertices.
    pub duplicate: usize,
    /// Faces that were turned over.
    pub turned: usize,
    /// Boundary loops that were closed.
    pub closed: usize,
}

impl Repaired {
    /// Every change in words, without full stop; nothing if there was nothing to do.
    pub fn steps(&self) -> Vec<String> {
        let plural = |n: usize, one: &str, many: &str| if n == 1 { format!("1 {one}") } else { format!("{n} {many}") };
        let mut steps = Vec::new();
        let mut step = |n: usize, verb: &str, one: &str, many: &str, rest: &str| {
            if n > 0 {
                steps.push(format!("{verb} {}{rest}", plural(n, one, many)));
            }
        };
        step(self.welded, "weld", "vertex", "vertices", " to others at the same place");
        step(self.corners, "drop", "corner", "corners", " that repeat the one before");
        step(self.degenerate, "drop", "degenerate face", "degenerate faces", "");
        step(self.duplicate, "drop", "duplicate face", "duplicate faces", "");
        step(self.turned, "turn", "face", "faces", " so that neighbours agree about the outside");
        step(self.closed, "close", "boundary loop", "boundary loops", "");
        steps
    }
}

/// A mesh in the making: for each new face the corners that it has of the old mesh ([`NONE`] for those that are new).
struct Draft {
    faces: Faces,
    from: Vec<u32>,
    /// The old number of each face.
    number: Vec<u32>,
}

impl Draft {
    fn push(&mut self, face: &[(u32, u32)], number: u32) {
        self.faces.push(&face.iter().map(|c| c.0).collect::<Vec<_>>());
        self.from.extend(face.iter().map(|c| c.1));
        self.number.push(number);
    }

    fn face(&self, f: usize) -> Vec<(u32, u32)> {
        self.faces.range(f).map(|c| (self.faces.corners()[c], self.from[c])).collect()
    }
}

impl Mesh {
    /// A repaired mesh, and what was done. O(n log n), as long as few vertices lie within the distance of welding.
    ///
    /// Faces that name vertices which do not exist are kept as they are.
    pub fn repaired(&self, wanted: &Repair) -> (Self, Repaired) {
        let mut done = Repaired::default();
        let weld = self.weld(wanted.weld);
        let is_kept = |v: usize| weld[v] as usize == v;
        done.welded = (0..weld.len()).filter(|&v| !is_kept(v)).count();
        let mut count = 0;
        let new: Vec<u32> = (0..weld.len())
            .map(|v| {
                count += u32::from(is_kept(v));
                count.wrapping_sub(1)
            })
            .collect();
        let number = |v: u32| weld.get(v as usize).map_or(v, |&w| new[w as usize]);

        let mut draft = Draft { faces: Faces::default(), from: Vec::new(), number: Vec::new() };
        let mut cycles = HashSet::new();
        for f in 0..self.faces.len() {
            let corners = self.faces.range(f);
            let n = corners.len();
            let mut face: Vec<(u32, u32)> = corners.map(|c| (number(self.faces.corners()[c]), c as u32)).collect();
            face.dedup_by_key(|c| c.0);
            while face.len() > 1 && face[0].0 == face[face.len() - 1].0 {
                face.pop();
            }
            let mut vertices: Vec<u32> = face.iter().map(|c| c.0).collect();
            vertices.sort_unstable();
            if vertices.len() < 3 || vertices.windows(2).any(|w| w[0] == w[1]) {
                done.degenerate += 1;
            } else if !cycles.insert(cycle(&face)) {
                done.duplicate += 1;
            } else {
                done.corners += n - face.len();
                draft.push(&face, f as u32);
            }
        }
        let flips = orient(&Corners::new(count as usize, &draft.faces));
        done.turned = flips.iter().filter(|&&flip| flip).count();
        if done.turned > 0 {
            draft = turned(&draft, count as usize, &flips);
        }
        done.closed = close(&mut draft, count as usize, wanted.close);
        (self.rebuilt(draft, &weld), done)
    }

    /// The vertex that each becomes.
    fn weld(&self, distance: f64) -> Vec<u32> {
        let mut weld: Vec<u32> = (0..self.positions.len() as u32).collect();
        let is_near = |p: [f64; 3], q: [f64; 3]| {
            let square: f64 = (0..3).map(|i| (p[i] - q[i]) * (p[i] - q[i])).sum();
            p == q || square <= distance * distance
        };
        // Cells as wide as the distance: what is near lies in the same or a neighbouring one.
        let cell = |p: [f64; 3], shift: [i64; 3]| {
            [0, 1, 2].map(|i| {
                if distance > 0.0 { (p[i] / distance).floor() as i64 + shift[i] } else { (p[i] + 0.0).to_bits() as i64 }
            })
        };
        let shifts: Vec<[i64; 3]> = match distance > 0.0 {
            true => (0..27).map(|i| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1]).collect(),
            false => vec![[0; 3]],
        };
        let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for (v, &p) in self.positions.iter().enumerate() {
            if p.iter().any(|x| !x.is_finite()) {
                continue;
            }
            let near = shifts.iter().filter_map(|&shift| cells.get(&cell(p, shift))).flatten();
            let first = near.filter(|&&w| is_near(p, self.positions[w as usize])).min().copied();
            match first {
                Some(w) => weld[v] = w,
                None => cells.entry(cell(p, [0; 3])).or_default().push(v as u32),
            }
        }
        weld
    }

    /// The mesh of a draft, with everything that sits on it.
    fn rebuilt(&self, draft: Draft, weld: &[u32]) -> Self {
        let kept: Vec<u32> = (0..weld.len() as u32).filter(|&v| weld[v as usize] == v).collect();
        let attributes = self.attributes.iter().map(|attribute| {
            let value = |e: u32| match attribute.indices.get(e as usize) {
                _ if e == NONE => Attribute::NONE,
                None => e,
                Some(&index) => index,
            };
            let numbers = |v: u32| attribute.get(v as usize);
            let is_one = |v: usize| weld[v] as usize == v || numbers(v as u32) == numbers(weld[v]);
            let mut domain = attribute.domain;
            let elements: Vec<u32> = match domain {
                Domain::Vertex if (0..weld.len()).all(is_one) => kept.clone(),
                Domain::Vertex => {
                    domain = Domain::Corner;
                    let corner = |&c: &u32| if c == NONE { NONE } else { self.faces.corners()[c as usize] };
                    draft.from.iter().map(corner).collect()
                }
                Domain::Corner => draft.from.clone(),
                Domain::Face => draft.number.clone(),
            };
            Attribute { domain, indices: elements.into_iter().map(value).collect(), ..attribute.clone() }
        });
        let attributes = attributes.collect();
        let label = |label: &Label| {
            let first_face = draft.number.partition_point(|&f| f < label.first_face) as u32;
            Label { first_face, ..label.clone() }
        };
        Self {
            positions: kept.iter().map(|&v| self.positions[v as usize]).collect(),
            precision: self.precision,
            labels: self.labels.iter().map(label).collect(),
            attributes,
            faces: draft.faces,
        }
    }
}

/// A face's vertices from the least on, in the direction of the lesser neighbour.
fn cycle(face: &[(u32, u32)]) -> Vec<u32> {
    let n = face.len();
    let least = (0..n).min_by_key(|&i| face[i].0).unwrap_or(0);
    let forward = face[(least + 1) % n].0 < face[(least + n - 1) % n].0;
    (0..n).map(|i| face[(least + if forward { i } else { n - i }) % n].0).collect()
}

fn turned(draft: &Draft, vertices: usize, flips: &[bool]) -> Draft {
    let mut flip = vec![false; draft.faces.len()];
    let corners = Corners::new(vertices, &draft.faces);
    flips.iter().enumerate().for_each(|(f, &is)| flip[corners.number(f as u32) as usize] = is);
    let mut new = Draft { faces: Faces::default(), from: Vec::new(), number: Vec::new() };
    for (f, flip) in flip.into_iter().enumerate() {
        let mut face = draft.face(f);
        if flip {
            face[1..].reverse();
        }
        new.push(&face, draft.number[f]);
    }
    new
}

/// Closes boundary loops of at most so many edges; only loops that meet no other at a vertex. Returns how many.
fn close(draft: &mut Draft, vertices: usize, most: usize) -> usize {
    if most < 3 {
        return 0;
    }
    // The vertex after each on the boundary, going the way of the faces; none where several loops meet.
    let corners = Corners::new(vertices, &draft.faces);
    let mut after = vec![NONE; vertices];
    let mut leaving = vec![0_u8; vertices];
    for c in (0..corners.len() as u32).filter(|&c| corners.sides(c).len() == 1) {
        let v = corners.vertex(c) as usize;
        after[v] = corners.vertex(corners.next(c));
        leaving[v] = leaving[v].saturating_add(1);
    }
    let mut closed = 0;
    let mut seen = vec![false; vertices];
    for start in 0..vertices {
        let mut face = Vec::new();
        let mut v = start;
        while !seen[v] && leaving[v] == 1 && face.len() <= most {
            seen[v] = true;
            face.push((v as u32, NONE));
            v = after[v] as usize;
        }
        if v == start && (3..=most).contains(&face.len()) {
            face.reverse();
            draft.push(&face, NONE);
            closed += 1;
        }
    }
    closed
}

#[cfg(test)]
mod tests {
    use super::super::{AttributeKind, LabelKind, Scalar};
    use super::*;

    fn mesh(positions: &[[f64; 3]], faces: &[&[u32]]) -> Mesh {
        let mut mesh = Mesh { positions: positions.to_vec(), ..Mesh::default() };
        faces.iter().for_each(|f| mesh.faces.push(f));
        mesh
    }

    #[test]
    fn a_soup_of_a_tetrahedron_becomes_one_and_values_that_differ_move_to_corners() {
        let place = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 3, 2], [2, 0, 3]];
        let positions: Vec<[f64; 3]> = faces.iter().flatten().map(|&v: &usize| place[v]).collect();
        let mut soup = Mesh::from_triangles(positions, (0..4).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]));
        let attribute = |name: &str, values: Vec<f64>| Attribute {
            kind: AttributeKind::Other,
            name: name.into(),
            domain: Domain::Vertex,
            width: 1,
            scalar: Scalar::F32,
            values,
            indices: Vec::new(),
        };
        soup.attributes = vec![
            attribute("corner", (0..12).map(f64::from).collect()),
            attribute("place", faces.iter().flatten().map(|&v| v as f64).collect()),
        ];
        soup.labels = vec![Label { kind: LabelKind::Group, name: "back".into(), first_face: 2 }];
        let (mesh, done) = soup.repaired(&Repair::default());
        assert_eq!(done, Repaired { welded: 8, turned: 1, ..Repaired::default() });
        assert!(mesh.inspect().is_closed());
        mesh.check().unwrap();
        assert_eq!(mesh.labels, soup.labels);
        assert_eq!((mesh.attributes[0].domain, mesh.attributes[1].domain), (Domain::Corner, Domain::Vertex));
        for f in 0..4 {
            for c in mesh.faces.range(f) {
                let (v, was) = (mesh.faces.corners()[c], mesh.attributes[0].get(c).unwrap()[0] as usize);
                assert_eq!(mesh.positions[v as usize], soup.positions[was]);
                assert_eq!(was / 3, f);
            }
        }
    }

    #[test]
    fn what_is_near_is_welded_and_what_is_left_of_faces_is_sound() {
        let nearly = mesh(
            &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.009], [9.0; 3]],
            &[&[0, 1, 2, 4], &[0, 2, 3], &[2, 4, 0], &[3, 0, 4], &[0, 5]],
        );
        let wanted = Repair { weld: 0.01, ..Repair::default() };
        let (back, done) = nearly.repaired(&wanted);
        assert_eq!(done, Repaired { welded: 1, corners: 1, degenerate: 2, duplicate: 1, ..Repaired::default() });
        assert_eq!((back.positions.len(), back.faces.len()), (5, 2));
        assert_eq!(nearly.repaired(&Repair::default()).1, Repaired { degenerate: 1, turned: 2, ..Repaired::default() });
        assert_eq!(back.repaired(&wanted).1, Repaired::default());
    }

    #[test]
    fn small_gaps_are_closed_only_when_asked() {
        let open = mesh(
            &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 1.0]],
            &[&[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]],
        );
        assert_eq!(open.repaired(&Repair { close: 3, ..Repair::default() }).1, Repaired::default());
        let (closed, done) = open.repaired(&Repair { close: 4, ..Repair::default() });
        assert_eq!(done, Repaired { closed: 1, ..Repaired::default() });
        assert!(closed.inspect().is_closed());
        assert_eq!(done.steps(), ["close 1 boundary loop"]);
    }
}
