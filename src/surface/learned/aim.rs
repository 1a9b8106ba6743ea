//! Where a writer lets a vertex slide to: near the original surface, and cheap.
//!
//! A candidate costs λ bits for its places, and the squared distance between the surfaces, as far as it depends on the vertex:
//! for each face of the original around it, with d the heights of its corners over that face's plane, A/6 (d₀² + d₁² + d₂² +
//! d₀d₁ + d₀d₂ + d₁d₂), the integral of the square of the height over the face. Neighbours that are coded stand where they were
//! coded, so that a vertex makes good what they missed; the others stand where they were.
//!
//! No face may turn by much, nor shrink to nothing, and no corner leave a plane by far.

use super::super::topology::{Surface, turn};
use super::frame::{Frame, PARTS};
use super::math::{exp, ln};
use super::vector::Vector;
use super::{Coder, Forecast, Scene};
use crate::mesh::half_edge::{next, prev};

/// What a writer of a surface whose vertices may slide wants. Lengths are in steps.
#[derive(Debug)]
pub(in crate::surface) struct Aim {
    /// Where each vertex of the closed surface was.
    points: Vec<Vector>,
    /// Of each face of the closed surface; without area for those of holes.
    faces: Vec<Face>,
    /// The mean of a third of the area around a vertex, halved.
    mean_weight: f64,
    /// How close each vertex is held, whatever it costs.
    holds: Vec<Hold>,
    /// What a bit is worth, in squared steps.
    lambda: f64,
    /// Corners stay this near to the planes of their faces.
    reach: f64,
    /// The longest slide, in lengths of the shortest edge.
    slide: f64,
}

/// How close a vertex is held to where it was.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Hold {
    /// As it pays.
    #[default]
    Free,
    /// As near to the planes of its faces as a place can be.
    Planes,
    /// At the nearest place.
    Point,
}

#[derive(Debug, Clone, Copy)]
struct Face {
    normal: Vector,
    area: f64,
}

/// The default of [`Aim::lambda`].
const LAMBDA: f64 = 0.05;
const SLIDE: f64 = 0.7;
/// What rounding may add to a slide: half the diagonal of a cube of steps.
const ROUNDING: f64 = 0.87;
/// The cosine by which a face may turn, and the share of its area that must be left.
const LEAST_COSINE: f64 = 0.35;
const LEAST_AREA: f64 = 0.1;
/// What an edge at a hole weighs, against a face of its length.
const EDGE_WEIGHT: f64 = 0.3;
/// What the squared distance from where it was weighs for a vertex that is held to planes.
const NEARNESS: f64 = 0.02;
/// Rounds of looking around the best candidate.
const ROUNDS: usize = 6;

impl Aim {
    /// To stay near `points` (of the vertices of the closed surface), with no corner farther than `reach` from the plane of a
    /// face if it can be.
    pub(in crate::surface) fn new(surface: &Surface, points: Vec<[f64; 3]>, holds: Vec<Hold>, reach: f64) -> Self {
        let points: Vec<Vector> = points.into_iter().map(Vector).collect();
        let faces = surface.triangles.iter().map(|t| {
            if t.iter().any(|&v| surface.is_hole[v as usize]) {
                return Face { normal: Vector::ZERO, area: 0.0 };
            }
            let [a, b, c] = t.map(|v| points[v as usize]);
            let normal = (b - a).cross(c - a);
            let size = normal.length();
            let normal = if size > 1e-12 { normal * (1.0 / size) } else { Vector::ZERO };
            Face { normal, area: 0.5 * size }
        });
        let faces: Vec<Face> = faces.collect();
        let vertices = surface.is_hole.iter().filter(|hole| !**hole).count().max(1);
        let area: f64 = faces.iter().map(|f| f.area).sum();
        let mean_weight = (0.5 * area / vertices as f64).max(1e-9);
        Self { points, faces, mean_weight, holds, lambda: LAMBDA, reach, slide: SLIDE }
    }

