//! Lossy planes: as many bytes as a rate allows, or as a quality of the decoded mesh needs.
//!
//! Whatever decides which pixels are one vertex must come out the same in every decoder, so the cluster phase works on
//! the reversible transform, cut short; where an index map decides, the better irreversible one is taken.

use super::Decoded;
use super::planes::{BorderChoice, Draft, Written};
use crate::codec::PlaneCodec;
use crate::codec::j2k::{J2k, Quality, Settings, Transform};
use crate::error::{Error, Result};
use crate::plane::Mask;
use crate::task::Task;

/// What to reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Goal {
    Lossless,
    /// Bits for each pixel, all planes together.
    BitsPerPixel(f64),
    /// A psnr of the decoded mesh, in dB.
    Psnr(f64),
}

/// What to reach, how it is measured, and in how many layers.
pub(crate) struct Target<'a> {
    pub(crate) goal: Goal,
    pub(crate) layers: u8,
    /// Pixels that come first.
    pub(crate) region: Option<&'a Mask>,
    /// The psnr of a decoded mesh, in dB.
    pub(crate) psnr: &'a dyn Fn(&Decoded) -> Result<f64>,
}

/// How much an error of a normal counts against the same of a position.
const NORMALS: f64 = 0.1;
/// Files that are tried for a psnr.
const ATTEMPTS: usize = 14;
/// So much more than asked for, in dB, is near enough.
const NEAR: f64 = 0.1;

/// A file, and whether its planes came through the irreversible transform.
pub(crate) fn write_lossy(draft: &Draft, choice: BorderChoice, target: &Target<'_>, task: Task<'_>) -> Result<(Written, bool)> {
    let transform = if choice == BorderChoice::Implied { Transform::Reversible53 } else { Transform::Irreversible97 };
    let write = |transform: Transform, quality: Quality| {
        let mut weights = vec![1.0; draft.planes.len()];
        weights.iter_mut().skip(3).for_each(|w| *w = NORMALS);
        let pixel_weights = Some(&draft.weights[..]);
        let codec = J2k {
            settings: Settings {
                transform,
                quality,
                layers: target.layers,
                weights,
                pixel_weights,
                region: target.region,
                ..Settings::default()
            },
        };
        let samples = codec.encode(&draft.planes, &task)?;
        draft.pack(&samples, &codec)
    };
    let lossless = || write(Transform::Reversible53, Quality::Lossless);
    match target.goal {
        Goal::Lossless => Ok((lossless()?, false)),
        Goal::BitsPerPixel(bpp) => Ok((write(transform, Quality::BitsPerPixel(bpp))?, transform == Transform::Irreversible97)),
        Goal::Psnr(wanted) => {
            let pixels = draft.planes.shape().pixels() as f64;
            // The highest rate that is too low, and the lowest that is enough, with the psnr of each.
            let mut below: Option<(f64, f64)> = None;
            let mut above: Option<(f64, f64, Written)> = None;
            // log₂ of the bits a pixel.
            let mut rate = -1.0_f64;
            for _ in 0..ATTEMPTS {
                task.step(0.5)?;
                let written = match write(transform, Quality::BitsPerPixel(rate.exp2())) {
                    Ok(written) => written,
                    // Too few bytes for a stream at all, or too few for a mesh.
                    Err(Error::Parameter(_) | Error::NoConvergence { .. }) if above.is_some() || rate < 4.0 => {
                        below = Some((rate, f64::NEG_INFINITY));
                        rate = above.as_ref().map_or(rate + 1.0, |a| (a.0 + rate) / 2.0);
                        continue;
                    }
                    Err(error) => return Err(error),
                };
                let psnr = (target.psnr)(&written.decoded)?;
                if psnr >= wanted {
                    above = Some((rate, psnr, written));
                } else {
                    below = Some((rate, psnr));
                }
                rate = match (&below, &above) {
                    (_, Some((_, psnr, _))) if *psnr < wanted + NEAR => break,
                    (Some((low, _)), Some((high, ..))) if high - low < 0.01 => break,
                    (Some((low, bad)), Some((high, good, _))) if bad.is_finite() => {
                        // A little above the line between the two.
                        let share = ((wanted + NEAR / 2.0 - bad) / (good - bad)).clamp(0.1, 0.9);
                        low + (high - low) * share
                    }
                    (Some((low, _)), Some((high, ..))) => (low + high) / 2.0,
                    (None, Some((high, ..))) => high - 1.0,
                    (Some((low, _)), None) => low + 1.0,
                    (None, None) => break,
                };
                // Beyond this nothing is lost any more.
                if above.is_none() && rate.exp2() * pixels > 48.0 * pixels {
                    break;
                }
            }
            if let Some((_, _, written)) = above {
                return Ok((written, transform == Transform::Irreversible97));
            }
            let written = lossless()?;
            let psnr = (target.psnr)(&written.decoded)?;
            if psnr >= wanted {
                return Ok((written, false));
            }
            Err(Error::Parameter(format!(
                "a psnr of {wanted} dB cannot be reached: the lattice allows {psnr:.1}; take more bits"
            )))
        }
    }
}
