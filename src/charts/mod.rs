//! The doors of geometry images: an image to a file, and back to a mesh.
//!
//! One of the few files that see both wings. On the way in: image → coefficients or planes → bytes, with a step that a search
//! may choose. On the way out: bytes → image (of any of its levels) → vertices and triangles.

#[cfg(all(feature = "png", feature = "exr"))]
mod picture;
#[cfg(feature = "encode")]
mod psnr;
#[cfg(feature = "encode")]
mod region;
#[cfg(feature = "encode")]
mod sample;
#[cfg(feature = "encode")]
mod search;
mod surface;
#[cfg(feature = "encode")]
mod write;

#[cfg(feature = "encode")]
pub(crate) use region::Interesting;
#[cfg(feature = "encode")]
pub(crate) use sample::sample;
#[cfg(feature = "encode")]
pub(crate) use search::{Aim, finish, search};
pub(crate) use surface::{mesh, surface};
#[cfg(feature = "encode")]
pub(crate) use write::How;

#[cfg(feature = "exr")]
use crate::codec::Exr;
use crate::codec::j2k::J2k;
use crate::codec::mask;
use crate::codec::wavelet::{self, Layout, Zones};
use crate::codec::{PlaneCodec, Raw};
use crate::error::{Error, Place, Result};
use crate::format::{ImageBody, ImageChunk, PlanesBy, RegionField};
use crate::limits::Budget;
use crate::plane::{GeometryImage, Gluing, Lattice, Mask, Planes, RegionCells, Shape};
use crate::task::Task;

/// Bytes a sample that the mesh takes, and its codec of planes.
const BYTES_A_SAMPLE: u64 = 160;
const STEPS_A_SAMPLE: u64 = 40;
/// The same where holes may leave several fans around a sample: the corners of two triangles are sorted into them.
const BYTES_A_SAMPLE_BESIDE_HOLES: u64 = 400;
const STEPS_A_SAMPLE_BESIDE_HOLES: u64 = 120;

/// The shape of the image that a chunk holds.
fn shape(chunk: &ImageChunk<'_>) -> Result<Shape> {
    let malformed = |e: Error| Error::malformed(Place::Whole, e.to_string());
    let shape = Shape::new(chunk.columns, chunk.rows).map_err(malformed)?;
    chunk.gluing.check(shape).map_err(malformed)?;
    Ok(shape)
}

/// The layout of coefficients, if the codec has them.
fn layout(chunk: &ImageChunk<'_>) -> Result<Option<Layout>> {
    match chunk.body {
        ImageBody::Wavelet { levels, step, .. } => {
            let layout = Layout { shape: shape(chunk)?, gluing: chunk.gluing, levels, step: step.into(), zones: None };
            layout.check()?;
            Ok(Some(layout))
        }
        ImageBody::Planes { .. } => Ok(None),
    }
}

/// Columns and rows of the image after `level` halvings, as far as the file has levels.
pub(crate) fn size_at(chunk: &ImageChunk<'_>, level: u8) -> Result<[u32; 2]> {
    Ok(match layout(chunk)? {
        Some(layout) => {
            let shape = layout.shape_at(level.min(chunk.levels()));
            [shape.width() as u32, shape.height() as u32]
        }
        None => {
            shape(chunk)?;
            [chunk.columns, chunk.rows]
        }
    })
}

/// Vertices of the image after `level` halvings, at most.
pub(crate) fn vertices_at(chunk: &ImageChunk<'_>, level: u8) -> Result<u64> {
    let [columns, rows] = size_at(chunk, level)?;
    // Where holes touch, a sample is up to four vertices.
    let copies = if chunk.holes.is_some() { 4 } else { 1 };
    Ok(if level == 0 { chunk.vertices() } else { copies * u64::from(columns) * u64::from(rows) })
}

/// Memory and steps that decoding an image and its mesh takes at most.
pub(crate) fn cost(chunk: &ImageChunk<'_>, level: u8) -> Result<(u64, u64)> {
    let codec = layout(chunk)?.map_or((0, 0), |layout| layout.cost(level.min(chunk.levels())));
    let mask = if chunk.holes.is_some() { mask::cost(squares(shape(chunk)?)?) } else { (0, 0) };
    let region = if chunk.region.is_some() { mask::cost(RegionCells::layout(shape(chunk)?)?.0) } else { (0, 0) };
    let parts = [mesh_cost(chunk, level)?, codec, mask, region];
    Ok(parts.into_iter().fold((0, 0), |sum: (u64, u64), part| (sum.0.saturating_add(part.0), sum.1.saturating_add(part.1))))
}

/// What the mesh takes of that, and codecs of planes.
fn mesh_cost(chunk: &ImageChunk<'_>, level: u8) -> Result<(u64, u64)> {
    let [columns, rows] = size_at(chunk, level)?;
    let samples = u64::from(columns) * u64::from(rows);
    let (bytes, steps) = match chunk.holes {
        Some(_) => (BYTES_A_SAMPLE_BESIDE_HOLES, STEPS_A_SAMPLE_BESIDE_HOLES),
        None => (BYTES_A_SAMPLE, STEPS_A_SAMPLE),
    };
    Ok((samples.saturating_mul(bytes), samples.saturating_mul(steps)))
}

/// The squares between the samples of an image.
fn squares(samples: Shape) -> Result<Shape> {
    Shape::new(samples.width() as u32 - 1, samples.height() as u32 - 1)
        .map_err(|e| Error::malformed(Place::Whole, e.to_string()))
}

