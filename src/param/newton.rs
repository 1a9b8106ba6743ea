//! Newton's method for low stretch, with Hessians made positive (Smith, Goes and Kim 2019; Teran et al. 2005).
//!
//! For the map of a triangle from the surface to the square with singular values σ₁ ≥ σ₂ > 0 the energy is its area times
//! Σ (p σᵢ² + ½ σᵢ⁻²): the squared stretch from the square to the surface plus p times Dirichlet's energy. It grows without bound where a
//! triangle gets flat, and a step ends before any does: from a map without folds only maps without folds are reached. Vertices
//! on the border of a square slide along their side.

use glam::{DMat2, DVec2};

use super::chart::{Chart, Freedom, Lift};
use crate::error::Result;
use crate::par;
use crate::sparse::{Cholesky, NOWHERE, Pattern};
use crate::task::Task;

/// The share of Dirichlet's energy: stretch alone makes good meshes, with this share images are coded in fewer bytes.
const DIRICHLET: f64 = 0.3;

/// Steps at most.
const STEPS: usize = 25;

/// On very large surfaces fewer steps are taken, so that all of them together solve for so many triangles at most.
const WORK: usize = 6_000_000;

/// The relative decrease below which nothing more is to be had.
const ENOUGH: f64 = 1e-4;

/// Triangles whose height is below this share of their longest side count as that high: a needle's energy should not outweigh all others.
const FLAT: f64 = 1e-4;

/// Faces that are worked on at once.
const BLOCK: usize = 1 << 15;

/// A triangle at rest: its area and the gradients of its corners' hat functions.
#[derive(Clone, Copy)]
struct Rest {
    area: f64,
    hats: [DVec2; 3],
}

/// A triangle's part of the gradient and of the Hessian, over its corners' two coordinates each.
struct Local {
    gradient: [f64; 6],
    hessian: [[f64; 6]; 6],
}

/// Lowers the energy of a chart without folds.
pub(super) fn improve(chart: &mut Chart, task: &Task<'_>) -> Result<()> {
    let rest = at_rest(chart);
    let (unknown, count) = number(chart);
    if count == 0 {
        return Ok(());
    }
    let (solver, slots) = analyse(chart, &unknown, count)?;
    let mut energy = total(chart, &rest, &chart.w);
    let steps = STEPS.min(1 + WORK / chart.faces().max(1));
    for step in 0..steps {
        task.step(step as f64 / steps as f64)?;
        if !energy.is_finite() {
            break;
        }
        let (values, gradient) = assemble(chart, &rest, &unknown, count, &slots, solver.pattern().len());
        let mut values = values;
        let mut direction: Vec<f64> = gradient.iter().map(|g| -g).collect();
        solver.pattern().raise_diagonal(&mut values, 1e-9);
        if solver.solve(&values, &mut direction).is_err() {
            break;
        }
        let move_by: Vec<DVec2> =
            unknown.iter().map(|u| DVec2::from(u.map(|i| if i == NOWHERE { 0.0 } else { direction[i as usize] }))).collect();
        let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
        let mut t = (0.9 * furthest(chart, &move_by)).min(1.0);
        let moved = |t: f64| -> Vec<DVec2> { chart.w.iter().zip(&move_by).map(|(w, d)| *w + t * *d).collect() };
        let mut next = None;
        for _ in 0..40 {
            let w = moved(t);
            let e = total(chart, &rest, &w);
            if e <= energy + 1e-4 * t * slope {
                next = Some((w, e));
                break;
            }
            t *= 0.5;
        }
        let Some((w, lower)) = next else { break };
        let gain = (energy - lower) / energy;
        chart.w = w;
        energy = lower;
        if gain < ENOUGH {
            break;
        }
    }
    Ok(())
}

/// The triangles of the surface, scaled to an area of 1 together.
fn at_rest(chart: &Chart) -> Vec<Rest> {
    let area: f64 = (0..chart.faces()).map(|f| chart.stretch2(f).0).sum();
    let scale = 1.0 / area.sqrt().max(f64::MIN_POSITIVE);
    let least = 1e-8 / (chart.faces() as f64).sqrt();
    let rest = |f: usize| {
        let [p, q, r] = chart.solid(f);
        let (e, d) = ((q - p) * scale, (r - p) * scale);
        let longest = e.length().max(d.length()).max((d - e).length()).max(least);
        let l = e.length().max(FLAT * longest);
        let x = e.dot(d) / l;
        let y = (e.cross(d).length() / l).max(FLAT * longest);
        // Rows of the inverse of [(l, 0), (x, y)] as columns.
        let (one, two) = (DVec2::new(1.0 / l, -x / (l * y)), DVec2::new(0.0, 1.0 / y));
        Rest { area: 0.5 * l * y, hats: [-one - two, one, two] }
    };
    (0..chart.faces()).map(rest).collect()
}

