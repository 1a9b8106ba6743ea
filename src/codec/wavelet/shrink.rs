//! A smoother way to lie in the surface: details lose what they have in the tangent plane (the first half of gim.md's
//! "rate-aware fit"; an encoder's affair, not part of the format).
//!
//! Where a sample lies along the surface is free, and costs bytes. Tangential details are moved towards zero by a share of
//! their quantiser step (soft thresholding); the shape that suffers from it a little is then fitted again by the caller, and
//! so on in turns.

use super::{Layout, Zones, analyse, coarse_grid, frame, into_frame, out_of_frame, preview};
use crate::codec::wavelet::lifting::Grid;
use crate::error::{Error, Result};
use crate::plane::GeometryImage;
use crate::task::Task;

use super::quantise::Band;

/// So many levels, the finest ones, give way.
const LEVELS: u8 = 4;

/// Moves the tangential details of an image, in frames of its own coarser levels, by `share` quantiser steps towards zero.
pub(crate) fn shrink(
    image: &GeometryImage,
    step: f64,
    zones: Option<Zones>,
    share: f64,
    task: &Task<'_>,
) -> Result<GeometryImage> {
    let layout = Layout { zones, ..Layout::new(image.shape(), image.gluing(), step) };
    layout.check().map_err(|e| Error::Parameter(e.to_string()))?;
    let mut grids = analyse(image, layout.levels, task)?;
    let mut grid = match grids.pop() {
        Some(coarse) => coarse,
        None => coarse_grid(&layout, &[])?,
    };
    for level in (0..layout.levels).rev() {
        task.step(0.5)?;
        let Some(mut details) = grids.pop() else { break };
        if level < LEVELS {
            let ahead = preview(&layout, level, &grid)?;
            give_way(&ahead, &mut details, |band, place| layout.steps(level, band, place).map(|s| share * s));
        }
        details.put_coarse(&grid);
        details.synthesise();
        grid = details;
    }
    image.with_points(grid.points)
}

fn give_way(preview: &Grid, details: &mut Grid, thresholds: impl Fn(Band, [usize; 2]) -> [f64; 3]) {
    let width = preview.shape.width();
    for (at, detail) in details.points.iter_mut().enumerate() {
        let (row, column) = (at / width, at % width);
        let Some(band) = Band::of(row, column) else { continue };
        let thresholds = thresholds(band, [row, column]);
        let own = frame(preview, row, column);
        let mut local = into_frame(&own, *detail);
        for i in 1..3 {
            let size = (local[i].abs() - thresholds[i]).max(0.0);
            local[i] = if local[i] < 0.0 { -size } else { size };
        }
        *detail = out_of_frame(&own, local);
    }
}
