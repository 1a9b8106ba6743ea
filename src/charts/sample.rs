//! A mesh to a geometry image and on to a file: how finely it is sampled, and where, for a target.
//!
//! The grid is the coarsest whose surface, before anything is rounded, is a few dB better than what is asked for: coarser ones
//! cannot reach it, finer ones cost bytes. With [`Adjust::Rate`] samples then move to where they cost less, in turns with the
//! search for the step, since what is cheap depends on the step.

use super::mesh;
use super::region::Interesting;
use super::search::{Aim, Found, finish, search};
use super::write::How;
use crate::codec::wavelet::shrink;
use crate::error::{Error, Result};
use crate::gim::{self, Atlas, Map, Sampler};
use crate::mesh::Scalar;
use crate::options::{Accuracy, Adjust, GimChoices, Grid};
use crate::plane::{GeometryImage, Shape};
use crate::task::Task;

/// Samples a side that [`Grid::Auto`] chooses among.
const SIDES: [usize; 11] = [33, 49, 65, 97, 129, 193, 257, 385, 513, 769, 1025];
/// By so much, in dB, a surface that is not yet rounded should be better than the target: rounding is worth most then. Finer grids cost
/// a little more, much coarser ones a lot.
const HEADROOM: f64 = 10.5;
/// The same where samples are not moved to where they cost less: finer grids then cost more than a little.
const LESS_HEADROOM: f64 = 6.5;
/// A Hausdorff distance before rounding is to be this share of what is allowed.
const ERROR_BEFORE: f64 = 0.6;
/// Turns of moving samples and searching for the step.
const TURNS: usize = 2;
/// Rounds of moving in each.
const ROUNDS: usize = 4;
/// How much of their quantiser step tangential details give way in each round.
const SHARE: f64 = 0.4;

/// Samples a surface for a target and codes it.
pub(crate) fn sample(
    atlas: &Atlas,
    interesting: Option<&Interesting<'_>>,
    how: How<'_>,
    choices: &GimChoices,
    aim: &Aim<'_>,
    task: Task<'_>,
) -> Result<Found> {
    let sampler = Sampler { sampling: choices.sampling, focus: interesting.map(Interesting::focus) };
    let plain = |side: usize| atlas.sample(side, sampler, &task);
    let adjusted = |images: Vec<GeometryImage>| -> Result<Vec<GeometryImage>> {
        match choices.adjust {
            Adjust::None => Ok(images),
            Adjust::Fit | Adjust::Rate => atlas.adjust(images, gim::Adjust::Fit, &task),
            Adjust::Hausdorff => atlas.adjust(images, gim::Adjust::Hausdorff(sampler.focus), &task),
        }
    };
    let cells = |images: &[GeometryImage]| interesting.map_or(Ok(Vec::new()), |some| some.cells(images));
    let cheapest = |images: Vec<GeometryImage>| -> Result<Found> {
        task.step(0.5)?;
        let cells = cells(&images)?;
        let how = interesting.map_or(how, |some| some.among(&cells, how));
        let mut found = search(&images, how, aim, None)?;
        let mut best = images;
        if choices.adjust == Adjust::Rate {
            let mut images = best.clone();
            for turn in 0..TURNS {
                task.step(0.6 + 0.15 * turn as f64)?;
                images = cheaper(atlas, images, found.step, interesting, task)?;
                let other = match search(&images, how, aim, Some(found.step)) {
                    Ok(other) => other,
                    // What was dropped is missed.
                    Err(Error::Parameter(_)) => break,
                    Err(error) => return Err(error),
                };
                if aim.prefers(&other, &found)? {
                    (found, best) = (other, images.clone());
                }
            }
        }
        finish(&best, how, aim, found)
    };
    match choices.grid {
        Grid::Side(side) => cheapest(adjusted(plain(side as usize)?)?),
        Grid::Size(columns, rows) => cheapest(adjusted(atlas.sample_as(Shape::new(columns, rows)?, sampler, &task)?)?),
        Grid::Auto => {
            let fitting: Vec<usize> = SIDES.into_iter().filter(|side| (side - 1).is_multiple_of(atlas.grains())).collect();
            let mut sides = &fitting[..];
            let headroom = if choices.adjust == Adjust::Rate { HEADROOM } else { LESS_HEADROOM };
            loop {
                let coded = |images: &[GeometryImage]| {
                    let cells = cells(images)?;
                    search(images, interesting.map_or(how, |some| some.among(&cells, how)), aim, None)
                };
                let (images, finer) = choose(plain, adjusted, sides, headroom, aim, coded, task)?;
                match cheapest(images) {
                    // The surface was good enough, but rounding it was not.
                    Err(Error::Parameter(_)) if !finer.is_empty() => sides = finer,
                    other => return other,
                }
            }
        }
    }
}

