//! A geometry image to a file, at a given step.

use super::{from_planes, mesh, plane_codec, surface};
use crate::codec::PlaneCodec;
use crate::codec::j2k::{self, J2k, Quality, Transform};
use crate::codec::mask;
use crate::codec::wavelet::{self, Layout, Zones};
use crate::error::{Error, Result};
use crate::format::{ChunkWriter, CoarseBox, HolesField, ImageBody, ImageChunk, PlanesBy, RegionField, short};
use crate::judge::Measured;
use crate::limits::{Budget, Limits};
use crate::mesh::{Mesh, Scalar};
use crate::options::Codec;
use crate::plane::{GeometryImage, Gluing, Lattice, MAX_DEPTH, Mask, Plane, Planes, RegionCells, bounding_box};
use crate::task::Task;

/// Images that were coded, and what a decoder will make of them.
pub(crate) struct Coded {
    images: Vec<CodedImage>,
    precision: Scalar,
}

struct CodedImage {
    body: ImageBody,
    region: Option<CodedRegion>,
    bytes: Vec<u8>,
    decoded: GeometryImage,
    holes: Option<Holes>,
}

struct CodedRegion {
    coarser: u8,
    bytes: Vec<u8>,
}

struct Holes {
    vertices: u32,
    squares: u32,
    bytes: Vec<u8>,
}

/// How images are coded beside their step.
#[derive(Clone, Copy)]
pub(crate) struct How<'a> {
    pub(crate) codec: Codec,
    pub(crate) precision: Scalar,
    /// What matters most of each image.
    pub(crate) regions: Option<Regions<'a>>,
}

/// The regions of interest of some images.
#[derive(Clone, Copy)]
pub(crate) struct Regions<'a> {
    pub(crate) cells: &'a [RegionCells],
    /// Away from them steps are 2 to this times as large.
    pub(crate) coarser: u8,
}

impl Regions<'_> {
    /// The zones of an image.
    pub(super) fn zones(&self, image: usize, gluing: Gluing) -> Option<Zones> {
        Some(Zones::new(self.cells.get(image)?, gluing, self.coarser))
    }
}

impl How<'_> {
    /// Codes images so that their samples are wrong by about `step` / √12; away from regions of interest by more.
    pub(crate) fn code(&self, images: &[GeometryImage], step: f64, task: Task<'_>) -> Result<Coded> {
        let code = |(i, image): (usize, &GeometryImage)| {
            let region = self.regions.and_then(|regions| Some((i, regions.cells.get(i)?)));
            self.code_one(image, step, region, task)
        };
        Ok(Coded { images: images.iter().enumerate().map(code).collect::<Result<_>>()?, precision: self.precision })
    }

    fn code_one(
        &self,
        image: &GeometryImage,
        step: f64,
        region: Option<(usize, &RegionCells)>,
        task: Task<'_>,
    ) -> Result<CodedImage> {
        let cells = region.map(|(_, cells)| cells);
        let zones = region.and_then(|(i, _)| self.regions?.zones(i, image.gluing()));
        let coarser = match self.codec {
            Codec::Wavelet => self.regions.map_or(0, |regions| regions.coarser),
            _ => 0,
        };
        let region = cells.map(|cells| CodedRegion { coarser, bytes: mask::write(cells.cells()) });
        let (body, bytes, decoded) = match self.codec {
            Codec::Wavelet => wavelet(image, step, zones, task)?,
            Codec::Raw => planes(image, step, PlanesBy::Raw, None, task)?,
            #[cfg(feature = "exr")]
            Codec::Exr => planes(image, step, PlanesBy::Exr, None, task)?,
            Codec::J2k => planes(image, step, PlanesBy::J2k, cells, task)?,
            other => {
                return Err(Error::Parameter(format!(
                    "the codec {other:?} is for exact connectivity; a geometry image takes wavelet, j2k, raw or exr"
                )));
            }
        };
        let decoded = match image.seams() {
            Some(seams) => decoded.averaging_seams(seams.clone())?,
            None => decoded,
        };
        let Some(holes) = image.holes() else { return Ok(CodedImage { body, region, bytes, decoded, holes: None }) };
        let decoded = decoded.with_holes(holes.clone())?;
        let squares = holes.shape().pixels() - holes.count();
        let holes = Holes { vertices: surface(&decoded).0.len() as u32, squares: squares as u32, bytes: mask::write(holes) };
        Ok(CodedImage { body, region, bytes, decoded, holes: Some(holes) })
    }
}

impl Coded {
    /// The mesh that a decoder will make.
    pub(crate) fn mesh(&self) -> Result<Mesh> {
        let decoded: Vec<&GeometryImage> = self.images.iter().map(|image| &image.decoded).collect();
        mesh(&decoded, self.precision)
    }