    /// How many faces of a surface, with its vertices at these positions, look away from where they looked.
    pub(in crate::surface) fn turned(&self, surface: &Surface, positions: &[[i32; 3]]) -> Vec<u32> {
        let at = |v: u32| Vector(positions[v as usize].map(|x| f64::from(x) / PARTS));
        let is_turned = |&f: &u32| {
            let [a, b, c] = surface.triangles[f as usize].map(at);
            let Face { normal, area } = self.faces[f as usize];
            area > 0.0 && (b - a).cross(c - a).dot(normal) <= 0.0
        };
        (0..self.faces.len() as u32).filter(is_turned).collect()
    }

    /// The faces, for sums over them: corners, normal and area of each with an area.
    pub(in crate::surface) fn each_face<'a>(
        &'a self,
        surface: &'a Surface,
    ) -> impl Iterator<Item = ([u32; 3], Vector, f64)> + 'a {
        let all = surface.triangles.iter().zip(&self.faces);
        all.filter(|(_, face)| face.area > 0.0).map(|(&t, face)| (t, face.normal, face.area))
    }

    /// Where a vertex was.
    pub(in crate::surface) fn point(&self, v: u32) -> Vector {
        self.points[v as usize]
    }
}

/// A plane that the vertex should stay near to.
struct Plane {
    normal: Vector,
    weight: f64,
    /// The heights of the other corners.
    others: f64,
}

/// A face around the vertex.
struct Corner {
    /// Where the two others are.
    ends: [Vector; 2],
    normal: Vector,
    area: f64,
}

/// All that matters to one vertex.
struct Local<'a> {
    here: Vector,
    planes: Vec<Plane>,
    fan: Vec<Corner>,
    shortest: f64,
    frame: &'a Frame,
    extent: [i32; 3],
    most: i64,
    hold: Hold,
    /// Squared distance to bits.
    scale: f64,
    lambda: f64,
    rates: Rates,
}

/// The best place so far, and what it costs.
struct Best {
    cost: f64,
    places: [i64; 3],
}

/// What candidates must keep.
#[derive(Clone, Copy)]
struct Bounds {
    reach: f64,
    slide: f64,
}

impl<const F: usize, const L: usize, const N: usize, const E: usize> Coder<'_, F, L, N, E> {
    /// The places that a writer takes.
    pub(super) fn offsets(&self, forecast: &Forecast, frame: &Frame, v: u32) -> [i64; 3] {
        let Some(aim) = self.sliding.and_then(|sliding| sliding.aim) else { return [0; 3] };
        let deviations = Self::deviations(forecast, frame);
        let mut local = Local::new(&self.scene, aim, frame, deviations, self.extent, self.values[0].last(), v);
        let cap = aim.slide * local.shortest + ROUNDING;
        let wanted = local.optimum(deviations, cap);
        let bounds = Bounds { reach: aim.reach, slide: cap };
        if local.hold == Hold::Free {
            let found = local.search(wanted, bounds, [2, 6], [2; 3]);
            if found.cost.is_finite() {
                return found.places;
            }
            // At an edge that the lattice does not follow: as near to its planes as can be.
            local.hold = Hold::Planes;
        }
        let held = local.search(local.here, Bounds { reach: f64::INFINITY, slide: 2.0 * cap }, [4, 3], [4, 4, 3]);
        if held.cost.is_finite() {
            return held.places;
        }
        local.hold = Hold::Free;
        // With less and less to keep.
        let loose = Bounds { slide: f64::INFINITY, ..bounds };
        for looser in [1.0, 2.0, 4.0] {
            let found = local.search(wanted, Bounds { reach: looser * aim.reach, ..loose }, [3, 8], [2; 3]);
            if found.cost.is_finite() {
                return found.places;
            }
        }
        local.least_harm()
    }
}

