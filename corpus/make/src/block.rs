//! A machined part: a plate with a drilled and chamfered hole, triangulated as CAD programs do.
//!
//! Few large flat regions, long thin triangles, sharp edges, and corners where very many triangles meet.

use crate::Shape;
use crate::trig::{cos, sin};

/// A plate of 60 × 40 × 10 with a hole of radius 12; about `faces` triangles.
pub fn block(faces: usize) -> Shape {
    // Eight triangles a segment: two for the wall, two for each chamfer, one for each flat face; and a few corners.
    let segments = (faces as u32 / 8).max(8);
    let mut shape = Shape::default();
    let ring = |radius: f64, z: f64, shape: &mut Shape| -> Vec<u32> {
        (0..segments)
            .map(|i| {
                let turn = f64::from(i) / f64::from(segments);
                shape.positions.push([30.0 + radius * cos(turn), 20.0 + radius * sin(turn), z]);
                shape.positions.len() as u32 - 1
            })
            .collect()
    };
    let rings: Vec<Vec<u32>> =
        [(13.0, 10.0), (12.0, 9.0), (12.0, 1.0), (13.0, 0.0)].map(|(r, z)| ring(r, z, &mut shape)).into();
    for pair in rings.windows(2) {
        let n = pair[0].len();
        for i in 0..n {
            let [a, b, c, d] = [pair[0][i], pair[0][(i + 1) % n], pair[1][(i + 1) % n], pair[1][i]];
            // Counter-clockwise seen from the axis, which is outside.
            shape.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let mut corners = |z: f64| -> Vec<u32> {
        [[60.0, 40.0], [0.0, 40.0], [0.0, 0.0], [60.0, 0.0]]
            .map(|[x, y]| {
                shape.positions.push([x, y, z]);
                shape.positions.len() as u32 - 1
            })
            .into()
    };
    let (top, bottom) = (corners(10.0), corners(0.0));
    for i in 0..4 {
        let [a, b, c, d] = [top[i], top[(i + 1) % 4], bottom[(i + 1) % 4], bottom[i]];
        shape.triangles.extend([[a, c, b], [a, d, c]]);
    }
    // Each quarter of the ring is a fan from the corner it faces; between quarters, a triangle to the next corner.
    let n = segments as usize;
    for (outline, ring, up) in [(&top, &rings[0], true), (&bottom, &rings[3], false)] {
        let mut add = |t: [u32; 3]| shape.triangles.push(if up { t } else { [t[0], t[2], t[1]] });
        for corner in 0..4 {
            let (from, to) = (corner * n / 4, (corner + 1) * n / 4);
            for i in from..to {
                add([outline[corner], ring[(i + 1) % n], ring[i]]);
            }
            add([outline[corner], outline[(corner + 1) % 4], ring[to % n]]);
        }
    }
    shape.rounded()
}
