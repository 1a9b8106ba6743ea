//! A surface whose vertices may slide: what a writer makes of its positions.

use super::filter::Filter;
use super::learned::{Aim, Hold};
use super::stretch::Sliding;
use super::{Effort, Positions, Slide, Walked, ranges_of};
use crate::entropy::BitWriter;
use crate::error::Result;
use crate::par;
use crate::task::Task;

/// What is wanted of the positions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wishes<'a> {
    pub(crate) effort: Effort,
    /// Whether the step along the normal becomes finer where edges are short.
    pub(crate) fine: bool,
    /// √2 to the power of this is how many times longer than that the other steps may be.
    pub(crate) longest: u8,
    /// How close each vertex of the mesh is held; empty for not at all.
    pub(crate) holds: &'a [Hold],
    /// How far a corner may be from the planes of its faces, in steps, if that can be held.
    pub(crate) reach: f64,
    /// Whether a filter may be used.
    pub(crate) may_filter: bool,
}

/// Positions that have slid.
#[derive(Debug)]
pub(crate) struct Slid {
    /// One stream for each range of vertices.
    pub(crate) streams: Vec<Vec<u8>>,
    /// What a reader must know.
    pub(crate) slide: Slide,
    /// Of each vertex of the mesh, as a reader will have it, in [`PARTS`](super::PARTS) of a step.
    pub(crate) positions: Vec<[i32; 3]>,
    /// Vertices of faces that look away from where they looked: three of the mesh for each face.
    pub(crate) turned: Vec<[u32; 3]>,
}

/// Codes the positions of a surface that was walked over; `points` are those of the mesh's vertices in steps.
pub(crate) fn slide(
    walked: &Walked,
    points: &[[f64; 3]],
    extent: [i32; 3],
    wishes: Wishes<'_>,
    task: Task<'_>,
) -> Result<Slid> {
    let surface = &walked.surface;
    // The vertex of the mesh that each of the closed surface is.
    let mut met = walked.order.iter();
    let of: Vec<Option<u32>> = surface.is_hole.iter().map(|&hole| if hole { None } else { met.next().copied() }).collect();
    let local = of.iter().map(|v| v.map_or([0.0; 3], |v| points[v as usize])).collect();
    let hold = |v: &Option<u32>| v.and_then(|v| wishes.holds.get(v as usize)).copied().unwrap_or_default();
    let aim = Aim::new(surface, local, of.iter().map(hold).collect(), wishes.reach);
    let coder = Positions::new(surface, wishes.effort);
    let ranges = ranges_of(surface.is_hole.len() as u32);
    let parts = par::map(ranges.len(), |i| {
        let mut positions = vec![[0; 3]; ranges[i].len()];
        let mut stretch = coder.stretch(ranges[i].clone(), extent);
        stretch.sliding = Some(Sliding { fine: wishes.fine, longest: wishes.longest, aim: Some(&aim) });
        let mut bits = BitWriter::default();
        coder.code(&mut bits, stretch, &mut positions, task)?;
        Ok((bits.finish(), positions))
    });
    let parts = parts.into_iter().collect::<Result<Vec<_>>>()?;
    let (streams, positions): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
    let mut coded: Vec<[i32; 3]> = positions.concat();
    let fitted = wishes.may_filter.then(|| Filter::fit(surface, &coder.outgoing, &coded, extent, &aim)).flatten();
    let filter = fitted.map(|(filter, after)| {
        coded = after;
        filter
    });
    let in_mesh = |v: u32| of[v as usize].unwrap_or(0);
    let turned = aim.turned(surface, &coded).into_iter().map(|f| surface.triangles[f as usize].map(in_mesh)).collect();
    let mut slid = vec![[0; 3]; points.len()];
    for (v, position) in of.iter().zip(coded) {
        if let Some(v) = v {
            slid[*v as usize] = position;
        }
    }
    Ok(Slid { streams, slide: Slide { fine: wishes.fine, longest: wishes.longest, filter }, positions: slid, turned })
}
