//! More samples in a region of interest (paper 000, section 4).
//!
//! Two ways. [`Closer::Lines`], ours: the grid's lines lie closer together where they cross the region, and farther apart elsewhere;
//! nothing can fold, and the rest of the surface loses evenly. [`Closer::Weights`], the paper's: the square is divided into the
//! region and four parts around it, and samples move to a mean of their neighbours that is weighed by part. As printed, distances
//! weigh too and the map folds within a few rounds (`spec/readings.md`); here a move that would fold is halved until it does not.

use glam::DVec2;

use super::interest::Interest;
use super::zhou::upright;
use crate::plane::{Gluing, Mask};

/// How samples come to be closer together in a region of interest.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Closer {
    /// The line that has most of the region is so many times as dense as one that has none; others in between.
    Lines(f64),
    /// The paper's: weights of the four parts around the region, from the one of most surplus samples to the one of fewest, then that
    /// of the region.
    Weights([f64; 5]),
}

impl Default for Closer {
    fn default() -> Self {
        Self::Lines(2.0)
    }
}

/// A region of interest as samplers see it.
#[derive(Clone, Copy)]
pub(crate) struct Focus<'a> {
    pub(crate) interest: &'a Interest,
    pub(crate) closer: Closer,
}

impl Closer {
    /// Draws points of the square together; `inside` says which samples of a regular grid are in the region, `vertices` where
    /// those of the surface lie.
    pub(super) fn draw(self, points: &mut [DVec2], inside: &Mask, gluing: Gluing, vertices: impl Fn() -> Vec<DVec2>) {
        if inside.count() == 0 {
            return;
        }
        match self {
            Closer::Lines(times) => {
                let [rows, columns] = lines(inside, gluing, times);
                points.iter_mut().for_each(|p| *p = DVec2::new(rows.at(p.x), columns.at(p.y)));
            }
            Closer::Weights(weights) => weigh(points, inside, &vertices(), weights),
        }
    }
}

/// A monotone map of the unit interval onto itself: where the line at `t` goes, for `t` in equal steps.
struct Lines(Vec<f64>);

impl Lines {
    /// With lines so dense in each of as many equal parts of the interval.
    fn of(density: &[f64]) -> Self {
        let total: f64 = density.iter().sum();
        let parts = density.len();
        let (mut part, mut before) = (0, 0.0);
        let at = |i: usize| {
            let wanted = total * i as f64 / parts as f64;
            while part + 1 < parts && before + density[part] < wanted {
                before += density[part];
                part += 1;
            }
            ((part as f64 + (wanted - before) / density[part]) / parts as f64).clamp(0.0, 1.0)
        };
        let mut places: Vec<f64> = (0..=parts).map(at).collect();
        places[parts] = 1.0;
        Self(places)
    }

    fn at(&self, t: f64) -> f64 {
        let parts = self.0.len() - 1;
        let place = t.clamp(0.0, 1.0) * parts as f64;
        let part = (place as usize).min(parts - 1);
        self.0[part] + (self.0[part + 1] - self.0[part]) * (place - part as f64)
    }
}

/// Densities change over so much of the square: details of all sizes stay as smooth as they were.
const BLEND: f64 = 0.1;

fn lines(inside: &Mask, gluing: Gluing, times: f64) -> [Lines; 2] {
    let (height, width) = (inside.shape().height(), inside.shape().width());
    let crossed = |n: usize, samples: &dyn Fn(usize) -> usize| {
        let met: Vec<usize> = (0..n).map(samples).collect();
        // Glued borders are halves that mirror each other.
        let met = |i: usize| if gluing == Gluing::Orbifold { met[i].max(met[n - 1 - i]) } else { met[i] };
        let most = (0..n).map(met).max().unwrap_or(0).max(1) as f64;
        let density = |i: usize| 1.0 + (times - 1.0) * met(i).max(met(i + 1)) as f64 / most;
        Lines::of(&blurred(&(0..n - 1).map(density).collect::<Vec<f64>>(), BLEND))
    };
    [
        crossed(height, &|row| (0..width).filter(|&column| inside.contains(row, column)).count()),
        crossed(width, &|column| (0..height).filter(|&row| inside.contains(row, column)).count()),
    ]
}

