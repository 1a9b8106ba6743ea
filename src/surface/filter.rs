//! What smooths a surface whose vertices were rounded: each moves along its normal by a few learned numbers.
//!
//! Rounding is noise that differs from vertex to vertex, and surfaces are smooth: so what a vertex is off the mean of its
//! neighbours, and that off the mean of theirs, tells a little of its error. How much depends on how even the surface is there:
//! four classes of five coefficients, fitted by the writer to the original. spec/surface.md, "Filter".

use super::learned::{PARTS, Vector, snap};
use super::topology::{Surface, turn};
use crate::mesh::half_edge::next;

/// Classes of surfaces: nearly plane to rough.
const CLASSES: usize = 4;
/// Differences that a move is a sum of.
const DIFFERENCES: usize = 5;
/// All coefficients.
const COEFFICIENTS: usize = CLASSES * DIFFERENCES;
/// A coefficient is a whole number of this part.
const COEFFICIENT_PARTS: f64 = 32.0;
/// The root mean square of the sines between a vertex's normal and those of its faces where the classes meet.
const CLASS_LIMITS: [f64; CLASSES - 1] = [0.04, 0.1, 0.25];
/// No difference counts for more steps.
const LARGEST: f64 = 2.0;
/// Rounds in which faces that turned are put back.
const ROUNDS: usize = 8;

/// The coefficients of a file: those of the first class, then those of the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Filter(pub(crate) [i8; COEFFICIENTS]);

/// What a vertex tells of its error.
#[derive(Debug, Clone, Copy)]
struct Sight {
    normal: Vector,
    differences: [f64; DIFFERENCES],
    class: usize,
}

impl Filter {
    /// Memory a vertex: four fields of vectors, the sights, two of positions.
    pub(crate) const BYTES_A_VERTEX: u64 = (5 * size_of::<Vector>() + size_of::<Sight>() + 2 * 12 + 2) as u64;
    /// Steps a vertex.
    pub(crate) const STEPS_A_VERTEX: u64 = 64;

    /// The positions (in [`PARTS`] of a step, of all vertices of the closed surface) after the filter.
    pub(super) fn apply(&self, surface: &Surface, outgoing: &[u32], before: &[[i32; 3]], extent: [i32; 3]) -> Vec<[i32; 3]> {
        let sights = sights(surface, outgoing, before);
        let mut after: Vec<[i32; 3]> = before
            .iter()
            .zip(&sights)
            .map(|(&p, sight)| {
                let mut sum = 0.0;
                for (j, difference) in sight.differences.iter().enumerate() {
                    sum += f64::from(self.0[sight.class * DIFFERENCES + j]) / COEFFICIENT_PARTS * difference;
                }
                let moved = point(p) + sight.normal * sum;
                [0, 1, 2].map(|i| snap(moved[i], extent[i]))
            })
            .collect();
        put_back(surface, before, &mut after);
        after
    }
}

fn point(p: [i32; 3]) -> Vector {
    Vector(p.map(|x| f64::from(x) / PARTS))
}

/// Whether a face has a vertex that fills a hole.
fn is_filling(surface: &Surface, triangle: &[u32; 3]) -> bool {
    triangle.iter().any(|&v| surface.is_hole[v as usize])
}

/// Puts the corners of faces that turned back to where they were, until none does.
fn put_back(surface: &Surface, before: &[[i32; 3]], after: &mut [[i32; 3]]) {
    let normal = |t: &[u32; 3], positions: &[[i32; 3]]| {
        let [a, b, c] = t.map(|v| point(positions[v as usize]));
        (b - a).cross(c - a)
    };
    let mut is_off = vec![false; before.len()];
    for _ in 0..ROUNDS {
        let mut any = false;
        for t in surface.triangles.iter().filter(|t| !is_filling(surface, t)) {
            if t.iter().any(|&v| before[v as usize] != after[v as usize]) {
                let was = normal(t, before);
                if was.dot(was) > 0.0 && normal(t, after).dot(was) <= 0.0 {
                    t.iter().for_each(|&v| is_off[v as usize] = true);
                    any = true;
                }
            }
        }
        if !any {
            return;
        }
        for ((off, after), before) in is_off.iter_mut().zip(after.iter_mut()).zip(before) {
            if std::mem::take(off) {
                *after = *before;
            }
        }
    }
}

/// Calls `f` for every half-edge that starts from a vertex.
fn around(surface: &Surface, start: u32, mut f: impl FnMut(u32)) {
    let mut h = start;
    loop {
        f(h);
        h = turn(&surface.opposite, h);
        if h == start {
            return;
        }
    }
}