impl<'a> Local<'a> {
    fn new(scene: &Scene<'_>, aim: &Aim, frame: &'a Frame, deviations: [f64; 3], extent: [i32; 3], most: i64, v: u32) -> Self {
        let here = aim.points[v as usize];
        let surface = scene.surface;
        let place = |u: u32| if scene.order.is_known(u) { scene.at(u) } else { aim.points[u as usize] };
        let moved = |u: u32| place(u) - aim.points[u as usize];
        let is_hole = |f: u32| surface.triangles[f as usize].iter().any(|&u| surface.is_hole[u as usize]);
        let (mut planes, mut fan) = (Vec::with_capacity(8), Vec::with_capacity(8));
        let mut shortest = f64::MAX;
        let start = scene.outgoing[v as usize];
        let mut h = start;
        loop {
            let (a, b, f) = (surface.from(next(h)), surface.from(prev(h)), h / 3);
            if !is_hole(f) {
                let Face { normal, area } = aim.faces[f as usize];
                for u in [a, b] {
                    shortest = shortest.min((aim.points[u as usize] - here).length());
                }
                fan.push(Corner { ends: [place(a), place(b)], normal, area });
                planes.push(Plane { normal, weight: area / 6.0, others: normal.dot(moved(a) + moved(b)) });
                // An edge at a hole stays where it is: a plane through it, upright on the face.
                for (u, across) in [(a, surface.opposite[h as usize]), (b, surface.opposite[prev(h) as usize])] {
                    let along = aim.points[u as usize] - here;
                    let length = along.length();
                    if is_hole(across / 3) && length > 1e-9 {
                        let upright = normal.cross(along * (1.0 / length));
                        if upright.length() > 0.5 {
                            let others = upright.dot(moved(u));
                            planes.push(Plane { normal: upright, weight: EDGE_WEIGHT * length * length / 6.0, others });
                        }
                    }
                }
            }
            h = turn(&surface.opposite, h);
            if h == start {
                break;
            }
        }
        let hold = aim.holds.get(v as usize).copied().unwrap_or_default();
        Self {
            here,
            planes,
            fan,
            shortest: if shortest < f64::MAX { shortest } else { 0.0 },
            frame,
            extent,
            most,
            hold,
            scale: 1.0 / aim.mean_weight,
            lambda: aim.lambda,
            rates: Rates::new(deviations),
        }
    }

    fn point(&self, places: [i64; 3]) -> Vector {
        Vector(self.frame.position(places, self.extent).map(|x| f64::from(x) / PARTS))
    }

    fn nearest(&self, point: Vector) -> [i64; 3] {
        [0, 1, 2].map(|axis| ((self.frame.coordinate(point, axis) + 0.5).floor() as i64).clamp(-self.most, self.most))
    }

    /// The point of least cost, with bits as the logarithm of a normal density: a quadratic form. No farther than `cap`.
    fn optimum(&self, deviations: [f64; 3], cap: f64) -> Vector {
        let mut m = [[0.0; 4]; 3];
        for plane in &self.planes {
            let w = plane.weight * self.scale;
            for i in 0..3 {
                for j in 0..3 {
                    m[i][j] += w * plane.normal[i] * plane.normal[j];
                }
                m[i][3] -= 0.5 * w * plane.others * plane.normal[i];
            }
        }
        let to_centre = self.frame.centre - self.here;
        for axis in 0..3 {
            let size = deviations[axis] * self.frame.steps[axis];
            let w = self.lambda / (2.0 * std::f64::consts::LN_2 * size * size);
            let e = self.frame.axes[axis];
            let along = w * e.dot(to_centre);
            for i in 0..3 {
                for j in 0..3 {
                    m[i][j] += w * e[i] * e[j];
                }
                m[i][3] += along * e[i];
            }
        }
        for i in 0..3 {
            m[i][i] += 1e-6;
        }
        let slide = solve(m);
        let length = slide.length();
        if !(length <= 1e9) {
            self.here
        } else if length > cap {
            self.here + slide * (cap / length)
        } else {
            self.here + slide
        }
    }

    /// The best place near the point wanted, the centre, and the original; if none of them is allowed, in a box of these
    /// sides around the last. `first` are the sides of the first look around the best.
    fn search(&self, wanted: Vector, bounds: Bounds, [wide, high]: [i64; 2], first: [i64; 3]) -> Best {
        let mut best = Best { cost: f64::INFINITY, places: [0; 3] };
        let home = self.nearest(self.here);
        for places in [self.nearest(wanted), [0; 3], home] {
            self.try_place(&mut best, places, bounds);
        }
        if !best.cost.is_finite() {
            each_around(home, [wide, wide, high], |places| self.try_place(&mut best, places, bounds));
            if !best.cost.is_finite() {
                return best;
            }
        }
        for round in 0..ROUNDS {
            let centre = best.places;
            each_around(centre, if round == 0 { first } else { [1; 3] }, |places| self.try_place(&mut best, places, bounds));
            if best.places == centre {
                break;
            }
        }
        best
    }

