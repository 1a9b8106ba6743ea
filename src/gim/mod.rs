//! Adaptive geometry images (papers 000, 001 and 003): a surface resampled as a rectangle of points.
//!
//! An [`Atlas`] flattens the surface once ([`crate::param`]); its charts are then sampled as often and as finely as wanted
//! ([`Map::sample`]) and the samples moved where they serve best ([`Map::adjust`]).

mod adjust;
mod fit;
mod focus;
mod gradient;
mod interest;
mod map;
mod resample;
mod rim;
mod sampling;
mod spread;
#[cfg(test)]
mod tests;
mod zhou;

pub use focus::Closer;
pub(crate) use focus::Focus;
pub(crate) use interest::{Interest, region_under};
pub(crate) use map::Map;
pub use resample::{Adjustment, Resample};
pub use sampling::Sampling;

pub(crate) use crate::param::Flattening;
pub use crate::param::{Border, Param};

use crate::error::{Error, MeshDefect, Result};
use crate::mesh::{Front, HalfEdges, Mesh, Union};
use crate::plane::{GeometryImage, Shape};
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
    /// Moved against the gradient of the Hausdorff distance (paper 000, Algorithms 1 to 3): of all, or of a region of interest.
    Hausdorff(Option<Focus<'a>>),
}

/// Where samples are taken, and what gets more of them.
#[derive(Clone, Copy, Default)]
pub(crate) struct Sampler<'a> {
    pub(crate) sampling: Sampling,
    pub(crate) focus: Option<Focus<'a>>,
}

/// Components of a surface at most: what falls into more pieces has no images worth the name.
const CHARTS: usize = 256;

/// Samples a side that a component is given at most to be seen between its holes.
const MOST_FOR_HOLES: usize = 129;

/// A surface flattened, chart by chart.
pub(crate) struct Atlas {
    maps: Vec<Map>,
}

impl Atlas {
    /// Flattens a mesh. What is no oriented manifold is cut apart first.
    ///
    /// # Errors
    /// As [`Atlas::new`].
    pub(crate) fn of_mesh(mesh: &Mesh, how: Flattening, task: &Task<'_>) -> Result<Self> {
        if mesh.faces.are_triangles()
            && let Ok(surface) = HalfEdges::new(mesh.positions.len(), mesh.faces.triangles())
        {
            return Self::new(&surface, &mesh.positions, how, task);
        }
        let front = Front::new(mesh.positions.len(), &mesh.faces);
        let positions: Vec<[f64; 3]> = front.vertex.iter().map(|&v| mesh.positions[v as usize]).collect();
        Self::new(&front.surface, &positions, how, task)
    }

    /// Flattens a surface, each of its components on a chart of its own.
    ///
    /// # Errors
    /// Surfaces that no chart can hold; [`Error::NoConvergence`] if a chart cannot be had without folds.
    pub(crate) fn new(mesh: &HalfEdges, positions: &[[f64; 3]], how: Flattening, task: &Task<'_>) -> Result<Self> {
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
            return Ok(Self { maps: vec![Map::new(mesh, positions, how, task)?] });
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
            maps.push(Map::new(&part, &positions, how, task)?);
        }
        Ok(Self { maps })
    }

    /// The charts.
    pub(crate) fn maps(&self) -> &[Map] {
        &self.maps
    }

    /// The surface sampled: one image a chart, with `side` samples a side for the one of the largest area.
    pub(crate) fn sample(&self, side: usize, sampler: Sampler<'_>, task: &Task<'_>) -> Result<Vec<GeometryImage>> {
        let image = |(map, mut side): (&Map, usize)| loop {
            match map.sample(Shape::new(side as u32, side as u32)?, sampler, task) {
                // Small parts between holes may be seen only by more samples than their area is due.
                Err(Error::Parameter(_)) if self.maps.len() > 1 && (3..MOST_FOR_HOLES).contains(&side) => side = 2 * side - 1,
                other => return other,
            }
        };
        self.maps.iter().zip(self.sides(side)).map(image).collect()
    }

    /// The surface as one image of any shape.
    pub(crate) fn sample_as(&self, shape: Shape, sampler: Sampler<'_>, task: &Task<'_>) -> Result<Vec<GeometryImage>> {
        match &self.maps[..] {
            [map] => Ok(vec![map.sample(shape, sampler, task)?]),
            maps => Err(Error::Parameter(format!(
                "{shape} samples for a surface of {} components: their grids are squares of different sizes, and one number says \
                 how many samples a side the largest has",
                maps.len()
            ))),
        }
    }

    /// Images of the charts with their samples moved.
    pub(crate) fn adjust(&self, images: Vec<GeometryImage>, how: Adjust<'_>, task: &Task<'_>) -> Result<Vec<GeometryImage>> {
        self.maps.iter().zip(images).map(|(map, image)| map.adjust(image, how, task)).collect()
    }

    /// Squares a side of the chart of the largest area are a multiple of this.
    pub(crate) fn grains(&self) -> usize {
        self.maps.iter().max_by(|a, b| a.area().total_cmp(&b.area())).map_or(1, Map::grains)
    }

    /// Samples a side for each chart if the one of the largest area has `side`: by area, of the same kind (2^k + 1 and 3 · 2^k + 1, odd,
    /// even), and such that its seams fit.
    pub(crate) fn sides(&self, side: usize) -> Vec<usize> {
        let areas: Vec<f64> = self.maps.iter().map(Map::area).collect();
        let largest = areas.iter().copied().fold(0.0, f64::max);
        let squares = side.saturating_sub(1);
        let halves_well = squares.is_power_of_two() || (squares.is_multiple_of(3) && (squares / 3).is_power_of_two());
        let of = |area: f64| {
            let share = if largest > 0.0 { (area / largest).sqrt() } else { 1.0 };
            let scaled = squares as f64 * share;
            if halves_well {
                let below = scaled.max(4.0).log2().floor().exp2();
                let near = [1.0, 1.5, 2.0].map(|f| below * f).into_iter().rfind(|&n| n <= scaled * 1.19);
                return (1 + near.unwrap_or(4.0) as usize).min(side);
            }
            let scaled = scaled.round() as usize;
            (1 + (scaled + (scaled + squares) % 2).max(4 + squares % 2)).min(side)
        };
        let fitting = |(map, area): (&Map, f64)| match map.grains() {
            _ if area == largest => side,
            1 => of(area),
            grains => (of(area) - 1).div_ceil(grains).next_power_of_two() * grains + 1,
        };
        self.maps.iter().zip(areas).map(fitting).collect()
    }
}
