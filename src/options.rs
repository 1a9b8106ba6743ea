//! What a caller may choose.

mod attributes;
mod gim;
mod roi;

pub use attributes::{AttributeChoices, Precision};
pub use gim::{Adjust, Border, GimChoices, Grid, Param, Sampling};
pub use roi::{Closer, Roi, RoiPlace};

use crate::error::{Error, Result};
use crate::plane::Lattice;
use crate::surface::Effort;

/// How a mesh is encoded.
///
/// ```
/// # let mesh = gimc::Mesh::from_triangles(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2]]);
/// let bytes = gimc::EncodeOptions::cgim().bits(12).encode(&mesh)?;
/// # Ok::<(), gimc::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct EncodeOptions {
    /// How the mesh is kept. Default: [`Method::Cgim`].
    pub method: Method,
    /// How exact positions are kept. Default: 12 bits; a psnr of 70 dB for geometry images.
    pub accuracy: Accuracy,
    /// What the error is measured on. Default: [`Metric::Vertex`].
    pub metric: Metric,
    /// Time for size. Default: [`Effort::Default`].
    pub effort: Effort,
    /// How the mesh becomes bytes. Default: [`Codec::Surface`]; [`Codec::Wavelet`] for geometry images.
    pub codec: Codec,
    /// Geometry images: how they are made.
    pub gim: GimChoices,
    /// Images of vertices: how small, and in which stages.
    pub image: ImageChoices,
    /// Whether vertices, faces and the corners of each face come back in the order they had. Default: no.
    pub keep_order: bool,
    /// JPEG 2000: how much of the planes is kept.
    pub j2k: J2kChoices,
    /// Which attributes are kept, and how exact. Default: all.
    pub attributes: AttributeChoices,
    /// What matters most of the surface. Default: nothing more than the rest.
    pub roi: Option<Roi>,
}

/// How a mesh is kept.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// With its connectivity, exactly.
    #[default]
    Cgim,
    /// As a geometry image: the surface is sampled anew.
    Gim,
}

/// What the error of a mesh with its own connectivity is measured on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Metric {
    /// The vertices: each stays within the bound.
    #[default]
    Vertex,
    /// The surfaces: vertices may slide along the surface as long as no point of either is farther than the bound from the
    /// other. About two thirds of the bytes at the same psnr.
    Surface,
}

/// How a mesh becomes bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Codec {
    /// By a walk over the surface: the smallest files.
    #[default]
    Surface,
    /// As index map and base colours of an image of vertices.
    Mbcim,
    /// As an image of vertices, sample by sample.
    Raw,
    /// The same as an OpenEXR picture.
    #[cfg(feature = "exr")]
    Exr,
    /// The same as a JPEG 2000 picture, without loss or with.
    J2k,
    /// Geometry images: as wavelet coefficients in local frames, the smallest files.
    Wavelet,
}

impl Codec {
    pub(crate) fn not_for_meshes(self) -> Error {
        Error::Parameter(format!("the codec {self:?} is for geometry images (method gim)"))
    }
}

/// What may be chosen for the codec [`Codec::J2k`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct J2kChoices {
    /// How much is kept. Default: everything.
    pub quality: Quality,
    /// Quality layers, 1 (the default) to 32; every one but the last has half the bytes of the next.
    pub layers: u8,
    /// How a reader knows which pixels are one vertex.
    pub boundaries: Boundaries,
}

impl Default for J2kChoices {
    fn default() -> Self {
        Self { quality: Quality::Lossless, layers: 1, boundaries: Boundaries::Exact }
    }
}

/// How much of the planes is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Quality {
    /// Everything.
    Lossless,
    /// At most so many bits for each pixel, all planes together.
    BitsPerPixel(f64),
    /// So much that the decoded mesh has at least this psnr, in dB.
    Psnr(f64),
}

