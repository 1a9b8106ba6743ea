//! The order that a mesh had: of its vertices, of its faces, and where each face began (spec/any-mesh.md, "ORDR").
//!
//! A walk numbers vertices and faces anew. Where the old order is wanted, each new vertex tells its old number, and each
//! face too. Old numbers mostly follow each other where the walk followed a row of the mesh; elsewhere they are near those of a
//! neighbour. Faces may be told in the order of their least old vertices instead, which many files are sorted by.

use super::neighbour::{LastFaces, latest_neighbours};
use crate::entropy::{AdaptiveBit, BitCoder, BitReader, BitWriter, Numbers};
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::mesh::Faces;

/// For vertices and faces as they are decoded, where they were.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(crate) struct Renumbering {
    /// The old number of every vertex.
    pub(crate) vertices: Vec<u32>,
    /// The old number of every face.
    pub(crate) faces: Vec<u32>,
    /// By how many corners every face is turned: the corner that was the first.
    pub(crate) turns: Vec<u32>,
}

/// Bytes of memory that reading takes.
pub(crate) fn memory(vertices: u32, faces: u32) -> u64 {
    u64::from(vertices) * 13 + u64::from(faces) * (5 + 4 + 12 + 24)
}

/// Steps that reading takes.
pub(crate) fn work(vertices: u32, faces: u32) -> u64 {
    u64::from(vertices) + 2 * u64::from(faces)
}

/// Writes an order; of two ways to go through the faces, the one that takes fewer bytes.
#[cfg(feature = "encode")]
pub(crate) fn write(faces: &Faces, order: &Renumbering) -> Result<Vec<u8>> {
    let mut best: Option<Vec<u8>> = None;
    for sorts in [false, true] {
        let mut budget = Budget::new(crate::Limits::default().memory(u64::MAX).work(u64::MAX).vertices(u64::MAX));
        let mut coder = BitWriter::default();
        code(&mut coder, faces, order.vertices.len(), sorts, order, &mut budget)?;
        let bytes = coder.finish();
        if best.as_ref().is_none_or(|best| bytes.len() < best.len()) {
            best = Some(bytes);
        }
    }
    Ok(best.unwrap_or_default())
}

/// Reads what [`write`] wrote.
pub(crate) fn read(bytes: &[u8], faces: &Faces, vertices: usize, budget: &mut Budget) -> Result<Renumbering> {
    code(&mut BitReader::new(bytes), faces, vertices, false, &Renumbering::default(), budget)
}

fn code<C: BitCoder>(
    coder: &mut C,
    faces: &Faces,
    vertices: usize,
    sorts: bool,
    known: &Renumbering,
    budget: &mut Budget,
) -> Result<Renumbering> {
    budget.reserve(memory(vertices as u32, faces.len() as u32))?;
    budget.spend(work(vertices as u32, faces.len() as u32))?;
    let sorts = coder.code(sorts, 1 << 15);
    let mut order = Renumbering { faces: vec![0; faces.len()], turns: vec![0; faces.len()], ..Renumbering::default() };
    let mut numbers = Places::new(vertices);
    let neighbour = latest_neighbours(faces, vertices);
    for v in 0..vertices {
        let near = order.vertices.get(neighbour[v] as usize).copied();
        let old = numbers.code(coder, known.vertices.get(v).copied().unwrap_or(0), near)?;
        order.vertices.push(old);
    }
    // The corner with the least old number.
    let least = |face: &[u32]| (0..face.len()).min_by_key(|&i| order.vertices[face[i] as usize]).unwrap_or(0);
    let mut sequence: Vec<u32> = (0..faces.len() as u32).collect();
    if sorts {
        let key = |f: u32| {
            let face = faces.get(f as usize);
            let (first, n) = (least(face), face.len());
            let old = |i: usize| if n == 0 { 0 } else { order.vertices[face[(first + i) % n] as usize] };
            (old(0), old(1), old(n.saturating_sub(1)), f)
        };
        sequence.sort_by_cached_key(|&f| key(f));
    }
    let mut numbers = Places::new(faces.len());
    let mut last_at = LastFaces::new(vertices);
    let mut turns = Numbers::new(4);
    let mut last = 0;
    for f in sequence {
        let f = f as usize;
        let face = faces.get(f);
        let near = last_at.near(face);
        order.faces[f] = numbers.code(coder, known.faces.get(f).copied().unwrap_or(0), near)?;
        last_at.set(face, order.faces[f]);
        if face.len() < 2 {
            continue;
        }
        let (n, first) = (face.len() as u32, least(face) as u32);
        let turn = known.turns.get(f).map_or(0, |&turn| (turn + n - first) % n);
        last = turns.code(coder, turn, last.min(3) as usize);
        if last >= n {
            return Err(error("a face turned by more corners than it has"));
        }
        order.turns[f] = (first + last) % n;
    }
    Ok(order)
}

