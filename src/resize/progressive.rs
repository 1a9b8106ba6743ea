//! The paper's resizing (004, II-B): saliency, size of the step, warp, evaluation, until the target is reached.
//!
//! Two things are not as printed, because it breaks surfaces as printed (spec/readings.md): no step changes a side by
//! more than a fifth, and the samples are evaluated once, in the original, at the places to which all steps together
//! lead. [`Progress::literal`] has neither.

use super::bicubic::Spline;
use super::field::Field;
use super::invert::inverse;
use super::saliency::{Energy, saliency};
use super::warp::Warp;
use crate::error::Result;
use crate::plane::{GeometryImage, Gluing};
use crate::task::Task;

/// A step makes no side shorter than this share of it.
pub(crate) const SMALLEST_STEP: f64 = 0.8;

/// Columns and rows.
pub(crate) type Size = (usize, usize);

/// How the target is approached.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    pub(crate) alpha: f64,
    /// Equation (6)'s threshold: a step goes no further than to as many samples as have more energy.
    pub(crate) lambda: Option<f64>,
    /// How many steps, each changing the sides by one ratio; otherwise as many as the limit of a fifth needs.
    pub(crate) steps: Option<usize>,
    pub(crate) energy: Energy,
    /// The least energy that a sample counts with.
    pub(crate) floor: f64,
    /// As printed: no limit of a step, folds stay, and every step evaluates the image of the last.
    pub(crate) literal: bool,
}

/// What came out, and how.
#[derive(Clone, Debug)]
pub(crate) struct Progressed {
    pub(crate) points: Vec<[f64; 3]>,
    /// The sizes on the way, the target last.
    pub(crate) sizes: Vec<Size>,
    /// Cells that folded, over all steps.
    pub(crate) folded: usize,
    /// From where in the original every sample comes; unless literal.
    pub(crate) places: Option<Field<[f64; 2]>>,
}

/// Resizes an image to `target`.
pub(crate) fn progressive(image: &GeometryImage, target: Size, how: &Progress, task: &Task<'_>) -> Result<Progressed> {
    let gluing = image.gluing();
    let spline = Spline::new(image);
    let mut places = Field::from_fn(image.width(), image.height(), |x, y| [x as f64, y as f64]);
    let mut current = image.clone();
    let mut done = Progressed { points: Vec::new(), sizes: Vec::new(), folded: 0, places: None };
    let size = |image: &GeometryImage| (image.width(), image.height());
    let mut step = 0;
    while size(&current) != target {
        task.step(share_done(size(image), size(&current), target))?;
        let energy = saliency(&current, how.alpha, how.energy);
        let (width, height) = how.next(size(image), size(&current), target, step, &energy, gluing);
        step += 1;
        if (width, height) == size(&current) {
            continue;
        }
        let warp = if how.literal { Warp::new } else { Warp::without_folds };
        let warp = warp(&energy, how.floor, gluing, width, height, task)?;
        done.folded += warp.folded().len();
        done.sizes.push((width, height));
        let back = inverse(&warp, width, height);
        let points: Vec<[f64; 3]> = if how.literal {
            let spline = Spline::new(&current);
            back.values.iter().map(|&place| spline.at(place)).collect()
        } else {
            places = Field::new(width, height, back.values.iter().map(|&place| places.linear(place)).collect());
            places.values.iter().map(|&place| spline.at(place)).collect()
        };
        current = GeometryImage::new(width, height, gluing, points)?;
    }
    done.points = current.points().to_vec();
    done.places = (!how.literal).then_some(places);
    Ok(done)
}

impl Progress {
    /// The size after step number `step`, counted from 0.
    fn next(&self, from: Size, now: Size, target: Size, step: usize, energy: &Field<f64>, gluing: Gluing) -> Size {
        // Equation (6), for any rectangle: both sides shrink to the root of the share of samples that matter.
        let wanted = self.lambda.map(|lambda| {
            let salient = energy.values.iter().filter(|&&e| e > lambda).count();
            (salient as f64 / energy.values.len() as f64).sqrt()
        });
        let steps = self.steps.unwrap_or_else(|| needed_steps(from, target));
        let (odd, shrink) = (gluing == Gluing::Orbifold, target.0 < now.0 || target.1 < now.1);
        let side = |from: usize, now: usize, target: usize| {
            let next = match wanted {
                _ if now == target => target,
                Some(share) if target < now => {
                    let least = if self.literal { 0.0 } else { (SMALLEST_STEP * now as f64).ceil() };
                    // Where all samples matter (6) stands still; a twentieth is a step.
                    let most = now - (now / 20).max(1);
                    ((share * now as f64).floor().max(least) as usize).min(most).max(target)
                }
                // (6) says nothing of growing.
                Some(_) if shrink => now,
                Some(_) => ((now as f64 / SMALLEST_STEP).floor() as usize).max(now + 1).min(target),
                None => {
                    let share = (step + 1) as f64 / steps as f64;
                    let next = from as f64 * (target as f64 / from as f64).powf(share.min(1.0));
                    (next.round() as usize).clamp(from.min(target), from.max(target))
                }
            };
            match (odd && next % 2 == 0, wanted.is_some() && next.abs_diff(now) <= 1) {
                (false, _) => next,
                // To the odd side nearer to this one, unless that is this one itself.
                (true, false) => {
                    if target < now {
                        next + 1
                    } else {
                        next - 1
                    }
                }
                (true, true) => {
                    if target < now {
                        next - 1
                    } else {
                        next + 1
                    }
                }
            }
        };
        (side(from.0, now.0, target.0), side(from.1, now.1, target.1))
    }
}

