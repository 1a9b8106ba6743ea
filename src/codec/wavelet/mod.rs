//! The codec `wavelet`: a geometry image as wavelet coefficients in local frames (spec/wavelet.md).
//!
//! ```text
//! image ─ lifting ─ details of every level, coarse samples
//! coarse samples, rounded ─ frames ─ details in frames, rounded ─ lifting back ─ the next finer level ─ …
//! indices ─ contexts ─ mixing ─ arithmetic coder ─ bytes
//! ```
//!
//! It knows how the border of the image is glued and sees no triangle. What a decoder repeats is `f64` with + − × ÷ √ in a
//! fixed order, so that every machine finds the same points; what the arithmetic coder needs is integers alone. A decoder
//! may stop after any level and has an image of half, a quarter, … of the samples a side.

mod coarse;
mod contexts;
#[cfg(feature = "encode")]
mod decide;
mod frames;
mod lifting;
mod quantise;
#[cfg(feature = "encode")]
mod shrink;
#[cfg(all(test, feature = "encode"))]
mod tests;
mod trained;
#[cfg(all(feature = "encode", feature = "inner"))]
#[allow(unreachable_pub)]
pub mod trial;
mod zones;

use contexts::{Contexts, Field, Place as At};
use frames::{frame, into_frame, out_of_frame};
use lifting::{Grid, most_levels};
use quantise::{Band, MAX_INDEX, MAX_LEVELS, coarse_step, steps, value};
#[cfg(feature = "encode")]
pub(crate) use shrink::shrink;
pub(crate) use zones::Zones;

use crate::entropy::{BitCoder, BitReader, BitWriter};
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
#[cfg(feature = "encode")]
use crate::plane::bounding_box;
use crate::plane::{GeometryImage, Gluing, Shape};
use crate::task::Task;

/// What is known of an image before its bytes are read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    pub(crate) shape: Shape,
    pub(crate) gluing: Gluing,
    /// How often it is halved.
    pub(crate) levels: u8,
    /// The error of one sample is about this over √12, in the units of the mesh.
    pub(crate) step: f64,
    /// Where steps are coarser, if there is a region of interest.
    pub(crate) zones: Option<Zones>,
}

/// Samples a side below which halving an image saves nothing.
const SMALLEST_SIDE: usize = 5;

impl Layout {
    /// A layout with the levels that suit most surfaces.
    #[cfg(feature = "encode")]
    pub(crate) fn new(shape: Shape, gluing: Gluing, step: f64) -> Self {
        let (mut levels, mut coarse) = (0, shape);
        let most = most_levels(shape, gluing).min(MAX_LEVELS);
        while levels < most && coarse.halved().width().min(coarse.halved().height()) >= SMALLEST_SIDE {
            coarse = coarse.halved();
            levels += 1;
        }
        Self { shape, gluing, levels, step, zones: None }
    }

    /// Refuses levels that the image has not.
    pub(crate) fn check(&self) -> Result<()> {
        self.gluing.check(self.shape).map_err(|e| Error::malformed(Place::Whole, e.to_string()))?;
        let most = most_levels(self.shape, self.gluing).min(MAX_LEVELS);
        if self.levels > most {
            let why = format!("{} levels of an image of {}; it has at most {most}", self.levels, self.shape);
            return Err(Error::malformed(Place::Whole, why));
        }
        if !(self.step > 0.0 && self.step.is_finite()) {
            return Err(Error::malformed(Place::Whole, format!("a step of {}", self.step)));
        }
        Ok(())
    }

    /// The shape of the image after `level` halvings.
    pub(crate) fn shape_at(&self, level: u8) -> Shape {
        (0..level).fold(self.shape, |shape, _| shape.halved())
    }

    /// Memory and steps that decoding up to `level` takes at most.
    pub(crate) fn cost(&self, level: u8) -> (u64, u64) {
        let pixels = self.shape_at(level).pixels() as u64;
        (pixels.saturating_mul(BYTES_A_SAMPLE).saturating_add(4 << 20), pixels.saturating_mul(STEPS_A_SAMPLE))
    }

    /// The steps of a detail at a place of a level.
    fn steps(&self, level: u8, band: Band, place: [usize; 2]) -> [f64; 3] {
        Zones::steps(self.zones.as_ref(), self.step, level, band, place)
    }

    fn grid(&self, level: u8) -> Result<Grid> {
        let shape = self.shape_at(level);
        Ok(Grid { shape, gluing: self.gluing, points: vec![[0.0; 3]; shape.pixels()] })
    }

    /// The longest side of a box in steps of the details of a level, at most 2²⁴.
    fn reach(&self, [low, high]: [[f64; 3]; 2], level: u8) -> u32 {
        let longest = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
        (longest / steps(self.step, level, Band::Column)[0]).min(f64::from(1 << 24)) as u32
    }

