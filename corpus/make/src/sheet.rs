//! Open shapes: the perfect grid, and a terrain with a ragged border.

use crate::edit::{fans_only, worn};
use crate::random::Random;
use crate::{Shape, noise};

/// `columns` × `rows` squares, each cut in two; vertex (x, y) is at `at(x, y)`.
fn lattice(columns: u32, rows: u32, mut at: impl FnMut(u32, u32) -> [f64; 3]) -> Shape {
    let mut shape = Shape::default();
    for y in 0..=rows {
        for x in 0..=columns {
            shape.positions.push(at(x, y));
        }
    }
    for y in 0..rows {
        for x in 0..columns {
            let a = y * (columns + 1) + x;
            let (b, c, d) = (a + 1, a + columns + 2, a + columns + 1);
            shape.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    shape
}

/// A flat square of perfect right triangles.
pub fn grid(faces: usize) -> Shape {
    let side = ((faces as f64 / 2.0).sqrt() + 0.5).floor().max(1.0) as u32;
    lattice(side, side, |x, y| [f64::from(x), f64::from(y), 0.0])
}

/// A piece of mountains in whole metres on a map grid far from its origin, as surveys give it.
pub fn terrain(faces: usize, seed: u64) -> Shape {
    const CELL: f64 = 10.0;
    let side = ((faces as f64 * 0.95).sqrt() + 1.0).floor() as u32;
    let mut random = Random::new(seed);
    let size = f64::from(side);
    let mut shape = lattice(side, side, |x, y| {
        let mut jitter = || (4.0 * random.signed() + 0.5).floor();
        let (jx, jy) = (jitter(), jitter());
        let (x, y) = (f64::from(x), f64::from(y));
        let height = noise::layered([6.0 * x / size, 6.0 * y / size, 0.5], 8, 0.42, seed);
        // Squared from the valley floor on: flat below, steep above.
        let height = (height + 1.4).max(0.05);
        [562_000.0 + CELL * x + jx, 511_000.0 + CELL * y + jy, (0.045 * CELL * size * height * height).round()]
    });
    let inside: Vec<bool> = (0..shape.positions.len() as u32)
        .map(|v| {
            let (x, y) = (f64::from(v % (side + 1)) / size - 0.5, f64::from(v / (side + 1)) / size - 0.5);
            let ragged = noise::layered([7.0 * x, 7.0 * y, 9.5], 4, 0.5, seed);
            // A rounded square with teeth.
            let (xx, yy) = (4.0 * x * x, 4.0 * y * y);
            xx * xx + yy * yy < 0.72 + 0.2 * ragged
        })
        .collect();
    shape.triangles.retain(|t| t.iter().all(|&v| inside[v as usize]));
    worn(fans_only(shape), faces, 0.1, seed).rounded()
}
