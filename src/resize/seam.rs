//! Seam carving (paper 004's SC: Avidan and Shamir, 2007): the cheapest connected path of samples is taken out, again
//! and again, across the columns and across the rows in turn. To enlarge, the cheapest paths are doubled instead.
//!
//! The first and the last line are never touched. On an orbifold two paths are taken at a time, one in each half,
//! whose ends mirror each other: so the border stays glued and the cones stay at its middles.
//!
//! A baseline. Every path costs a look at all samples, so the whole costs O(samples · lines taken out).

use std::ops::Range;

use super::field::Field;
use super::saliency::{Energy, saliency};
use crate::error::{Error, Result};
use crate::plane::{GeometryImage, Gluing};
use crate::task::Task;

/// Carves an image to `width` × `height`.
pub(crate) fn carve(
    image: &GeometryImage,
    (width, height): (usize, usize),
    alpha: f64,
    energy: Energy,
    task: &Task<'_>,
) -> Result<Vec<[f64; 3]>> {
    let mut carving = Carving { image: image.clone(), alpha, energy };
    let away = |now: &GeometryImage| now.width().abs_diff(width) + now.height().abs_diff(height);
    let all = away(image).max(1);
    while away(&carving.image) > 0 {
        task.step(1.0 - away(&carving.image) as f64 / all as f64)?;
        carving.columns(width)?;
        carving.image = turned(&carving.image)?;
        carving.columns(height)?;
        carving.image = turned(&carving.image)?;
    }
    Ok(carving.image.points().to_vec())
}

/// Rows as columns.
fn turned(image: &GeometryImage) -> Result<GeometryImage> {
    let points = Field::new(image.width(), image.height(), image.points().to_vec()).transposed();
    GeometryImage::new(points.width, points.height, image.gluing(), points.values)
}

struct Carving {
    image: GeometryImage,
    alpha: f64,
    energy: Energy,
}

impl Carving {
    /// Brings the columns nearer to `target`: one path less, or up to a fifth more.
    fn columns(&mut self, target: usize) -> Result<()> {
        let width = self.image.width();
        if target < width {
            let paths = self.paths()?;
            self.image = without(&self.image, &paths)?;
        } else if target > width {
            // The cheapest paths of all are found by taking them out of a copy, which remembers the columns.
            let paths_a_time = if self.image.gluing() == Gluing::Orbifold { 2 } else { 1 };
            let most = ((width / 5).max(paths_a_time)).min(target - width).min((width - 2) / 2 * paths_a_time / 2 + 1);
            let mut copy = Self { image: self.image.clone(), ..*self };
            let mut columns = Field::from_fn(width, self.image.height(), |x, _| x);
            let mut doubled = Field::from_fn(width, self.image.height(), |_, _| false);
            let mut found = 0;
            while found + paths_a_time <= most.max(paths_a_time) {
                let paths = copy.paths()?;
                for path in &paths {
                    for (y, &x) in path.iter().enumerate() {
                        doubled.values[y * width + columns.at(x, y)] = true;
                    }
                }
                columns = remove(&columns, &paths);
                copy.image = without(&copy.image, &paths)?;
                found += paths_a_time;
            }
            self.image = widened(&self.image, &doubled, found)?;
        }
        Ok(())
    }

    /// The cheapest path from the first row to the last; two that mirror each other's ends on an orbifold.
    fn paths(&self) -> Result<Vec<Vec<usize>>> {
        let energy = saliency(&self.image, self.alpha, self.energy);
        let (last, middle) = (self.image.width() - 1, self.image.width() / 2);
        let stuck = || Error::Parameter(format!("no seam is left to take out of {} columns", last + 1));
        if self.image.gluing() == Gluing::Open {
            return Ok(vec![cheapest(&energy, 1..last, None).ok_or_else(stuck)?.0]);
        }
        let halves = [1..middle, middle + 1..last];
        let pair = |first: usize| {
            let (path, cost) = cheapest(&energy, halves[first].clone(), None)?;
            let ends = (last - path[0], last - path[path.len() - 1]);
            let (mirrored, more) = cheapest(&energy, halves[1 - first].clone(), Some(ends))?;
            Some((vec![path, mirrored], cost + more))
        };
        match (pair(0), pair(1)) {
            (Some(left), Some(right)) => Ok(if left.1 <= right.1 { left.0 } else { right.0 }),
            _ => Err(stuck()),
        }
    }
}