fn sights(surface: &Surface, outgoing: &[u32], positions: &[[i32; 3]]) -> Vec<Sight> {
    let points: Vec<Vector> = positions.iter().map(|&p| point(p)).collect();
    let neighbour = |h: u32| surface.from(next(h));
    // The mean of the neighbours of each vertex, less its own; the nearer ones weigh more in the second.
    let even = |field: &[Vector]| each(surface, outgoing, field, |_, _| 1.0);
    let near = |field: &[Vector]| {
        each(surface, outgoing, field, |v, u| 1.0 / ((points[u as usize] - points[v as usize]).length() + 0.5))
    };
    let first = even(&points);
    let second = even(&first);
    let third = even(&second);
    let first_near = near(&points);
    let second_near = near(&first_near);
    let mut sights = Vec::with_capacity(points.len());
    for v in 0..points.len() {
        let mut normal = Vector::ZERO;
        let mut is_inside = !surface.is_hole[v];
        let face = |h: u32| {
            let [a, b, c] = surface.triangles[h as usize / 3].map(|u| points[u as usize]);
            (b - a).cross(c - a)
        };
        around(surface, outgoing[v], |h| {
            if is_filling(surface, &surface.triangles[h as usize / 3]) {
                is_inside = false;
            } else {
                normal += face(h);
            }
            is_inside &= neighbour(h) as usize != v;
        });
        let size = normal.length();
        if !is_inside || !(size > 0.0) {
            sights.push(Sight { normal: Vector::ZERO, differences: [0.0; DIFFERENCES], class: 0 });
            continue;
        }
        normal = normal * (1.0 / size);
        let (mut off, mut all) = (0.0, 0.0);
        around(surface, outgoing[v], |h| {
            let m = face(h);
            let size = m.length();
            if size > 0.0 {
                let along = m.dot(normal);
                off += size - along * along / size;
                all += size;
            }
        });
        let sine = (off / all).max(0.0).sqrt();
        let class = CLASS_LIMITS.iter().filter(|&&limit| sine >= limit).count();
        let differences = [&first, &second, &third, &first_near, &second_near];
        let differences = differences.map(|field| field[v].dot(normal).clamp(-LARGEST, LARGEST));
        sights.push(Sight { normal, differences, class });
    }
    sights
}

/// For each vertex the weighted mean of a field over its neighbours, less the field at itself.
fn each(surface: &Surface, outgoing: &[u32], field: &[Vector], weight: impl Fn(u32, u32) -> f64) -> Vec<Vector> {
    let mut out = Vec::with_capacity(field.len());
    for v in 0..field.len() as u32 {
        let (mut sum, mut weights) = (Vector::ZERO, 0.0);
        if !surface.is_hole[v as usize] {
            around(surface, outgoing[v as usize], |h| {
                let u = surface.from(next(h));
                if !surface.is_hole[u as usize] {
                    let w = weight(v, u);
                    sum += field[u as usize] * w;
                    weights += w;
                }
            });
        }
        out.push(if weights > 0.0 { sum * (1.0 / weights) - field[v as usize] } else { Vector::ZERO });
    }
    out
}

#[cfg(feature = "encode")]
mod fit {
    use super::*;
    use crate::surface::learned::Aim;

    /// A filter is used if it takes at least this share of the squared error away.
    const LEAST_GAIN: f64 = 0.003;

    impl Filter {
        /// The filter that brings a surface nearest to its original, with what it makes of the positions; if it is worth its bytes.
        pub(in crate::surface) fn fit(
            surface: &Surface,
            outgoing: &[u32],
            positions: &[[i32; 3]],
            extent: [i32; 3],
            aim: &Aim,
        ) -> Option<(Self, Vec<[i32; 3]>)> {
            let sights = sights(surface, outgoing, positions);
            let mut m = [[0.0; COEFFICIENTS + 1]; COEFFICIENTS];
            for (corners, normal, area) in aim.each_face(surface) {
                let heights = corners.map(|v| normal.dot(point(positions[v as usize]) - aim.point(v)));
                let seen = corners.map(|v| {
                    let sight = &sights[v as usize];
                    let slope = normal.dot(sight.normal);
                    (sight.class * DIFFERENCES, sight.differences.map(|d| d * slope))
                });
                // The integral over the face of the square of a height that is linear: A/12 of the products of its corners, twice
                // where they are the same.
                for i in 0..3 {
                    for j in 0..3 {
                        let weight = area / 12.0 * if i == j { 2.0 } else { 1.0 };
                        for p in 0..DIFFERENCES {
                            let row = &mut m[seen[i].0 + p];
                            row[COEFFICIENTS] -= weight * seen[i].1[p] * heights[j];
                            for q in 0..DIFFERENCES {
                                row[seen[j].0 + q] += weight * seen[i].1[p] * seen[j].1[q];
                            }
                        }
                    }
                }
            }
            let filter = Self(solve(m).map(|a| (a * COEFFICIENT_PARTS).round().clamp(-127.0, 127.0) as i8));
            if filter.0 == [0; COEFFICIENTS] {
                return None;
            }
            let after = filter.apply(surface, outgoing, positions, extent);
            let error = |positions: &[[i32; 3]]| {
                let of_face = |(corners, normal, area): ([u32; 3], Vector, f64)| {
                    let [a, b, c] = corners.map(|v| normal.dot(point(positions[v as usize]) - aim.point(v)));
                    area / 6.0 * (a * a + b * b + c * c + a * b + b * c + c * a)
                };
                aim.each_face(surface).map(of_face).sum::<f64>()
            };
            (error(&after) < (1.0 - LEAST_GAIN) * error(positions)).then_some((filter, after))
        }
    }