    /// A box in steps of the coarse samples.
    fn coarse_box(&self, bounds: [[f64; 3]; 2]) -> [[i32; 3]; 2] {
        let step = coarse_step(self.step, self.levels);
        let limit = f64::from(MAX_INDEX);
        bounds.map(|corner| corner.map(|x| (x / step).floor().clamp(-limit, limit) as i32))
    }
}

/// The image itself, its preview, a level's coefficients and indices, and the finished points.
const BYTES_A_SAMPLE: u64 = 160;
/// Decisions of three indices with their contexts, and the transform.
const STEPS_A_SAMPLE: u64 = 60;

/// An image as integers.
#[cfg(feature = "encode")]
#[derive(Clone, Debug)]
pub(crate) struct Quantised {
    layout: Layout,
    coarse: Vec<[i32; 3]>,
    /// Of every level, the finest first, at the place of their samples.
    details: Vec<Vec<[i32; 3]>>,
}

/// Rounds an image, and gives also what a decoder will find.
#[cfg(feature = "encode")]
pub(crate) fn quantise(image: &GeometryImage, layout: Layout, task: &Task<'_>) -> Result<(Quantised, GeometryImage)> {
    layout.check()?;
    let mut open = analyse(image, layout.levels, task)?;
    let too_small =
        || Error::Parameter(format!("a step of {} is too small for this image: it needs indices beyond 2³⁰", layout.step));
    let step = coarse_step(layout.step, layout.levels);
    let index = |x: f64| {
        let index = (x / step + 0.5).floor();
        (index.abs() <= f64::from(MAX_INDEX)).then_some(index as i32).ok_or_else(too_small)
    };
    let coarse = open.pop().map_or(Vec::new(), |grid| grid.points);
    let coarse: Vec<[i32; 3]> =
        coarse.into_iter().map(|[x, y, z]| Ok([index(x)?, index(y)?, index(z)?])).collect::<Result<_>>()?;
    let mut decoded = coarse_grid(&layout, &coarse)?;
    let mut decider = decide::Decider::new(layout.clone(), bounding_box(image.points().iter().copied()).unwrap_or_default());
    let mut details = vec![Vec::new(); usize::from(layout.levels)];
    for level in (0..layout.levels).rev() {
        task.step(0.5)?;
        let preview = preview(&layout, level, &decoded)?;
        let mut shares = open.pop().ok_or_else(too_small)?;
        in_frames(&preview, &mut shares, |band, place| layout.steps(level, band, place));
        let indices = decider.indices(&shares, level).ok_or_else(too_small)?;
        decoded = refine(&layout, level, &decoded, preview, &indices);
        details[usize::from(level)] = indices;
    }
    let (width, height) = (layout.shape.width(), layout.shape.height());
    let image = GeometryImage::new(width, height, layout.gluing, decoded.points)?;
    Ok((Quantised { layout, coarse, details }, image))
}

/// All levels of an image: details and coarse samples of each, the finest first; last the coarsest samples alone.
#[cfg(feature = "encode")]
fn analyse(image: &GeometryImage, levels: u8, task: &Task<'_>) -> Result<Vec<Grid>> {
    let mut grids = Vec::new();
    let mut grid = Grid { shape: image.shape(), gluing: image.gluing(), points: image.points().to_vec() };
    for _ in 0..levels {
        task.step(0.2)?;
        grid.analyse();
        let coarse = grid.coarse();
        grids.push(grid);
        grid = coarse;
    }
    grids.push(grid);
    Ok(grids)
}

/// Turns details into the frames of the preview, in steps.
#[cfg(feature = "encode")]
fn in_frames(preview: &Grid, details: &mut Grid, steps: impl Fn(Band, [usize; 2]) -> [f64; 3]) {
    let width = preview.shape.width();
    for (at, detail) in details.points.iter_mut().enumerate() {
        let (row, column) = (at / width, at % width);
        if let Some(band) = Band::of(row, column) {
            let local = into_frame(&frame(preview, row, column), *detail);
            let steps = steps(band, [row, column]);
            *detail = [0, 1, 2].map(|i| local[i] / steps[i]);
        }
    }
}

fn coarse_grid(layout: &Layout, indices: &[[i32; 3]]) -> Result<Grid> {
    let step = coarse_step(layout.step, layout.levels);
    let mut grid = layout.grid(layout.levels)?;
    for (point, index) in grid.points.iter_mut().zip(indices) {
        *point = index.map(|q| f64::from(q) * step);
    }
    Ok(grid)
}

/// The image of a level as its coarser neighbour foretells it: all details are 0.
fn preview(layout: &Layout, level: u8, coarse: &Grid) -> Result<Grid> {
    let mut grid = layout.grid(level)?;
    grid.put_coarse(coarse);
    grid.synthesise();
    Ok(grid)
}

