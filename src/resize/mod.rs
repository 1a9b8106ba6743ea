//! Smaller and larger geometry images that keep what matters (paper 004, and its baselines).
//!
//! [`ResizeOptions`] says how; [`ResizeOptions::resize`] does it. The paper's road, file by file: `saliency` (II-A) →
//! `warp` (equations (3) to (5), solved with `multigrid`) → `invert` → `bicubic`, step by step in `progressive`. Its
//! baselines: `downsample` (RDS), `seam` (SC), `direct` (VR).

mod bicubic;
mod direct;
mod downsample;
mod field;
mod invert;
mod multigrid;
mod options;
mod progressive;
mod saliency;
mod seam;
#[cfg(test)]
mod test_images;
mod warp;

pub(crate) use field::Field;
pub use options::{ResizeMethod, ResizeOptions, Resized};
pub(crate) use saliency::{Energy, saliency};
