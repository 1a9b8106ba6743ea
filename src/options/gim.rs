//! What a caller may choose for geometry images.

use super::{Accuracy, Codec, EncodeOptions, ImageChoices, J2kChoices, Method, Metric};
use crate::error::{Error, Result};
pub use crate::gim::{Border, Param, Sampling};

/// What may be chosen for geometry images.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct GimChoices {
    /// Samples a side. Default: as many as the target needs.
    pub grid: Grid,
    /// How the surface is flattened. Default: [`Param::Stretch`].
    pub param: Param,
    /// What becomes the border of the square. Default: [`Border::Auto`].
    pub border: Border,
    /// Where samples are taken. Default: at equal distances.
    pub sampling: Sampling,
    /// Where samples are moved. Default: [`Adjust::Rate`].
    pub adjust: Adjust,
    /// How the image came about, to be told by the file. Default: nothing.
    pub history: Option<String>,
}

/// Samples a side of a geometry image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Grid {
    /// As many as the target needs: 2^k + 1 or 3 · 2^k + 1.
    #[default]
    Auto,
    /// So many; odd for closed surfaces, and best of the form 2^k + 1 or 3 · 2^k + 1.
    Side(u32),
    /// So many columns and rows; for surfaces of one component without handles.
    Size(u32, u32),
}

/// Where the samples of a geometry image are moved.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Adjust {
    /// Nowhere: they lie on the surface.
    None,
    /// Along their normals, so that the mean distance falls.
    Fit,
    /// The same, and along the surface to where they cost fewer bytes.
    #[default]
    Rate,
    /// Against the gradient of the Hausdorff distance (paper 000, Algorithms 1 to 3).
    Hausdorff,
}

impl GimChoices {
    /// The smallest files; the default.
    pub fn compact() -> Self {
        Self::default()
    }

    /// Good ones in a third of the time.
    pub fn quality() -> Self {
        Self { param: Param::Yoshizawa, adjust: Adjust::Fit, ..Self::default() }
    }

    /// The choices of paper 000: Yoshizawa's parametrisation, the boundary on the square, samples adjusted for the Hausdorff distance.
    pub fn paper() -> Self {
        Self { param: Param::Yoshizawa, border: Border::Square, adjust: Adjust::Hausdorff, ..Self::default() }
    }
}

impl EncodeOptions {
    /// Refuses what is for the other method.
    pub(super) fn check_method(&self) -> Result<()> {
        let refuse = |why: &str| Err(Error::Parameter(why.into()));
        match self.method {
            Method::Cgim if self.codec == Codec::Wavelet => Err(self.codec.not_for_meshes()),
            Method::Cgim if self.metric == Metric::Vertex && matches!(self.accuracy, Accuracy::Psnr(_) | Accuracy::Size(_)) => {
                refuse(
                    "this target is for the metric surface or the method gim; the metric vertex takes bits, a step or an error",
                )
            }
            Method::Cgim if self.gim != GimChoices::default() => refuse("these choices are for geometry images (method gim)"),
            Method::Gim if matches!(self.codec, Codec::Surface | Codec::Mbcim) => refuse(
                "the codecs surface and mbcim keep connectivity (method cgim); geometry images take wavelet, j2k, raw or exr",
            ),
            Method::Gim if self.image != ImageChoices::default() => {
                refuse("search, alignment, normals and stages are for images of vertices (method cgim)")
            }
            Method::Gim if self.accuracy == Accuracy::Exact => refuse("coordinates bit by bit are for the method cgim"),
            Method::Gim if self.j2k != J2kChoices::default() => {
                refuse("a geometry image is coded for a psnr, an error, a size or a step, not for a rate of JPEG 2000")
            }
            Method::Gim if self.keep_order => refuse("a geometry image has no order of the original to keep"),
            _ => Ok(()),
        }
    }
}
