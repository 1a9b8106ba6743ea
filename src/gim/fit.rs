//! Least squares along normals: every sample of an image moves along its own normal until the mean distance is least.
//!
//! Between the image's surface and the original, distances are measured at points of both: from points of the original to
//! the image's nearest triangle, and from the image's vertices and triangles' centres back. How far each vertex goes, `h`, solves
//!
//! ```text
//! min Σ w (Σ_k b_k (N_k · n) h_k − n · (p − foot))²  +  μ |h|²  +  λ |second differences of h|²
//! ```
//!
//! with `b` the barycentric weights of the foot, `N` the normals of the image's vertices and `n` that of the original. Nothing slides,
//! so what a parametrisation has done well is kept. One or two rounds are enough.

use glam::DVec3;

use super::spread::{Sample, spread};
use crate::error::Result;
use crate::geom::{Bvh, Triangle};
use crate::par;
use crate::plane::GeometryImage;
use crate::sparse::{Conjugate, NOWHERE, Pattern, conjugate_gradients};
use crate::task::Task;

/// Points that one piece of work looks up, one after the other.
const CHUNK: usize = 4096;

/// What distances from the image weigh beside those from the original.
const BACKWARD: f64 = 0.5;

/// How much the heights are held back.
#[derive(Debug, Clone, Copy)]
pub(super) struct Damping {
    /// μ: all of them.
    pub(super) size: f64,
    /// λ: their second differences.
    pub(super) bend: f64,
}

impl Damping {
    /// For images that are to be near.
    pub(super) const NEAR: Self = Self { size: 1e-3, bend: 1e-5 };
    /// For images that are to cost little.
    pub(super) const CHEAP: Self = Self { size: 1e-2, bend: 1e-4 };
}

/// The surface that images are drawn to, in the frame of its map.
pub(super) struct Target {
    tree: Bvh,
}

/// One row of the least squares: over the corners of the image's triangle, or its first corner alone.
#[derive(Clone, Copy)]
struct Equation {
    triangle: u32,
    coefficients: [f64; 3],
    weight: f64,
    right: f64,
}

impl Target {
    pub(super) fn new(triangles: &[Triangle]) -> Self {
        Self { tree: Bvh::new(triangles) }
    }

    /// The closest point, and the unit normal there.
    pub(super) fn foot(&self, p: DVec3, hint: &mut u32) -> (DVec3, DVec3) {
        let Some(hit) = self.tree.closest(p, *hint) else { return (p, DVec3::ZERO) };
        *hint = hit.slot;
        (self.tree.on(hit.slot, p).point, normal(self.tree.triangles()[hit.slot as usize]).normalize_or_zero())
    }

    /// Points of the surface for an image of so many samples.
    pub(super) fn samples(&self, pixels: usize) -> Vec<Sample> {
        spread(self.tree.triangles(), (5 * pixels).max(150_000))
    }

    /// One round: `image` is in the same frame.
    pub(super) fn fit(
        &self,
        image: &GeometryImage,
        samples: &[Sample],
        damping: Damping,
        task: &Task<'_>,
    ) -> Result<GeometryImage> {
        let triangles = image.triangles();
        let points: Vec<DVec3> = image.points().iter().map(|&p| p.into()).collect();
        let corners = |t: [u32; 3]| t.map(|v| points[v as usize]);
        let normals = vertex_normals(&points, &triangles);
        let representatives = image.representatives();
        let heights = Heights::new(&representatives, &triangles);

        let tree = Bvh::new(&triangles.iter().map(|&t| corners(t)).collect::<Vec<_>>());
        task.step(0.2)?;
        let forward = forward(&tree, samples, &triangles, &normals, task);
        task.step(0.5)?;
        let (vertices, centres) = self.backward(&points, &triangles, &normals, &heights, task);
        task.step(0.8)?;

        // Sums over the equations, all scaled to the number of the original's points.
        let per = samples.len() as f64 / heights.count as f64;
        let share = BACKWARD * samples.len() as f64 / (vertices.len() + centres.len()).max(1) as f64;
        let mut system = System::new(&heights);
        forward.iter().for_each(|e| system.add(e, 1.0));
        centres.iter().for_each(|e| system.add(e, share));
        vertices.iter().for_each(|&(unknown, c, r)| system.add_one(unknown, c, r, share));
        let h = system.solve(damping.size * per, damping.bend * per, image.width(), &representatives);

        let at = |p: usize| {
            let r = representatives[p] as usize;
            (points[r] + normals[r] * h[heights.unknown[r] as usize]).to_array()
        };
        image.with_points((0..points.len()).map(at).collect())
    }