/// Means over a share of all values around each.
fn blurred(values: &[f64], share: f64) -> Vec<f64> {
    let reach = (0.5 * share * values.len() as f64).ceil() as usize;
    let sums: Vec<f64> = std::iter::once(0.0)
        .chain(values.iter().scan(0.0, |sum, v| {
            *sum += v;
            Some(*sum)
        }))
        .collect();
    let mean = |i: usize| {
        let (from, to) = (i.saturating_sub(reach), (i + reach + 1).min(values.len()));
        (sums[to] - sums[from]) / (to - from) as f64
    };
    (0..values.len()).map(mean).collect()
}

/// Rounds of the paper's motion of samples, and halvings of a move before it is dropped.
const ROUNDS: usize = 20;
const HALVINGS: i32 = 4;

/// Rows and columns, plus one, to the six neighbours of a sample: along the grid and one diagonal.
const AROUND: [(usize, usize); 6] = [(0, 1), (1, 0), (1, 2), (2, 1), (0, 0), (2, 2)];

/// The paper's motion of samples; those of the border stay.
fn weigh(points: &mut [DVec2], inside: &Mask, vertices: &[DVec2], weights: [f64; 5]) {
    let shape = inside.shape();
    let parts = Parts::around(inside);
    let count = |points: &[DVec2]| {
        let mut counts = [0_usize; 5];
        points.iter().for_each(|&p| counts[parts.of(p)] += 1);
        counts
    };
    // Where there are most samples beyond what vertices are due, the weight is least.
    let (samples, due) = (count(points), count(vertices));
    let surplus = |part: usize| {
        let ideal = due[part] as f64 / vertices.len().max(1) as f64 * points.len() as f64;
        samples[part] as f64 - ideal
    };
    let mut order = [0, 1, 2, 3];
    order.sort_by(|&a, &b| surplus(b).total_cmp(&surplus(a)));
    let mut of_part = [weights[4]; 5];
    order.into_iter().zip(weights).for_each(|(part, weight)| of_part[part] = weight);
    let (width, height) = (shape.width(), shape.height());
    for _ in 0..ROUNDS {
        for row in 1..height - 1 {
            for column in 1..width - 1 {
                let at = row * width + column;
                let here = points[at];
                let near = AROUND.map(|(r, c)| points[(row + r - 1) * width + column + c - 1]);
                let weighed = near.map(|p| (of_part[parts.of(p)] * here.distance(p), p));
                let total: f64 = weighed.iter().map(|(w, _)| w).sum();
                if !(total > 0.0) {
                    continue;
                }
                let goal = weighed.iter().map(|&(w, p)| w * p).sum::<DVec2>() / total;
                let moved = (0..HALVINGS).any(|halving| {
                    points[at] = here + (goal - here) * 0.5_f64.powi(halving);
                    upright(points, shape, row, column)
                });
                if !moved {
                    points[at] = here;
                }
            }
        }
    }
}

/// The region's box, and the four parts of the square around it: between the rays from its middle to the square's corners.
struct Parts {
    low: DVec2,
    high: DVec2,
}

impl Parts {
    fn around(inside: &Mask) -> Self {
        let shape = inside.shape();
        let (mut low, mut high) = (DVec2::ONE, DVec2::ZERO);
        for at in inside.iter().enumerate().filter(|(_, inside)| *inside).map(|(at, _)| at) {
            let p = DVec2::new(
                (at / shape.width()) as f64 / (shape.height() - 1) as f64,
                (at % shape.width()) as f64 / (shape.width() - 1) as f64,
            );
            (low, high) = (low.min(p), high.max(p));
        }
        Self { low, high }
    }

