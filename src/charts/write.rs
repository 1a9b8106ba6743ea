//! A geometry image to a file, at a given step.

use super::{from_planes, mesh, plane_codec, surface};
use crate::codec::PlaneCodec;
use crate::codec::j2k::{self, J2k, Quality, Transform};
use crate::codec::mask;
use crate::codec::wavelet::{self, Layout};
use crate::error::{Error, Result};
use crate::format::{ChunkWriter, CoarseBox, HolesField, ImageBody, ImageChunk, PlanesBy, short};
use crate::limits::{Budget, Limits};
use crate::mesh::{Mesh, Scalar};
use crate::options::Codec;
use crate::plane::{GeometryImage, Lattice, MAX_DEPTH, Plane, Planes, bounding_box};
use crate::task::Task;

/// Images that were coded, and what a decoder will make of them.
pub(crate) struct Coded {
    images: Vec<CodedImage>,
    precision: Scalar,
}

struct CodedImage {
    body: ImageBody,
    bytes: Vec<u8>,
    decoded: GeometryImage,
    holes: Option<Holes>,
}

struct Holes {
    vertices: u32,
    squares: u32,
    bytes: Vec<u8>,
}

/// How an image is coded beside its step.
#[derive(Clone, Copy)]
pub(crate) struct How {
    pub(crate) codec: Codec,
    pub(crate) precision: Scalar,
}

impl How {
    /// Codes images so that their samples are wrong by about `step` / √12.
    pub(crate) fn code(&self, images: &[GeometryImage], step: f64, task: Task<'_>) -> Result<Coded> {
        let images = images.iter().map(|image| self.code_one(image, step, task)).collect::<Result<_>>()?;
        Ok(Coded { images, precision: self.precision })
    }

    fn code_one(&self, image: &GeometryImage, step: f64, task: Task<'_>) -> Result<CodedImage> {
        let (body, bytes, decoded) = match self.codec {
            Codec::Wavelet => wavelet(image, step, task)?,
            Codec::Raw => planes(image, step, PlanesBy::Raw, task)?,
            #[cfg(feature = "exr")]
            Codec::Exr => planes(image, step, PlanesBy::Exr, task)?,
            Codec::J2k => planes(image, step, PlanesBy::J2k, task)?,
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
        let Some(holes) = image.holes() else { return Ok(CodedImage { body, bytes, decoded, holes: None }) };
        let decoded = decoded.with_holes(holes.clone())?;
        let squares = holes.shape().pixels() - holes.count();
        let holes = Holes { vertices: surface(&decoded).0.len() as u32, squares: squares as u32, bytes: mask::write(holes) };
        Ok(CodedImage { body, bytes, decoded, holes: Some(holes) })
    }
}

impl Coded {
    /// The mesh that a decoder will make.
    pub(crate) fn mesh(&self) -> Result<Mesh> {
        let decoded: Vec<&GeometryImage> = self.images.iter().map(|image| &image.decoded).collect();
        mesh(&decoded, self.precision)
    }

    /// The whole file, with what was measured of it: the first image says it of all of them.
    pub(crate) fn file(&self, psnr: Option<f64>, bound: Option<f64>, history: Option<&str>) -> Vec<u8> {
        let psnr = psnr.map(|p| (p * 100.0).floor().clamp(0.0, 65535.0) as u16);
        let bound = bound.map(|b| short(b, true)).filter(|b| b.is_finite());
        let mut writer = ChunkWriter::new();
        for (i, CodedImage { body, bytes, decoded, holes }) in self.images.iter().enumerate() {
            let chunk = ImageChunk {
                gluing: decoded.gluing(),
                double: self.precision == Scalar::F64,
                columns: decoded.width() as u32,
                rows: decoded.height() as u32,
                seams: decoded.seams().cloned(),
                holes: holes.as_ref().map(|h| HolesField { vertices: h.vertices, squares: h.squares, bytes: &h.bytes }),
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
        self.file(Some(0.0), Some(1.0), history).len() as u64
    }
}

type Parts = (ImageBody, Vec<u8>, GeometryImage);

fn wavelet(image: &GeometryImage, step: f64, task: Task<'_>) -> Result<Parts> {
    // The step is written with 16 bits, and never larger than asked for.
    let step = short(step, false);
    let layout = Layout::new(image.shape(), image.gluing(), step.into());
    if !(step > 0.0 && step.is_finite()) {
        return Err(Error::Parameter(format!("a step of {step} is not one that a file can hold")));
    }
    let (quantised, decoded) = wavelet::quantise(image, layout, &task)?;
    let bounds = CoarseBox::around(box_of(&decoded), layout.step);
    let bytes = wavelet::write(&quantised, bounds.bounds())?;
    Ok((ImageBody::Wavelet { levels: layout.levels, step, bounds }, bytes, decoded))
}

fn box_of(image: &GeometryImage) -> [[f64; 3]; 2] {
    bounding_box(image.points().iter().copied()).unwrap_or([[0.0; 3]; 2])
}

/// JPEG 2000 keeps this many bits of its samples, whatever its error.
const J2K_DEPTH: u8 = 16;

fn planes(image: &GeometryImage, step: f64, by: PlanesBy, task: Task<'_>) -> Result<Parts> {
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
        jpeg_2000(&planes, step / step_of_samples, task)?
    } else {
        plane_codec(by)?.encode(&planes, &task)?
    };
    let mut unlimited = Budget::new(Limits::default().memory(u64::MAX).work(u64::MAX).vertices(u64::MAX).pixels(u64::MAX));
    let decoded = plane_codec(by)?.decode(&bytes, shape, &[depth; 3], &mut unlimited)?;
    let decoded = from_planes(&decoded, image.gluing(), &lattice)?;
    Ok((ImageBody::Planes { codec: by, depth, lattice }, bytes, decoded))
}

/// Planes whose samples may be wrong by about `step` / √12.
fn jpeg_2000(planes: &Planes, step: f64, task: Task<'_>) -> Result<Vec<u8>> {
    let peak = f64::from((1_u32 << J2K_DEPTH) - 1);
    let lossless = j2k::Settings::default();
    let settings = if step <= 1.0 {
        lossless
    } else {
        let psnr = 20.0 * (peak * 12_f64.sqrt() / step).log10();
        j2k::Settings { transform: Transform::Irreversible97, quality: Quality::Psnr(psnr), ..lossless }
    };
    J2k { settings }.encode(planes, &task)
}