#[cold]
fn error(why: &str) -> Error {
    Error::malformed(Place::Chunk(*b"ORDR", 0), format!("order: {why}"))
}

/// Codes numbers below a count, each once.
struct Places {
    taken: Vec<bool>,
    next: u32,
    follows: [AdaptiveBit; 8],
    is_near: [AdaptiveBit; 4],
    is_less: [AdaptiveBit; 4],
    distance: Numbers,
    was_near: usize,
    /// Whether the last three numbers followed the one before.
    history: usize,
}

impl Places {
    fn new(count: usize) -> Self {
        Self {
            taken: vec![false; count],
            next: 0,
            follows: [AdaptiveBit::default(); 8],
            is_near: [AdaptiveBit::default(); 4],
            is_less: [AdaptiveBit::default(); 4],
            distance: Numbers::new(4),
            was_near: 0,
            history: 0,
        }
    }

    /// `near` is the number of a neighbour.
    fn code<C: BitCoder>(&mut self, coder: &mut C, place: u32, near: Option<u32>) -> Result<u32> {
        let follows = self.follows[self.history].code(coder, place == self.next);
        let lately = self.history & 1;
        self.history = (2 * self.history + usize::from(follows)) & 7;
        let place = if follows {
            self.next
        } else {
            // From the neighbour's number or from the next: whatever is nearer.
            let from_near = near.unwrap_or(self.next);
            let is_near = near.is_some() && {
                let is = place.abs_diff(from_near) < place.abs_diff(self.next);
                self.is_near[2 * self.was_near + lately].code(coder, is)
            };
            self.was_near = usize::from(is_near);
            let from = if is_near { from_near } else { self.next };
            let context = 2 * usize::from(is_near);
            let is_less = self.is_less[context + lately].code(coder, place < from);
            let distance = place.abs_diff(from).wrapping_sub(1);
            let distance = self.distance.code(coder, distance, context + usize::from(is_less)).saturating_add(1);
            if is_less { from.wrapping_sub(distance) } else { from.saturating_add(distance) }
        };
        self.next = place.wrapping_add(1);
        if coder.is_exhausted() {
            return Err(error("the stream ends too soon"));
        }
        match self.taken.get_mut(place as usize) {
            Some(taken) if !*taken => {
                *taken = true;
                Ok(place)
            }
            Some(_) => Err(error("two have one number")),
            None => Err(error("a number beyond the last")),
        }
    }
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_order_comes_back(
            vertices in 1_usize..40,
            faces in proptest::collection::vec(proptest::collection::vec(0_u32..1000, 0..6), 0..40),
            shuffles in proptest::collection::vec(any::<u32>(), 80),
        ) {
            let mut all = Faces::default();
            faces.iter().for_each(|f| all.push(&f.iter().map(|v| v % vertices as u32).collect::<Vec<_>>()));
            let shuffled = |n: usize| {
                let mut order: Vec<u32> = (0..n as u32).collect();
                order.sort_by_key(|&i| shuffles[i as usize]);
                order
            };
            let turns = (0..all.len()).map(|f| match all.get(f).len() as u32 {
                0 | 1 => 0,
                n => shuffles[f] % n,
            });
            let order = Renumbering { vertices: shuffled(vertices), faces: shuffled(all.len()), turns: turns.collect() };
            let bytes = write(&all, &order).unwrap();
            let mut budget = Budget::new(crate::Limits::default());
            prop_assert_eq!(read(&bytes, &all, vertices, &mut budget).unwrap(), order);
        }
    }

    #[test]
    fn an_order_that_did_not_change_costs_next_to_nothing() {
        let faces: Faces = (0..10_000_u32).map(|i| [i, i + 1, i + 2]).collect();
        let same = |n: u32| (0..n).collect();
        let order = Renumbering { vertices: same(10_002), faces: same(10_000), turns: vec![0; 10_000] };
        assert!(write(&faces, &order).unwrap().len() < 60);
    }
}
