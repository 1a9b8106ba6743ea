//! JPEG 2000 Part 1 (ISO/IEC 15444-1, ITU-T T.800): our own encoder, one file an annex, and a foreign decoder.
//!
//! ```text
//! planes ─ dwt (F) ─ quantise (E) ─ [maxshift (H)] ─ bitplane (D) ─ mq (C) ─ code-blocks
//!        code-blocks ─ rate (J.14) ─ packet, tag_tree (B) ─ codestream (A) ─ bytes ─ [jp2 (I)]
//! ```
//!
//! The profile: one tile, unsigned samples of 1 to 16 bits, no component transform (on geometry it costs bytes), 5/3 or 9/7,
//! code-blocks of 64 × 64, LRCP, quality layers, and a region of interest of any shape. Components are weighed against
//! each other by the rate–distortion optimisation instead.
//!
//! Code-blocks are coded in any order by any number of threads; each is a function of its coefficients alone, and
//! everything after it runs in a fixed order, so the bytes are always the same.

#[cfg(feature = "encode")]
mod bitplane;
mod codestream;
#[cfg(feature = "encode")]
mod component;
mod decode;
#[cfg(feature = "encode")]
mod dwt;
#[cfg(feature = "encode")]
mod encode;
mod jp2;
#[cfg(feature = "encode")]
mod maxshift;
#[cfg(feature = "encode")]
mod mq;
#[cfg(feature = "encode")]
mod packet;
mod partition;
mod quantise;
#[cfg(feature = "encode")]
mod rate;
#[cfg(feature = "encode")]
mod tag_tree;
#[cfg(feature = "encode")]
mod target;
#[cfg(all(test, feature = "encode"))]
mod tests;

pub(crate) use codestream::{Profile, Transform};
pub(crate) use decode::{decode, profile};
#[cfg(feature = "encode")]
pub(crate) use encode::{Encoded, Quality, Settings, encode};
pub(crate) use jp2::wrap;
#[cfg(feature = "encode")]
pub(crate) use target::psnr;

/// The deepest samples: what the decoder's `f32` holds exactly after the transform.
pub(crate) const MAX_DEPTH: u8 = 16;
/// The most decompositions.
pub(crate) const MAX_LEVELS: u8 = 6;
/// The most quality layers.
pub(crate) const MAX_LAYERS: u8 = 32;