/// The path of least energy within some columns, from any sample of the first row to any of the last, or between
/// given ones; and its energy.
fn cheapest(energy: &Field<f64>, columns: Range<usize>, ends: Option<(usize, usize)>) -> Option<(Vec<usize>, f64)> {
    if columns.is_empty() {
        return None;
    }
    let (width, height) = (energy.width, energy.height);
    let near = |x: usize| x.saturating_sub(1).max(columns.start)..(x + 2).min(columns.end);
    let mut sums = vec![f64::INFINITY; width * height];
    for x in columns.clone().filter(|&x| ends.is_none_or(|(first, _)| first == x)) {
        sums[x] = energy.values[x];
    }
    for y in 1..height {
        for x in columns.clone() {
            let before = near(x).map(|b| sums[(y - 1) * width + b]).fold(f64::INFINITY, f64::min);
            sums[y * width + x] = before + energy.at(x, y);
        }
    }
    let at = |x: usize, y: usize| sums[y * width + x];
    let least = |y: usize, range: Range<usize>| range.min_by(|&a, &b| at(a, y).total_cmp(&at(b, y)));
    let mut x = match ends {
        Some((_, last)) => last,
        None => least(height - 1, columns.clone())?,
    };
    let cost = at(x, height - 1);
    let mut path = vec![x; height];
    for y in (0..height - 1).rev() {
        x = least(y, near(x))?;
        path[y] = x;
    }
    cost.is_finite().then_some((path, cost))
}

/// A field without the samples of paths that do not meet.
fn remove<T: Copy>(field: &Field<T>, paths: &[Vec<usize>]) -> Field<T> {
    let mut values = Vec::with_capacity(field.values.len());
    for y in 0..field.height {
        let row = field.row(y).iter().enumerate();
        values.extend(row.filter(|(x, _)| paths.iter().all(|path| path[y] != *x)).map(|(_, v)| *v));
    }
    Field::new(field.width - paths.len(), field.height, values)
}

fn without(image: &GeometryImage, paths: &[Vec<usize>]) -> Result<GeometryImage> {
    let points = remove(&Field::new(image.width(), image.height(), image.points().to_vec()), paths);
    GeometryImage::new(points.width, points.height, image.gluing(), points.values)
}

/// Adds a sample beside every one that is doubled, halfway towards the middle of the image.
fn widened(image: &GeometryImage, doubled: &Field<bool>, by: usize) -> Result<GeometryImage> {
    let (width, height) = (image.width(), image.height());
    let mut points = Vec::with_capacity((width + by) * height);
    for y in 0..height {
        for x in 0..width {
            let point = image.point(y, x);
            let half = |other: usize| [0, 1, 2].map(|i| (point[i] + image.point(y, other)[i]) / 2.0);
            match (doubled.at(x, y), 2 * x < width) {
                (false, _) => points.push(point),
                (true, true) => points.extend([point, half(x + 1)]),
                (true, false) => points.extend([half(x - 1), point]),
            }
        }
    }
    GeometryImage::new(width + by, height, image.gluing(), points)
}

#[cfg(test)]
mod tests {
    use super::super::test_images::{bump, pillow, rough};
    use super::*;

