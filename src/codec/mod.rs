//! Planes to bytes and back: one codec a way, known by four characters.

#[cfg(feature = "exr")]
mod exr;
pub(crate) mod j2k;
pub(crate) mod mask;
pub(crate) mod mbcim;
mod raw;
pub(crate) mod wavelet;

#[cfg(feature = "exr")]
pub(crate) use exr::{Exr, read_points, write_points};
pub(crate) use raw::Raw;

use crate::error::Result;
use crate::limits::Budget;
use crate::plane::{Planes, Shape};
use crate::task::Task;

/// Which codec made some bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct CodecId(pub(crate) [u8; 4]);

impl std::fmt::Display for CodecId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.0.escape_ascii())
    }
}

/// A way to turn planes into bytes.
pub(crate) trait PlaneCodec: std::fmt::Debug + Sync {
    /// Its name in a file.
    fn id(&self) -> CodecId;

    /// The planes as bytes.
    fn encode(&self, planes: &Planes, task: &Task) -> Result<Vec<u8>>;

    /// The planes of some bytes, which must have the shape and the depths that the container states.
    fn decode(&self, bytes: &[u8], shape: Shape, depths: &[u8], budget: &mut Budget) -> Result<Planes>;
}
