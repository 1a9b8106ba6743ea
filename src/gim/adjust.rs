//! Samples moved against the gradient of the Hausdorff distance (paper 000, section 3.3 and Algorithms 1 to 3; readings in
//! `spec/readings.md`).
//!
//! For every square of four samples two greatest distances are kept: from points of the original whose nearest part of the image is
//! there (D1), and from points of the square's two triangles to the original (D2). Where they peak, the corners that matter
//! move down the gradient of the squared distance by ρᵏ of it, for the first k with which the peak around falls, *whichever*
//! distance it is of: a move is taken only if the larger of both falls over all squares that it touches. Hence the whole never
//! gets worse. Peaks that are far from each other move at the same time.

use glam::DVec3;

use super::fit::{Target, barycentric, chunks};
use super::gradient;
use super::spread::spread;
use crate::error::Result;
use crate::geom::{Aabb, Bvh, PLACES, Triangle, distance2};
use crate::par;
use crate::plane::{GeometryImage, Mask};
use crate::task::Task;

/// A point of the original looks for its distance this many squares around its own.
const RADIUS: usize = 1;

/// Halvings of a step.
const HALVINGS: i32 = 14;

/// Points of the original for each square, beside its vertices and points of its edges.
const DENSITY: usize = 6;

/// Peaks down to this share of the greatest are lowered.
const LOWEST: f64 = 0.3;

/// Peaks that move in one pass are this many squares apart: none reads what another writes.
const APART: usize = 4 * RADIUS + 4;

/// Passes at most.
const PASSES: usize = 400;

/// Peaks that are tried at most, for each square of the image, and at least.
const TRIES: (usize, usize) = (1, 20_000);

/// A point of the original with the square that it looks around and its squared distance.
#[derive(Clone, Copy)]
struct Probe {
    point: DVec3,
    distance2: f64,
}

/// The squares of an image, its points, and what is known of their distances.
struct Squares<'a> {
    target: &'a Target,
    width: usize,
    height: usize,
    /// The sample that stands for each.
    of: Vec<u32>,
    /// The samples that each representative stands for, if more than itself.
    glued: Vec<Vec<u32>>,
    forced: Vec<Option<bool>>,
    /// Whether each square is no part of the surface.
    hole: Vec<bool>,
    /// Whether each square's distance to the original does not count.
    outside: Vec<bool>,
    points: Vec<DVec3>,
    /// Sorted by square; those of square `s` are `starts[s] .. starts[s + 1]`.
    probes: Vec<Probe>,
    starts: Vec<usize>,
    /// The squared distances of each square.
    from_original: Vec<f64>,
    from_image: Vec<f64>,
}

/// What a move of some samples touches.
struct Region {
    /// Squares that have one of them as a corner.
    touched: Vec<usize>,
    /// Squares whose probes may see those, the peak first, and the places in `window` of the squares that their probes look at.
    homes: Vec<(usize, Vec<u32>)>,
    window: Vec<usize>,
    /// The greatest squared distance of all of them.
    before: f64,
}

impl Region {
    fn new(squares: &Squares<'_>, square: usize, steps: &[(u32, DVec3)]) -> Self {
        let sorted = |mut list: Vec<usize>| {
            list.sort_unstable();
            list.dedup();
            list
        };
        let touched = squares.touching(steps);
        let mut homes = sorted(touched.iter().flat_map(|&s| squares.around(s, RADIUS)).collect());
        let parts = homes.iter().flat_map(|&s| squares.around(s, RADIUS)).filter(|&s| !squares.hole[s]);
        let window = sorted(parts.collect());
        // What stops a step is most often the peak itself.
        homes.sort_by_key(|&s| s != square);
        let before = homes.iter().map(|&s| squares.from_original[s]);
        let before = before.chain(touched.iter().map(|&s| squares.from_image[s])).fold(0.0, f64::max);
        let place = |s: usize| window.binary_search(&s).unwrap_or(0) as u32;
        // Its own square is the likeliest to be nearest, and spares a probe most of the others.
        let looks_at = |s: usize| {
            let around = std::iter::once(s).chain(squares.around(s, RADIUS).filter(move |&t| t != s));
            around.filter(|&s| !squares.hole[s]).map(place).collect()
        };
        let homes = homes.iter().map(|&s| (s, looks_at(s))).collect();
        Self { touched, homes, window, before }
    }
}