    /// Solves a symmetric system that may be singular: with a little on its diagonal.
    fn solve(mut m: [[f64; COEFFICIENTS + 1]; COEFFICIENTS]) -> [f64; COEFFICIENTS] {
        for (i, row) in m.iter_mut().enumerate() {
            row[i] += 1e-6 + 1e-9 * row[i];
        }
        for i in 0..COEFFICIENTS {
            let pivot = m[i];
            for r in (0..COEFFICIENTS).filter(|&r| r != i) {
                let factor = m[r][i] / pivot[i];
                if factor != 0.0 {
                    for c in i..=COEFFICIENTS {
                        m[r][c] -= factor * pivot[c];
                    }
                }
            }
        }
        std::array::from_fn(|i| m[i][COEFFICIENTS] / m[i][i])
    }
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;
    use crate::mesh::HalfEdges;
    use crate::surface::learned::Aim;
    use crate::surface::{Effort, Filled, Walked, trace};
    use crate::task::Task;
    use proptest::prelude::*;

    #[allow(clippy::unwrap_used)] // what a test does not expect should fail it
    /// A walked shape, and its points times `scale`, in the order of the walk.
    fn walked(shape: &corpus_make::Shape, scale: f64) -> (Walked, Vec<[f64; 3]>) {
        let half_edges = HalfEdges::new(shape.positions.len(), shape.triangles.clone()).unwrap();
        let walked = trace(&Filled::new(&half_edges), Effort::Default, Task::default()).unwrap().1;
        let mut order = walked.order.iter();
        let point = |&hole: &bool| {
            if hole { [0.0; 3] } else { shape.positions[*order.next().unwrap() as usize].map(|x| (x + 3.0) * scale) }
        };
        let points = walked.surface.is_hole.iter().map(point).collect();
        (walked, points)
    }

    fn rounded(points: &[[f64; 3]]) -> Vec<[i32; 3]> {
        points.iter().map(|p| p.map(|x| x.round() as i32 * PARTS as i32)).collect()
    }

    #[test]
    fn a_rounded_sphere_comes_nearer_to_the_sphere() {
        let (walked, points) = walked(&corpus_make::sphere(2000), 80.0);
        let outgoing = walked.surface.outgoing();
        let before = rounded(&points);
        let aim = Aim::new(&walked.surface, points, Vec::new(), 1.5);
        let (filter, after) = Filter::fit(&walked.surface, &outgoing, &before, [9000; 3], &aim).unwrap();
        assert_eq!(after, filter.apply(&walked.surface, &outgoing, &before, [9000; 3]));
        let off = |positions: &[[i32; 3]]| {
            let radius = |p: &[i32; 3]| (point(*p) - Vector([240.0; 3])).length();
            positions.iter().map(|p| (radius(p) - 80.0).powi(2)).sum::<f64>()
        };
        assert!(off(&after) < 0.5 * off(&before), "{} after {}", off(&after), off(&before));
    }

    #[test]
    fn the_boundary_stays_where_it_is() {
        let (walked, points) = walked(&corpus_make::torus_with_holes(600, 3, 1), 15.0);
        let before = rounded(&points);
        let after = Filter([32; COEFFICIENTS]).apply(&walked.surface, &walked.surface.outgoing(), &before, [3000; 3]);
        let mut moved = 0;
        for t in &walked.surface.triangles {
            for &v in t {
                let stays = before[v as usize] == after[v as usize];
                assert!(stays || !is_filling(&walked.surface, t), "vertex {v}");
                moved += usize::from(!stays);
            }
        }
        assert!(moved > 100);
    }

    proptest! {
        #[test]
        fn no_filter_turns_a_face_or_leaves_the_box(
            seed: u64, faces in 4_usize..300, scale in 0.3_f64..30.0, coefficients: [i8; COEFFICIENTS],
        ) {
            let (walked, points) = walked(&corpus_make::any(seed, faces), scale);
            let before = rounded(&points).into_iter().map(|p| p.map(|x| x.clamp(0, 2000))).collect::<Vec<_>>();
            let after = Filter(coefficients).apply(&walked.surface, &walked.surface.outgoing(), &before, [2000; 3]);
            for t in walked.surface.triangles.iter().filter(|t| !is_filling(&walked.surface, t)) {
                let normal = |positions: &[[i32; 3]]| {
                    let [a, b, c] = t.map(|v| point(positions[v as usize]));
                    (b - a).cross(c - a)
                };
                let was = normal(&before);
                prop_assert!(was == Vector::ZERO || normal(&after).dot(was) > 0.0);
            }
            prop_assert!(after.iter().flatten().all(|x| (0..=2000).contains(x)));
        }
    }
}
