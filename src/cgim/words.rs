//! A mesh as the words of its levels, without columns: all of the connectivity, in the fewest choices.
//!
//! The sweep takes in everything that it can in every round, so that the words say little beside the
//! triangles. Which columns the vertices stand in follows from the words ([`align`](super::align)),
//! and any other sweep over the same mesh can be made from what they hold.

use super::check::canonical;
use super::open::{Opening, Piece, Recipe, pieces};
use super::rebuild::{Rebuilt, word_triangles};
use super::side::{finish, first_regions};
use super::stratify::stratify;
use crate::error::Result;
use crate::mesh::{HalfEdges, NONE};
use crate::par;
use crate::plane::{Block, Levels, SideInformation};
use crate::task::Task;

/// The words of a mesh.
#[derive(Debug)]
pub(crate) struct Words {
    /// The levels of each piece; entries are regions, numbered by first occurrence.
    pub(crate) blocks: Vec<Levels>,
    /// The vertex of the mesh that each region is; dummies have numbers from the mesh's vertices on.
    pub(crate) origin: Vec<u32>,
    pub(crate) side: SideInformation,
    /// The mesh as a reader will have it.
    pub(crate) rebuilt: Rebuilt,
}

/// The words of any oriented manifold: for each piece those of `trials` sweeps for which `cost` is least.
///
/// # Errors
/// If the task is cancelled.
pub(crate) fn words(
    surface: &HalfEdges,
    trials: usize,
    cost: impl Fn(&Levels) -> usize + Sync,
    task: &Task<'_>,
) -> Result<Words> {
    let mut side = SideInformation::default();
    let mut blocks = Vec::new();
    let mut origin = Vec::new();
    let mut missing = Vec::new();
    let pieces = pieces(surface)?;
    for (i, piece) in pieces.iter().enumerate() {
        task.step(i as f64 / pieces.len() as f64)?;
        let (levels, vertex) = best(piece, trials, &cost)?;
        missing.extend(missing_triangles(piece, &levels, &vertex));
        let mut region = vec![NONE; vertex.len()];
        let mut renumber = |v: u32| {
            if region[v as usize] == NONE {
                region[v as usize] = origin.len() as u32;
                origin.push(vertex[v as usize]);
            }
            region[v as usize]
        };
        let levels = levels.map(&mut renumber);
        side.blocks.push(Block { rows: levels.len() as u32, mirrored: false });
        blocks.push(levels);
    }
    let first = first_regions(&origin);
    side.missing = missing.into_iter().map(|t| t.map(|v| first[&v])).collect();
    let triangles = word_triangles(&blocks, origin.len() as u32, &side)?;
    let rebuilt = finish(&mut side, &origin, triangles, surface)?;
    Ok(Words { blocks, origin, side, rebuilt })
}

/// The cheapest of some sweeps, and the vertex of the surface (or the dummy) that each vertex of the disk is.
fn best(piece: &Piece, trials: usize, cost: &(impl Fn(&Levels) -> usize + Sync)) -> Result<(Levels, Vec<u32>)> {
    let sweeps = par::map(trials.max(1), |i| {
        let disk = piece.open(&recipe(i));
        let levels = stratify(&disk.half_edges, &disk.plan)?;
        let bytes = if trials > 1 { cost(&levels) } else { 0 };
        Ok((bytes, levels, disk.origin))
    });
    let mut best: Option<(usize, Levels, Vec<u32>)> = None;
    for sweep in sweeps {
        let sweep: Result<_> = sweep;
        let sweep: (usize, Levels, Vec<u32>) = sweep?;
        if best.as_ref().is_none_or(|b| sweep.0 < b.0) {
            best = Some(sweep);
        }
    }
    let (_, levels, origin) = best.unwrap_or_default();
    Ok((levels, origin.into_iter().map(|v| piece.origin[v as usize]).collect()))
}

/// Full sweeps from here and there.
fn recipe(i: usize) -> Recipe {
    let opening = [Opening::Plain, Opening::Slit, Opening::Edge, Opening::FreeSlit][i % 4];
    let turn = (i / 4) as u16;
    Recipe {
        opening,
        alpha: 0,
        keep: 255,
        columns: 0,
        seed: turn as u8,
        start: turn.wrapping_mul(40_503),
        length: if opening == Opening::Slit { turn.wrapping_mul(5000) } else { 1 << 14 },
    }
}

/// The triangles of a piece that its levels do not hold: the one that was taken out, if one was.
fn missing_triangles(piece: &Piece, levels: &Levels, vertex: &[u32]) -> Vec<[u32; 3]> {
    let mut found: Vec<_> = levels.triangles().map(|t| canonical(t.map(|v| vertex[v as usize]))).collect();
    let all = piece.triangles().into_iter().map(|t| t.map(|v| piece.origin[v as usize]));
    if found.len() == all.len() {
        return Vec::new();
    }
    found.sort_unstable();
    all.filter(|&t| found.binary_search(&canonical(t)).is_err()).collect()
}
