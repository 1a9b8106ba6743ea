//! The step that meets a psnr: as large as can be.
//!
//! Trials are measured by few samples. How far these are off is seen once, by many, where the target is nearly met; it is
//! about the same for all steps near to it. Only what is going to be written is measured by many.

use super::search::{Aim, Found, named};
use super::write::How;
use crate::error::{Error, Result};
use crate::plane::GeometryImage;

/// Trials of one search.
const TRIALS: usize = 16;
/// Steps this near to each other are the same to a file (as a logarithm).
const NEAR: f64 = 0.004;
/// So much may what was found by a first search be off, in dB.
const ROUGH: f64 = 0.15;
/// And what is written be better than asked for.
const SLACK: f64 = 0.015;
/// What few samples leave uncertain of surfaces that are nearly the same.
const UNSURE: f64 = 0.002;
/// A psnr falls by so many dB while the step grows by one (as a logarithm): less than 20 / ln 10, since rounding is not all
/// that is wrong.
const FALL: f64 = 7.0;

/// Images, coded again and again.
struct Trials<'a> {
    images: &'a [GeometryImage],
    how: How<'a>,
    aim: &'a Aim<'a>,
    /// What many samples say more than few, in dB.
    offset: f64,
}

impl Trials<'_> {
    fn at(&self, step: f64) -> Result<Found> {
        let Aim { judge, task, .. } = *self.aim;
        if task.is_over() {
            return Err(Error::Cancelled);
        }
        let coded = self.how.code(self.images, step, task)?;
        let psnr = judge.psnr(&coded.mesh()?, task)?;
        Ok(Found { psnr, ..Found::new(coded, step) })
    }

    /// Measures by many samples.
    fn confirm(&mut self, found: &mut Found) -> Result<f64> {
        let measured = match found.measured {
            Some(measured) => measured,
            None => self.aim.judge.measure(&found.coded.mesh()?, self.aim.task)?,
        };
        found.measured = Some(measured);
        self.offset = measured.aimed_at() - found.psnr;
        Ok(measured.aimed_at())
    }

    /// A step whose psnr lies in `low ..= high`, or else the largest that was found above.
    fn approach(&self, first: Option<Found>, start: f64, [low, high]: [f64; 2]) -> Result<Option<Found>> {
        let middle = 0.5 * (low + high);
        // Steps (as logarithms) and what their psnr is above the middle.
        let (mut fine, mut bad) = (None::<(f64, f64)>, None::<(f64, f64)>);
        let (mut first, mut best, mut next) = (first, None::<Found>, start.ln());
        for trial in 0..TRIALS {
            let found = match first.take().map_or_else(|| self.at(next.exp()), Ok) {
                Ok(found) => found,
                // Beyond what the codec can hold: the image is as good as it can be.
                Err(Error::Parameter(_)) if best.is_none() && bad.is_some() => break,
                Err(error) => return Err(error),
            };
            let psnr = found.psnr + self.offset;
            let here = (found.step.ln(), psnr - middle);
            if (low..=high).contains(&psnr) {
                return Ok(Some(found));
            }
            if psnr > high {
                (fine, best) = (Some(here), Some(found));
            } else {
                bad = Some(here);
            }
            next = match (fine, bad) {
                (Some((a, above)), Some((b, below))) => {
                    if (b - a).abs() < NEAR {
                        break;
                    }
                    // The secant; a third of the trials half the way, lest one end stays.
                    let share = if trial % 3 == 2 { 0.5 } else { (above / (above - below)).clamp(0.05, 0.95) };
                    a + (b - a) * share
                }
                // As long as only one end is known, the way to the other is helped along more and more.
                (Some((a, above)), None) => a + (above / FALL + 0.01 * (1 << trial.min(7)) as f64).min(3.0),
                (None, Some((b, below))) => b - (-below / FALL + 0.01 * (1 << trial.min(7)) as f64).min(3.0),
                (None, None) => break,
            };
        }
        Ok(best)
    }
}

fn out_of_reach(target: f64, images: &[GeometryImage]) -> Error {
    let with = named(images);
    Error::Parameter(format!("a psnr of {target} dB cannot be reached with {with}: take a larger grid, or --method cgim"))
}

/// Codes images so that their psnr is nearly what is aimed at.
pub(super) fn search(images: &[GeometryImage], how: How<'_>, aim: &Aim<'_>, target: f64, start: Option<f64>) -> Result<Found> {
    let trials = Trials { images, how, aim, offset: 0.0 };
    // A sample moves in three directions, and the surface feels one of them.
    let start = start.unwrap_or(4.0 * aim.judge.diagonal() / 10_f64.powf(target / 20.0));
    trials.approach(None, start, [target - ROUGH, target + ROUGH])?.ok_or_else(|| out_of_reach(target, images))
}

/// Larger steps that happen to be fine too: what few coefficients become depends on the step like on dice.
const THROWS: i32 = 6;
const THROW: f64 = 1.009;
/// So many of them are measured by many samples at most.
const CONFIRMED: usize = 3;
/// And so often what was found is asked to be a little better.
const RETRIES: usize = 6;

/// The fewest bytes around a step that nearly meets the target.
pub(super) fn finish(images: &[GeometryImage], how: How<'_>, aim: &Aim<'_>, target: f64, found: Found) -> Result<Found> {
    let size = |found: &Found| found.coded.size(aim.history);
    let mut trials = Trials { images, how, aim, offset: 0.0 };
    let mut found = found;
    trials.confirm(&mut found)?;
    let mut best: Option<Found> = None;
    let mut low = target + UNSURE;
    // What is found is measured, and if it was not enough, more is asked for.
    for _ in 0..RETRIES {
        let step = found.step;
        let near = trials.approach(Some(found), step, [low, low + SLACK])?;
        found = near.ok_or_else(|| out_of_reach(target, images))?;
        let psnr = trials.confirm(&mut found)?;
        if psnr >= target {
            best = Some(found);
            break;
        }
        low += target - psnr + UNSURE;
    }
    let mut best = best.ok_or_else(|| out_of_reach(target, images))?;
    let start = best.step;
    let mut lucky = (1..=THROWS).map(|throw| trials.at(start * THROW.powi(throw))).collect::<Result<Vec<_>>>()?;
    lucky.retain(|found| found.psnr + trials.offset >= target && size(found) < size(&best));
    lucky.sort_by_key(size);
    for mut found in lucky.into_iter().take(CONFIRMED) {
        if trials.confirm(&mut found)? >= target {
            best = found;
            break;
        }
    }
    Ok(best)
}