/// The unknown of each vertex's two coordinates, and how many there are.
fn number(chart: &Chart) -> (Vec<[u32; 2]>, usize) {
    let mut count = 0;
    let mut take = |wanted: bool| {
        count += u32::from(wanted);
        if wanted { count - 1 } else { NOWHERE }
    };
    let unknown = (0..chart.w.len())
        .map(|v| match (chart.mesh.outgoing(v as u32), chart.freedom[v]) {
            (None, _) | (_, Freedom::Fixed) => [NOWHERE; 2],
            (_, Freedom::Along(0)) => [take(true), NOWHERE],
            (_, Freedom::Along(_)) => [NOWHERE, take(true)],
            (_, Freedom::Free) => [take(true), take(true)],
        })
        .collect();
    (unknown, count as usize)
}

/// The pattern of the Hessian and for each triangle the slots of its 21 entries.
fn analyse(chart: &Chart, unknown: &[[u32; 2]], count: usize) -> Result<(Cholesky, Vec<u32>)> {
    let mut pairs = Vec::with_capacity(21 * chart.faces());
    for t in chart.mesh.triangles() {
        let ids: Vec<u32> = t.iter().flat_map(|&v| unknown[v as usize]).collect();
        for i in 0..6 {
            for j in 0..=i {
                let outside = ids[i] == NOWHERE || ids[j] == NOWHERE;
                pairs.push(if outside { (NOWHERE, NOWHERE) } else { (ids[i].max(ids[j]), ids[i].min(ids[j])) });
            }
        }
    }
    let (pattern, slots) = Pattern::new(count, &pairs);
    Ok((Cholesky::new(pattern)?, slots))
}

#[inline]
fn jacobian(hats: &[DVec2; 3], corners: [DVec2; 3]) -> DMat2 {
    let column = |x: fn(&DVec2) -> f64| (0..3).map(|k| corners[k] * x(&hats[k])).sum::<DVec2>();
    DMat2::from_cols(column(|h| h.x), column(|h| h.y))
}

#[inline]
fn corners(chart: &Chart, w: &[DVec2], face: usize) -> ([DVec2; 3], [Lift; 3]) {
    let t = chart.mesh.triangles()[face];
    let lifts = [0, 1, 2].map(|k| chart.lift(face, k));
    ([0, 1, 2].map(|k| lifts[k].of(w[t[k] as usize])), lifts)
}

/// The energy of a layout; infinite if a triangle is turned over.
fn total(chart: &Chart, rest: &[Rest], w: &[DVec2]) -> f64 {
    let blocks = par::map(rest.len().div_ceil(BLOCK), |block| {
        let mut sum = 0.0;
        for f in block * BLOCK..rest.len().min((block + 1) * BLOCK) {
            let j = jacobian(&rest[f].hats, corners(chart, w, f).0);
            let det = j.determinant();
            if !(det > 0.0) {
                return f64::INFINITY;
            }
            let squares = j.x_axis.length_squared() + j.y_axis.length_squared();
            sum += rest[f].area * squares * (DIRICHLET + 0.5 / (det * det));
        }
        sum
    });
    blocks.into_iter().sum()
}

/// The Hessian's entries and the gradient.
fn assemble(
    chart: &Chart,
    rest: &[Rest],
    unknown: &[[u32; 2]],
    count: usize,
    slots: &[u32],
    entries: usize,
) -> (Vec<f64>, Vec<f64>) {
    let (mut values, mut gradient) = (vec![0.0; entries], vec![0.0; count]);
    for start in (0..rest.len()).step_by(BLOCK) {
        let locals = par::map(BLOCK.min(rest.len() - start), |i| local(chart, rest, start + i));
        for (i, local) in locals.iter().enumerate() {
            let f = start + i;
            let t = chart.mesh.triangles()[f];
            for a in 0..6 {
                let id = unknown[t[a / 2] as usize][a % 2];
                if id != NOWHERE {
                    gradient[id as usize] += local.gradient[a];
                }
                for b in 0..=a {
                    let slot = slots[21 * f + a * (a + 1) / 2 + b];
                    if slot != NOWHERE {
                        values[slot as usize] += local.hessian[a][b];
                    }
                }
            }
        }
    }
    (values, gradient)
}