    /// All paths, one by one.
    fn brute(energy: &Field<f64>, columns: &Range<usize>, ends: Option<(usize, usize)>) -> f64 {
        fn go(energy: &Field<f64>, columns: &Range<usize>, x: usize, y: usize, last: Option<usize>) -> f64 {
            if y == energy.height - 1 {
                return if last.is_none_or(|last| last == x) { energy.at(x, y) } else { f64::INFINITY };
            }
            let next = (x.saturating_sub(1)..=x + 1).filter(|x| columns.contains(x));
            energy.at(x, y) + next.map(|x| go(energy, columns, x, y + 1, last)).fold(f64::INFINITY, f64::min)
        }
        let starts = columns.clone().filter(|&x| ends.is_none_or(|(first, _)| first == x));
        starts.map(|x| go(energy, columns, x, 0, ends.map(|e| e.1))).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_cheapest_path_is_the_cheapest_of_all_paths() {
        for seed in 0..30_usize {
            let (width, height) = (5 + seed % 4, 3 + seed % 5);
            let energy = Field::from_fn(width, height, |x, y| ((x * 31 + y * 17 + seed * 7) * 2_654_435 % 1009) as f64);
            for columns in [1..width - 1, 0..width, 2..width - 1] {
                for ends in [None, Some((columns.start, columns.end - 1)), Some((columns.end - 1, columns.end - 1))] {
                    let expected = brute(&energy, &columns, ends);
                    let Some((path, cost)) = cheapest(&energy, columns.clone(), ends) else {
                        assert!(expected.is_infinite());
                        continue;
                    };
                    assert_eq!(cost, expected);
                    assert_eq!(path.iter().enumerate().map(|(y, &x)| energy.at(x, y)).sum::<f64>(), cost);
                    assert!(path.windows(2).all(|p| p[0].abs_diff(p[1]) <= 1) && path.iter().all(|x| columns.contains(x)));
                    assert!(ends.is_none_or(|(a, b)| path[0] == a && path[height - 1] == b));
                }
            }
        }
    }

    #[test]
    fn only_given_points_remain_and_the_border_keeps_its_order() {
        let image = bump(24, 19, 0.4);
        let carved = carve(&image, (11, 9), 0.5, Energy::Robust, &Task::default()).unwrap();
        assert!(carved.iter().all(|p| image.points().contains(p)));
        for y in 0..9 {
            assert_eq!((carved[y * 11][0], carved[y * 11 + 10][0]), (0.0, 1.0));
        }
        for x in 0..11 {
            assert_eq!((carved[x][1], carved[8 * 11 + x][1]), (0.0, 1.0));
        }
        assert!((0..10).all(|x| carved[x][0] < carved[x + 1][0]), "the first row in order");
    }

    #[test]
    fn an_orbifold_stays_glued_with_its_cones_in_the_middle() {
        for image in [pillow(21, 17), rough(15, 15, Gluing::Orbifold)] {
            let (w, h) = (image.width(), image.height());
            let points = carve(&image, (9, 11), 0.5, Energy::Robust, &Task::default()).unwrap();
            let carved = GeometryImage::new(9, 11, Gluing::Orbifold, points.clone()).unwrap();
            assert_eq!(carved.points(), points, "gluing changed a point");
            assert_eq!(carved.point(0, 4), image.point(0, w / 2));
            assert_eq!(carved.point(5, 8), image.point(h / 2, w - 1));
        }
    }

    #[test]
    fn an_image_grows_by_doubled_paths_and_keeps_all_its_points() {
        for (image, size) in [(bump(9, 8, 0.3), (14, 17)), (pillow(9, 7), (15, 11)), (pillow(5, 5), (11, 5))] {
            let points = carve(&image, size, 0.5, Energy::Robust, &Task::default()).unwrap();
            assert_eq!(points.len(), size.0 * size.1);
            assert!(image.points().iter().all(|p| points.contains(p)));
            let grown = GeometryImage::new(size.0, size.1, image.gluing(), points.clone()).unwrap();
            assert_eq!(grown.points(), points);
        }
    }
}
