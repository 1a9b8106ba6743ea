//! The step that meets a target: as large as a psnr or a bound on the error allows, or as small as a size allows.

use super::psnr;
use super::write::{Coded, How};
use crate::error::{Error, Result};
use crate::judge::{Judge, Measured};
use crate::options::Accuracy;
use crate::plane::GeometryImage;
use crate::task::Task;

/// What is aimed at, and against what.
pub(crate) struct Aim<'a> {
    pub(crate) accuracy: Accuracy,
    pub(crate) judge: &'a Judge,
    pub(crate) history: Option<&'a str>,
    pub(crate) task: Task<'a>,
}

/// Images at the step that was found.
pub(crate) struct Found {
    pub(crate) coded: Coded,
    pub(crate) step: f64,
    /// Its psnr by few samples, where that was aimed at.
    pub(super) psnr: f64,
    /// What it is by many, if that is known.
    pub(super) measured: Option<Measured>,
}

impl Found {
    pub(super) fn new(coded: Coded, step: f64) -> Self {
        Self { coded, step, psnr: f64::NAN, measured: None }
    }
}

impl Aim<'_> {
    /// Whether one result is better than another that meets the same target.
    pub(crate) fn prefers(&self, new: &Found, old: &Found) -> Result<bool> {
        let psnr = |found: &Found| -> Result<f64> { self.judge.psnr(&found.coded.mesh()?, self.task) };
        let size = |found: &Found| found.coded.size(self.history) as f64;
        Ok(match self.accuracy {
            Accuracy::Size(_) => psnr(new)? > psnr(old)?,
            Accuracy::Psnr(target) => {
                let at_target = |found: &Found| size(found) * (BYTES_A_DB * (target - found.psnr)).exp();
                at_target(new) < at_target(old)
            }
            // Nothing else is asked for than fewer bytes.
            _ => size(new) < size(old),
        })
    }

    /// The file of what was found, with its measures by many samples.
    pub(crate) fn file(&self, found: &Found) -> Result<Vec<u8>> {
        self.task.step(0.9)?;
        let decoded = found.coded.mesh()?;
        let measured = match found.measured {
            Some(measured) => measured,
            None => self.judge.measure(&decoded, self.task)?,
        };
        let bound = self.judge.bound(&decoded, measured.hausdorff, self.task)?;
        Ok(found.coded.file(Some(&measured), Some(bound), self.history))
    }
}

/// A dB more is about this share more bytes (as a logarithm).
const BYTES_A_DB: f64 = 0.1;
/// Trials of a search.
const TRIALS: i32 = 14;
/// Steps this near to each other are the same to a file.
const NEAR: f64 = 1.006;
/// Of the bytes that are allowed, this share may stay unused.
const UNUSED: f64 = 0.995;

/// What a trial says of its step.
enum Verdict {
    /// Larger steps may do too; how much larger, by the measure's own rule of thumb.
    Fine(f64),
    /// Only smaller ones will do.
    Bad(f64),
    /// As good as it gets.
    Done,
}

/// Codes images as the aim asks for; a psnr is met nearly, until it is [finished](finish). `start` is a step that may be near.
pub(crate) fn search(images: &[GeometryImage], how: How<'_>, aim: &Aim<'_>, start: Option<f64>) -> Result<Found> {
    let Aim { accuracy, judge, history, task } = *aim;
    let diagonal = judge.diagonal();
    let longest = longest_side(images);
    let (coded, step) = match accuracy {
        Accuracy::Step(step) => (how.code(images, step, task)?, step),
        Accuracy::Bits(bits) => {
            let step = longest.max(f64::MIN_POSITIVE) / f64::from((1_u32 << bits) - 1);
            (how.code(images, step, task)?, step)
        }
        Accuracy::Psnr(target) => return psnr::search(images, how, aim, target, start),
        Accuracy::Size(bytes) => {
            let judged = |coded: &Coded| {
                let size = coded.size(history);
                let share = size as f64 / bytes as f64;
                // Twice the step is about a third of the bytes less.
                let more = share.powf(1.7);
                Ok(match share {
                    s if s > 1.0 => Verdict::Fine(more),
                    s if s > UNUSED => Verdict::Done,
                    _ => Verdict::Bad(more),
                })
            };
            smallest(longest.max(1e-300) / 500.0, bytes, |step| how.code(images, step, task), judged, task)?
        }
        Accuracy::Error(_) | Accuracy::RelativeError(_) => {
            let bound = match accuracy {
                Accuracy::Error(bound) => bound,
                Accuracy::RelativeError(share) => share * diagonal,
                _ => 0.0,
            };
            let judged = |coded: &Coded| {
                let decoded = coded.mesh()?;
                let seen = judge.hausdorff(&decoded, task)?;
                if seen > bound {
                    return Ok(Verdict::Bad(bound / seen));
                }
                let certain = judge.bound(&decoded, seen, task)?;
                Ok(match certain / bound {
                    s if s > 1.0 => Verdict::Bad(1.0 / s),
                    s if s > 0.99 => Verdict::Done,
                    s => Verdict::Fine(1.0 / s),
                })
            };
            bisect(bound, |step| how.code(images, step, task), judged, task)?.ok_or_else(|| {
                Error::Parameter(format!(
                    "an error of {bound} cannot be held with {}: take a larger grid, or --method cgim",
                    named(images)
                ))
            })?
        }
        Accuracy::Lattice(_) | Accuracy::Exact => {
            let why = "a lattice, or coordinates bit by bit, are for exact connectivity; a geometry image takes a step";
            return Err(Error::Parameter(why.into()));
        }
    };
    Ok(Found::new(coded, step))
}