/// Gradient and Hessian of one triangle, the latter with its negative eigenvalues dropped.
fn local(chart: &Chart, rest: &[Rest], face: usize) -> Local {
    let Rest { area, hats } = rest[face];
    let (corners, lifts) = corners(chart, &chart.w, face);
    let j = jacobian(&hats, corners);
    let [[a, c], [b, d]] = j.to_cols_array_2d();
    // Singular values: J = U diag(s, t) Vᵀ with rotations U and V.
    let (e, f, g, h) = (0.5 * (a + d), 0.5 * (a - d), 0.5 * (c + b), 0.5 * (c - b));
    let (q, r) = (e.hypot(h), f.hypot(g));
    let (s, t) = ((q + r).max(1e-12), (q - r).max(1e-12));
    let (one, two) = (g.atan2(f), h.atan2(e));
    let u = DMat2::from_angle(0.5 * (two + one));
    let v = DMat2::from_angle(0.5 * (two - one)).transpose();
    let (u, v) = ([u.x_axis, u.y_axis], [v.x_axis, v.y_axis]);
    let first = |x: f64| 2.0 * DIRICHLET * x - 1.0 / (x * x * x);
    let second = |x: f64| 2.0 * DIRICHLET + 3.0 / (x * x * x * x);
    let (fs, ft) = (first(s), first(t));
    let apart = s - t;
    let eigenvalues = [second(s), second(t), (fs + ft) / (s + t), if apart > 1e-9 * s { (fs - ft) / apart } else { second(s) }];
    // Each eigenvector is a 2 x 2 matrix D; on a corner it acts as D · hat.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let act = |m: usize, hat: DVec2| {
        let (x, y) = (v[0].dot(hat), v[1].dot(hat));
        match m {
            0 => u[0] * x,
            1 => u[1] * y,
            2 => (u[0] * y - u[1] * x) * half,
            _ => (u[0] * y + u[1] * x) * half,
        }
    };
    let mut local = Local { gradient: [0.0; 6], hessian: [[0.0; 6]; 6] };
    let mut columns = [[0.0; 6]; 4];
    for k in 0..3 {
        let sign = lifts[k].sign;
        let (x, y) = (v[0].dot(hats[k]), v[1].dot(hats[k]));
        let force = (u[0] * (fs * x) + u[1] * (ft * y)) * (area * sign);
        (local.gradient[2 * k], local.gradient[2 * k + 1]) = (force.x, force.y);
        for (m, column) in columns.iter_mut().enumerate() {
            let q = act(m, hats[k]) * sign;
            (column[2 * k], column[2 * k + 1]) = (q.x, q.y);
        }
    }
    for (m, q) in columns.iter().enumerate() {
        let weight = area * eigenvalues[m].max(0.0);
        for a in 0..6 {
            for b in 0..=a {
                local.hessian[a][b] += weight * q[a] * q[b];
            }
        }
    }
    local
}

/// How far all vertices may go along `move_by` until the first triangle is flat.
fn furthest(chart: &Chart, move_by: &[DVec2]) -> f64 {
    let root = |f: usize| {
        let (p, lifts) = corners(chart, &chart.w, f);
        let t = chart.mesh.triangles()[f];
        let d = [0, 1, 2].map(|k| lifts[k].sign * move_by[t[k] as usize]);
        let (a, b, da, db) = (p[1] - p[0], p[2] - p[0], d[1] - d[0], d[2] - d[0]);
        let (c0, c1, c2) = (a.perp_dot(b), a.perp_dot(db) + da.perp_dot(b), da.perp_dot(db));
        let under = c1 * c1 - 4.0 * c2 * c0;
        if under < 0.0 {
            return f64::INFINITY;
        }
        let q = -0.5 * (c1 + under.sqrt().copysign(c1));
        [q / c2, c0 / q].into_iter().filter(|r| *r > 0.0).fold(f64::INFINITY, f64::min)
    };
    let blocks = par::map(chart.faces().div_ceil(BLOCK), |block| {
        (block * BLOCK..chart.faces().min((block + 1) * BLOCK)).map(root).fold(f64::INFINITY, f64::min)
    });
    blocks.into_iter().fold(f64::INFINITY, f64::min)
}
