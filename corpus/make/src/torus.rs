//! A torus with round holes in its skin: one handle and several boundary loops.

use crate::edit::{fans_only, worn};
use crate::random::Random;
use crate::trig::{cos, sin};
use crate::{Shape, noise};

/// A bumpy torus of radii 1 and 0.4 with up to `holes` holes.
pub fn torus_with_holes(faces: usize, holes: u32, seed: u64) -> Shape {
    let around = ((faces as f64 * 1.5 / 2.0 * 2.5).sqrt() as u32).max(8);
    let across = (around * 2 / 5).max(6);
    let mut random = Random::new(seed);
    let mut shape = Shape::default();
    for i in 0..around {
        for j in 0..across {
            let u = (f64::from(i) + 0.25 * random.signed()) / f64::from(around);
            let v = (f64::from(j) + 0.25 * random.signed()) / f64::from(across);
            let direction = [cos(u), sin(u)];
            let p = [direction[0] * (1.0 + 0.4 * cos(v)), direction[1] * (1.0 + 0.4 * cos(v)), 0.4 * sin(v)];
            let r = 0.4 * (1.0 + 0.15 * noise::layered(p.map(|x| 3.0 * x), 5, 0.5, seed));
            shape.positions.push([direction[0] * (1.0 + r * cos(v)), direction[1] * (1.0 + r * cos(v)), r * sin(v)]);
        }
    }
    let at = |i: u32, j: u32| (i % around) * across + j % across;
    for i in 0..around {
        for j in 0..across {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            shape.triangles.extend(if random.below(2) == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    // Holes are evenly spread around the ring, so that they stay apart.
    for hole in 0..holes {
        let (u, v) = ((f64::from(hole) + 0.5 * random.unit()) / f64::from(holes), random.unit());
        let radius = 0.10 + 0.08 * random.unit();
        let centre = [cos(u) * (1.0 + 0.4 * cos(v)), sin(u) * (1.0 + 0.4 * cos(v)), 0.4 * sin(v)];
        let far = |p: [f64; 3]| p.iter().zip(centre).map(|(x, c)| (x - c) * (x - c)).sum::<f64>() > radius * radius;
        let positions = &shape.positions;
        shape.triangles.retain(|t| t.iter().all(|&v| far(positions[v as usize])));
    }
    worn(fans_only(shape), faces, 0.15, seed).rounded()
}