    /// From the image's vertices (unknown, coefficient, right side) and its triangles' centres to the surface.
    fn backward(
        &self,
        points: &[DVec3],
        triangles: &[[u32; 3]],
        normals: &[DVec3],
        heights: &Heights,
        task: &Task<'_>,
    ) -> (Vec<(u32, f64, f64)>, Vec<Equation>) {
        let used: Vec<u32> = (0..points.len() as u32).filter(|&v| heights.unknown[v as usize] != NOWHERE).collect();
        let vertices = chunks(used.len(), task, |i, hint| {
            let v = used[i] as usize;
            let (foot, n) = self.foot(points[v], hint);
            (heights.unknown[v], normals[v].dot(n), n.dot(foot - points[v]))
        });
        let centres = chunks(triangles.len(), task, |i, hint| {
            let [a, b, c] = triangles[i].map(|v| v as usize);
            let centre = (points[a] + points[b] + points[c]) / 3.0;
            let (foot, n) = self.foot(centre, hint);
            let coefficients = [a, b, c].map(|v| normals[v].dot(n) / 3.0);
            Equation { triangle: i as u32, coefficients, weight: 1.0, right: n.dot(foot - centre) }
        });
        (vertices, centres)
    }
}

/// From points of the original to the image.
fn forward(tree: &Bvh, samples: &[Sample], triangles: &[[u32; 3]], normals: &[DVec3], task: &Task<'_>) -> Vec<Equation> {
    let mut found = chunks(samples.len(), task, |i, hint| {
        let Sample { point, normal: n } = samples[i];
        let Some(hit) = tree.closest(point, *hint) else {
            return (0.0, Equation { triangle: 0, coefficients: [0.0; 3], weight: 0.0, right: 0.0 });
        };
        *hint = hit.slot;
        let solid = tree.triangles()[hit.slot as usize];
        let foot = tree.on(hit.slot, point).point;
        let b = barycentric(foot, solid);
        let triangle = tree.id(hit.slot);
        let t = triangles[triangle as usize];
        let coefficients = [0, 1, 2].map(|k| b[k] * normals[t[k] as usize].dot(n));
        let weight = normal(solid).normalize_or_zero().dot(n).max(0.0);
        (hit.distance2.sqrt(), Equation { triangle, coefficients, weight, right: n.dot(point - foot) })
    });
    // Points that are far off may have found a part of the image that is not theirs.
    let mut distances: Vec<f64> = found.iter().map(|f| f.0).collect();
    if !distances.is_empty() {
        let middle = distances.len() / 2;
        let usual = 6.0 * *distances.select_nth_unstable_by(middle, f64::total_cmp).1 + 1e-12;
        found.iter_mut().filter(|f| f.0 > usual).for_each(|f| f.1.weight *= 0.3);
    }
    found.into_iter().map(|f| f.1).collect()
}

/// `f(0, hint), f(1, hint), …` in chunks, each with a hint of its own.
pub(super) fn chunks<T: Send>(n: usize, task: &Task<'_>, f: impl Fn(usize, &mut u32) -> T + Sync + Send) -> Vec<T> {
    let parts = par::map(n.div_ceil(CHUNK), |chunk| {
        let mut hint = 0;
        let end = if task.is_over() { chunk * CHUNK } else { n.min((chunk + 1) * CHUNK) };
        (chunk * CHUNK..end).map(|i| f(i, &mut hint)).collect::<Vec<_>>()
    });
    parts.into_iter().flatten().collect()
}

fn normal([a, b, c]: Triangle) -> DVec3 {
    (b - a).cross(c - a)
}

/// The weights of the corners that give a point of the triangle.
pub(super) fn barycentric(p: DVec3, [a, b, c]: Triangle) -> [f64; 3] {
    let (u, v, q) = (b - a, c - a, p - a);
    let (uu, uv, vv, qu, qv) = (u.dot(u), u.dot(v), v.dot(v), q.dot(u), q.dot(v));
    let det = uu * vv - uv * uv;
    if det > 1e-24 * uu * vv {
        let (s, t) = (((vv * qu - uv * qv) / det).clamp(0.0, 1.0), ((uu * qv - uv * qu) / det).clamp(0.0, 1.0));
        return [(1.0 - s - t).max(0.0), s, t];
    }
    // Without area: along the longest side.
    let sides = [(uu, 0, 1, q.dot(u)), (vv, 0, 2, q.dot(v)), ((c - b).length_squared(), 1, 2, (p - b).dot(c - b))];
    let (length2, from, to, along) = sides.into_iter().fold(sides[0], |best, s| if s.0 > best.0 { s } else { best });
    let t = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
    let mut weights = [0.0; 3];
    (weights[from], weights[to]) = (1.0 - t, t);
    weights
}

/// Unit normals of the vertices: the mean of the triangles around each, by area.
fn vertex_normals(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; points.len()];
    for t in triangles {
        let n = normal(t.map(|v| points[v as usize]));
        t.iter().for_each(|&v| sums[v as usize] += n);
    }
    sums.into_iter().map(DVec3::normalize_or_zero).collect()
}

