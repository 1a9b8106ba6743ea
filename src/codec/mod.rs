//! Planes to bytes and back: one codec a way.

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

/// A way to turn planes into bytes.
pub(crate) trait PlaneCodec: std::fmt::Debug + Sync {
    /// The planes as bytes.
    fn encode(&self, planes: &Planes, task: &Task) -> Result<Vec<u8>>;

    /// The planes of some bytes, which must have the shape and the depths that the container states.
    fn decode(&self, bytes: &[u8], shape: Shape, depths: &[u8], budget: &mut Budget) -> Result<Planes>;
}