/// The images with their samples where they cost less at a step.
fn cheaper(
    atlas: &Atlas,
    images: Vec<GeometryImage>,
    step: f64,
    interesting: Option<&Interesting<'_>>,
    task: Task<'_>,
) -> Result<Vec<GeometryImage>> {
    let moved = |(map, image): (&Map, GeometryImage)| {
        let zones = interesting.map(|some| some.zones(&image)).transpose()?;
        let shrink = |image: &GeometryImage| shrink(image, step, zones.clone(), SHARE, &task);
        map.adjust(image, gim::Adjust::Rate { shrink: &shrink, rounds: ROUNDS }, &task)
    };
    atlas.maps().iter().zip(images).map(moved).collect()
}

/// What moving samples may be worth, in dB.
const ADJUSTING: f64 = 9.0;

/// The coarsest images of some sides that are good enough for the target, and the sides beyond.
fn choose<'a>(
    plain: impl Fn(usize) -> Result<Vec<GeometryImage>>,
    adjusted: impl Fn(Vec<GeometryImage>) -> Result<Vec<GeometryImage>>,
    sides: &'a [usize],
    headroom: f64,
    aim: &Aim<'_>,
    coded: impl Fn(&[GeometryImage]) -> Result<Found>,
    task: Task<'_>,
) -> Result<(Vec<GeometryImage>, &'a [usize])> {
    let judge = aim.judge;
    let wanted = wanted_psnr(aim) + headroom;
    let psnr = |images: &[GeometryImage]| judge.psnr(&mesh(images, Scalar::F64)?, task);
    let enough = |images: &[GeometryImage]| -> Result<bool> {
        let bound = match aim.accuracy {
            Accuracy::Error(bound) => bound,
            Accuracy::RelativeError(share) => share * judge.diagonal(),
            _ => return Ok(psnr(images)? >= wanted),
        };
        Ok(judge.hausdorff(&mesh(images, Scalar::F64)?, task)? <= ERROR_BEFORE * bound)
    };
    let by_psnr = !matches!(aim.accuracy, Accuracy::Error(_) | Accuracy::RelativeError(_) | Accuracy::Size(_));
    let mut best: Option<(Vec<GeometryImage>, Found)> = None;
    let (mut last, mut before) = (None, (1, f64::NEG_INFINITY));
    for (i, &side) in sides.iter().enumerate() {
        task.step(0.4)?;
        let images = plain(side)?;
        let finer = &sides[i + 1..];
        if by_psnr && !finer.is_empty() {
            let found = psnr(&images)?;
            // Creases gain 6 dB by twice the samples, smooth surfaces up to twice that, and seldom much more than last time.
            let doublings = |to: usize| (to as f64 / side as f64).log2();
            let gain = (1.2 * (found - before.1) / -doublings(before.0)).clamp(6.0, 12.0);
            let most = found + ADJUSTING + gain * doublings(finer[finer.len() - 1]);
            if most < wanted_psnr(aim) {
                return Err(Error::Parameter(format!(
                    "{} dB are out of reach: {side} samples a side come to {found:.1} dB, and more to about {most:.0} dB; \
                     --method cgim keeps the mesh's own triangles",
                    wanted_psnr(aim),
                )));
            }
            before = (side, found);
            if found + ADJUSTING < wanted {
                continue;
            }
        }
        let images = adjusted(images)?;
        if let Accuracy::Size(_) = aim.accuracy {
            // The side at which so many bytes buy the best psnr.
            let Ok(found) = coded(&images) else { break };
            match &best {
                Some((_, other)) if !aim.prefers(&found, other)? => break,
                _ => best = Some((images, found)),
            }
            continue;
        }
        let done = enough(&images)?;
        last = Some((images, finer));
        if done {
            break;
        }
    }
    let chosen = best.map(|(images, _)| (images, &sides[..0])).or(last);
    chosen.ok_or_else(|| Error::Parameter("no grid fits so few bytes".into()))
}

/// The psnr that a target amounts to.
fn wanted_psnr(aim: &Aim<'_>) -> f64 {
    match aim.accuracy {
        Accuracy::Psnr(psnr) => psnr,
        // The surface is wrong by about a fifth of the step.
        Accuracy::Step(step) => 20.0 * (5.0 * aim.judge.diagonal() / step).log10(),
        Accuracy::Bits(bits) => 6.02 * f64::from(bits) + 14.0,
        _ => 70.0,
    }
}
