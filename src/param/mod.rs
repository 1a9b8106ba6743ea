//! Parametrisation: a surface flattened onto the unit square.
//!
//! A disk is pinned to the square's border ([`border`]); a closed surface of genus 0 covers the plane again and again, folded
//! about four cones ([`orbifold`]), and the square is one copy of it. Either way every vertex has one unknown point, found from
//! its neighbours ([`barycentric`]) and improved until the surface is stretched as little as may be ([`yoshizawa`],
//! [`newton`]). Triangles that would be turned over are never kept silently: what comes out has none.

mod barycentric;
mod border;
mod chart;
mod cones;
mod newton;
mod orbifold;
mod split;
#[cfg(test)]
mod tests;
mod weights;
mod yoshizawa;

pub(crate) use chart::{Chart, Freedom};
pub(crate) use split::split_edges;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::mesh::{HalfEdges, boundary_loops};
use crate::plane::Gluing;
use crate::task::Task;

/// How the inside of a chart is laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Param {
    /// Every vertex is the mean of its neighbours (Tutte 1963; paper 000's "barycentric mapping").
    Tutte,
    /// Neighbours weigh by mean-value coordinates (Floater 2003).
    MeanValue,
    /// Weights are divided by the stretch found, and the system is solved again (Yoshizawa, Belyaev and Seidel 2004; paper 000's
    /// "geometric-stretch parametrization").
    Yoshizawa,
    /// From there, Newton's method on stretch and Dirichlet energy.
    #[default]
    Stretch,
}

/// Flattens a connected surface of genus 0 with at most one boundary loop.
///
/// # Errors
/// Other surfaces are refused; and [`Error::NoConvergence`] if no map without folds is found in f64.
pub(crate) fn flatten(mesh: HalfEdges, positions: Vec<DVec3>, param: Param, task: &Task<'_>) -> Result<Chart> {
    let loops = boundary_loops(&mesh);
    let used = (0..mesh.vertices() as u32).filter(|&v| mesh.outgoing(v).is_some()).count();
    let edges = (3 * mesh.triangles().len() + loops.iter().map(Vec::len).sum::<usize>()) / 2;
    let euler = used as i64 - edges as i64 + mesh.triangles().len() as i64;
    let mut chart = match loops.len() {
        0 if euler == 2 => orbifold::lay_out(mesh, positions, param, task)?,
        1 if euler == 1 => border::lay_out(mesh, positions, param, task)?,
        count if euler + count as i64 == 2 => return Err(refused(format!("a component with {count} boundary loops"))),
        count => return Err(refused(format!("a component with {} handles", (2 - euler - count as i64) / 2))),
    };
    if param == Param::Stretch && chart.folds() == 0 {
        newton::improve(&mut chart, task)?;
    }
    match chart.folds() {
        0 => Ok(chart),
        folds => Err(Error::NoConvergence { what: "a map without folds", after: 1, residual: folds as f64 }),
    }
}

fn refused(id: String) -> Error {
    Error::Unsupported { what: Error::IMAGE_OF, id }
}

impl Chart {
    /// Whether the chart is a copy of a closed surface.
    pub(crate) fn is_closed(&self) -> bool {
        self.gluing == Gluing::Orbifold
    }
}
