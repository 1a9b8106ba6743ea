//! The side information of an image, from what its regions are.

use std::collections::{HashMap, HashSet};

use super::check::canonical;
use super::rebuild::{Rebuilt, boundary, rebuild};
use crate::error::{Error, Result};
use crate::limits::{Budget, Limits};
use crate::mesh::{HalfEdges, NONE};
use crate::plane::{Seam, SideInformation};

/// What each region is: a vertex of the surface, or, from `surface.vertices()` on, a dummy.
pub(super) type Origin = Vec<u32>;

/// For each vertex and dummy the first region that it is.
pub(super) fn first_regions(origin: &Origin) -> HashMap<u32, u32> {
    let mut first = HashMap::new();
    for (region, &v) in origin.iter().enumerate() {
        first.entry(v).or_insert(region as u32);
    }
    first
}

/// Finds dummies and seams, given the triangles of regions, and proves that the surface can be had back.
pub(super) fn finish(
    side: &mut SideInformation,
    origin: &Origin,
    triangles: Vec<[u32; 3]>,
    surface: &HalfEdges,
) -> Result<Rebuilt> {
    let first = first_regions(origin);
    side.dummies = first.iter().filter(|&(&v, _)| v >= surface.vertices() as u32).map(|(_, &region)| region).collect();
    side.dummies.sort_unstable();
    if first.len() < origin.len() {
        side.seams = seams(origin, &triangles)?;
    }
    let rebuilt = rebuild(triangles, origin.len() as u32, side, &mut unlimited())?;
    prove(&rebuilt, origin, surface)?;
    Ok(rebuilt)
}

/// Pairs the boundary edges that are one edge of the surface.
fn seams(origin: &Origin, triangles: &[[u32; 3]]) -> Result<Vec<Seam>> {
    let edges = boundary(origin.len() as u32, triangles)?;
    let ends = |[a, b]: [u32; 2]| [origin[a as usize], origin[b as usize]];
    let place: HashMap<[u32; 2], u32> = edges.iter().zip(0..).map(|(&edge, i)| (ends(edge), i)).collect();
    let mut seams: Vec<Seam> = Vec::new();
    for (&edge, i) in edges.iter().zip(0..) {
        let [a, b] = ends(edge);
        let Some(&partner) = place.get(&[b, a]).filter(|&&j| j > i) else { continue };
        match seams.last_mut() {
            Some(seam) if seam.first + seam.length == i && seam.partner.checked_sub(seam.length) == Some(partner) => {
                seam.length += 1;
            }
            _ => seams.push(Seam { first: i, partner, length: 1 }),
        }
    }
    Ok(seams)
}

/// Compares the mesh with the surface, face by face and as a multiset.
fn prove(rebuilt: &Rebuilt, origin: &Origin, surface: &HalfEdges) -> Result<()> {
    let mut vertex = vec![NONE; rebuilt.vertices as usize];
    let mut taken = HashSet::new();
    let mut one_to_one = true;
    for (&new, &old) in rebuilt.vertex.iter().zip(origin).filter(|&(&new, _)| new != NONE) {
        let known = std::mem::replace(&mut vertex[new as usize], old);
        one_to_one &= if known == NONE { taken.insert(old) } else { known == old };
    }
    let mut found: Vec<_> = rebuilt.triangles.iter().map(|t| canonical(t.map(|v| vertex[v as usize]))).collect();
    let mut wanted: Vec<_> = surface.triangles().iter().copied().map(canonical).collect();
    found.sort_unstable();
    wanted.sort_unstable();
    let used = (0..surface.vertices() as u32).filter(|&v| surface.outgoing(v).is_some()).count();
    if one_to_one && used == rebuilt.vertices as usize && found == wanted {
        Ok(())
    } else {
        Err(Error::NoConvergence { what: "the image of the mesh", after: 1, residual: 1.0 })
    }
}

pub(super) fn unlimited() -> Budget {
    Budget::new(Limits::default().memory(u64::MAX).work(u64::MAX).pixels(u64::MAX).vertices(u64::MAX))
}
