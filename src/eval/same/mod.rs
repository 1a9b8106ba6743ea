//! Do two meshes have the same connectivity, up to the order of vertices, faces and corners?
//!
//! They do if there is a one-to-one map of the used vertices that carries the oriented faces of one,
//! each up to a cyclic turn and counted as often as it occurs, onto those of the other; with a tolerance,
//! no coordinate may move farther than that on the way. Any polygons will do, manifold or not. The answer
//! is never a guess: *same* is confirmed by the faces under the map that was found, *different* comes
//! from something that no map changes or from a search that tried everything, and a search that grows
//! beyond its budget is *undecided*.
//!
//! In order, from cheap to dear: counts; the same numbers; the nearest vertices; colours ([`shape`]: vertices
//! told apart by the faces around them, round after round); a walk over both surfaces in lockstep ([`search`]).

mod search;
mod shape;

use super::report::json::Json;
use crate::error::{Error, Result};
use crate::geom::PointTree;
use crate::mesh::{Corners, Mesh, NONE};
use crate::par;
use crate::task::Task;
use search::{Found, Search};
use shape::Shape;

/// An answer that may be missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Proven by a map of the vertices.
    Same,
    /// Proven by something that no map changes, or by trying every map.
    Different,
    /// The search was given up.
    Undecided,
}

impl Verdict {
    /// `true`, `false`, or `null` if undecided.
    pub fn to_json(self) -> Json {
        match self {
            Self::Same => true.into(),
            Self::Different => false.into(),
            Self::Undecided => Json::Null,
        }
    }
}

/// What [`same`] found.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Correspondence {
    /// Whether a map within the tolerance carries one mesh onto the other.
    pub verdict: Verdict,
    /// Whether any map does, wherever it puts the vertices.
    pub connectivity: Verdict,
    /// For each vertex of the first mesh that of the second, if a map was found; [`Correspondence::UNUSED`]
    /// for vertices that no face uses.
    pub map: Option<Vec<u32>>,
    /// The largest difference of a coordinate under the map.
    pub largest_move: Option<f64>,
    /// Why the verdict is not *same*; empty if it is.
    pub reason: String,
}

impl Correspondence {
    /// No vertex.
    pub const UNUSED: u32 = NONE;

    fn different(reason: impl Into<String>) -> Self {
        Self {
            verdict: Verdict::Different,
            connectivity: Verdict::Different,
            map: None,
            largest_move: None,
            reason: reason.into(),
        }
    }
}

/// Looks for a map of vertices that carries the faces of `a` onto those of `b`.
///
/// With a `tolerance`, no coordinate may move farther. Without one, the map that moves vertices little is looked
/// for first, so that it is the right one also where a mesh is symmetric. If one mesh is all triangles and
/// the other is not, the other's polygons are cut into fans first. Faces of fewer than three corners and vertices that no
/// face uses do not count.
///
/// O(n log n) on meshes that occur; the budget bounds what contrived ones may cost.
///
/// # Errors
/// [`Error::Cancelled`] if the task is over.
pub fn same(a: &Mesh, b: &Mesh, tolerance: Option<f64>, task: &Task<'_>) -> Result<Correspondence> {
    let fanned = |mesh: &Mesh| Mesh {
        faces: mesh.faces.triangles().into_iter().collect(),
        ..Mesh::from_triangles(mesh.positions.clone(), [])
    };
    let cut = match (a.faces.are_triangles(), b.faces.are_triangles()) {
        (false, true) => Some((fanned(a), b.clone())),
        (true, false) => Some((a.clone(), fanned(b))),
        _ => None,
    };
    match &cut {
        Some((a, b)) => compare(a, b, tolerance, task),
        None => compare(a, b, tolerance, task),
    }
}

