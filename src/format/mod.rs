//! The container: a signature, then chunks (spec/format.md).
//!
//! Every file holds first a header ([`Header`]), then what its codec needs. What a reader does not
//! know it skips if the chunk's tag begins with a lower-case letter, and refuses otherwise.

mod attributes;
mod chunk;
mod counts;
mod fixes;
mod geometry_image;
mod header;
mod labels;
mod mbcim;
mod planes;
mod recipe;
mod seams;
mod side;
mod stage;
mod surface;

pub(crate) use attributes::{AttributeRecord, NumberForm};
#[cfg(feature = "encode")]
pub(crate) use chunk::ChunkWriter;
pub(crate) use chunk::{Chunk, Chunks, VERSION};
pub(crate) use fixes::FixesChunk;
#[cfg(feature = "encode")]
pub(crate) use geometry_image::{CoarseBox, short};
pub(crate) use geometry_image::{HolesField, ImageBody, ImageChunk, PlanesBy, RegionField};
pub(crate) use header::{Extras, Header, LatticeForm, MAX_BITS, MAX_EXTENT};
pub(crate) use labels::LabelsChunk;
pub(crate) use mbcim::MbcimChunk;
pub(crate) use planes::{Borders, PlanesChunk};
pub(crate) use recipe::RecipeChunk;
pub(crate) use stage::STAGE;
#[cfg(feature = "encode")]
pub(crate) use surface::write_stage;
pub(crate) use surface::{SlideField, SurfaceChunk, read_stage};

/// The order that a mesh had (spec/any-mesh.md, "ORDR"); the payload is one stream.
pub(crate) const ORDER_TAG: [u8; 4] = *b"ORDR";

/// Coordinates bit by bit (spec/any-mesh.md, "EXAC"); the payload is one stream.
pub(crate) const EXACT_TAG: [u8; 4] = *b"EXAC";
