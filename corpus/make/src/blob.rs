//! Closed shapes: the sphere, a sphere with bumps, and a body with any number of handles.

use crate::base::{icosahedron, polycube, smoothed, subdivided};
use crate::edit::{normals, worn};
use crate::{Shape, noise};

/// A sphere of radius 1 with perfect triangles: 20 n² of them, the nearest to `faces`.
pub fn sphere(faces: usize) -> Shape {
    round(faces).rounded()
}

fn round(faces: usize) -> Shape {
    let n = ((faces as f64 / 20.0).sqrt() + 0.5).floor().max(1.0) as u32;
    let mut shape = subdivided(&icosahedron(), n);
    for p in &mut shape.positions {
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        *p = p.map(|x| x / length);
    }
    shape
}

/// A sphere with bumps at every scale and the valences of a decimated scan.
pub fn bumpy_sphere(faces: usize, seed: u64) -> Shape {
    let mut shape = round(faces + faces / 2 + 20);
    for p in &mut shape.positions {
        let bump = noise::layered(p.map(|x| 2.5 * x), 6, 0.38, seed);
        *p = p.map(|x| x * (1.0 + 0.25 * bump));
    }
    worn(shape, faces, 0.15, seed).rounded()
}

/// A smooth body with `handles` holes in a row, gently bumpy.
pub fn genus(faces: usize, handles: u32, seed: u64) -> Shape {
    let mut cubes = Vec::new();
    for x in 0..2 * handles as i32 + 1 {
        for y in 0..3 {
            if x % 2 == 0 || y != 1 {
                cubes.push([x, y, 0]);
            }
        }
    }
    let mut shape = polycube(&cubes);
    while shape.triangles.len() < faces + faces / 8 {
        shape = smoothed(&shape);
    }
    let normals = normals(&shape);
    for (p, n) in shape.positions.iter_mut().zip(normals) {
        let bump = 0.05 * noise::layered(p.map(|x| 2.0 * x), 5, 0.45, seed);
        *p = [p[0] + bump * n[0], p[1] + bump * n[1], p[2] + bump * n[2]];
    }
    worn(shape, faces, 0.1, seed).rounded()
}
