//! A surface before it is flattened: its own triangles, and those that fill its holes.

use glam::DVec3;

use super::split_edges;
use crate::error::Result;
use crate::mesh::{HalfEdges, close};

/// Triangles, and which of them are no part of the surface but fill a hole.
#[derive(Debug, Clone)]
pub(super) struct Sheet {
    pub(super) mesh: HalfEdges,
    pub(super) positions: Vec<DVec3>,
    /// For each triangle; empty if there is no filling.
    pub(super) filling: Vec<bool>,
}

impl Sheet {
    /// A surface with some of its boundary loops closed by fans about their middles.
    pub(super) fn filled(mesh: HalfEdges, mut positions: Vec<DVec3>, loops: &[Vec<u32>]) -> Result<Self> {
        if loops.is_empty() {
            return Ok(Self { mesh, positions, filling: Vec::new() });
        }
        let closed = close(&mesh, loops)?;
        for around in loops {
            let sum: DVec3 = around.iter().map(|&h| positions[mesh.from(h) as usize]).sum();
            positions.push(sum / around.len() as f64);
        }
        let filling = (0..closed.triangles().len()).map(|f| f >= mesh.triangles().len()).collect();
        Ok(Self { mesh: closed, positions, filling })
    }

    /// The same with a new vertex in the middle of every edge for which `wanted` says so of one of its half-edges.
    pub(super) fn split(&self, wanted: impl Fn(u32) -> bool) -> Result<Self> {
        let (mesh, positions, origin) = split_edges(&self.mesh, &self.positions, wanted)?;
        let filling = origin.iter().filter_map(|&f| self.filling.get(f as usize).copied()).collect();
        Ok(Self { mesh, positions, filling })
    }
}
