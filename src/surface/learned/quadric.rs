//! A quadric through the known vertices nearby: z = c₀ + c₁x + c₂y + c₃x² + c₄xy + c₅y² in a local frame,
//! least squares with weights that fall with the distance.

use super::super::topology::turn;
use super::Scene;
use super::ring::Ring;
use super::vector::Vector;

/// Vertices that a fit looks at, at most.
const POINTS: usize = 28;
/// Heights are kept within this many edge lengths: an extrapolation farther out means nothing.
const STEEPEST: f64 = 1.5;
/// Ridge on the linear terms, which the data always settle, and on the curvatures, which it may not.
const RIDGE: [f64; 6] = [1e-6, 1e-6, 1e-6, 0.02, 0.02, 0.02];

/// Collects points and solves; one for many vertices.
#[derive(Debug)]
pub(super) struct Fit {
    points: Vec<u32>,
    /// The last fit that took each vertex.
    taken: Vec<u32>,
    fits: u32,
    first: u32,
}

/// The coefficients c₀ … c₅.
pub(super) struct Quadric([f64; 6]);

impl Quadric {
    pub(super) fn height(&self, x: f64, y: f64) -> f64 {
        let c = &self.0;
        (c[0] + c[1] * x + c[2] * y + c[3] * x * x + c[4] * x * y + c[5] * y * y).clamp(-STEEPEST, STEEPEST)
    }

    pub(super) fn curvatures(&self) -> [f64; 2] {
        [self.0[3], self.0[5]]
    }
}

impl Fit {
    pub(super) fn new(range: &std::ops::Range<u32>) -> Self {
        Self { points: Vec::new(), taken: vec![0; range.len()], fits: 0, first: range.start }
    }

    /// The vertices collected last.
    pub(super) fn points(&self) -> &[u32] {
        &self.points
    }

    fn take(&mut self, scene: &Scene<'_>, v: u32) {
        if scene.order.is_known(v) {
            let taken = &mut self.taken[(v - self.first) as usize];
            if *taken != self.fits {
                *taken = self.fits;
                self.points.push(v);
            }
        }
    }

    /// Collects the known vertices near a vertex: its ring and the apexes of its gates, then theirs.
    pub(super) fn collect(&mut self, scene: &Scene<'_>, ring: &Ring) {
        self.fits += 1;
        self.points.clear();
        ring.known.iter().for_each(|&v| self.take(scene, v));
        ring.gates.iter().for_each(|g| self.take(scene, g.c));
        for i in 0..self.points.len() {
            if self.points.len() >= POINTS {
                break;
            }
            let start = scene.outgoing[self.points[i] as usize];
            let mut h = start;
            loop {
                self.take(scene, scene.surface.from(crate::mesh::half_edge::next(h)));
                h = turn(&scene.surface.opposite, h);
                // A vertex of very many neighbours must not make every fit around it long.
                if h == start || self.points.len() >= 2 * POINTS {
                    break;
                }
            }
        }
    }

    /// Fits the collected vertices around `origin`, in units of `length`.
    pub(super) fn fit(&self, scene: &Scene<'_>, origin: Vector, [x, y, z]: [Vector; 3], length: f64) -> Option<Quadric> {
        let scale = 1.0 / length;
        let mut normal = [[0.0; 7]; 6];
        for &v in &self.points {
            let d = (scene.at(v) - origin) * scale;
            let (px, py, pz) = (d.dot(x), d.dot(y), d.dot(z));
            let r2 = px * px + py * py + pz * pz;
            let weight = 1.0 / (0.3 + r2 * r2);
            let row = [1.0, px, py, px * px, px * py, py * py, pz];
            for i in 0..6 {
                let wi = weight * row[i];
                for j in i..7 {
                    normal[i][j] += wi * row[j];
                }
            }
        }
        for i in 0..6 {
            normal[i][i] += RIDGE[i];
        }
        solve(normal).map(Quadric)
    }
}

/// Solves a symmetric positive definite system (upper triangle and right side given) by L D Lᵀ.
fn solve(mut m: [[f64; 7]; 6]) -> Option<[f64; 6]> {
    for i in 0..6 {
        if !(m[i][i] > 1e-12) {
            return None;
        }
        let pivot = 1.0 / m[i][i];
        for r in i + 1..6 {
            let factor = m[i][r] * pivot;
            for c in r..7 {
                m[r][c] -= factor * m[i][c];
            }
        }
    }
    let mut solution = [0.0; 6];
    for i in (0..6).rev() {
        let mut sum = m[i][6];
        for j in i + 1..6 {
            sum -= m[i][j] * solution[j];
        }
        solution[i] = sum / m[i][i];
    }
    Some(solution)
}
