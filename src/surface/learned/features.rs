//! What geometry and connectivity suggest about a vertex: vectors that a learned sum is made of.
//!
//! Each feature is a displacement from the plain prediction (the mean parallelogram). They turn and
//! grow with the mesh, so one weight a feature serves all three axes. The first [`LEAN`] are what
//! effort `default` uses; `best` uses all. spec/surface.md, "Features", lists them by number.

use super::Scene;
use super::math::cot;
use super::quadric;
use super::ring::{Gate, Ring, Sums};
use super::vector::Vector;

/// All features.
pub(super) const ALL: usize = 43;
/// The features that effort `default` uses.
pub(super) const LEAN: usize = 24;

/// A vertex with at least one gate, seen from its neighbours.
#[derive(Debug, Clone)]
pub(super) struct View {
    /// The mean parallelogram.
    pub(super) base: Vector,
    /// The mean length of the edges opposite.
    pub(super) length: f64,
    /// The mean normal of the faces across.
    pub(super) normal: Vector,
    /// The prediction from valences alone.
    pub(super) by_valence: Vector,
    /// How far the parallelograms are from their mean: along the normal, and across it.
    pub(super) spread: [f64; 2],
    /// Displacements from `base`; only the first `count` are filled in.
    pub(super) features: [Vector; ALL],
}

/// The angle of a triangle of an even mesh.
const EVEN: f64 = std::f64::consts::FRAC_PI_3;

pub(super) fn view<const N: usize>(scene: &Scene<'_>, ring: &Ring, sums: &Sums, quadrics: &mut quadric::Fit, v: u32) -> View {
    let k = ring.gates.len() as f64;
    let mean = |f: &mut dyn FnMut(&Gate) -> Vector| {
        let mut sum = Vector::ZERO;
        for gate in &ring.gates {
            sum += f(gate);
        }
        sum * (1.0 / k)
    };
    let base = mean(&mut |g| scene.parallelogram(g));
    let mut normal = Vector::ZERO;
    let mut length = 0.0;
    for g in &ring.gates {
        let (a, b, c) = (scene.at(g.a), scene.at(g.b), scene.at(g.c));
        let u = b - a;
        normal += u.cross(c - a);
        length += u.length();
    }
    let length = length / k + 0.5;
    let size = normal.length();
    if size > 1e-9 {
        normal = normal * (1.0 / size);
    }
    let shapes = shapes(scene, ring, sums, v);
    let mut spread = [0.0; 2];
    for g in &ring.gates {
        let d = scene.parallelogram(g) - base;
        let along = d.dot(normal).abs();
        spread[0] += along / k;
        spread[1] += (d.dot(d) - along * along).max(0.0).sqrt() / k;
    }

    let mut f = [Vector::ZERO; ALL];
    for (feature, shape) in [0, 2, 3, 4].into_iter().zip(shapes) {
        f[feature] = shape - base;
    }
    f[1] = ring.known.iter().fold(Vector::ZERO, |sum, &a| sum + scene.at(a)) * (1.0 / ring.known.len() as f64) - base;
    second_ring(scene, ring, &mut f);
    f[6] = residuals(scene, ring);
    let (first, last) = (ring.gates[0], ring.gates[ring.gates.len() - 1]);
    [f[7], f[8], f[16], f[17], f[18], f[19]] = defects(scene, &first);
    if ring.gates.len() > 1 {
        [f[9], f[10], f[20], f[21], f[22], f[23]] = defects(scene, &last);
    }
    f[11] = closing(scene, ring, sums, base);
    let umbrella = umbrella(scene, ring, sums);
    f[14] = normal * umbrella.dot(normal);
    f[15] = umbrella - f[14];

    // A frame along the known arc: from the start of the first gate to the end of the last.
    let arc = (scene.at(last.b) - scene.at(first.a)).tangential(normal);
    let arc_length = arc.length();
    let frame = (arc_length > 1e-6).then(|| {
        let x = arc * (1.0 / arc_length);
        [x, normal.cross(x)]
    });
    let quadric_frame = frame.or_else(|| {
        let u = (scene.at(first.b) - scene.at(first.a)).tangential(normal);
        let size = u.length();
        (size > 1e-9).then(|| [u * (1.0 / size), normal.cross(u * (1.0 / size))])
    });
    quadrics.collect(scene, ring);
    if let Some([x, y]) = quadric_frame
        && size > 1e-9
        && let Some(fit) = quadrics.fit(scene, base, [x, y, normal], length)
    {
        let middle = (f[3] + f[0]) * (0.5 / length);
        f[12] = normal * (fit.height(0.0, 0.0) * length);
        f[13] = normal * (fit.height(middle.dot(x), middle.dot(y)) * length);
        f[41] = normal * (fit.curvatures()[0] * length * 0.3);
        f[42] = normal * (fit.curvatures()[1] * length * 0.3);
    }
    if N > LEAN {
        f[25] = normal * (0.2 * length);
        f[26] = match (ring.gates.len(), ring.edge) {
            (1, Some([a, b])) => (scene.at(a) + scene.at(b)) * 0.5 - base,
            (1, None) => Vector::ZERO,
            _ => scene.parallelogram(&first) - base,
        };
        if ring.gates.len() >= 3 {
            f[40] = scene.parallelogram(&ring.gates[ring.gates.len() / 2]) - base;
        }
        if let Some([x, y]) = frame {
            framed(scene, ring, sums, v, x * length, y * length, &mut f);
        }
    }
    View { base, length, normal, by_valence: shapes[0], spread, features: f }
}