/// What moving some samples comes to.
struct Move {
    square: usize,
    points: Vec<(u32, DVec3)>,
    /// Squares whose probes have new distances, and these.
    probes: Vec<(usize, Vec<f64>)>,
    /// Squares with a new D2.
    squares: Vec<(usize, f64)>,
}

/// The image with its samples moved, in the frame of the target; only what is near the samples `inside` counts, if they are given.
pub(super) fn adjust(
    target: &Target,
    solids: &[Triangle],
    image: &GeometryImage,
    inside: Option<&Mask>,
    task: &Task<'_>,
) -> Result<GeometryImage> {
    let mut squares = Squares::new(target, solids, image, task)?;
    if let Some(inside) = inside {
        squares.look_only_at(inside);
    }
    let count = squares.from_image.len();
    let mut dead = vec![false; count];
    let mut share = 0.8;
    let mut tries = TRIES.1.max(TRIES.0 * count);
    for pass in 0..PASSES {
        task.step(pass as f64 / PASSES as f64)?;
        let worst = (0..count).map(|s| squares.peak(s)).fold(0.0, f64::max);
        let chosen = squares.choose(worst * share * share, &dead);
        tries = tries.saturating_sub(chosen.len());
        if tries == 0 {
            break;
        }
        let moves = par::map(chosen.len(), |i| (chosen[i], squares.lower(chosen[i])));
        let mut moved = false;
        for (square, found) in moves {
            match found {
                Some(found) => {
                    moved = true;
                    squares.take(found, &mut dead);
                }
                None => dead[square] = true,
            }
        }
        if !moved && chosen.is_empty() {
            share *= 0.8;
            if share < LOWEST {
                break;
            }
        }
    }
    let points = squares.of.iter().map(|&r| squares.points[r as usize].to_array()).collect();
    image.with_points(points)
}

impl<'a> Squares<'a> {
    fn new(target: &'a Target, solids: &[Triangle], image: &GeometryImage, task: &Task<'_>) -> Result<Self> {
        let (width, height) = (image.width(), image.height());
        let of = image.representatives();
        let mut glued = vec![Vec::new(); of.len()];
        for (p, &r) in of.iter().enumerate().filter(|(p, r)| *p != **r as usize) {
            glued[r as usize].push(p as u32);
        }
        let count = (width - 1) * (height - 1);
        let forced = (0..count).map(|s| image.forced_diagonal(s / (width - 1), s % (width - 1))).collect();
        let hole = (0..count).map(|s| image.is_hole(s / (width - 1), s % (width - 1))).collect();
        let points = image.points().iter().map(|&p| p.into()).collect();
        let mut squares = Self {
            target,
            width,
            height,
            of,
            glued,
            forced,
            hole,
            outside: vec![false; count],
            points,
            probes: Vec::new(),
            starts: vec![0; count + 1],
            from_original: vec![0.0; count],
            from_image: vec![0.0; count],
        };
        squares.set_probes(solids, task);
        squares.from_image =
            chunks(count, task, |s, hint| squares.square_to_original(s, |v| squares.points[v as usize], f64::INFINITY, hint));
        task.step(0.0)?;
        Ok(squares)
    }