/// What a search found, as near to the target as it can be, and not below.
pub(crate) fn finish(images: &[GeometryImage], how: How<'_>, aim: &Aim<'_>, found: Found) -> Result<Found> {
    match aim.accuracy {
        Accuracy::Psnr(target) => psnr::finish(images, how, aim, target, found),
        _ => Ok(found),
    }
}

fn longest_side(images: &[GeometryImage]) -> f64 {
    let points = images.iter().flat_map(|image| image.points()).copied();
    let bounds = crate::plane::bounding_box(points).unwrap_or([[0.0; 3]; 2]);
    (0..3).map(|i| bounds[1][i] - bounds[0][i]).fold(0.0, f64::max)
}

/// What messages call images.
pub(super) fn named(images: &[GeometryImage]) -> String {
    match images {
        [image] => format!("an image of {} samples", image.shape()),
        _ => {
            let widest = images.iter().map(GeometryImage::width).max().unwrap_or(0);
            format!("{} images of up to {widest} samples a side", images.len())
        }
    }
}

/// The largest step found that is fine.
fn bisect(
    start: f64,
    code: impl Fn(f64) -> Result<Coded>,
    aim: impl Fn(&Coded) -> Result<Verdict>,
    task: Task<'_>,
) -> Result<Option<(Coded, f64)>> {
    let (mut step, mut fine, mut bad) = (start, 0.0_f64, f64::INFINITY);
    let mut best = None;
    for trial in 0..TRIALS {
        if task.is_over() {
            return Err(Error::Cancelled);
        }
        let coded = match code(step) {
            Ok(coded) => coded,
            // Beyond what the codec can hold: the image is as good as it can be.
            Err(Error::Parameter(_)) if best.is_none() && bad.is_finite() => break,
            Err(error) => return Err(error),
        };
        let factor = match aim(&coded)? {
            Verdict::Done => return Ok(Some((coded, step))),
            Verdict::Fine(factor) => {
                fine = step;
                best = Some((coded, step));
                factor
            }
            Verdict::Bad(factor) => {
                bad = step;
                factor
            }
        };
        if bad / fine < NEAR {
            break;
        }
        step = next(step, factor, fine, bad, trial);
    }
    Ok(best)
}

/// The step after one that was off by a factor: there, but strictly between what is known.
fn next(step: f64, factor: f64, fine: f64, bad: f64, trial: i32) -> f64 {
    let guess = step * factor.clamp(1.0 / 16.0, 16.0);
    // As long as only one end is known, the rule of thumb is helped along more and more.
    let more = 1.02_f64.powi(1 << trial.min(7)).min(16.0);
    match (fine > 0.0, bad.is_finite()) {
        (true, true) => {
            let (low, high) = (fine * (bad / fine).powf(0.1), bad * (fine / bad).powf(0.1));
            if (low..=high).contains(&guess) { guess } else { (fine * bad).sqrt() }
        }
        (false, _) => guess.min(step / more),
        (true, false) => guess.max(step * more),
    }
}

/// The smallest step found whose file is small enough.
fn smallest(
    start: f64,
    bytes: u64,
    code: impl Fn(f64) -> Result<Coded>,
    aim: impl Fn(&Coded) -> Result<Verdict>,
    task: Task<'_>,
) -> Result<(Coded, f64)> {
    // Seen from the size, steps that are too small are "fine" (larger ones may do) and those that fit are "bad".
    let (mut step, mut too_small, mut fits) = (start, 0.0_f64, f64::INFINITY);
    let (mut best, mut least): (Option<(Coded, f64)>, u64) = (None, u64::MAX);
    for trial in 0..TRIALS {
        if task.is_over() {
            return Err(Error::Cancelled);
        }
        let coded = match code(step) {
            Ok(coded) => coded,
            Err(Error::Parameter(_)) if best.is_some() => break,
            Err(error) => return Err(error),
        };
        least = least.min(coded.size(None));
        let factor = match aim(&coded)? {
            Verdict::Done => return Ok((coded, step)),
            Verdict::Fine(factor) => {
                too_small = step;
                factor
            }
            Verdict::Bad(factor) => {
                fits = step;
                best = Some((coded, step));
                factor
            }
        };
        if fits / too_small < NEAR {
            break;
        }
        step = next(step, factor, too_small, fits, trial);
    }
    best.ok_or_else(|| Error::Parameter(format!("{bytes} bytes are too few: the smallest file found has {least}")))
}
