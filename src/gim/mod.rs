//! Adaptive geometry images (papers 000, 001 and 003): a surface resampled as a rectangle of points.
//!
//! An [`Atlas`] flattens the surface once ([`crate::param`]); its charts are then sampled as often and as finely as wanted
//! ([`Map::sample`]) and the samples moved where they serve best ([`Map::adjust`]).

mod adjust;
mod fit;
mod gradient;
mod map;
mod resample;
mod sampling;
mod spread;
#[cfg(test)]
mod tests;
mod zhou;

pub(crate) use map::Map;
pub use resample::{Adjustment, Resample};
pub use sampling::Sampling;

pub use crate::param::Param;

use crate::error::{Error, MeshDefect, Result};
use crate::mesh::{HalfEdges, Union};
use crate::plane::GeometryImage;
use crate::task::Task;

/// Keeps what a codec can write cheaply of an image and drops the rest: the byte wing's part of [`Adjust::Rate`].
pub(crate) type Shrink<'a> = &'a (dyn Fn(&GeometryImage) -> Result<GeometryImage> + Sync);

/// What is done to the samples once they are taken.
#[derive(Clone, Copy, Default)]
pub(crate) enum Adjust<'a> {
    /// Nothing.
    #[default]
    None,
    /// Drawn to where the surface is, so that the mean distance falls.
    Fit,
    /// The same, in turns with dropping what would cost bytes and does not move the surface.
    Rate {
        /// Drops it.
        shrink: Shrink<'a>,
        /// Turns.
        rounds: usize,
    },
    /// Moved against the gradient of the Hausdorff distance (paper 000, Algorithms 1 to 3).
    Hausdorff,
}

/// Components of a surface at most: what falls into more pieces has no images worth the name.
const CHARTS: usize = 256;

/// How a surface becomes geometry images.
#[derive(Clone, Copy)]
pub(crate) struct ImageRequest<'a> {
    /// Samples a side; odd for closed surfaces.
    pub(crate) side: usize,
    pub(crate) param: Param,
    pub(crate) sampling: Sampling,
    pub(crate) adjust: Adjust<'a>,
}

/// A surface flattened, chart by chart.
pub(crate) struct Atlas {
    maps: Vec<Map>,
}

impl Atlas {
    /// Flattens a surface, each of its components on a chart of its own.
    ///
    /// # Errors
    /// Surfaces that no chart can hold; [`Error::NoConvergence`] if a chart cannot be had without folds.
    pub(crate) fn new(mesh: &HalfEdges, positions: &[[f64; 3]], param: Param, task: &Task<'_>) -> Result<Self> {
        let mut sets = Union::new(mesh.vertices());
        mesh.triangles().iter().for_each(|t| {
            sets.join(t[0], t[1]);
            sets.join(t[0], t[2]);
        });
        let roots: Vec<u32> = mesh.triangles().iter().map(|t| sets.find(t[0])).collect();
        let mut first: Vec<u32> = roots.clone();
        first.sort_unstable();
        first.dedup();
        if first.is_empty() {
            return Err(Error::Mesh(MeshDefect::Empty));
        }
        if first.len() > CHARTS {
            return Err(Error::Unsupported {
                what: Error::IMAGE_OF,
                id: format!("{} components (at most {CHARTS})", first.len()),
            });
        }
        if first.len() == 1 {
            return Ok(Self { maps: vec![Map::new(mesh, positions, param, task)?] });
        }
        // Triangles sorted by component, so that all components together cost what one does.
        let mut order: Vec<u32> = (0..roots.len() as u32).collect();
        order.sort_by_key(|&f| roots[f as usize]);
        let mut maps = Vec::new();
        for faces in order.chunk_by(|&f, &g| roots[f as usize] == roots[g as usize]) {
            let mut used: Vec<u32> = faces.iter().flat_map(|&f| mesh.triangles()[f as usize]).collect();
            used.sort_unstable();
            used.dedup();
            let local = |v: u32| used.binary_search(&v).unwrap_or(0) as u32;
            let triangles = faces.iter().map(|&f| mesh.triangles()[f as usize].map(local)).collect();
            let part = HalfEdges::new(used.len(), triangles)?;
            let positions: Vec<_> = used.iter().map(|&v| positions[v as usize]).collect();
            maps.push(Map::new(&part, &positions, param, task)?);
        }
        Ok(Self { maps })
    }

    /// The charts.
    pub(crate) fn maps(&self) -> &[Map] {
        &self.maps
    }

    /// Samples a side for each chart if the one of the largest area has `side`: by area, and of the same kind (2^k + 1, odd, even).
    pub(crate) fn sides(&self, side: usize) -> Vec<usize> {
        let areas: Vec<f64> = self.maps.iter().map(Map::area).collect();
        let largest = areas.iter().copied().fold(0.0, f64::max);
        let of = |area: f64| {
            let share = if largest > 0.0 { (area / largest).sqrt() } else { 1.0 };
            let squares = side.saturating_sub(1);
            if squares.is_power_of_two() {
                let halvings = (-share.max(f64::MIN_POSITIVE).log2()).round().clamp(0.0, 60.0) as u32;
                return 1 + (squares >> halvings).max(4.min(squares));
            }
            let scaled = (squares as f64 * share).round() as usize;
            (1 + (scaled + (scaled + squares) % 2).max(4 + squares % 2)).min(side)
        };
        areas.into_iter().map(of).collect()
    }
}

/// Flattens a surface, samples and adjusts it: one image a chart.
pub(crate) fn geometry_images(
    mesh: &HalfEdges,
    positions: &[[f64; 3]],
    request: &ImageRequest<'_>,
    task: &Task<'_>,
) -> Result<Vec<GeometryImage>> {
    let atlas = Atlas::new(mesh, positions, request.param, task)?;
    let image = |(map, side): (&Map, usize)| map.adjust(map.sample(side, request.sampling, task)?, request.adjust, task);
    atlas.maps().iter().zip(atlas.sides(request.side)).map(image).collect()
}
