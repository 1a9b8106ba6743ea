//! Which edges of the surface cut polygons.
//!
//! The longest edge of both its triangles is likely to be one where polygons are common; an edge of a triangle that has its
//! diagonal already is not where most are quads.

use super::super::topology::Skin;
use super::{Source, error};
use crate::entropy::{AdaptiveBit, BitCoder};
use crate::error::Result;
use crate::limits::Budget;
use crate::mesh::NONE;
use crate::mesh::half_edge::next;

pub(super) const BYTES_A_FACE: u64 = 3 + 4 + 1;

/// The faces of the skin, several triangles each where there are diagonals.
pub(super) struct Polygons {
    /// A side of every face.
    pub(super) starts: Vec<u32>,
    is_diagonal: Vec<bool>,
}

impl Polygons {
    /// The side that follows `h` around its face.
    pub(super) fn after(&self, skin: &Skin, h: u32) -> u32 {
        let mut h = next(h);
        while self.is_diagonal.get(h as usize).is_some_and(|&is| is) {
            h = next(skin.opposite[h as usize]);
        }
        h
    }
}

pub(super) fn code<C: BitCoder, S: Source>(
    coder: &mut C,
    skin: &Skin,
    positions: &[[i32; 3]],
    are_there: bool,
    source: &S,
    budget: &mut Budget,
) -> Result<Polygons> {
    let faces = skin.triangles.len() as u32;
    budget.spend(3 * u64::from(faces))?;
    if !are_there {
        return Ok(Polygons { starts: (0..faces).map(|f| 3 * f).collect(), is_diagonal: Vec::new() });
    }
    let mut is_diagonal = vec![false; 3 * faces as usize];
    let mut diagonals = vec![0_u8; faces as usize];
    let mut model = vec![AdaptiveBit::default(); 3 * 3 * 3 * 3 * 3 * 3];
    for h in 0..3 * faces {
        let g = skin.opposite[h as usize];
        if g == NONE || g < h {
            continue;
        }
        let (f, e) = (h / 3, g / 3);
        let before = if f > 0 { diagonals[f as usize - 1].min(2) } else { 0 };
        let undecided = (h % 3..3).filter(|c| skin.opposite[(3 * f + c) as usize] != NONE).count().clamp(1, 3) - 1;
        let context = [
            diagonals[f as usize].min(2).into(),
            diagonals[e as usize].min(2).into(),
            rank(skin, positions, h),
            rank(skin, positions, g),
            before.into(),
            undecided,
        ];
        let context = context.into_iter().fold(0, |all, c| 3 * all + c);
        if model[context].code(coder, source.is_diagonal(h)) {
            is_diagonal[h as usize] = true;
            is_diagonal[g as usize] = true;
            diagonals[f as usize] += 1;
            diagonals[e as usize] += 1;
        }
        if h % 4096 == 0 && coder.is_exhausted() {
            return Err(error("the stream ends too soon"));
        }
    }
    gather(skin, is_diagonal)
}

/// How many edges of its triangle are longer than `h`.
fn rank(skin: &Skin, positions: &[[i32; 3]], h: u32) -> usize {
    let length = |h: u32| {
        let [p, q] = [h, next(h)].map(|h| positions[skin.from(h) as usize]);
        (0..3).map(|i| (i64::from(p[i]) - i64::from(q[i])).pow(2)).sum::<i64>()
    };
    let own = length(h);
    usize::from(length(next(h)) > own) + usize::from(length(next(next(h))) > own)
}

/// Triangles joined by diagonals, each group with its first side; refuses groups that are no polygons.
fn gather(skin: &Skin, is_diagonal: Vec<bool>) -> Result<Polygons> {
    let mut seen = vec![false; skin.triangles.len()];
    let mut polygons = Polygons { starts: Vec::new(), is_diagonal };
    let mut group = Vec::new();
    for f in 0..skin.triangles.len() as u32 {
        if std::mem::replace(&mut seen[f as usize], true) {
            continue;
        }
        group.clear();
        group.push(f);
        let (mut i, mut start, mut sides) = (0, NONE, 0);
        while i < group.len() {
            for h in 3 * group[i]..3 * group[i] + 3 {
                if polygons.is_diagonal[h as usize] {
                    let e = skin.opposite[h as usize] / 3;
                    if !std::mem::replace(&mut seen[e as usize], true) {
                        group.push(e);
                    }
                } else {
                    sides += 1;
                    start = start.min(h);
                }
            }
            i += 1;
        }
        // A polygon of n corners is cut by n − 3 diagonals, and its sides are one cycle.
        if sides != group.len() + 2 {
            return Err(error("diagonals that cut no polygon"));
        }
        let (mut h, mut turns) = (polygons.after(skin, start), 1);
        while h != start && turns <= sides {
            h = polygons.after(skin, h);
            turns += 1;
        }
        if turns != sides {
            return Err(error("diagonals that cut no polygon"));
        }
        polygons.starts.push(start);
    }
    Ok(polygons)
}
