//! What a later stage knows beside the past: where, roughly, everything around a vertex lies.
//!
//! The vertices that come later in the order are known to a cell of the coarser lattice. So the surface around a vertex
//! is known on all sides, on some only roughly, and what that suggests corrects the prediction from the past: the
//! suggestions below, in units of the edge length, are weighted as least squares learns.

use super::super::topology::turn;
use super::least_squares::LeastSquares;
use super::ring::Ring;
use super::vector::Vector;
use super::{Scene, learn};
use crate::mesh::half_edge::{next, prev};

/// The suggestions of [`Suggestions::new`].
const SUGGESTIONS: usize = 4;

/// Weights of the suggestions, by the class of the vertex.
#[derive(Debug)]
pub(super) struct Around {
    weights: Vec<LeastSquares<SUGGESTIONS>>,
}

/// What the surroundings of one vertex suggest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Suggestions {
    /// The prediction without them.
    pub(super) prediction: Vector,
    /// How far each suggestion is from that.
    differences: [Vector; SUGGESTIONS],
}

impl Around {
    pub(super) fn new(classes: usize) -> Self {
        Self { weights: vec![LeastSquares::new([0.0; SUGGESTIONS], 0.999, 0.1); classes] }
    }

    /// The prediction with what the surroundings suggest, weighted.
    pub(super) fn correct(&self, class: usize, suggestions: &Suggestions, length: f64, largest: f64) -> Vector {
        let mut correction = Vector::ZERO;
        for axis in 0..3 {
            correction.0[axis] = self.weights[class].predict(&suggestions.inputs(axis, 1.0 / length)) * length;
        }
        // A correction that runs off means nothing.
        if correction.length() <= largest { suggestions.prediction + correction } else { suggestions.prediction }
    }

    /// Learns from a position, as [`learn`] does.
    pub(super) fn learn(&mut self, class: usize, suggestions: &Suggestions, position: Vector, scale: f64, most: f64) {
        for axis in 0..3 {
            let wanted = (position[axis] - suggestions.prediction[axis]) * scale;
            learn(&mut self.weights[class], &suggestions.inputs(axis, scale), wanted, most);
        }
    }
}

impl Suggestions {
    /// The mean parallelogram over the faces that are not wholly known; the mean of all neighbours, and of those that are
    /// not known; and the mean of all neighbours, each moved as it lies off the mean of its own.
    pub(super) fn new(scene: &Scene<'_>, ring: &Ring, v: u32, prediction: Vector) -> Self {
        let [mut parallelograms, mut all, mut unknown, mut curved] = [Mean::default(); 4];
        each_half_edge(scene, v, |h| {
            let surface = scene.surface;
            let corners @ [a, b, c] =
                [surface.from(next(h)), surface.from(prev(h)), surface.apex(surface.opposite[next(h) as usize])];
            if corners.iter().all(|&u| scene.has(u)) && !corners.iter().all(|&u| scene.order.is_known(u)) {
                parallelograms.add(scene.at(a) + scene.at(b) - scene.at(c));
            }
        });
        for &a in ring.all.iter().filter(|&&a| scene.has(a)) {
            all.add(scene.at(a));
            if !scene.order.is_known(a) {
                unknown.add(scene.at(a));
            }
            let mut others = Mean::default();
            each_half_edge(scene, a, |h| {
                let u = scene.surface.from(next(h));
                if u != v && scene.has(u) {
                    others.add(scene.at(u));
                }
            });
            if let Some(mean) = others.get() {
                curved.add(scene.at(a) * 2.0 - mean);
            }
        }
        let difference = |mean: Mean| mean.get().map_or(Vector::ZERO, |m| m - prediction);
        Self { prediction, differences: [parallelograms, all, unknown, curved].map(difference) }
    }

    fn inputs(&self, axis: usize, scale: f64) -> [f64; SUGGESTIONS] {
        self.differences.map(|d| d[axis] * scale)
    }
}

/// Half-edges looked at around a vertex, at most: one of very many neighbours must not make all around it slow.
const TURNS: usize = 64;

fn each_half_edge(scene: &Scene<'_>, v: u32, mut f: impl FnMut(u32)) {
    let start = scene.outgoing[v as usize];
    let mut h = start;
    for _ in 0..TURNS {
        f(h);
        h = turn(&scene.surface.opposite, h);
        if h == start {
            break;
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Mean {
    sum: Vector,
    count: u32,
}

impl Default for Mean {
    fn default() -> Self {
        Self { sum: Vector::ZERO, count: 0 }
    }
}

impl Mean {
    fn add(&mut self, point: Vector) {
        self.sum += point;
        self.count += 1;
    }

    fn get(self) -> Option<Vector> {
        (self.count > 0).then(|| self.sum * (1.0 / f64::from(self.count)))
    }
}
