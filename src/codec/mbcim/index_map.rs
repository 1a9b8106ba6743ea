//! An index map pixel by pixel (spec/mbcim.md, "Raster form"): any map at all, by whomever it was made.
//!
//! In raster order each pixel is asked: is it the one to the left? the one above? the next other one above, to the
//! right? a new one? If nothing of that, its id follows plainly. What is implied is not asked, so a map has one form.
//! The chances are mixed from which neighbours are equal, how far the runs around go on, and how many half-cells
//! the ids nearby have had so far.

use crate::entropy::{BitCoder, Mixer, MixerOptions, Start, hash};
use crate::error::{Error, Place, Result};
use crate::limits::Budget;

/// Contexts a decision.
const CONTEXTS: usize = 10;
/// What a line of a mixer's table takes.
const BYTES_A_LINE: u64 = 64;
/// Steps a pixel.
const STEPS: u64 = 2 * CONTEXTS as u64;
/// The most that is counted.
const MANY: u32 = 15;

mod node {
    pub(super) const LEFT: usize = 0;
    pub(super) const ABOVE: usize = 1;
    pub(super) const NEXT: usize = 2;
    pub(super) const NEW: usize = 3;
}

/// What was chosen for a pixel.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Choice {
    Left,
    Above,
    Next,
    New,
    Other,
}

struct Map {
    columns: usize,
    ids: Vec<u32>,
    /// For each pixel of the row above the first pixel to its right that has another id.
    run_end: Vec<u32>,
    /// For each id its half-cells so far.
    closed: Vec<u8>,
    mixer: Mixer<CONTEXTS, 0>,
}

/// Codes a map of `columns` by `rows` ids below `limit`, numbered by first occurrence. A writer gives it as `known`.
pub(crate) fn code<C: BitCoder>(
    coder: &mut C,
    known: Option<&[u32]>,
    [rows, columns]: [usize; 2],
    limit: u32,
    budget: &mut Budget,
) -> Result<Vec<u32>> {
    let lines_log2 = limit.max(1).ilog2().clamp(6, 15) + 1;
    budget.reserve((CONTEXTS as u64 * BYTES_A_LINE) << lines_log2)?;
    budget.reserve(columns as u64 * 4)?;
    let options = MixerOptions { lines_log2, rate_shift: 5, count_limit: 1000 };
    let mut map = Map {
        columns,
        ids: Vec::new(),
        run_end: vec![0; columns],
        closed: Vec::new(),
        mixer: Mixer::new(options, &[Start::even(25); 3]),
    };
    let mut recent = 0_u32;
    for i in 0..rows {
        if coder.is_exhausted() {
            return Err(malformed(format!("the index map ends too soon, in row {i}")));
        }
        // Row by row: a promise of many rows costs nothing before they come.
        budget.reserve(columns as u64 * 4)?;
        budget.spend(columns as u64 * STEPS)?;
        map.find_runs(i);
        let mut run = 0;
        for j in 0..columns {
            let wanted = known.map(|k| k[i * columns + j]);
            let (id, choice) = map.pixel(coder, wanted, j, [run, recent], limit)?;
            run = if choice == Choice::Left { run + 1 } else { 0 };
            if choice != Choice::Left {
                recent = recent << 3 | choice as u32;
            }
            map.close(id, j);
            map.ids.push(id);
        }
    }
    if map.closed.len() != limit as usize {
        return Err(malformed(format!("an index map of {} ids, {limit} expected", map.closed.len())));
    }
    Ok(map.ids)
}

impl Map {
    fn find_runs(&mut self, row: usize) {
        if row == 0 {
            return;
        }
        let above = &self.ids[(row - 1) * self.columns..];
        let mut end = self.columns as u32;
        for j in (0..self.columns).rev() {
            if j + 1 < self.columns && above[j] != above[j + 1] {
                end = j as u32 + 1;
            }
            self.run_end[j] = end;
        }
    }

