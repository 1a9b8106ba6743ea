//! Distances from one surface to another (`measures.md`: `d(A→B)`): sampled, and certified.
//!
//! A surface is a list of triangles with three finite corners each; who owns them is not asked.

mod certified;
mod directed;
mod sampled;

pub(crate) use certified::certify;
pub(crate) use directed::{Frame, Surface};
#[cfg(feature = "encode")]
pub(crate) use sampled::sample_spread;
pub(crate) use sampled::{SampleOptions, Sampled, sample};