    /// The whole file, with what was measured of it: the first image says it of all of them.
    pub(crate) fn file(&self, measured: Option<&Measured>, bound: Option<f64>, history: Option<&str>) -> Vec<u8> {
        let hundredths = |psnr: f64| (psnr * 100.0).floor().clamp(0.0, 65535.0) as u16;
        let psnr = measured.map(|m| hundredths(m.psnr));
        let of_region = measured.and_then(|m| m.region).map_or(0, hundredths);
        let bound = bound.map(|b| short(b, true)).filter(|b| b.is_finite());
        let mut writer = ChunkWriter::new();
        for (i, CodedImage { body, region, bytes, decoded, holes }) in self.images.iter().enumerate() {
            let chunk = ImageChunk {
                gluing: decoded.gluing(),
                double: self.precision == Scalar::F64,
                columns: decoded.width() as u32,
                rows: decoded.height() as u32,
                seams: decoded.seams().cloned(),
                holes: holes.as_ref().map(|h| HolesField { vertices: h.vertices, squares: h.squares, bytes: &h.bytes }),
                region: region.as_ref().map(|region| RegionField {
                    coarser: region.coarser,
                    psnr: if i == 0 { of_region } else { 0 },
                    bytes: &region.bytes,
                }),
                body: *body,
                psnr: psnr.filter(|_| i == 0),
                bound: bound.filter(|_| i == 0),
                bytes,
            };
            writer.chunk(ImageChunk::TAG, &chunk.write());
        }
        if let Some(history) = history {
            writer.chunk(ImageChunk::HISTORY, history.as_bytes());
        }
        writer.into_bytes()
    }

    /// The bytes of the whole file with all that may be measured.
    pub(crate) fn size(&self, history: Option<&str>) -> u64 {
        let measured = Measured { psnr: 0.0, region: None, hausdorff: 1.0 };
        self.file(Some(&measured), Some(1.0), history).len() as u64
    }
}

type Parts = (ImageBody, Vec<u8>, GeometryImage);

fn wavelet(image: &GeometryImage, step: f64, zones: Option<Zones>, task: Task<'_>) -> Result<Parts> {
    // The step is written with 16 bits, and never larger than asked for.
    let step = short(step, false);
    let layout = Layout { zones, ..Layout::new(image.shape(), image.gluing(), step.into()) };
    if !(step > 0.0 && step.is_finite()) {
        return Err(Error::Parameter(format!("a step of {step} is not one that a file can hold")));
    }
    let (levels, finest) = (layout.levels, layout.step);
    let (quantised, decoded) = wavelet::quantise(image, layout, &task)?;
    let bounds = CoarseBox::around(box_of(&decoded), finest);
    let bytes = wavelet::write(&quantised, bounds.bounds())?;
    Ok((ImageBody::Wavelet { levels, step, bounds }, bytes, decoded))
}

fn box_of(image: &GeometryImage) -> [[f64; 3]; 2] {
    bounding_box(image.points().iter().copied()).unwrap_or([[0.0; 3]; 2])
}

/// JPEG 2000 keeps this many bits of its samples, whatever its error.
const J2K_DEPTH: u8 = 16;

fn planes(image: &GeometryImage, step: f64, by: PlanesBy, region: Option<&RegionCells>, task: Task<'_>) -> Result<Parts> {
    let [low, high] = box_of(image);
    let longest = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
    let depth = match by {
        PlanesBy::J2k => J2K_DEPTH,
        _ => (1..=MAX_DEPTH).find(|&d| longest / step <= f64::from((1_u32 << d) - 1)).ok_or_else(|| {
            Error::Parameter(format!("a step of {step} needs samples of more than {MAX_DEPTH} bits: take a larger step"))
        })?,
    };
    let whole = f64::from((1_u32 << depth) - 1);
    let step_of_samples = if by != PlanesBy::J2k || longest == 0.0 { step } else { longest / whole };
    let lattice = Lattice { origin: low, step: step_of_samples };
    let shape = image.shape();
    let plane = |axis: usize| {
        let sample = |p: &[f64; 3]| lattice.index(p[axis], axis).clamp(0.0, whole) as i32;
        Plane::new(shape, depth, image.points().iter().map(sample).collect())
    };
    let planes = Planes::new(vec![plane(0)?, plane(1)?, plane(2)?])?;
    let bytes = if by == PlanesBy::J2k {
        jpeg_2000(&planes, step / step_of_samples, region, task)?
    } else {
        plane_codec(by)?.encode(&planes, &task)?
    };
    let mut unlimited = Budget::new(Limits::default().memory(u64::MAX).work(u64::MAX).vertices(u64::MAX).pixels(u64::MAX));
    let decoded = plane_codec(by)?.decode(&bytes, shape, &[depth; 3], &mut unlimited)?;
    let decoded = from_planes(&decoded, image.gluing(), &lattice)?;
    Ok((ImageBody::Planes { codec: by, depth, lattice }, bytes, decoded))
}

/// JPEG 2000 quantises a quarter as coarsely as its samples may be wrong on average, and keeps all of that in a region.
const J2K_COARSER: f64 = 4.0;

/// Planes whose samples may be wrong by about `step` / √12; away from a region, which comes first by maxshift, by four times as much.
fn jpeg_2000(planes: &Planes, step: f64, region: Option<&RegionCells>, task: Task<'_>) -> Result<Vec<u8>> {
    let peak = f64::from((1_u32 << J2K_DEPTH) - 1);
    let lossless = j2k::Settings::default();
    let region = region.map(|cells| Mask::from_fn(planes.shape(), |row, column| cells.has(row, column)));
    let region = region.as_ref().filter(|mask| mask.count() > 0);
    let step = if region.is_some() { J2K_COARSER * step } else { step };
    let settings = if step <= 1.0 {
        lossless
    } else {
        let psnr = 20.0 * (peak * 12_f64.sqrt() / step).log10();
        j2k::Settings { transform: Transform::Irreversible97, quality: Quality::Psnr(psnr), region, ..lossless }
    };
    J2k { settings }.encode(planes, &task)
}