    /// Finds for each point of the original the square that is nearest.
    fn set_probes(&mut self, solids: &[Triangle], task: &Task<'_>) {
        let count = self.from_image.len();
        let parts: Vec<usize> = (0..count).filter(|&s| !self.hole[s]).collect();
        let of_square = |&s: &usize| self.triangles(s, |v| self.points[v as usize]).map(|t| t.0);
        let triangles: Vec<Triangle> = parts.iter().flat_map(of_square).collect();
        let tree = Bvh::new(&triangles);
        let area: f64 = triangles.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum();
        let spacing = (area / count as f64).sqrt() / 3.0;
        let mut points: Vec<DVec3> = spread(solids, DENSITY * count).iter().map(|s| s.point).collect();
        for [a, b, c] in solids {
            points.push(*a);
            for (p, q) in [(*a, *b), (*b, *c), (*c, *a)] {
                // Each edge once: most are there from both sides, in opposite directions.
                if (p.x, p.y, p.z) < (q.x, q.y, q.z) {
                    let parts = ((p.distance(q) / spacing).ceil()).clamp(1.0, 200.0) as usize;
                    points.extend((1..parts).map(|i| p.lerp(q, i as f64 / parts as f64)));
                }
            }
        }
        let found = chunks(points.len(), task, |i, hint| {
            let hit = tree.closest(points[i], *hint);
            *hint = hit.map_or(0, |h| h.slot);
            hit.map_or((0, 0.0), |h| (parts[tree.id(h.slot) as usize / 2], h.distance2))
        });
        for &(s, _) in &found {
            self.starts[s + 1] += 1;
        }
        for s in 0..count {
            self.starts[s + 1] += self.starts[s];
        }
        let mut next = self.starts.clone();
        self.probes = vec![Probe { point: DVec3::ZERO, distance2: 0.0 }; found.len()];
        for (&(s, distance2), &point) in found.iter().zip(&points) {
            self.probes[next[s]] = Probe { point, distance2 };
            next[s] += 1;
            self.from_original[s] = self.from_original[s].max(distance2);
        }
    }

    /// Forgets all distances but those of squares that have a sample inside.
    fn look_only_at(&mut self, inside: &Mask) {
        let outside: Vec<bool> = (0..self.from_image.len())
            .map(|s| {
                let (row, column) = self.row_column(s);
                ![(0, 0), (0, 1), (1, 0), (1, 1)].iter().any(|(i, j)| inside.contains(row + i, column + j))
            })
            .collect();
        let (mut kept, mut starts) = (Vec::new(), vec![0]);
        for (s, &outside) in outside.iter().enumerate() {
            if outside {
                (self.from_original[s], self.from_image[s]) = (0.0, 0.0);
            } else {
                kept.extend_from_slice(&self.probes[self.starts[s]..self.starts[s + 1]]);
            }
            starts.push(kept.len());
        }
        (self.probes, self.starts, self.outside) = (kept, starts, outside);
    }

    fn row_column(&self, square: usize) -> (usize, usize) {
        (square / (self.width - 1), square % (self.width - 1))
    }

    /// The two triangles of a square with points from `at`, and their samples.
    fn triangles(&self, square: usize, at: impl Fn(u32) -> DVec3) -> [(Triangle, [u32; 3]); 2] {
        let (row, column) = self.row_column(square);
        let first = row * self.width + column;
        let [a, b, c, d] = [first, first + 1, first + self.width + 1, first + self.width].map(|p| self.of[p]);
        let [p, q, r, s] = [a, b, c, d].map(&at);
        let falling = self.forced[square].unwrap_or_else(|| p.distance_squared(r) <= q.distance_squared(s));
        if falling {
            [([p, s, r], [a, d, c]), ([p, r, q], [a, c, b])]
        } else {
            [([p, s, q], [a, d, b]), ([q, s, r], [b, d, c])]
        }
    }

    /// The squares within `radius` of a square.
    fn around(&self, square: usize, radius: usize) -> impl Iterator<Item = usize> + use<> {
        let (row, column) = self.row_column(square);
        let (rows, columns) = (self.height - 1, self.width - 1);
        let (first, last) = (column.saturating_sub(radius), (column + radius).min(columns - 1));
        (row.saturating_sub(radius)..=(row + radius).min(rows - 1))
            .flat_map(move |r| (first..=last).map(move |c| r * columns + c))
    }

    /// The squared distance from a probe of a square to the image, and the triangle that is nearest.
    fn probe(&self, square: usize, p: DVec3, at: &impl Fn(u32) -> DVec3) -> (f64, Triangle, [u32; 3]) {
        let mut best = (f64::INFINITY, [DVec3::ZERO; 3], [0; 3]);
        for s in self.around(square, RADIUS).filter(|&s| !self.hole[s]) {
            for (t, samples) in self.triangles(s, at) {
                let d = distance2(p, t);
                if d < best.0 {
                    best = (d, t, samples);
                }
            }
        }
        best
    }