fn compare(a: &Mesh, b: &Mesh, tolerance: Option<f64>, task: &Task<'_>) -> Result<Correspondence> {
    for (which, mesh) in [("first", a), ("second", b)] {
        if mesh.faces.corners().iter().any(|&v| v as usize >= mesh.positions.len()) {
            return Ok(Correspondence::different(format!("the {which} mesh has a face with a vertex that does not exist")));
        }
    }
    let (mut x, mut y) = par::join(|| Shape::new(a), || Shape::new(b));
    let differ = |what: &str, x: usize, y: usize| Ok(Correspondence::different(format!("{what}: {x} and {y}")));
    if x.used.len() != y.used.len() {
        return differ("vertices that a face uses", x.used.len(), y.used.len());
    }
    if x.corners.face_count() != y.corners.face_count() {
        return differ("faces", x.corners.face_count(), y.corners.face_count());
    }
    let question = Question { tolerance, faces: canonical(&y.corners, |v| v) };
    if question.faces.len() != x.corners.len() + x.corners.face_count() {
        return differ("corners of all faces", x.corners.len(), y.corners.len());
    }

    // The same numbers.
    if x.used == y.used {
        let mut map = vec![NONE; a.positions.len()];
        x.used.iter().for_each(|&v| map[v as usize] = v);
        if let Some(found) = question.answered_by(map, &x, &y) {
            return Ok(found);
        }
    }
    // The nearest vertices.
    let points: Vec<_> = y.used.iter().map(|&w| y.positions[w as usize]).collect();
    let tree = PointTree::new(&points);
    let nearest = par::map(x.used.len(), |i| tree.nearest(x.positions[x.used[i] as usize]));
    let mut map = vec![NONE; a.positions.len()];
    let mut least_move = 0.0_f64;
    for (&v, (w, d)) in x.used.iter().zip(nearest.into_iter().flatten()) {
        map[v as usize] = y.used[w as usize];
        least_move = least_move.max(d);
    }
    if let Some(found) = question.answered_by(map, &x, &y) {
        return Ok(found);
    }
    if task.is_over() {
        return Err(Error::Cancelled);
    }
    if !shape::colour(&mut x, &mut y) {
        return Ok(Correspondence::different("the faces around vertices do not agree"));
    }
    let search = |tolerance| Search::new(&x, &y, &tree, tolerance, task).run();
    // Some vertex moves that far under any map. The right one is likely to do with little more, and where a mesh is
    // symmetric or has equal components, a bound is what keeps others away.
    let bound = search(tolerance.or(Some(LITTLE_MORE * least_move)))?;
    if let Found::Map(map) = bound {
        return Ok(question.judged(map, &x, &y));
    }
    Ok(match search(None)? {
        Found::Map(map) => {
            let mut found = question.judged(map, &x, &y);
            if found.verdict == Verdict::Different && found.connectivity == Verdict::Same && bound == Found::GaveUp {
                found.verdict = Verdict::Undecided;
                found.reason = "the search for a map within the tolerance was given up".into();
            }
            found
        }
        Found::Nothing => Correspondence::different("walking both surfaces in lockstep leads nowhere"),
        Found::GaveUp => {
            let verdict = if tolerance.is_some() && bound == Found::Nothing { Verdict::Different } else { Verdict::Undecided };
            let reason = "the search for a map was given up".into();
            Correspondence { verdict, connectivity: Verdict::Undecided, map: None, largest_move: None, reason }
        }
    })
}

/// How much farther than the least that some vertex must move anyway all of them may at first.
const LITTLE_MORE: f64 = 2.0;

/// What a map must do.
struct Question {
    tolerance: Option<f64>,
    /// The faces of the second mesh.
    faces: Vec<u32>,
}

impl Question {
    /// The answer, if the map is one.
    fn answered_by(&self, map: Vec<u32>, x: &Shape, y: &Shape) -> Option<Correspondence> {
        let found = self.judged(map, x, y);
        (found.verdict == Verdict::Same).then_some(found)
    }

    /// What a map proves.
    fn judged(&self, map: Vec<u32>, x: &Shape, y: &Shape) -> Correspondence {
        let mut taken = vec![false; y.positions.len()];
        let one_to_one = x.used.iter().all(|&v| {
            let w = map[v as usize];
            w != NONE && !std::mem::replace(&mut taken[w as usize], true)
        });
        if !one_to_one || canonical(&x.corners, |v| map[v as usize]) != self.faces {
            return Correspondence::different("the map does not carry the faces");
        }
        let moved = |v: u32| (x.positions[v as usize] - y.positions[map[v as usize] as usize]).abs().max_element();
        let largest = x.used.iter().map(|&v| moved(v)).fold(0.0, f64::max);
        let far = self.tolerance.is_some_and(|most| largest > most);
        Correspondence {
            verdict: if far { Verdict::Different } else { Verdict::Same },
            connectivity: Verdict::Same,
            largest_move: Some(largest),
            map: Some(map),
            reason: if far {
                format!("the connectivity is the same, but a coordinate moves by {largest}")
            } else {
                String::new()
            },
        }
    }
}

/// All faces under a renaming of vertices as one list, whatever their order and first corners: each face's
/// length and corners from its least turn on, sorted.
fn canonical(corners: &Corners, rename: impl Fn(u32) -> u32) -> Vec<u32> {
    let mut flat = Vec::with_capacity(corners.len());
    let mut faces = Vec::with_capacity(corners.face_count());
    for f in 0..corners.face_count() as u32 {
        let start = flat.len();
        flat.extend(corners.of_face(f).iter().map(|&v| rename(v)));
        let face = &mut flat[start..];
        let n = face.len();
        face.rotate_left(least_turn(face));
        faces.push((start, n));
    }
    faces.sort_unstable_by(|&(s, n), &(t, m)| n.cmp(&m).then_with(|| flat[s..s + n].cmp(&flat[t..t + m])));
    let mut sorted = Vec::with_capacity(flat.len() + faces.len());
    for (start, n) in faces {
        sorted.push(n as u32);
        sorted.extend_from_slice(&flat[start..start + n]);
    }
    sorted
}

/// How far a list must be turned to become the least of its turns. O(n): two candidates race, and whichever loses
/// after `k` equal steps takes all turns within these `k` steps out of the race with it.
fn least_turn(list: &[u32]) -> usize {
    let n = list.len();
    let (mut i, mut j, mut k) = (0, 1, 0);
    while i < n && j < n && k < n {
        match list[(i + k) % n].cmp(&list[(j + k) % n]) {
            std::cmp::Ordering::Equal => {
                k += 1;
                continue;
            }
            std::cmp::Ordering::Greater => i += k + 1,
            std::cmp::Ordering::Less => j += k + 1,
        }
        j += usize::from(i == j);
        k = 0;
    }
    i.min(j)
}

#[cfg(test)]
mod tests;