    /// Left, above, above left, and the next other one above, of the pixel that comes now.
    fn neighbours(&self, j: usize) -> [Option<u32>; 4] {
        let at = self.ids.len();
        let left = (j > 0).then(|| self.ids[at - 1]);
        let Some(up) = at.checked_sub(self.columns) else { return [left, None, None, None] };
        let next = self.run_end[j] as usize;
        let next = (next < self.columns).then(|| self.ids[up - j + next]);
        [left, Some(self.ids[up]), (j > 0).then(|| self.ids[up - 1]), next]
    }

    fn pixel<C: BitCoder>(
        &mut self,
        coder: &mut C,
        wanted: Option<u32>,
        j: usize,
        [run, recent]: [u32; 2],
        limit: u32,
    ) -> Result<(u32, Choice)> {
        let [left, above, corner, next] = self.neighbours(j);
        let contexts = self.contexts([left, above, corner, next], j, run, recent);
        self.mixer.choose(contexts, usize::from(left == above) + usize::from(above.is_none()) * 2);
        let mut is = |id: u32, node: usize, coder: &mut C| self.mixer.code(coder, wanted == Some(id), node, []);
        if let Some(left) = left
            && is(left, node::LEFT, coder)
        {
            return Ok((left, Choice::Left));
        }
        let above = above.filter(|_| above != left);
        if let Some(above) = above
            && is(above, node::ABOVE, coder)
        {
            return Ok((above, Choice::Above));
        }
        let next = next.filter(|_| next != left);
        if let Some(next) = next
            && is(next, node::NEXT, coder)
        {
            return Ok((next, Choice::Next));
        }
        let ids = self.closed.len() as u32;
        let excluded = |id: u32| [left, above, next].contains(&Some(id));
        // With all old ids excluded there is no choice.
        let others = u64::from(ids) - [left, above, next].iter().flatten().count() as u64;
        if others == 0 || ids < limit && is(ids, node::NEW, coder) {
            if ids >= limit {
                return Err(malformed(format!("the index map has more than its {limit} ids")));
            }
            self.closed.push(0);
            return Ok((ids, Choice::New));
        }
        let bits = 32 - (ids - 1).leading_zeros();
        let id = coder.raw(wanted.unwrap_or(0), bits);
        if id >= ids || excluded(id) {
            return Err(malformed(format!("id {id} where another of the first {ids} is due")));
        }
        Ok((id, Choice::Other))
    }

    /// Counts the half-cells that a pixel completes.
    fn close(&mut self, id: u32, j: usize) {
        if let [Some(left), Some(above), Some(corner), _] = self.neighbours(j) {
            for [a, b, c] in [[corner, above, left], [above, id, left]] {
                if a != b && b != c && c != a {
                    for v in [a, b, c] {
                        self.closed[v as usize] = self.closed[v as usize].saturating_add(1);
                    }
                }
            }
        }
    }

    fn contexts(&self, [left, above, corner, next]: [Option<u32>; 4], j: usize, run: u32, recent: u32) -> [u32; CONTEXTS] {
        let at = self.ids.len();
        let back = |k: usize| at.checked_sub(k).map(|p| self.ids[p]);
        let far_left = if j > 1 { back(2) } else { None };
        let two_above = back(2 * self.columns);
        let equal = |a: Option<u32>, b: Option<u32>| u32::from(a.is_some() && a == b);
        let pattern = equal(left, above)
            | equal(left, corner) << 1
            | equal(above, corner) << 2
            | equal(left, far_left) << 3
            | equal(above, two_above) << 4
            | equal(left, next) << 5
            | u32::from(above.is_none()) << 6
            | equal(two_above, corner) << 7;
        let closed = |id: Option<u32>| id.map_or(MANY, |id| u32::from(self.closed[id as usize]).min(MANY - 1));
        let (l, a, n) = (closed(left), closed(above), closed(next));
        let to_go = if above.is_some() { (self.run_end[j] - j as u32).min(MANY) } else { 0 };
        let run = run.min(MANY);
        let long = (run + 1).ilog2() * 8 + (to_go + 1).ilog2();
        let pack = |parts: &[u32]| parts.iter().fold(pattern, |sum, &part| hash(sum, part));
        [
            pack(&[]),
            pack(&[run, to_go]),
            pack(&[l, a]),
            pack(&[l, a, n, to_go]),
            pack(&[recent & 0x1ff]),
            pack(&[recent & 0x7fff]),
            pack(&[l, a, recent & 0x3f]),
            pack(&[long, l, n]),
            pack(&[to_go, recent & 0xfff]),
            pack(&[l, a, n, long]),
        ]
    }
}