/// How a reader of lossy planes knows which pixels are one vertex.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Boundaries {
    /// From an index map in the file: the connectivity is exact at any rate.
    #[default]
    Exact,
    /// From the run counts of rows and columns, by the paper's cluster phase. The file says whether that gives the exact
    /// connectivity.
    Implied,
}

/// What may be chosen for images of vertices (V-matrices).
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ImageChoices {
    /// Trials for an image of few pixels; 1 (the default) takes the first.
    pub search: usize,
    /// Where the search starts.
    pub seed: u64,
    /// Algorithm 2's α, 0 for none; `None` (the default) is 5 for the first trial, and searched for by the others.
    pub alpha: Option<u8>,
    /// The share of the vertices that may be taken in which each level takes in, from 0 to 1; `None` (the default) is 1
    /// for the first trial, and searched for by the others.
    pub keep: Option<f64>,
    /// Whether the matrix is made as the paper makes it (Algorithms 1 and 2), and stored as it is. Default: no.
    pub paper: bool,
    /// Bits of each of the two planes of normals, 2 to 16; `None` (the default) for no normals.
    pub normals: Option<u8>,
    /// Codecs surface and mbcim: bits that each stage after the first adds to every coordinate; empty (the default) for
    /// one stage.
    pub stages: Vec<u8>,
}

impl Default for ImageChoices {
    fn default() -> Self {
        Self { search: 1, seed: 1, alpha: None, keep: None, paper: false, normals: None, stages: Vec::new() }
    }
}

/// How exact positions are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Accuracy {
    /// 2^bits lattice points on the longest side of the box; 1 to 24 bits.
    Bits(u32),
    /// Lattice points at this distance, in the units of the mesh.
    Step(f64),
    /// No point of either surface farther than this from the other, in the units of the mesh.
    Error(f64),
    /// The same, as a share of the diagonal of the box.
    RelativeError(f64),
    /// A lattice given by the caller: files that share one agree where they meet.
    Lattice(Lattice),
    /// Geometry images, and the metric [`Metric::Surface`]: at least this psnr, in dB, with as few bytes as a search finds.
    Psnr(f64),
    /// Likewise: at most so many bytes, with the best psnr that a search finds.
    Size(u64),
    /// Every coordinate bit by bit, in the number type that the mesh has.
    Exact,
}

impl EncodeOptions {
    /// Keeps the connectivity exactly (method `cgim`), with 12 bits a coordinate.
    pub fn cgim() -> Self {
        Self {
            method: Method::Cgim,
            accuracy: Accuracy::Bits(12),
            metric: Metric::default(),
            effort: Effort::default(),
            codec: Codec::default(),
            gim: GimChoices::default(),
            image: ImageChoices::default(),
            keep_order: false,
            j2k: J2kChoices::default(),
            attributes: AttributeChoices::default(),
            roi: None,
        }
    }

    /// Samples the surface as a geometry image (method `gim`), with a psnr of 70 dB.
    pub fn gim() -> Self {
        Self { method: Method::Gim, accuracy: Accuracy::Psnr(70.0), codec: Codec::Wavelet, ..Self::cgim() }
    }

    /// The same with at least this psnr, in dB.
    pub fn psnr(self, psnr: f64) -> Self {
        self.accuracy(Accuracy::Psnr(psnr))
    }

    /// The same with at most so many bytes.
    pub fn size(self, bytes: u64) -> Self {
        self.accuracy(Accuracy::Size(bytes))
    }

    /// The same with other choices for geometry images.
    pub fn gim_choices(mut self, choices: GimChoices) -> Self {
        self.gim = choices;
        self
    }

    /// The same with a region of interest.
    pub fn roi(mut self, roi: Roi) -> Self {
        self.roi = Some(roi);
        self
    }

    /// The same with 2^`bits` lattice points on the longest side of the box.
    pub fn bits(self, bits: u32) -> Self {
        self.accuracy(Accuracy::Bits(bits))
    }