/// Four ways to set a triangle on a gate, averaged: with angles by valence, in the plane's slant
/// (the gate's own triangle mirrored and scaled) or in its plane; with the angles that are left
/// free at the gate's ends, in its plane or its slant.
fn shapes(scene: &Scene<'_>, ring: &Ring, sums: &Sums, v: u32) -> [Vector; 4] {
    let mut total = [Vector::ZERO; 4];
    for g in &ring.gates {
        let (a, b, c) = (scene.at(g.a), scene.at(g.b), scene.at(g.c));
        let u = b - a;
        let uu = u.dot(u) + 1e-9;
        let [ca, cb] = scene.cotangents(g.a, g.b, v);
        let [ea, eb] = scene.cotangents(g.a, g.b, g.c);
        let (height, height_c) = (1.0 / (ca + cb), 1.0 / (ea + eb));
        let (foot, foot_c) = (ca * height, ea * height_c);
        let slant = a + u * foot_c - c;
        let straight = a + u * ((c - a).dot(u) / uu) - c;
        let per_height = uu.sqrt() / (straight.length() + 1e-9);
        total[0] += a + u * foot + slant * (height / height_c);
        total[1] += a + u * foot + straight * (per_height * height);

        let (mut at_a, mut at_b) = (scene.free_angle(sums, g.a), scene.free_angle(sums, g.b));
        let both = at_a + at_b;
        if both > 2.7 {
            at_a *= 2.7 / both;
            at_b *= 2.7 / both;
        }
        let (ca, cb) = (cot(at_a), cot(at_b));
        let sum = (ca + cb).max(0.25);
        let foot = (ca / sum).clamp(-1.0, 2.0);
        let height = (1.0 / sum).min(3.0);
        total[2] += a + u * foot + straight * (per_height * height);
        total[3] += a + u * foot + slant * (per_height * height).min(3.0);
    }
    total.map(|t| t * (1.0 / ring.gates.len() as f64))
}

/// Feature 5: straight on from the vertices two rings away; feature 24: their middle.
fn second_ring(scene: &Scene<'_>, ring: &Ring, f: &mut [Vector; ALL]) {
    let (mut straight, mut straight_count) = (Vector::ZERO, 0.0);
    let (mut middle, mut middle_count) = (Vector::ZERO, 0.0);
    for g in &ring.gates {
        let p = scene.parallelogram(g);
        let [d, e] = scene.sides(g.across).map(|h| scene.known_apex(h));
        if let Some(d) = d {
            straight += scene.at(g.a) * 2.0 - d - p;
            straight_count += 1.0;
        }
        if let Some(e) = e {
            straight += scene.at(g.b) * 2.0 - e - p;
            straight_count += 1.0;
        }
        if let (Some(d), Some(e)) = (d, e) {
            middle += (d + e) * 0.5 - scene.at(g.c);
            middle_count += 1.0;
        }
    }
    if straight_count > 0.0 {
        f[5] = straight * (1.0 / straight_count);
    }
    if middle_count > 0.0 {
        f[24] = middle * (1.0 / middle_count);
    }
}

/// Feature 6: the mean of the neighbours' own residuals.
fn residuals(scene: &Scene<'_>, ring: &Ring) -> Vector {
    let sum = ring.known.iter().fold(Vector::ZERO, |sum, &a| sum + scene.residual(a));
    sum * (1.0 / (ring.known.len() + ring.gates.len()) as f64)
}