/// Reads an image; `level` 0 is all of it, each further one halves its sides.
pub(crate) fn read(chunk: &ImageChunk<'_>, level: u8, budget: &mut Budget, task: Task<'_>) -> Result<GeometryImage> {
    let [columns, rows] = size_at(chunk, level)?;
    budget.check_pixels(u64::from(columns) * u64::from(rows))?;
    let (memory, work) = mesh_cost(chunk, level)?;
    budget.reserve(memory)?;
    budget.spend(work)?;
    let level = level.min(chunk.levels());
    let whole = shape(chunk)?;
    let malformed = |e: Error| Error::malformed(Place::Whole, e.to_string());
    let mut image = match (chunk.body, layout(chunk)?) {
        (ImageBody::Wavelet { bounds, .. }, Some(layout)) => {
            let zones = match chunk.region {
                Some(region) if region.coarser > 0 => {
                    let cells = region_cells(&region, whole, budget)?;
                    Some(Zones::new(&cells, chunk.gluing, region.coarser))
                }
                _ => None,
            };
            let layout = Layout { zones, ..layout };
            wavelet::decode(chunk.bytes, &layout, bounds.bounds(), level, budget, &task)?
        }
        (ImageBody::Planes { codec, depth, lattice }, _) => {
            let planes = plane_codec(codec)?.decode(chunk.bytes, whole, &[depth; 3], budget)?;
            from_planes(&planes, chunk.gluing, &lattice).map_err(malformed)?
        }
        (ImageBody::Wavelet { .. }, None) => return Err(Error::malformed(Place::Whole, "an image without a layout")),
    };
    if let Some(seams) = &chunk.seams {
        image = image.averaging_seams(seams.clone()).map_err(malformed)?;
    }
    if let Some(holes) = &chunk.holes {
        let mask = mask::read(holes.bytes, squares(whole)?, budget)?;
        let left = mask.shape().pixels() - mask.count();
        if left != holes.squares as usize {
            let why = format!("{left} squares that are no holes, and {} are told of", holes.squares);
            return Err(Error::malformed(Place::Whole, why));
        }
        image = image.with_holes(at_level(&mask, level)).map_err(malformed)?;
    }
    Ok(image)
}

/// The region of interest of an image, if it has one.
pub(crate) fn region(chunk: &ImageChunk<'_>, budget: &mut Budget) -> Result<Option<RegionCells>> {
    let whole = shape(chunk)?;
    budget.check_pixels(whole.pixels() as u64)?;
    budget.reserve(whole.pixels() as u64)?;
    chunk.region.map(|region| region_cells(&region, whole, budget)).transpose()
}

/// The cells of an image that its region of interest takes.
fn region_cells(region: &RegionField<'_>, image: Shape, budget: &mut Budget) -> Result<RegionCells> {
    let (cells, _) = RegionCells::layout(image)?;
    RegionCells::new(image, mask::read(region.bytes, cells, budget)?)
}

/// The holes of an image after `level` halvings: squares all of whose parts are holes.
fn at_level(holes: &Mask, level: u8) -> Mask {
    let (width, height) = (holes.shape().width() >> level, holes.shape().height() >> level);
    let part = |row: usize, column: usize| {
        let parts = 1 << level;
        (row * parts..(row + 1) * parts).all(|r| (column * parts..(column + 1) * parts).all(|c| holes.contains(r, c)))
    };
    let shape = Shape::new(width as u32, height as u32).unwrap_or(holes.shape());
    Mask::from_fn(shape, part)
}

fn plane_codec(codec: PlanesBy) -> Result<Box<dyn PlaneCodec>> {
    match codec {
        PlanesBy::Raw => Ok(Box::new(Raw)),
        #[cfg(feature = "exr")]
        PlanesBy::Exr => Ok(Box::new(Exr)),
        #[cfg(not(feature = "exr"))]
        PlanesBy::Exr => Err(Error::Unsupported { what: "codec", id: "exr".into() }),
        PlanesBy::J2k => Ok(Box::new(J2k::default())),
    }
}

/// The name of the codec of an image.
pub(crate) fn codec_name(body: &ImageBody) -> &'static str {
    match body {
        ImageBody::Wavelet { .. } => "wavelet",
        ImageBody::Planes { codec: PlanesBy::Raw, .. } => "raw",
        ImageBody::Planes { codec: PlanesBy::Exr, .. } => "exr",
        ImageBody::Planes { codec: PlanesBy::J2k, .. } => "j2k",
    }
}

/// Samples as points. Where samples are glued and a lossy codec made them differ, all take their mean.
fn from_planes(planes: &Planes, gluing: Gluing, lattice: &Lattice) -> Result<GeometryImage> {
    let shape = planes.shape();
    let point = |at: usize| lattice.point([0, 1, 2].map(|i| i64::from(planes[i].samples()[at])));
    GeometryImage::averaging(shape.width(), shape.height(), gluing, (0..shape.pixels()).map(point).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Plane;

    #[test]
    fn copies_that_a_lossy_codec_made_differ_take_their_mean() {
        let shape = Shape::new(5, 5).unwrap();
        let plane = |k: i32| Plane::new(shape, 8, (0..25).map(|p| (p * k) % 200).collect()).unwrap();
        let planes = Planes::new(vec![plane(3), plane(7), plane(1)]).unwrap();
        let lattice = Lattice { origin: [10.0; 3], step: 2.0 };
        let image = from_planes(&planes, Gluing::Orbifold, &lattice).unwrap();
        // The corners are samples 0, 4, 20 and 24; samples 5 and 15 of the first column are glued.
        assert_eq!(image.point(0, 0)[2], 10.0 + 2.0 * 12.0);
        assert_eq!(image.point(1, 0)[2], 10.0 + 2.0 * 10.0);
        assert_eq!(image.point(3, 0), image.point(1, 0));
        assert_eq!(image.point(1, 1)[2], 10.0 + 2.0 * 6.0);
    }
}