    /// The same with lattice points at distance `step`, in the units of the mesh.
    pub fn step(self, step: f64) -> Self {
        self.accuracy(Accuracy::Step(step))
    }

    /// The same with a bound on the Hausdorff distance, in the units of the mesh.
    pub fn error(self, bound: f64) -> Self {
        self.accuracy(Accuracy::Error(bound))
    }

    /// The same with a bound on the Hausdorff distance, as a share of the diagonal of the box.
    pub fn error_relative(self, bound: f64) -> Self {
        self.accuracy(Accuracy::RelativeError(bound))
    }

    /// The same on a given lattice.
    pub fn lattice(self, origin: [f64; 3], step: f64) -> Self {
        self.accuracy(Accuracy::Lattice(Lattice { origin, step }))
    }

    /// The same with every coordinate bit by bit.
    pub fn exact(self) -> Self {
        self.accuracy(Accuracy::Exact)
    }

    /// The same with another accuracy.
    pub fn accuracy(mut self, accuracy: Accuracy) -> Self {
        self.accuracy = accuracy;
        self
    }

    /// The same with the error measured on something else.
    pub fn metric(mut self, metric: Metric) -> Self {
        self.metric = metric;
        self
    }

    /// The same with more or less time for size.
    pub fn effort(mut self, effort: Effort) -> Self {
        self.effort = effort;
        self
    }

    /// The same with another codec.
    pub fn codec(mut self, codec: Codec) -> Self {
        self.codec = codec;
        self
    }

    /// The same with another choice for images of vertices.
    pub fn image(mut self, image: ImageChoices) -> Self {
        self.image = image;
        self
    }

    /// The same with or without the order of vertices, faces and first corners; the part `order` of the file is what it costs.
    pub fn keep_order(mut self, keep: bool) -> Self {
        self.keep_order = keep;
        self
    }

    /// The same with another choice for JPEG 2000.
    pub fn j2k(mut self, j2k: J2kChoices) -> Self {
        self.j2k = j2k;
        self
    }

    /// The same with another choice of attributes.
    pub fn attributes(mut self, attributes: AttributeChoices) -> Self {
        self.attributes = attributes;
        self
    }

    /// Refuses values that mean nothing.
    pub(crate) fn check(&self) -> Result<()> {
        let positive = |what: &str, x: f64| {
            if x > 0.0 && x.is_finite() {
                Ok(())
            } else {
                Err(Error::Parameter(format!("{what} must be a positive number, found {x}")))
            }
        };
        self.image.check()?;
        self.j2k.check()?;
        self.check_codec()?;
        self.check_method()?;
        self.check_metric()?;
        self.check_roi()?;
        self.attributes.check()?;
        match self.accuracy {
            Accuracy::Bits(bits) if !(1..=crate::format::MAX_BITS).contains(&bits) => {
                Err(Error::Parameter(format!("bits must be 1 to {}, found {bits}", crate::format::MAX_BITS)))
            }
            Accuracy::Bits(_) | Accuracy::Exact => Ok(()),
            Accuracy::Psnr(psnr) if !(psnr > 0.0 && psnr < 300.0) => {
                Err(Error::Parameter(format!("the psnr must be between 0 and 300 dB, found {psnr}")))
            }
            Accuracy::Size(0) => Err(Error::Parameter("a file has more than 0 bytes".into())),
            Accuracy::Psnr(_) | Accuracy::Size(_) => Ok(()),
            Accuracy::Step(step) => positive("the step", step),
            Accuracy::Error(bound) | Accuracy::RelativeError(bound) => positive("the error", bound),
            Accuracy::Lattice(lattice) => {
                positive("the step of the lattice", lattice.step)?;
                match lattice.origin.iter().find(|x| !x.is_finite()) {
                    Some(x) => Err(Error::Parameter(format!("the origin of the lattice must be finite, found {x}"))),
                    None => Ok(()),
                }
            }
        }
    }
}

