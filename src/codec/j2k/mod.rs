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
#[cfg(all(feature = "encode", any(test, feature = "inner")))]
#[cfg_attr(not(feature = "inner"), allow(unreachable_pub))]
pub mod trial;
#[cfg(feature = "encode")]
mod weigh;

pub(crate) use codestream::{Profile, Transform};
pub(crate) use decode::{decode, profile};
#[cfg(feature = "encode")]
pub(crate) use encode::{Encoded, Quality, Settings, encode};
pub(crate) use jp2::wrap;
#[cfg(all(feature = "encode", any(test, feature = "inner")))]
pub(crate) use target::psnr;

use super::PlaneCodec;
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::plane::{Planes, Shape};
use crate::task::Task;

/// The deepest samples: what the decoder's `f32` holds exactly after the transform.
pub(crate) const MAX_DEPTH: u8 = 16;
/// The most decompositions.
pub(crate) const MAX_LEVELS: u8 = 6;
/// The most quality layers.
pub(crate) const MAX_LAYERS: u8 = 32;

/// JPEG 2000 as a codec of planes: a codestream after three bytes in which the container states what is not told by the
/// planes' shape and depths.
#[derive(Clone, Debug, Default)]
pub(crate) struct J2k<'a> {
    /// How planes are encoded; a decoder has no use for it.
    #[cfg(feature = "encode")]
    pub(crate) settings: Settings<'a>,
    #[cfg(not(feature = "encode"))]
    settings: std::marker::PhantomData<&'a ()>,
}

/// Transform, decompositions, layers.
const STATED: usize = 3;

/// The codestream of a payload, as a `.j2k` file has it.
pub(crate) fn codestream(payload: &[u8]) -> Result<&[u8]> {
    let end = || Error::malformed(Place::Whole, format!("{} bytes of JPEG 2000, expected at least {STATED}", payload.len()));
    payload.get(STATED..).ok_or_else(end)
}

impl PlaneCodec for J2k<'_> {
    #[cfg(feature = "encode")]
    fn encode(&self, planes: &Planes, task: &Task) -> Result<Vec<u8>> {
        let Encoded { mut bytes, profile, .. } = encode(planes, &self.settings, task)?;
        bytes.splice(0..0, [profile.transform.code(), profile.levels, profile.layers]);
        Ok(bytes)
    }

    #[cfg(not(feature = "encode"))]
    fn encode(&self, _: &Planes, _: &Task) -> Result<Vec<u8>> {
        Err(Error::Unsupported { what: "writing codec", id: "j2k".into() })
    }

    fn decode(&self, payload: &[u8], shape: Shape, depths: &[u8], budget: &mut Budget) -> Result<Planes> {
        let codestream = codestream(payload)?;
        let transform = Transform::from_code(payload[0])
            .ok_or_else(|| Error::malformed(Place::Whole, format!("wavelet transform {}, expected 0 or 1", payload[0])))?;
        let (levels, layers) = (payload[1], payload[2]);
        decode(codestream, &Profile { shape, depths: depths.to_vec(), transform, levels, layers }, budget)
    }
}
