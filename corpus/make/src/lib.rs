//! Procedural meshes of any size, the same on every machine.
//!
//! Tests, benches and fuzz targets need meshes that nobody has to download and that behave like real ones: irregular
//! valences, detail at several scales, boundaries, handles, several components. Each shape here starts from something
//! regular, is bent by [`noise`], and is then worn by [`edit`]: edges are collapsed and flipped until the valences look
//! like those of a decimated scan.
//!
//! Only `+ − × ÷ √` and integers are used, in a fixed order, so that one seed gives one mesh, to the bit.

mod base;
mod blob;
mod block;
pub mod edit;
pub mod noise;
mod ply;
pub mod random;
mod several;
mod sheet;
mod torus;
pub mod trig;

pub use blob::{bumpy_sphere, genus, sphere};
pub use block::block;
pub use several::{any, components};
pub use sheet::{grid, terrain};
pub use torus::torus_with_holes;

/// A triangle mesh: an oriented manifold, with coordinates that `f32` holds exactly.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Shape {
    /// Vertex positions.
    pub positions: Vec<[f64; 3]>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// Rounds every coordinate to `f32`.
    pub fn rounded(mut self) -> Self {
        for x in self.positions.iter_mut().flatten() {
            *x = f64::from(*x as f32);
        }
        self
    }

    /// Drops the vertices that no triangle uses, and numbers the others in the order they had.
    pub fn compacted(mut self) -> Self {
        let mut used = vec![false; self.positions.len()];
        self.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        let mut number = vec![0; used.len()];
        let mut kept = Vec::new();
        for (v, &used) in used.iter().enumerate() {
            if used {
                number[v] = kept.len() as u32;
                kept.push(self.positions[v]);
            }
        }
        self.positions = kept;
        self.triangles.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
        self
    }

    /// The same mesh with vertices, triangles and first corners in an order that says nothing.
    pub fn shuffled(&self, seed: u64) -> Self {
        let mut random = random::Random::new(seed);
        let mut order: Vec<u32> = (0..self.positions.len() as u32).collect();
        random.shuffle(&mut order);
        let mut positions = vec![[0.0; 3]; order.len()];
        for (p, &to) in self.positions.iter().zip(&order) {
            positions[to as usize] = *p;
        }
        let mut triangles: Vec<[u32; 3]> = self
            .triangles
            .iter()
            .map(|t| {
                let mut t = t.map(|v| order[v as usize]);
                t.rotate_left(random.below(3) as usize);
                t
            })
            .collect();
        random.shuffle(&mut triangles);
        Self { positions, triangles }
    }

    /// The same mesh as the bytes of a binary little-endian PLY file.
    pub fn to_ply(&self) -> Vec<u8> {
        ply::write(self)
    }
}

/// The names that [`by_name`] knows.
pub const NAMES: [&str; 8] = ["bumpy_sphere", "torus_with_holes", "terrain", "genus", "block", "components", "grid", "sphere"];

/// The shape called `name`, with about `faces` triangles.
pub fn by_name(name: &str, faces: usize, seed: u64) -> Option<Shape> {
    Some(match name {
        "bumpy_sphere" => bumpy_sphere(faces, seed),
        "torus_with_holes" => torus_with_holes(faces, 5, seed),
        "terrain" => terrain(faces, seed),
        "genus" => genus(faces, 5, seed),
        "block" => block(faces),
        "components" => components(faces, 12, seed),
        "grid" => grid(faces),
        "sphere" => sphere(faces),
        _ => return None,
    })
}

/// The meshes in `corpus/meshes`: file name, shape, triangles asked for, seed.
pub const COMMITTED: [(&str, &str, usize, u64); 7] = [
    ("bumpy_sphere.ply", "bumpy_sphere", 8000, 1),
    ("torus_with_holes.ply", "torus_with_holes", 6000, 2),
    ("terrain.ply", "terrain", 8000, 3),
    ("genus_5.ply", "genus", 5000, 4),
    ("block.ply", "block", 1200, 5),
    ("components.ply", "components", 4000, 6),
    ("sphere.ply", "sphere", 320, 7),
];