impl EncodeOptions {
    /// Refuses choices that the codec has no use for.
    fn check_codec(&self) -> Result<()> {
        let refuse = |why: &str| Err(Error::Parameter(why.into()));
        let is_surface = self.codec == Codec::Surface;
        if !self.image.stages.is_empty() && !is_surface && self.codec != Codec::Mbcim {
            return refuse("stages are for the codecs surface and mbcim");
        }
        if !self.image.stages.is_empty() && is_surface && self.effort == Effort::Fast {
            return refuse("stages of the codec surface need the effort default or best");
        }
        if self.image.paper && is_surface {
            return refuse("an image made as the paper makes it needs a codec that stores it: mbcim, raw, exr or j2k");
        }
        if self.image.paper && self.j2k.boundaries == Boundaries::Implied {
            return refuse(
                "the cluster phase needs an image whose vertices hang together, and one made as the paper makes it may have others",
            );
        }
        if self.image.normals.is_some() && (is_surface || self.codec == Codec::Mbcim) {
            return refuse("planes of normals are for the codecs raw, exr and j2k");
        }
        if self.j2k != J2kChoices::default() && self.codec != Codec::J2k {
            return refuse("rates, layers and boundaries are for the codec j2k");
        }
        Ok(())
    }
}

impl EncodeOptions {
    /// Refuses what vertices that slide cannot have.
    fn check_metric(&self) -> Result<()> {
        let refuse = |why: &str| Err(Error::Parameter(why.into()));
        if self.metric == Metric::Vertex {
            return Ok(());
        }
        if self.method != Method::Cgim || self.codec != Codec::Surface {
            return refuse("the metric surface is for the method cgim with the codec surface");
        }
        if self.effort == Effort::Fast {
            return refuse("the metric surface needs the effort default or best");
        }
        if !self.image.stages.is_empty() {
            return refuse("stages are for the metric vertex");
        }
        if self.roi.is_some() {
            return refuse("regions of interest are for the metric vertex");
        }
        match self.accuracy {
            Accuracy::Exact => refuse("coordinates bit by bit are for the metric vertex"),
            Accuracy::Lattice(_) => refuse("a lattice of your own is for the metric vertex: vertices that slide leave it"),
            _ => Ok(()),
        }
    }
}

impl J2kChoices {
    fn check(&self) -> Result<()> {
        if !(1..=32).contains(&self.layers) {
            return Err(Error::Parameter(format!("layers must be 1 to 32, found {}", self.layers)));
        }
        match self.quality {
            Quality::BitsPerPixel(x) | Quality::Psnr(x) if !(x > 0.0 && x.is_finite()) => {
                Err(Error::Parameter(format!("a rate or psnr must be a positive number, found {x}")))
            }
            _ => Ok(()),
        }
    }
}

impl ImageChoices {
    fn check(&self) -> Result<()> {
        let bits: u32 = self.stages.iter().map(|&b| u32::from(b)).sum();
        if self.stages.contains(&0) || bits > crate::format::MAX_BITS {
            return Err(Error::Parameter(format!(
                "stages of {:?} bits; each has at least 1, all together at most {}",
                self.stages,
                crate::format::MAX_BITS
            )));
        }
        if let Some(bits) = self.normals.filter(|bits| !(2..=16).contains(bits)) {
            return Err(Error::Parameter(format!("normals of 2 to 16 bits, found {bits}")));
        }
        if let Some(keep) = self.keep.filter(|&k| !(k > 0.0 && k <= 1.0)) {
            return Err(Error::Parameter(format!("the share to keep must be above 0 and at most 1, found {keep}")));
        }
        match self.alpha {
            Some(alpha) if alpha > crate::cgim::Recipe::MAX_ALPHA => {
                Err(Error::Parameter(format!("alpha must be 0 to {}, found {alpha}", crate::cgim::Recipe::MAX_ALPHA)))
            }
            _ => Ok(()),
        }
    }
}