    /// The greatest squared distance from a square's places to the original; may stop once it is `enough`.
    fn square_to_original(&self, square: usize, at: impl Fn(u32) -> DVec3, enough: f64, hint: &mut u32) -> f64 {
        let mut worst = 0.0_f64;
        if self.hole[square] || self.outside[square] {
            return worst;
        }
        for (t, _) in self.triangles(square, &at) {
            for w in PLACES {
                let p = t[0] * w[0] + t[1] * w[1] + t[2] * w[2];
                worst = worst.max(self.target.foot(p, hint).0.distance_squared(p));
                if worst >= enough {
                    return worst;
                }
            }
        }
        worst
    }

    /// The greater of a square's squared distances.
    fn peak(&self, square: usize) -> f64 {
        self.from_original[square].max(self.from_image[square])
    }

    /// Squares above `least` that are the greatest around, the greatest first, far from each other.
    fn choose(&self, least: f64, dead: &[bool]) -> Vec<usize> {
        let higher = |s: usize, t: usize| (self.peak(t), s) > (self.peak(s), t);
        let mut peaks: Vec<usize> = (0..dead.len())
            .filter(|&s| self.peak(s) > least && !dead[s])
            .filter(|&s| self.around(s, 2 * RADIUS + 2).all(|t| dead[t] || !higher(s, t)))
            .collect();
        peaks.sort_unstable_by(|&s, &t| self.peak(t).total_cmp(&self.peak(s)).then(s.cmp(&t)));
        let (mut taken, mut chosen) = (vec![false; dead.len()], Vec::new());
        let glued = self.glued.iter().any(|g| !g.is_empty());
        let mut at_border = false;
        for s in peaks {
            // What lies across a glued border is near too; there one at a time moves.
            let (row, column) = self.row_column(s);
            let border = row.min(self.height - 2 - row).min(column).min(self.width - 2 - column) < APART;
            if taken[s] || (glued && border && at_border) {
                continue;
            }
            at_border |= border;
            self.around(s, APART).for_each(|t| taken[t] = true);
            chosen.push(s);
        }
        chosen
    }

    /// Tries to lower a peak.
    fn lower(&self, square: usize) -> Option<Move> {
        let here = |v: u32| self.points[v as usize];
        let (samples, gradient) = if self.from_original[square] >= self.from_image[square] {
            let probes = &self.probes[self.starts[square]..self.starts[square + 1]];
            let worst = probes.iter().max_by(|a, b| a.distance2.total_cmp(&b.distance2))?;
            let (_, t, samples) = self.probe(square, worst.point, &here);
            let c = Bvh::new(&[t]).on(0, worst.point).point;
            (samples, gradient::of_triangle(worst.point, c, barycentric(c, t)))
        } else {
            let mut hint = 0;
            let mut worst = (-1.0, [0; 3], [DVec3::ZERO; 3]);
            for (t, samples) in self.triangles(square, here) {
                for alpha in PLACES {
                    let p = t[0] * alpha[0] + t[1] * alpha[1] + t[2] * alpha[2];
                    let c = self.target.foot(p, &mut hint).0;
                    if c.distance_squared(p) > worst.0 {
                        worst = (c.distance_squared(p), samples, gradient::of_point(p, c, alpha));
                    }
                }
            }
            (worst.1, worst.2)
        };
        let steps: Vec<(u32, DVec3)> = samples.into_iter().zip(gradient).filter(|(_, g)| g.length_squared() > 0.0).collect();
        if steps.is_empty() {
            return None;
        }
        let region = Region::new(self, square, &steps);
        (0..HALVINGS).find_map(|k| self.attempt(square, &steps, 0.5_f64.powi(k), &region))
    }

    /// All squares that have one of these samples as a corner.
    fn touching(&self, steps: &[(u32, DVec3)]) -> Vec<usize> {
        let mut touched = Vec::new();
        for (v, _) in steps {
            for &p in std::iter::once(v).chain(&self.glued[*v as usize]) {
                let (row, column) = (p as usize / self.width, p as usize % self.width);
                for r in row.saturating_sub(1)..=row.min(self.height - 2) {
                    touched.extend((column.saturating_sub(1)..=column.min(self.width - 2)).map(|c| r * (self.width - 1) + c));
                }
            }
        }
        touched.sort_unstable();
        touched.dedup();
        touched
    }