/// How far the parallelogram rule is off at faces behind a gate: across its two far sides, then one
/// face further behind each.
fn defects(scene: &Scene<'_>, gate: &Gate) -> [Vector; 6] {
    let defect = |h: u32| -> Option<(Vector, u32)> {
        let apex = scene.known_apex(h)?;
        let opposite = scene.surface.opposite[h as usize];
        let [a, b] = scene.ends(h);
        Some((apex - (a + b - scene.at(scene.surface.apex(h))), opposite))
    };
    let mut found = [Vector::ZERO; 6];
    for (i, side) in scene.sides(gate.across).into_iter().enumerate() {
        if let Some((d, behind)) = defect(side) {
            found[i] = d;
            for (j, side) in scene.sides(behind).into_iter().enumerate() {
                found[2 + 2 * i + j] = defect(side).map_or(Vector::ZERO, |(d, _)| d);
            }
        }
    }
    found
}

/// Feature 11: where the vertex would make its neighbours the means of their rings.
fn closing(scene: &Scene<'_>, ring: &Ring, sums: &Sums, base: Vector) -> Vector {
    let (mut total, mut count) = (Vector::ZERO, 0.0);
    for &a in &ring.known {
        let (known, sum) = sums.neighbours(a);
        let valence = scene.surface.valence[a as usize];
        if !scene.is_boundary(a) && known + 1 == valence {
            total += scene.at(a) * f64::from(valence) - sum;
            count += 1.0;
        }
    }
    if count > 0.0 { total * (1.0 / count) - base } else { Vector::ZERO }
}

/// How far the vertices across the gates are from the means of their rings.
fn umbrella(scene: &Scene<'_>, ring: &Ring, sums: &Sums) -> Vector {
    let (mut total, mut count) = (Vector::ZERO, 0.0);
    for g in &ring.gates {
        let (known, sum) = sums.neighbours(g.c);
        if !scene.is_boundary(g.c) && known == scene.surface.valence[g.c as usize] {
            total += sum * (1.0 / f64::from(known)) - scene.at(g.c);
            count += 1.0;
        }
    }
    if count > 0.0 { total * (1.0 / count) } else { Vector::ZERO }
}

/// Features 27–39: the frame of the known arc, scaled by how valences and free angles differ from even ones.
fn framed(scene: &Scene<'_>, ring: &Ring, sums: &Sums, v: u32, x: Vector, y: Vector, f: &mut [Vector; ALL]) {
    let (a, d) = (ring.gates[0].a, ring.gates[ring.gates.len() - 1].b);
    let deviation = |v: u32| (scene.degree(v).min(12.0) - 6.0) / 6.0;
    let place = |v: u32| ring.all.iter().position(|&w| w == v).unwrap_or(0);
    let count = ring.all.len();
    let unknown_deviation = |v: u32| if scene.order.is_known(v) { 0.0 } else { deviation(v) };
    let after = unknown_deviation(ring.all[(place(d) + 1) % count]);
    let before = unknown_deviation(ring.all[(place(a) + count - 1) % count]);
    let unknown = |v: u32| f64::from(scene.neighbours(v) - sums.neighbours(v).0.min(scene.neighbours(v)));
    let (free_a, free_d) = (unknown(a), unknown(d));
    let (turn_a, turn_d) = (scene.free_angle(sums, a) - EVEN, scene.free_angle(sums, d) - EVEN);
    f[27] = y * 0.3;
    f[28] = y * ((free_a + free_d - 4.0) * 0.25);
    f[29] = x * ((free_d - free_a) * 0.25);
    f[30] = x * 0.2;
    f[31] = y * ((turn_a + turn_d) * 0.5);
    f[32] = x * ((turn_d - turn_a) * 0.5);
    f[33] = y * deviation(v);
    f[34] = x * (deviation(d) - deviation(a));
    f[35] = y * (deviation(a) + deviation(d));
    let inner = &ring.gates[..ring.gates.len() - 1];
    if !inner.is_empty() {
        f[36] = y * (inner.iter().map(|g| deviation(g.b)).sum::<f64>() / inner.len() as f64);
    }
    f[37] = x * (after - before);
    f[38] = y * (after + before);
    let (sum, unknowns) =
        ring.all.iter().filter(|&&w| !scene.order.is_known(w)).fold((0.0, 0.0), |(s, n), &w| (s + deviation(w), n + 1.0));
    if unknowns > 0.0 {
        f[39] = y * (sum / unknowns);
    }
}
