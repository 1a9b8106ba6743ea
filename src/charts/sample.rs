//! A mesh to a geometry image and on to a file: how finely it is sampled, and where, for a target.
//!
//! The grid is the coarsest whose surface, before anything is rounded, is a few dB better than what is asked for: coarser ones
//! cannot reach it, finer ones cost bytes. With [`Adjust::Rate`] samples then move to where they cost less, in turns with the
//! search for the step, since what is cheap depends on the step.

use super::mesh;
use super::search::{Aim, Found, finish, search};
use super::write::How;
use crate::codec::wavelet::shrink;
use crate::error::{Error, Result};
use crate::gim::{self, Atlas, Map};
use crate::mesh::{HalfEdges, Mesh, Scalar};
use crate::options::{Accuracy, Adjust, GimChoices, Grid};
use crate::plane::GeometryImage;
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
pub(crate) fn sample(original: &Mesh, how: How, choices: &GimChoices, aim: &Aim<'_>, task: Task<'_>) -> Result<Found> {
    let triangles = original.faces.triangles();
    let surface = HalfEdges::new(original.positions.len(), triangles)?;
    let atlas = Atlas::new(&surface, &original.positions, choices.param, &task)?;
    let [map] = atlas.maps() else {
        return Err(Error::Parameter(format!(
            "a surface of {} charts, and a file holds one; `--method cgim` stores any mesh",
            atlas.maps().len()
        )));
    };
    task.step(0.3)?;
    let plain = |side: usize| map.sample(side, choices.sampling, &task);
    let adjusted = |image: GeometryImage| -> Result<GeometryImage> {
        match choices.adjust {
            Adjust::None => Ok(image),
            Adjust::Fit | Adjust::Rate => map.adjust(image, gim::Adjust::Fit, &task),
            Adjust::Hausdorff => map.adjust(image, gim::Adjust::Hausdorff, &task),
        }
    };
    let cheapest = |image: GeometryImage| -> Result<Found> {
        task.step(0.5)?;
        let mut found = search(&image, how, aim, None)?;
        let mut best = image;
        if choices.adjust == Adjust::Rate {
            let mut image = best.clone();
            for turn in 0..TURNS {
                task.step(0.6 + 0.15 * turn as f64)?;
                image = cheaper(map, image, found.step, task)?;
                let other = match search(&image, how, aim, Some(found.step)) {
                    Ok(other) => other,
                    // What was dropped is missed.
                    Err(Error::Parameter(_)) => break,
                    Err(error) => return Err(error),
                };
                if aim.prefers(&other, &found)? {
                    (found, best) = (other, image.clone());
                }
            }
        }
        finish(&best, how, aim, found)
    };
    match choices.grid {
        Grid::Side(side) => cheapest(adjusted(plain(side as usize)?)?),
        Grid::Auto => {
            let mut sides = &SIDES[..];
            let headroom = if choices.adjust == Adjust::Rate { HEADROOM } else { LESS_HEADROOM };
            loop {
                let (image, finer) = choose(plain, adjusted, sides, headroom, aim, how, task)?;
                match cheapest(image) {
                    // The surface was good enough, but rounding it was not.
                    Err(Error::Parameter(_)) if !finer.is_empty() => sides = finer,
                    other => return other,
                }
            }
        }
    }
}

/// The image with its samples where they cost less at a step.
fn cheaper(map: &Map, image: GeometryImage, step: f64, task: Task<'_>) -> Result<GeometryImage> {
    let shrink = |image: &GeometryImage| shrink(image, step, SHARE, &task);
    map.adjust(image, gim::Adjust::Rate { shrink: &shrink, rounds: ROUNDS }, &task)
}

/// What moving samples may be worth, in dB.
const ADJUSTING: f64 = 9.0;

/// The coarsest image of some sides that is good enough for the target, and the sides beyond.
fn choose<'a>(
    plain: impl Fn(usize) -> Result<GeometryImage>,
    adjusted: impl Fn(GeometryImage) -> Result<GeometryImage>,
    sides: &'a [usize],
    headroom: f64,
    aim: &Aim<'_>,
    how: How,
    task: Task<'_>,
) -> Result<(GeometryImage, &'a [usize])> {
    let judge = aim.judge;
    let wanted = wanted_psnr(aim) + headroom;
    let psnr = |image: &GeometryImage| judge.psnr(&mesh(image, Scalar::F64)?, task);
    let enough = |image: &GeometryImage| -> Result<bool> {
        let bound = match aim.accuracy {
            Accuracy::Error(bound) => bound,
            Accuracy::RelativeError(share) => share * judge.diagonal(),
            _ => return Ok(psnr(image)? >= wanted),
        };
        Ok(judge.hausdorff(&mesh(image, Scalar::F64)?, task)? <= ERROR_BEFORE * bound)
    };
    let by_psnr = !matches!(aim.accuracy, Accuracy::Error(_) | Accuracy::RelativeError(_) | Accuracy::Size(_));
    let mut best: Option<(GeometryImage, Found)> = None;
    let mut last = None;
    for (i, &side) in sides.iter().enumerate() {
        task.step(0.4)?;
        let image = plain(side)?;
        let finer = &sides[i + 1..];
        if by_psnr && !finer.is_empty() && psnr(&image)? + ADJUSTING < wanted {
            continue;
        }
        let image = adjusted(image)?;
        if let Accuracy::Size(_) = aim.accuracy {
            // The side at which so many bytes buy the best psnr.
            let found = search(&image, how, aim, None);
            let Ok(found) = found else { break };
            match &best {
                Some((_, other)) if !aim.prefers(&found, other)? => break,
                _ => best = Some((image, found)),
            }
            continue;
        }
        let done = enough(&image)?;
        last = Some((image, finer));
        if done {
            break;
        }
    }
    let chosen = best.map(|(image, _)| (image, &sides[..0])).or(last);
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