    /// The move by `share` of the gradient, if both distances stay below what the greater was.
    fn attempt(&self, square: usize, steps: &[(u32, DVec3)], share: f64, region: &Region) -> Option<Move> {
        let points: Vec<(u32, DVec3)> = steps.iter().map(|&(v, g)| (v, self.points[v as usize] - share * g)).collect();
        let at = |v: u32| points.iter().find(|p| p.0 == v).map_or(self.points[v as usize], |p| p.1);
        let window: Vec<([Triangle; 2], Aabb)> = region
            .window
            .iter()
            .map(|&s| self.triangles(s, at).map(|t| t.0))
            .map(|t| (t, Aabb::of(t.into_iter().flatten())))
            .collect();
        let mut probes = Vec::with_capacity(region.homes.len());
        for (s, looks_at) in &region.homes {
            let mut distances = Vec::with_capacity(self.starts[s + 1] - self.starts[*s]);
            for probe in &self.probes[self.starts[*s]..self.starts[s + 1]] {
                let mut d = f64::INFINITY;
                for &i in looks_at {
                    let (triangles, aabb) = &window[i as usize];
                    if aabb.distance2(probe.point) < d {
                        d = triangles.iter().map(|&t| distance2(probe.point, t)).fold(d, f64::min);
                    }
                }
                if d >= region.before {
                    return None;
                }
                distances.push(d);
            }
            probes.push((*s, distances));
        }
        let (mut squares, mut hint) = (Vec::with_capacity(region.touched.len()), 0);
        for &s in &region.touched {
            let d = self.square_to_original(s, at, region.before, &mut hint);
            if d >= region.before {
                return None;
            }
            squares.push((s, d));
        }
        Some(Move { square, points, probes, squares })
    }

    fn take(&mut self, found: Move, dead: &mut [bool]) {
        for (v, p) in found.points {
            self.points[v as usize] = p;
        }
        for (s, distances) in found.probes {
            self.from_original[s] = distances.iter().copied().fold(0.0, f64::max);
            for (probe, d) in self.probes[self.starts[s]..self.starts[s + 1]].iter_mut().zip(distances) {
                probe.distance2 = d;
            }
            self.around(s, RADIUS).for_each(|t| dead[t] = false);
        }
        for (s, d) in found.squares {
            self.from_image[s] = d;
        }
        self.around(found.square, 2 * RADIUS + 2).for_each(|t| dead[t] = false);
    }

    /// The greatest distance of all.
    #[cfg(test)]
    fn worst(&self) -> f64 {
        (0..self.from_image.len()).map(|s| self.peak(s)).fold(0.0, f64::max).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Gluing;

    /// A bumpy sheet as triangles, and an image of it with too few samples.
    fn sheet() -> (Vec<Triangle>, GeometryImage) {
        let height = |x: f64, y: f64| 0.2 * (7.0 * x).sin() * (5.0 * y + 0.3).cos();
        let at = |i: usize, j: usize, n: usize| {
            let (x, y) = (i as f64 / n as f64, j as f64 / n as f64);
            DVec3::new(x, y, height(x, y))
        };
        let mut triangles = Vec::new();
        for i in 0..40 {
            for j in 0..40 {
                let [a, b, c, d] = [at(i, j, 40), at(i + 1, j, 40), at(i + 1, j + 1, 40), at(i, j + 1, 40)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let points = (0..9 * 9).map(|p| at(p / 9, p % 9, 8).to_array()).collect();
        (triangles, GeometryImage::new(9, 9, Gluing::Open, points).unwrap())
    }

    #[test]
    fn the_greatest_distance_falls_and_never_rises() {
        let (triangles, image) = sheet();
        let target = Target::new(&triangles);
        let task = Task::default();
        let before = Squares::new(&target, &triangles, &image, &task).unwrap().worst();
        let adjusted = adjust(&target, &triangles, &image, None, &task).unwrap();
        let after = Squares::new(&target, &triangles, &adjusted, &task).unwrap().worst();
        assert!(after < 0.9 * before, "{before} to {after}");
        let again = adjust(&target, &triangles, &adjusted, None, &task).unwrap();
        assert!(Squares::new(&target, &triangles, &again, &task).unwrap().worst() <= after);
    }
}
