//! Parametrisation: a surface flattened onto the unit square.
//!
//! A disk is pinned to the square's border ([`border`]); a closed surface of genus 0 covers the plane again and again, folded
//! about four cones ([`orbifold`]), and the square is one copy of it; one with handles is cut open ([`seams`]). Boundary loops
//! that are not the square's border are filled ([`sheet`]). Either way every vertex has one unknown point, found from its
//! neighbours ([`barycentric`]) and improved until the surface is stretched as little as may be ([`yoshizawa`], [`newton`]).
//! Triangles that would be turned over are never kept silently: what comes out has none.

mod barycentric;
mod border;
mod chart;
mod cones;
mod newton;
mod orbifold;
mod seams;
mod sheet;
mod split;
#[cfg(test)]
mod tests;
mod weights;
mod yoshizawa;

pub(crate) use chart::Chart;
pub(crate) use split::split_edges;

use std::f64::consts::PI;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::mesh::{HalfEdges, boundary_loops};
use crate::task::Task;
use sheet::Sheet;

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

/// What becomes the border of the square where a surface has a boundary and no handles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Border {
    /// The longest boundary loop if it is long for the surface; else the loops are filled, and the surface is laid out as a closed
    /// one with holes.
    #[default]
    Auto,
    /// Always the longest boundary loop, as in the papers.
    Square,
}

/// How a surface is flattened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Flattening {
    pub(crate) param: Param,
    pub(crate) border: Border,
}

/// A surface with a boundary is laid out as if it were closed if its longest loop, as a circle, would hold less than this share of
/// its area: to be spread around a square costs a bust or a foot more than the squares that fill its hole. Of eight surfaces
/// those with shares of 0.01 to 0.2 took 8 to 46 % fewer bytes so, and those of 0.9 and 1.2 two to three times as many.
const NEARLY_CLOSED: f64 = 0.3;

/// Flattens a connected surface.
///
/// Without handles it is closed, or its longest boundary loop becomes the square; other loops are filled. With handles all are, and it is
/// cut open along seams.
///
/// # Errors
/// [`Error::Unsupported`] for surfaces of too many handles; and [`Error::NoConvergence`] if no map without folds is found in f64.
pub(crate) fn flatten(mesh: HalfEdges, positions: Vec<DVec3>, how: Flattening, task: &Task<'_>) -> Result<Chart> {
    let param = how.param;
    let mut loops = boundary_loops(&mesh);
    let length = |around: &Vec<u32>| -> f64 {
        around.iter().map(|&h| positions[mesh.from(h) as usize].distance(positions[mesh.to(h) as usize])).sum()
    };
    loops.sort_by(|a, b| length(a).total_cmp(&length(b)));
    let longest = loops.last().map_or(0.0, length);
    let area: f64 = mesh.triangles().iter().map(|t| area(t.map(|v| positions[v as usize]))).sum();
    let share = if how.border == Border::Auto { NEARLY_CLOSED } else { 0.0 };
    let is_open = !loops.is_empty() && longest * longest / (4.0 * PI) >= share * area;
    let mut chart = if handles(&mesh, &loops) > 0 {
        seams::lay_out(Sheet::filled(mesh, positions, &loops)?, param, task)?
    } else if is_open {
        loops.pop();
        border::lay_out(Sheet::filled(mesh, positions, &loops)?, param, task)?
    } else {
        orbifold::lay_out(Sheet::filled(mesh, positions, &loops)?, param, task)?
    };
    if param == Param::Stretch && chart.folds() == 0 {
        newton::improve(&mut chart, task)?;
    }
    match chart.folds() {
        0 => Ok(chart),
        folds => Err(Error::NoConvergence { what: "a map without folds", after: 1, residual: folds as f64 }),
    }
}

/// The area of a triangle.
pub(crate) fn area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// Handles of a connected surface, from its Euler number.
fn handles(mesh: &HalfEdges, loops: &[Vec<u32>]) -> i64 {
    let used = (0..mesh.vertices() as u32).filter(|&v| mesh.outgoing(v).is_some()).count() as i64;
    let faces = mesh.triangles().len() as i64;
    let edges = (3 * faces + loops.iter().map(|around| around.len() as i64).sum::<i64>()) / 2;
    (2 - loops.len() as i64 - (used - edges + faces)) / 2
}

fn refused(id: String) -> Error {
    Error::Unsupported { what: Error::IMAGE_OF, id }
}
