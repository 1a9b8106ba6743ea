//! The container: a signature, then chunks (spec/format.md).
//!
//! Every file holds first a header ([`Header`]), then what its codec needs. What a reader does not
//! know it skips if the chunk's tag begins with a lower-case letter, and refuses otherwise.

mod chunk;
mod header;
mod mbcim;
mod planes;
mod recipe;
mod side;
mod surface;

#[cfg(feature = "encode")]
pub(crate) use chunk::ChunkWriter;
pub(crate) use chunk::{Chunks, VERSION};
pub(crate) use header::{Header, LatticeForm, MAX_BITS, MAX_EXTENT};
pub(crate) use mbcim::MbcimChunk;
pub(crate) use planes::PlanesChunk;
pub(crate) use recipe::RecipeChunk;
pub(crate) use surface::SurfaceChunk;