/// The unknowns: one for each representative.
struct Heights {
    unknown: Vec<u32>,
    count: usize,
    pattern: Pattern,
    /// For each triangle the slots of its six entries.
    slots: Vec<u32>,
    /// The unknowns of each triangle.
    triangles: Vec<[u32; 3]>,
}

/// The entries of a triangle's part of the matrix.
const ENTRIES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 0), (2, 0), (2, 1)];

impl Heights {
    fn new(representatives: &[u32], triangles: &[[u32; 3]]) -> Self {
        let mut unknown = vec![NOWHERE; representatives.len()];
        let mut count = 0;
        for (p, &r) in representatives.iter().enumerate() {
            if r as usize == p {
                unknown[p] = count;
                count += 1;
            }
        }
        let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| unknown[v as usize])).collect();
        let entry = |t: &[u32; 3], (i, j): (usize, usize)| (t[i].max(t[j]), t[i].min(t[j]));
        let pairs: Vec<_> = triangles.iter().flat_map(|t| ENTRIES.map(|e| entry(t, e))).collect();
        let (pattern, slots) = Pattern::new(count as usize, &pairs);
        Self { unknown, count: count as usize, pattern, slots, triangles }
    }
}

/// The normal equations.
struct System<'a> {
    heights: &'a Heights,
    values: Vec<f64>,
    diagonal: Vec<f64>,
    right: Vec<f64>,
}

impl<'a> System<'a> {
    fn new(heights: &'a Heights) -> Self {
        let zeros = vec![0.0; heights.count];
        Self { heights, values: vec![0.0; heights.pattern.len()], diagonal: zeros.clone(), right: zeros }
    }

    fn add(&mut self, e: &Equation, share: f64) {
        let weight = e.weight * share;
        let t = self.heights.triangles[e.triangle as usize];
        for (i, (a, b)) in ENTRIES.into_iter().enumerate() {
            let slot = self.heights.slots[6 * e.triangle as usize + i] as usize;
            self.values[slot] += weight * e.coefficients[a] * e.coefficients[b];
        }
        for k in 0..3 {
            self.right[t[k] as usize] += weight * e.coefficients[k] * e.right;
        }
    }

    fn add_one(&mut self, unknown: u32, coefficient: f64, right: f64, weight: f64) {
        self.diagonal[unknown as usize] += weight * coefficient * coefficient;
        self.right[unknown as usize] += weight * coefficient * right;
    }

    fn solve(&self, size: f64, bend: f64, width: usize, representatives: &[u32]) -> Vec<f64> {
        let unknown: Vec<u32> = representatives.iter().map(|&r| self.heights.unknown[r as usize]).collect();
        let pattern = &self.heights.pattern;
        let extra: Vec<f64> = self.diagonal.iter().map(|d| d + size).collect();
        // Two second differences of weights 1, −2, 1 through each sample and four mixed ones: 12 + 4 on the diagonal.
        let diagonal: Vec<f64> = pattern.diagonal(&self.values).iter().zip(&extra).map(|(d, e)| d + e + 16.0 * bend).collect();
        let times = |x: &[f64]| {
            let mut y = pattern.times(&self.values, x, true);
            for i in 0..y.len() {
                y[i] += extra[i] * x[i];
            }
            add_bending(&mut y, x, bend, width, &unknown);
            y
        };
        conjugate_gradients(&self.right, &diagonal, Conjugate { tolerance: 1e-4, steps: 60 }, times)
    }
}

/// Adds `weight · LᵀL x`, `L` the second differences along rows and columns and the mixed ones.
fn add_bending(y: &mut [f64], x: &[f64], weight: f64, width: usize, unknown: &[u32]) {
    let height = unknown.len() / width;
    let id = |row: usize, column: usize| unknown[row * width + column] as usize;
    let mut add = |at: &[usize], factors: &[f64]| {
        let d = weight * at.iter().zip(factors).map(|(&i, f)| f * x[i]).sum::<f64>();
        at.iter().zip(factors).for_each(|(&i, f)| y[i] += f * d);
    };
    for row in 0..height {
        for column in 0..width {
            if column + 2 < width {
                add(&[id(row, column), id(row, column + 1), id(row, column + 2)], &[1.0, -2.0, 1.0]);
            }
            if row + 2 < height {
                add(&[id(row, column), id(row + 1, column), id(row + 2, column)], &[1.0, -2.0, 1.0]);
            }
            if row + 1 < height && column + 1 < width {
                let square = [id(row, column), id(row, column + 1), id(row + 1, column + 1), id(row + 1, column)];
                add(&square, &[1.0, -1.0, 1.0, -1.0]);
            }
        }
    }
}
