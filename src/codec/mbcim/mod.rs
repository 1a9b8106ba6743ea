//! The codec `mbcim`: an image of few colours as an index map, base colours, and stages that refine them.
//!
//! Our reading of the paper's MBCIM (spec/mbcim.md, spec/readings.md): one map for the whole image, coded
//! without loss, so that it holds the connectivity exactly; the colours follow, one a vertex.

pub(crate) mod base_colour;
pub(crate) mod index_map;
pub(crate) mod ladder;
mod meeting;
pub(crate) mod stage;

pub(crate) use meeting::Meetings;