/// How many steps of at most a fifth lead from one size to another.
fn needed_steps(from: Size, target: Size) -> usize {
    let along = |from: usize, target: usize| {
        let ratio = target.min(from) as f64 / target.max(from) as f64;
        (ratio.ln() / SMALLEST_STEP.ln() - 1e-9).ceil().max(1.0) as usize
    };
    along(from.0, target.0).max(along(from.1, target.1))
}

fn share_done(from: Size, now: Size, target: Size) -> f64 {
    let log = |a: usize, b: usize| (a as f64 / b as f64).ln().abs();
    let (all, left) = (log(from.0, target.0) + log(from.1, target.1), log(now.0, target.0) + log(now.1, target.1));
    if all > 0.0 { (1.0 - left / all).clamp(0.0, 1.0) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::super::test_images::{bump, pillow};
    use super::*;

    const ROBUST: Progress =
        Progress { alpha: 0.3, lambda: None, steps: None, energy: Energy::Robust, floor: 0.02, literal: false };
    const LITERAL: Progress =
        Progress { alpha: 0.5, lambda: Some(0.1), steps: None, energy: Energy::Paper, floor: 1e-3, literal: true };

    fn run(image: &GeometryImage, target: Size, how: &Progress) -> Progressed {
        progressive(image, target, how, &Task::default()).unwrap()
    }

    #[test]
    fn no_step_changes_a_side_by_more_than_a_fifth_and_no_cell_folds() {
        let with_lambda = Progress { lambda: Some(0.1), ..ROBUST };
        for (image, target) in [
            (bump(60, 60, 0.6), (20, 20)),
            (bump(60, 40, 0.6), (23, 40)),
            (bump(20, 30, 0.6), (50, 12)),
            (pillow(61, 61), (21, 21)),
            (pillow(41, 61), (31, 81)),
        ] {
            for how in [ROBUST, with_lambda] {
                let done = run(&image, target, &how);
                assert_eq!((done.folded, done.sizes.last()), (0, Some(&target)));
                let mut before = (image.width(), image.height());
                for &size in &done.sizes {
                    for (a, b) in [(before.0, size.0), (before.1, size.1)] {
                        // One more where rounding to odd sides would stand still.
                        let least = if image.gluing() == Gluing::Orbifold { 2 } else { 1 };
                        let change = a.abs_diff(b) as f64;
                        assert!(change <= least as f64 + 0.2 * a.max(b) as f64, "{a} to {b} in {:?}", done.sizes);
                    }
                    before = size;
                }
            }
        }
    }

    #[test]
    fn as_printed_the_first_step_is_far_too_long_and_cells_fold() {
        let done = run(&bump(80, 80, 0.6), (24, 24), &LITERAL);
        assert!(done.sizes[0].0 < 60, "{:?}", done.sizes);
        assert!(done.folded > 50, "{} cells", done.folded);
        assert_eq!(run(&bump(80, 80, 0.6), (24, 24), &ROBUST).folded, 0);
    }

    #[test]
    fn the_number_of_steps_is_the_callers() {
        for steps in [1, 3, 7] {
            let done = run(&bump(64, 50, 0.5), (20, 25), &Progress { steps: Some(steps), ..ROBUST });
            assert_eq!(done.sizes.len(), steps);
            assert_eq!(done.folded, 0);
        }
    }

    #[test]
    fn the_border_comes_from_the_border_and_what_matters_gets_more_samples() {
        let image = bump(60, 60, 0.6);
        let done = run(&image, (20, 20), &ROBUST);
        let places = done.places.unwrap();
        for i in 0..20 {
            let ends = [places.at(i, 0)[1], places.at(i, 19)[1], places.at(0, i)[0], places.at(19, i)[0]];
            assert_eq!(ends, [0.0, 59.0, 0.0, 59.0]);
        }
        let inside = |places: &[[f64; 2]]| places.iter().filter(|p| (p[0] - 29.5).hypot(p[1] - 29.5) < 12.0).count();
        let even = 0.125 * 400.0; // the share of the circle
        assert!(inside(&places.values) as f64 > 1.5 * even, "{} samples at the bump", inside(&places.values));
    }

    #[test]
    fn a_glued_border_stays_glued() {
        let done = run(&pillow(41, 33), (17, 13), &ROBUST);
        let welded = GeometryImage::new(17, 13, Gluing::Orbifold, done.points.clone()).unwrap();
        assert_eq!(welded.points(), done.points);
        let places = done.places.unwrap();
        for u in 0..17 {
            assert!((places.at(u, 0)[0] + places.at(16 - u, 0)[0] - 40.0).abs() < 1e-6);
        }
    }
}
