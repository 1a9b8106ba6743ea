//! Regular beginnings: linear subdivision, the icosahedron, polycubes, and Loop's scheme.

use std::collections::BTreeMap;

use crate::Shape;
use crate::edit::sub;

/// The icosahedron with corners at distance 1.
pub(crate) fn icosahedron() -> Shape {
    let phi = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let length = (1.0 + phi * phi).sqrt();
    let (a, b) = (1.0 / length, phi / length);
    let mut positions = Vec::new();
    for axis in 0..3 {
        for (s, t) in [(a, b), (-a, b), (a, -b), (-a, -b)] {
            let mut p = [0.0; 3];
            p[(axis + 1) % 3] = s;
            p[(axis + 2) % 3] = t;
            positions.push(p);
        }
    }
    // Faces are the triples of corners that are pairwise as near as corners get, turned outward.
    let near = |i: usize, j: usize| {
        let d = sub(positions[i], positions[j]);
        d.iter().map(|x| x * x).sum::<f64>() < 4.5 * a * a
    };
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(i, k) {
                    let n = crate::edit::cross(sub(positions[j], positions[i]), sub(positions[k], positions[i]));
                    let outward = n.iter().zip(positions[i]).map(|(x, y)| x * y).sum::<f64>() > 0.0;
                    triangles.push(if outward { [i, j, k] } else { [i, k, j] }.map(|v| v as u32));
                }
            }
        }
    }
    Shape { positions, triangles }
}

/// Every triangle cut into `n`² equal ones.
pub(crate) fn subdivided(shape: &Shape, n: u32) -> Shape {
    let mut positions = shape.positions.clone();
    let mut on_edges = BTreeMap::new();
    let blend = |corners: [u32; 3], weights: [u32; 3]| {
        let mut p = [0.0; 3];
        for (corner, weight) in corners.into_iter().zip(weights) {
            for (x, c) in p.iter_mut().zip(shape.positions[corner as usize]) {
                *x += c * f64::from(weight) / f64::from(n);
            }
        }
        p
    };
    let mut triangles = Vec::with_capacity(shape.triangles.len() * (n * n) as usize);
    for &[a, b, c] in &shape.triangles {
        // `at[i][j]`: the point with weights (n − i, i − j, j).
        let mut at: Vec<Vec<u32>> = Vec::new();
        for i in 0..=n {
            let mut row = Vec::new();
            for j in 0..=i {
                let (corners, weights) = ([a, b, c], [n - i, i - j, j]);
                let named: Vec<(u32, u32)> = corners.into_iter().zip(weights).filter(|x| x.1 > 0).collect();
                let fresh = |positions: &mut Vec<[f64; 3]>| {
                    positions.push(blend(corners, weights));
                    positions.len() as u32 - 1
                };
                row.push(match *named {
                    [(v, _)] => v,
                    [(u, s), (v, t)] => {
                        let key = if u < v { (u, v, s) } else { (v, u, t) };
                        *on_edges.entry(key).or_insert_with(|| fresh(&mut positions))
                    }
                    _ => fresh(&mut positions),
                });
            }
            at.push(row);
        }
        for i in 0..n as usize {
            for j in 0..=i {
                triangles.push([at[i][j], at[i + 1][j], at[i + 1][j + 1]]);
                if j < i {
                    triangles.push([at[i][j], at[i + 1][j + 1], at[i][j + 1]]);
                }
            }
        }
    }
    Shape { positions, triangles }
}

/// The surface of a set of unit cubes. Cubes that touch only along an edge or at a corner are not allowed.
pub(crate) fn polycube(cubes: &[[i32; 3]]) -> Shape {
    let solid: std::collections::BTreeSet<[i32; 3]> = cubes.iter().copied().collect();
    let mut numbers = BTreeMap::new();
    let mut shape = Shape::default();
    for &cube in &solid {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut beyond = cube;
                beyond[axis] += 2 * side - 1;
                if solid.contains(&beyond) {
                    continue;
                }
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(s, t)| {
                    let mut p = cube;
                    p[axis] += side;
                    p[u] += s;
                    p[v] += t;
                    *numbers.entry(p).or_insert_with(|| {
                        shape.positions.push(p.map(f64::from));
                        shape.positions.len() as u32 - 1
                    })
                });
                if side == 0 {
                    corners.reverse();
                }
                let [a, b, c, d] = corners;
                shape.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    shape
}

/// One step of Loop's scheme (Loop 1987, with Warren's weights) on a closed mesh.
pub(crate) fn smoothed(shape: &Shape) -> Shape {
    let mut sums = vec![([0.0; 3], 0_u32); shape.positions.len()];
    let mut middle = BTreeMap::new();
    let mut positions = shape.positions.clone();
    let add = |sum: &mut [f64; 3], p: [f64; 3], w: f64| sum.iter_mut().zip(p).for_each(|(s, x)| *s += w * x);
    for &[a, b, c] in &shape.triangles {
        for (u, v, apex) in [(a, b, c), (b, c, a), (c, a, b)] {
            let (sum, degree) = &mut sums[u as usize];
            add(sum, shape.positions[v as usize], 1.0);
            *degree += 1;
            let m = *middle.entry((u.min(v), u.max(v))).or_insert_with(|| {
                positions.push([0.0; 3]);
                positions.len() - 1
            });
            // Each of the two triangles at the edge brings half of both ends and its own apex.
            for (v, w) in [(u, 3.0 / 16.0), (v, 3.0 / 16.0), (apex, 1.0 / 8.0)] {
                add(&mut positions[m], shape.positions[v as usize], w);
            }
        }
    }
    for (v, &(sum, degree)) in sums.iter().enumerate() {
        let beta = if degree == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * f64::from(degree)) };
        for (x, s) in positions[v].iter_mut().zip(sum) {
            *x = *x * (1.0 - f64::from(degree) * beta) + beta * s;
        }
    }
    let mut triangles = Vec::with_capacity(4 * shape.triangles.len());
    for &[a, b, c] in &shape.triangles {
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(u, v)| middle[&(u.min(v), u.max(v))] as u32);
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    Shape { positions, triangles }
}