    /// 4 in the box; else 0 to 3 by the side of the square that is seen behind a point from the middle of the box.
    fn of(&self, p: DVec2) -> usize {
        if p.cmpge(self.low).all() && p.cmple(self.high).all() {
            return 4;
        }
        let middle = 0.5 * (self.low + self.high);
        let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let left_of = |k: usize| (corners[k % 4] - middle).perp_dot(p - middle) >= 0.0;
        (0..4).find(|&k| left_of(k) && !left_of(k + 1)).unwrap_or(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Shape;

    /// A regular grid, and the samples of it in a box.
    fn grid(side: usize, low: DVec2, high: DVec2) -> (Vec<DVec2>, Mask) {
        let at = |i: usize| DVec2::new((i / side) as f64, (i % side) as f64) / (side - 1) as f64;
        let points: Vec<DVec2> = (0..side * side).map(at).collect();
        let shape = Shape::new(side as u32, side as u32).unwrap();
        let inside = points.iter().map(|p| p.cmpge(low).all() && p.cmple(high).all());
        let mask = Mask::from_bits(shape, inside).unwrap();
        (points, mask)
    }

    fn inside(points: &[DVec2], mask: &Mask) -> usize {
        let parts = Parts::around(mask);
        points.iter().filter(|&&p| parts.of(p) == 4).count()
    }

    #[test]
    fn both_ways_gather_samples_in_the_region_and_no_square_turns_over() {
        let (regular, mask) = grid(33, DVec2::new(0.2, 0.5), DVec2::new(0.4, 0.8));
        for (closer, least) in
            [(Closer::Lines(2.0), 1.6), (Closer::Lines(4.0), 2.5), (Closer::Weights([1.0, 1.25, 1.5, 1.75, 20.0]), 1.5)]
        {
            for gluing in [Gluing::Open, Gluing::Orbifold] {
                let mut points = regular.clone();
                closer.draw(&mut points, &mask, gluing, || regular.clone());
                let share = inside(&points, &mask) as f64 / inside(&regular, &mask) as f64;
                // Glued halves share the density.
                let least = if gluing == Gluing::Open { least } else { 0.6 * least };
                assert!(share > least, "{closer:?} {gluing:?}: {share}");
                assert!((0..33).all(|i| (0..33).all(|j| upright(&points, mask.shape(), i, j))), "{closer:?}");
                let corners = [0, 32, 33 * 32, 33 * 33 - 1];
                assert!(corners.iter().all(|&c| points[c] == regular[c]));
            }
        }
    }

    #[test]
    fn lines_through_a_glued_border_stay_symmetric() {
        let (regular, mask) = grid(33, DVec2::new(0.0, 0.1), DVec2::new(0.1, 0.3));
        let mut points = regular.clone();
        Closer::Lines(3.0).draw(&mut points, &mask, Gluing::Orbifold, Vec::new);
        for i in 0..33 {
            assert!((points[i].y + points[32 - i].y - 1.0).abs() < 1e-12);
            assert!((points[33 * i].x + points[33 * (32 - i)].x - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn parts_are_seen_behind_the_sides_of_the_square() {
        let parts = Parts { low: DVec2::splat(0.4), high: DVec2::splat(0.6) };
        let places = [(0.5, 0.1), (0.9, 0.5), (0.5, 0.9), (0.1, 0.5), (0.5, 0.5)];
        let found = places.map(|(x, y)| parts.of(DVec2::new(x, y)));
        assert_eq!(found, [0, 1, 2, 3, 4]);
    }

    #[test]
    fn no_region_moves_no_sample() {
        let (regular, mask) = grid(9, DVec2::splat(2.0), DVec2::splat(3.0));
        let mut points = regular.clone();
        Closer::default().draw(&mut points, &mask, Gluing::Open, Vec::new);
        assert_eq!(points, regular);
    }
}
