//! Many things in one file, and a small mesh of any kind for property tests and fuzzers.

use crate::random::Random;
use crate::{Shape, block, bumpy_sphere, edit, genus, grid, sphere, terrain, torus_with_holes};

impl Shape {
    /// Adds `other`, scaled by `scale` and then moved by `offset`.
    pub fn append(&mut self, other: &Shape, scale: f64, offset: [f64; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions.iter().map(|p| [0, 1, 2].map(|axis| scale * p[axis] + offset[axis])));
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    }
}

/// `count` parts of very different sizes, closed and open ones; about `faces` triangles in all.
pub fn components(faces: usize, count: usize, seed: u64) -> Shape {
    let mut random = Random::new(seed);
    let shares: Vec<f64> = (0..count).map(|_| 0.05 + random.unit() * random.unit()).collect();
    let total: f64 = shares.iter().sum();
    let mut shape = Shape::default();
    for (i, share) in shares.iter().enumerate() {
        let (n, part_seed) = ((faces as f64 * share / total) as usize, random.bits());
        let part = match i % 4 {
            0 => bumpy_sphere(n, part_seed),
            1 => torus_with_holes(n, 2, part_seed),
            2 => block(n),
            _ => grid(n),
        };
        let size = part.positions.iter().flatten().fold(1e-9_f64, |m, x| m.max(x.abs()));
        let scale = (0.3 + share) / size;
        shape.append(&part, scale, [(i % 4) as f64 * 3.0, (i / 4) as f64 * 3.0, random.signed()]);
    }
    shape.rounded()
}

/// A small manifold mesh that a test cannot foresee: any kind, any order, up to about `faces` triangles.
pub fn any(seed: u64, faces: usize) -> Shape {
    let mut random = Random::new(seed);
    let n = 4 + random.below(faces.max(1) as u64) as usize;
    let holes = random.below(6) as u32;
    let part_seed = random.bits();
    let mut shape = match random.below(9) {
        0 => bumpy_sphere(n, part_seed),
        1 => torus_with_holes(n, holes, part_seed),
        2 => terrain(n, part_seed),
        3 => genus(n, holes, part_seed),
        4 => block(n),
        5 => components(n, 1 + holes as usize, part_seed),
        6 => grid(n),
        7 => sphere(n),
        _ => smallest(),
    };
    // So few triangles can leave nothing of a terrain.
    if shape.triangles.is_empty() {
        shape = smallest();
    }
    if random.below(2) == 0 {
        let mut mesh = edit::Editable::new(shape);
        mesh.flip_some(0.3, false, &mut random);
        shape = mesh.finish();
    }
    if random.below(2) == 0 { shape.shuffled(random.bits()) } else { shape }
}

/// A tetrahedron and a lone triangle: the smallest closed and the smallest open part.
fn smallest() -> Shape {
    let mut shape = Shape {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    };
    let triangle = Shape { positions: shape.positions[..3].to_vec(), triangles: vec![[0, 1, 2]] };
    shape.append(&triangle, 0.5, [2.0, 0.25, -1.0]);
    shape
}
