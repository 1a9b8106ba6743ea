//! Boundary loops, and how to close them.

use super::half_edge::HalfEdges;
use crate::error::Result;

/// The boundary loops, each as its half-edges in order; a loop starts at its smallest half-edge,
/// and the loops are ordered by that. O(half-edges).
pub(crate) fn boundary_loops(mesh: &HalfEdges) -> Vec<Vec<u32>> {
    let count = 3 * mesh.triangles().len() as u32;
    let mut seen = vec![false; count as usize];
    let mut loops = Vec::new();
    for first in 0..count {
        if mesh.opposite(first).is_some() || seen[first as usize] {
            continue;
        }
        // H5: the half-edge that leaves a boundary vertex along the boundary is its `outgoing`.
        let mut around = Vec::new();
        let mut h = Some(first);
        while let Some(g) = h.filter(|&g| !std::mem::replace(&mut seen[g as usize], true)) {
            around.push(g);
            h = mesh.outgoing(mesh.to(g));
        }
        loops.push(around);
    }
    loops
}

/// The triangles with every boundary loop closed by a fan about a new vertex ("dummy"): loop `i`
/// about vertex `mesh.vertices() + i`. The first triangles are those of the mesh, in order.
pub(crate) fn close(mesh: &HalfEdges, loops: &[Vec<u32>]) -> Result<HalfEdges> {
    let mut triangles = mesh.triangles().to_vec();
    for (i, around) in loops.iter().enumerate() {
        let dummy = (mesh.vertices() + i) as u32;
        triangles.extend(around.iter().map(|&h| [mesh.to(h), mesh.from(h), dummy]));
    }
    HalfEdges::new(mesh.vertices() + loops.len(), triangles)
}
