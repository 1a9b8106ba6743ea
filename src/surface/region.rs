//! A stage for some vertices only: those of a region of interest (spec/surface.md, "Region of interest").
//!
//! A stream says which they are, in the order in which the walk met them; then their stage is coded as if all others were holes.

use super::topology::Surface;
use crate::entropy::{AdaptiveBit, BitCoder};

/// Answers that a bit counts.
const LIMIT: u32 = 255;
/// Neighbours inside, and outside, are counted up to here.
const MOST: usize = 3;

/// Memory a vertex, and a face, that a region takes: marks, neighbours, and a surface of its own.
pub(super) const BYTES_A_VERTEX: u64 = 1 + 1 + 8 + 12;
pub(super) const BYTES_A_FACE: u64 = 3 * 4 + 3 * 4 + 3 * 8;

/// Codes whether each vertex is inside, by how many of its neighbours that came before it are.
pub(super) fn code<C: BitCoder>(coder: &mut C, surface: &Surface, inside: &mut [bool]) {
    let mut models = [[AdaptiveBit::default(); MOST + 1]; MOST + 1];
    let mut counts = vec![[0_u8; 2]; inside.len()];
    let (starts, later) = later_neighbours(surface);
    for v in 0..inside.len() {
        if surface.is_hole[v] {
            inside[v] = false;
            continue;
        }
        let [out, within] = counts[v].map(|n| usize::from(n).min(MOST));
        let model = &mut models[out][within];
        let is_inside = coder.code(inside[v], model.p().clamp(1, 65535));
        model.learn(is_inside, LIMIT);
        inside[v] = is_inside;
        for &w in &later[starts[v]..starts[v + 1]] {
            let count = &mut counts[w as usize][usize::from(is_inside)];
            *count = count.saturating_add(1);
        }
    }
}

/// For each vertex those of higher numbers that its half-edges end at: the list of `v` is `starts[v]..starts[v + 1]`.
fn later_neighbours(surface: &Surface) -> (Vec<usize>, Vec<u32>) {
    let edges = || surface.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).filter(|(from, to)| from < to);
    let mut starts = vec![0; surface.is_hole.len() + 1];
    edges().for_each(|(from, _)| starts[from as usize + 1] += 1);
    for v in 1..starts.len() {
        starts[v] += starts[v - 1];
    }
    let mut next = starts.clone();
    let mut later = vec![0; starts[starts.len() - 1]];
    edges().for_each(|(from, to)| {
        later[next[from as usize]] = to;
        next[from as usize] += 1;
    });
    (starts, later)
}

impl Surface {
    /// The same surface with all vertices that are not inside as holes.
    pub(super) fn only(&self, inside: &[bool]) -> Self {
        Self {
            triangles: self.triangles.clone(),
            opposite: self.opposite.clone(),
            valence: self.valence.clone(),
            is_hole: inside.iter().map(|inside| !inside).collect(),
        }
    }
}

/// What is known of a coordinate outside, `shift` bits of which are missing: the middle of its cell, as far as the box goes.
pub(crate) fn middle(cell: i32, shift: u32, extent: i32) -> i32 {
    ((cell << shift) + (1 << shift >> 1)).min(extent)
}