    fn try_place(&self, best: &mut Best, places: [i64; 3], bounds: Bounds) {
        if places.iter().any(|p| p.abs() > self.most) {
            return;
        }
        let slide = self.point(places) - self.here;
        let far = slide.dot(slide);
        if far > bounds.slide * bounds.slide {
            return;
        }
        let (mut error, mut highest) = (0.0, 0.0_f64);
        for plane in &self.planes {
            let d = plane.normal.dot(slide);
            if d.abs() > bounds.reach {
                return;
            }
            error += plane.weight * d * (d + plane.others);
            highest = highest.max(d.abs());
        }
        let cost = match self.hold {
            Hold::Free => error * self.scale + self.lambda * self.rates.of(places),
            Hold::Planes => highest * highest + NEARNESS * far,
            Hold::Point => far,
        };
        if cost < best.cost && self.keeps_faces(self.here + slide) {
            *best = Best { cost, places };
        }
    }

    fn keeps_faces(&self, point: Vector) -> bool {
        self.fan.iter().all(|corner| {
            let normal = (corner.ends[0] - point).cross(corner.ends[1] - point);
            let size = normal.length();
            corner.area <= 1e-12 || normal.dot(corner.normal) >= LEAST_COSINE * size && size >= LEAST_AREA * 2.0 * corner.area
        })
    }

    /// Where no place keeps all faces: one near the original that turns the fewest.
    fn least_harm(&self) -> [i64; 3] {
        let home = self.nearest(self.here);
        let mut best = (usize::MAX, f64::INFINITY, home);
        each_around(home, [3, 3, 8], |places| {
            if places.iter().any(|p| p.abs() > self.most) {
                return;
            }
            let point = self.point(places);
            let is_turned = |c: &&Corner| (c.ends[0] - point).cross(c.ends[1] - point).dot(c.normal) <= 0.0;
            let turned = self.fan.iter().filter(is_turned).count();
            let far = (point - self.here).dot(point - self.here);
            if (turned, far) < (best.0, best.1) {
                best = (turned, far, places);
            }
        });
        best.2
    }
}

/// All places no farther than `sides` from `centre` on each axis.
fn each_around(centre: [i64; 3], sides: [i64; 3], mut f: impl FnMut([i64; 3])) {
    for x in -sides[0]..=sides[0] {
        for y in -sides[1]..=sides[1] {
            for z in -sides[2]..=sides[2] {
                f([centre[0] + x, centre[1] + y, centre[2] + z]);
            }
        }
    }
}

/// Solves three equations of a positive definite matrix.
fn solve(mut m: [[f64; 4]; 3]) -> Vector {
    for i in 0..3 {
        for r in (0..3).filter(|&r| r != i) {
            let factor = m[r][i] / m[i][i];
            for c in i..4 {
                m[r][c] -= factor * m[i][c];
            }
        }
    }
    Vector([0, 1, 2].map(|i| m[i][3] / m[i][i]))
}

/// The bits of a place on each axis, by logistic densities around 0.
struct Rates {
    bits: [[f64; Self::KEPT]; 3],
    widths: [f64; 3],
}

impl Rates {
    const KEPT: usize = 12;

    fn new(deviations: [f64; 3]) -> Self {
        let widths = deviations.map(|d| (d * super::density::SCALE).max(0.04));
        Self { bits: widths.map(|width| std::array::from_fn(|q| bits(q as f64, width))), widths }
    }

    fn of(&self, places: [i64; 3]) -> f64 {
        let mut sum = 0.0;
        for axis in 0..3 {
            let q = places[axis].unsigned_abs() as usize;
            sum += self.bits[axis].get(q).copied().unwrap_or_else(|| bits(q as f64, self.widths[axis]));
        }
        sum
    }
}

/// −log₂ of the chance of q ± ½, q not negative.
fn bits(q: f64, width: f64) -> f64 {
    // Both beyond the middle, where differences are small: 1 − F.
    let beyond = |x: f64| 1.0 / (1.0 + exp(x / width));
    let chance = beyond(q - 0.5) - beyond(q + 0.5);
    -ln(chance.max(1e-12)) * std::f64::consts::LOG2_E
}