fn malformed(why: String) -> Error {
    Error::malformed(Place::Whole, why)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;
    use crate::entropy::{BitReader, BitWriter};
    use proptest::prelude::*;

    /// The same map with its ids numbered by first occurrence, and how many there are.
    fn renumbered(map: &[u32]) -> (Vec<u32>, u32) {
        let mut new = std::collections::HashMap::new();
        let map = map.iter().map(|&id| {
            let next = new.len() as u32;
            *new.entry(id).or_insert(next)
        });
        (map.collect(), new.len() as u32)
    }

    fn there_and_back(map: &[u32], rows: usize, columns: usize) -> usize {
        let (map, ids) = renumbered(map);
        let budget = || Budget::new(Limits::default());
        let mut writer = BitWriter::default();
        assert_eq!(code(&mut writer, Some(&map), [rows, columns], ids, &mut budget()).unwrap(), map);
        let bytes = writer.finish();
        assert_eq!(code(&mut BitReader::new(&bytes), None, [rows, columns], ids, &mut budget()).unwrap(), map);
        bytes.len()
    }

    proptest! {
        #[test]
        fn any_map_comes_back(rows in 1_usize..20, columns in 1_usize..20, ids in 1_u32..500, seed: u64) {
            let mut state = seed | 1;
            let map: Vec<u32> = (0..rows * columns)
                .map(|_| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    (state >> 33) as u32 % ids
                })
                .collect();
            there_and_back(&map, rows, columns);
        }

        #[test]
        fn any_bytes_are_a_map_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..300), ids in 0_u32..50) {
            let mut budget = Budget::new(Limits::default().memory(1 << 22).work(1 << 22));
            drop(code(&mut BitReader::new(&bytes), None, [30, 40], ids, &mut budget));
        }
    }

    #[test]
    fn one_colour_costs_nothing_and_all_different_ones_next_to_nothing() {
        assert!(there_and_back(&vec![7; 300 * 400], 300, 400) < 40);
        let all: Vec<u32> = (0..300 * 400).collect();
        assert!(there_and_back(&all, 300, 400) < 2000);
    }

    #[test]
    fn noise_costs_little_more_than_its_ids() {
        let mut state = 1_u64;
        let map: Vec<u32> = (0..100 * 100)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 33) as u32 % 256
            })
            .collect();
        assert!(there_and_back(&map, 100, 100) < 10_000 * 5 / 4);
    }

    /// Printed, not judged: `cargo test --release --lib four_million -- --ignored --nocapture`.
    #[test]
    #[ignore = "takes seconds"]
    fn a_map_of_four_million_pixels_is_coded_in_seconds() {
        // Bands that wander: runs of about ten pixels, as in an image of vertices.
        let (rows, columns) = (2000, 2000);
        let map: Vec<u32> = (0..rows * columns)
            .map(|p| {
                let (i, j) = (p / columns, p % columns);
                ((i / 9 + (j * j / 977) % 3) * 300 + (j + i * 7 % 5) / 10) as u32
            })
            .collect();
        let (map, ids) = renumbered(&map);
        let budget = || Budget::new(Limits::default());
        let start = std::time::Instant::now();
        let mut writer = BitWriter::default();
        code(&mut writer, Some(&map), [rows, columns], ids, &mut budget()).unwrap();
        let bytes = writer.finish();
        let wrote = start.elapsed();
        let start = std::time::Instant::now();
        assert_eq!(code(&mut BitReader::new(&bytes), None, [rows, columns], ids, &mut budget()).unwrap(), map);
        println!("{} bytes, {ids} ids; {wrote:?} to write, {:?} to read", bytes.len(), start.elapsed());
        assert!(wrote.as_secs_f64() < 3.0 && start.elapsed().as_secs_f64() < 3.0);
    }
}
