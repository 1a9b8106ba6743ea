//! One warp to the target, samples that meet averaged (paper 004's VR: Wolf, Guttmann and Cohen-Or, 2007).
//!
//! A baseline: samples of little energy are lost in one go, and what lies where nothing lands is guessed.

use super::field::Field;
use super::saliency::{Energy, saliency};
use super::warp::Warp;
use crate::error::Result;
use crate::plane::{GeometryImage, Gluing};
use crate::task::Task;

/// The points, and how many cells folded.
pub(crate) fn direct(
    image: &GeometryImage,
    (width, height): (usize, usize),
    alpha: f64,
    energy: Energy,
    floor: f64,
    task: &Task<'_>,
) -> Result<(Vec<[f64; 3]>, usize)> {
    let energy = saliency(image, alpha, energy);
    let warp = Warp::new(&energy, floor, image.gluing(), width, height, task)?;
    Ok((average(image, &warp, width, height), warp.folded().len()))
}

/// The mean of the samples that land nearest to each new one.
fn average(image: &GeometryImage, warp: &Warp, width: usize, height: usize) -> Vec<[f64; 3]> {
    let mut sums = vec![([0.0; 3], 0.0); width * height];
    let near = |at: f64, side: usize| at.round_ties_even().clamp(0.0, (side - 1) as f64) as usize;
    let border = |at: usize, last: usize, to: usize, side: usize| match at {
        0 => 0,
        at if at == last => side - 1,
        _ => to,
    };
    for (p, point) in image.points().iter().enumerate() {
        let (x, y) = (p % image.width(), p / image.width());
        let u = border(x, image.width() - 1, near(warp.x.values[p], width), width);
        let v = border(y, image.height() - 1, near(warp.y.values[p], height), height);
        let (sum, count) = &mut sums[v * width + u];
        (0..3).for_each(|i| sum[i] += point[i]);
        *count += 1.0;
    }
    if image.gluing() == Gluing::Orbifold {
        share_glued(image, width, height, &mut sums);
    }
    let found = sums.iter().map(|(sum, count)| (*count > 0.0).then(|| sum.map(|x| x / count))).collect();
    nearest(&Field::new(width, height, found))
}

/// Both sides of a glued border take the mean of what landed on either.
fn share_glued(image: &GeometryImage, width: usize, height: usize, sums: &mut [([f64; 3], f64)]) {
    let shape = crate::plane::Shape::new(width as u32, height as u32);
    let Ok(shape) = shape else { return };
    let of = |p: usize| {
        let (row, column) = image.gluing().representative(shape, p / width, p % width);
        row * width + column
    };
    for p in 0..sums.len() {
        if of(p) != p {
            let (sum, count) = std::mem::take(&mut sums[p]);
            let (to, all) = &mut sums[of(p)];
            (0..3).for_each(|i| to[i] += sum[i]);
            *all += count;
        }
    }
    (0..sums.len()).for_each(|p| sums[p] = sums[of(p)]);
}

/// What is known, or the nearest that is, looking in growing squares.
fn nearest(field: &Field<Option<[f64; 3]>>) -> Vec<[f64; 3]> {
    let (width, height) = (field.width as isize, field.height as isize);
    let look = |x: isize, y: isize| {
        let mut best: Option<(isize, [f64; 3])> = None;
        for reach in 0..width.max(height) {
            if best.is_some_and(|(square, _)| reach * reach > square) {
                break;
            }
            let edge = |dx: isize, dy: isize| dx.abs().max(dy.abs()) == reach;
            for dy in -reach..=reach {
                let step = if dy.abs() == reach { 1 } else { (2 * reach).max(1) };
                for dx in (-reach..=reach).step_by(step as usize).filter(|&dx| edge(dx, dy)) {
                    let inside = (0..width).contains(&(x + dx)) && (0..height).contains(&(y + dy));
                    let Some(point) = inside.then(|| field.at((x + dx) as usize, (y + dy) as usize)).flatten() else {
                        continue;
                    };
                    let square = dx * dx + dy * dy;
                    if best.is_none_or(|(least, _)| square < least) {
                        best = Some((square, point));
                    }
                }
            }
        }
        best.map_or([0.0; 3], |(_, point)| point)
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    places.map(|(x, y)| field.at(x as usize, y as usize).unwrap_or_else(|| look(x, y))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::test_images::{bump, pillow};
    use super::*;

    #[test]
    fn an_even_warp_to_half_the_side_averages_what_lands_together() {
        let image = bump(9, 9, 0.0);
        let half = |at: usize| at as f64 / 2.0;
        let warp = Warp { x: Field::from_fn(9, 9, |x, _| half(x)), y: Field::from_fn(9, 9, |_, y| half(y)) };
        let points = average(&image, &warp, 5, 5);
        // Columns 0.5 and 1.5 go to 0 and 2: target column 1 has source column 2 alone, 2 has 3, 4 and 5.
        assert_eq!(points[5 * 2 + 1][0], 2.0 / 8.0);
        assert!((points[5 * 2 + 2][0] - 4.0 / 8.0).abs() < 1e-12);
    }

    #[test]
    fn what_nothing_lands_on_takes_the_nearest_point() {
        let brute = |field: &Field<Option<[f64; 3]>>, x: usize, y: usize| {
            let squares = (0..field.height).flat_map(|v| (0..field.width).map(move |u| (u, v)));
            let known = squares.filter(|&(u, v)| field.at(u, v).is_some());
            known.map(|(u, v)| u.abs_diff(x).pow(2) + v.abs_diff(y).pow(2)).min()
        };
        let field = Field::from_fn(13, 9, |x, y| (x * 7 + y * 5).is_multiple_of(11).then_some([x as f64, y as f64, 0.0]));
        for (p, point) in nearest(&field).iter().enumerate() {
            let (x, y) = (p % 13, p / 13);
            let square = (point[0] - x as f64).powi(2) + (point[1] - y as f64).powi(2);
            assert_eq!(Some(square as usize), brute(&field, x, y));
        }
    }

    #[test]
    fn a_glued_border_stays_glued() {
        let image = pillow(31, 21);
        let (points, _) = direct(&image, (11, 13), 0.5, Energy::Robust, 0.1, &Task::default()).unwrap();
        let welded = GeometryImage::new(11, 13, Gluing::Orbifold, points.clone()).unwrap();
        assert_eq!(welded.points(), points);
    }
}
