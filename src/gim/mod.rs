//! Adaptive geometry images (papers 000, 001 and 003): a surface resampled as a rectangle of points.
//!
//! An [`Atlas`] flattens the surface once ([`crate::param`]); its charts are then sampled as often and as finely as wanted
//! ([`Map::sample`]) and the samples moved where they serve best ([`Map::adjust`]).

mod fit;
mod map;
mod sampling;
mod spread;
#[cfg(test)]
mod tests;

pub(crate) use map::Map;
pub(crate) use sampling::Sampling;

use crate::error::{Error, Result};
use crate::mesh::HalfEdges;
use crate::param::Param;
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
    /// Flattens a surface.
    ///
    /// # Errors
    /// Surfaces that no chart can hold; [`Error::NoConvergence`] if a chart cannot be had without folds.
    pub(crate) fn new(mesh: &HalfEdges, positions: &[[f64; 3]], param: Param, task: &Task<'_>) -> Result<Self> {
        Ok(Self { maps: vec![Map::new(mesh, positions, param, task)?] })
    }

    /// The charts.
    pub(crate) fn maps(&self) -> &[Map] {
        &self.maps
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
    let image = |map: &Map| map.adjust(map.sample(request.side, request.sampling, task)?, request.adjust, task);
    atlas.maps().iter().map(image).collect()
}

/// What stands in for a method that a surface is too wild for.
fn refused(why: impl std::fmt::Display) -> Error {
    Error::Parameter(format!("{why}; `--method cgim` stores any manifold"))
}