/// The image of a level, from its coarser neighbour and indices.
fn refine(layout: &Layout, level: u8, coarse: &Grid, preview: Grid, indices: &[[i32; 3]]) -> Grid {
    if indices.iter().all(|index| *index == [0; 3]) {
        return preview;
    }
    let width = preview.shape.width();
    let mut points = vec![[0.0; 3]; preview.points.len()];
    for at in 0..points.len() {
        let (row, column) = (at / width, at % width);
        let Some(band) = Band::of(row, column) else { continue };
        let of = layout.gluing.representative(preview.shape, row, column);
        if of != (row, column) {
            points[at] = points[of.0 * width + of.1];
        } else if indices[at] != [0; 3] {
            let steps = layout.steps(level, band, [row, column]);
            let local = [0, 1, 2].map(|i| value(indices[at][i], steps[i]));
            points[at] = out_of_frame(&frame(&preview, row, column), local);
        }
    }
    let mut grid = Grid { points, ..preview };
    grid.put_coarse(coarse);
    grid.synthesise();
    grid
}

/// The bytes of an image that lies in a box, which a reader must be told too.
#[cfg(feature = "encode")]
pub(crate) fn write(image: &Quantised, bounds: [[f64; 3]; 2]) -> Result<Vec<u8>> {
    let layout = &image.layout;
    let mut coder = BitWriter::default();
    let mut indices = image.coarse.clone();
    coarse::code(&mut coder, layout.shape_at(layout.levels), layout.gluing, layout.coarse_box(bounds), &mut indices)?;
    let (width, height) = (layout.shape.width(), layout.shape.height());
    let mut field = Field { width, height, indices: vec![[0; 3]; width * height], reach: 0 };
    let mut contexts = Contexts::default();
    for level in (0..layout.levels).rev() {
        let details = &image.details[usize::from(level)];
        let columns = layout.shape_at(level).width();
        for (at, &index) in details.iter().enumerate().filter(|(_, index)| **index != [0; 3]) {
            field.indices[((at / columns) * width + at % columns) << level] = index;
        }
        let some = details.iter().any(|index| *index != [0; 3]);
        field.reach = layout.reach(bounds, level);
        code_level(&mut coder, &mut contexts, &mut field, layout, level, 0, some);
    }
    Ok(coder.finish())
}

/// Codes the details of a level. `finest` is the level whose samples are all in the field.
fn code_level<C: BitCoder>(
    coder: &mut C,
    contexts: &mut Contexts,
    field: &mut Field,
    layout: &Layout,
    level: u8,
    finest: u8,
    some: bool,
) -> bool {
    if !coder.code(some, 1 << 15) {
        return false;
    }
    let (shape, stride) = (layout.shape_at(level), 1_usize << (level - finest));
    let age = usize::from(layout.levels - 1 - level);
    for row in 0..shape.height() {
        for column in 0..shape.width() {
            let Some(band) = Band::of(row, column) else { continue };
            if layout.gluing.representative(shape, row, column) == (row, column) {
                let place = At { row: row * stride, column: column * stride, stride, band, age };
                contexts.code(coder, field, place);
            }
        }
    }
    true
}

/// Reads the image that some bytes hold, down to `finest`: 0 for all of it, 1 for half of the samples a side, and so on.
pub(crate) fn decode(
    bytes: &[u8],
    layout: &Layout,
    bounds: [[f64; 3]; 2],
    finest: u8,
    budget: &mut Budget,
    task: &Task<'_>,
) -> Result<GeometryImage> {
    layout.check()?;
    let finest = finest.min(layout.levels);
    let shape = layout.shape_at(finest);
    budget.check_pixels(shape.pixels() as u64)?;
    let (memory, work) = layout.cost(finest);
    budget.reserve(memory)?;
    budget.spend(work)?;
    let mut coder = BitReader::new(bytes);
    let coarse_shape = layout.shape_at(layout.levels);
    let mut indices = vec![[0; 3]; coarse_shape.pixels()];
    coarse::code(&mut coder, coarse_shape, layout.gluing, layout.coarse_box(bounds), &mut indices)?;
    let mut grid = coarse_grid(layout, &indices)?;
    let (width, height) = (shape.width(), shape.height());
    let mut field = Field { width, height, indices: vec![[0; 3]; width * height], reach: 0 };
    let mut contexts = Contexts::default();
    for level in (finest..layout.levels).rev() {
        task.step(1.0 - f64::from(level) / f64::from(layout.levels))?;
        let ahead = preview(layout, level, &grid)?;
        field.reach = layout.reach(bounds, level);
        let some = code_level(&mut coder, &mut contexts, &mut field, layout, level, finest, false);
        grid = if some {
            let (columns, stride) = (ahead.shape.width(), 1 << (level - finest));
            let at = |at: usize| field.indices[at / columns * stride * width + at % columns * stride];
            let details: Vec<[i32; 3]> = (0..ahead.points.len()).map(at).collect();
            refine(layout, level, &grid, ahead, &details)
        } else {
            ahead
        };
    }
    GeometryImage::new(width, height, layout.gluing, grid.points).map_err(|e| Error::malformed(Place::Whole, e.to_string()))
}
