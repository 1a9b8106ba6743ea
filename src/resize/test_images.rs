//! Images for the tests of this room.

use crate::plane::{GeometryImage, Gluing};

/// The unit square with a steep bump of some height in its middle; 0 for none.
pub(crate) fn bump(width: usize, height: usize, rise: f64) -> GeometryImage {
    let point = |p: usize| {
        let (x, y) = ((p % width) as f64 / (width - 1) as f64, (p / width) as f64 / (height - 1) as f64);
        let square = ((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5)) * 60.0;
        [x, y, rise * (-square).exp()]
    };
    GeometryImage::new(width, height, Gluing::Open, (0..width * height).map(point).collect()).unwrap()
}

/// A closed surface: two sheets over a square whose border is glued as an orbifold's, with a bump on one of them.
pub(crate) fn pillow(width: usize, height: usize) -> GeometryImage {
    // Half-turn invariant functions about all four cones: cosines of sums and differences.
    let point = |p: usize| {
        let tau = std::f64::consts::TAU;
        let (s, t) = ((p % width) as f64 / (width - 1) as f64, (p / width) as f64 / (height - 1) as f64);
        let (a, b) = (tau / 2.0 * (s + t - 0.5), tau / 2.0 * (s - t + 0.5));
        let bump = (-((s - 0.5) * (s - 0.5) + (t - 0.5) * (t - 0.5)) * 40.0).exp();
        [a.cos(), b.cos(), 0.5 * a.sin() * b.sin() + 0.3 * bump]
    };
    GeometryImage::new(width, height, Gluing::Orbifold, (0..width * height).map(point).collect()).unwrap()
}

/// Points without any order.
pub(crate) fn rough(width: usize, height: usize, gluing: Gluing) -> GeometryImage {
    let mut state = (width * 1009 + height) as u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1_u64 << 24) as f64
    };
    let points = (0..width * height).map(|_| [next(), next(), next()]).collect();
    GeometryImage::new(width, height, gluing, points).unwrap()
}
