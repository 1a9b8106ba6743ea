//! Decisions to bytes: a binary arithmetic coder, adaptive models of its bits, and a mixer of many models.
//!
//! Writing and reading are the same code: everything above [`BitCoder`] is generic over the side,
//! hands the coder a decision that only a writer looks at, and goes on with the one that comes back.
//! So the two sides cannot drift apart. All arithmetic here is on integers.

mod logistic;
mod mix;
mod model;
mod range;
mod residual;

pub(crate) use mix::{Mixer, MixerOptions, Start, hash};
pub(crate) use model::{AdaptiveBit, Numbers};
pub(crate) use range::{BitCoder, BitReader, BitWriter};
pub(crate) use residual::Residuals;
