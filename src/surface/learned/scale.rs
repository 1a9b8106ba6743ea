//! How large a residual will be: two learned numbers, across the normal and along it.

use super::Scene;
use super::features::View;
use super::least_squares::LeastSquares;
use super::math::{exp, ln};
use super::ring::Ring;

/// Logarithms that a scale is learned from.
const INPUTS: usize = 16;

/// Learns the logarithms of |residual| across and along the normal.
#[derive(Debug, Clone)]
pub(super) struct Scale {
    across: LeastSquares<INPUTS>,
    along: LeastSquares<INPUTS>,
}

/// What a scale is made from, and the residuals' expected sizes.
#[derive(Debug, Clone)]
pub(super) struct Expected {
    inputs: [f64; INPUTS],
    logs: [f64; 2],
    /// Expected |residual| across the normal.
    pub(super) across: f64,
    /// Expected |residual| along the normal.
    pub(super) along: f64,
}

/// Rounding to the lattice alone moves a coordinate by this much.
const SMALLEST: [f64; 2] = [0.05, 0.03];

impl Scale {
    pub(super) fn new([across, along]: [[f64; INPUTS]; 2]) -> Self {
        let model = |start| LeastSquares::new(start, 0.9992, 0.05);
        Self { across: model(across), along: model(along) }
    }

    /// What to expect of a vertex that is predicted `shift` away from the mean parallelogram.
    pub(super) fn expect(&self, scene: &Scene<'_>, ring: &Ring, view: &View, shift: f64, v: u32) -> Expected {
        let [along, across] = scene.mean_errors(ring);
        let (mut defect, mut defect_along, mut count) = (0.0, 0.0, 0.0);
        for d in view.features[7..11].iter().chain(&view.features[16..24]) {
            let size = d.length();
            if size > 0.0 {
                defect += size;
                defect_along += d.dot(view.normal).abs();
                count += 1.0;
            }
        }
        if count > 0.0 {
            defect /= count;
            defect_along /= count;
        }
        let (mut nearest, mut farthest) = (f64::MAX, 0.0_f64);
        for &a in &ring.known {
            let d = (scene.at(a) - view.base).length();
            nearest = nearest.min(d);
            farthest = farthest.max(d);
        }
        let mut bend = 0.0;
        for g in &ring.gates {
            let n = (scene.at(g.b) - scene.at(g.a)).cross(scene.at(g.c) - scene.at(g.a));
            let size = n.length();
            if size > 0.0 {
                bend += 1.0 - n.dot(view.normal) / size;
            }
        }
        let log = |x: f64| ln(x + 0.3);
        let inputs = [
            1.0,
            log(along),
            log(across),
            ln(view.length),
            log(view.spread[0]),
            log(view.spread[1]),
            log(shift),
            log(view.features[5].dot(view.normal).abs()),
            log(defect),
            log(defect_along),
            log(view.features[0].length()),
            log(view.features[2].length()),
            log(nearest),
            log(farthest),
            0.3 * (scene.degree(v) - 6.0),
            ln(bend.max(0.0) / ring.gates.len() as f64 + 0.003),
        ];
        let logs = [self.across.predict(&inputs), self.along.predict(&inputs)];
        let within = |log: f64, smallest: f64| exp(log).clamp(smallest, scene.largest);
        Expected { inputs, logs, across: within(logs[0], SMALLEST[0]), along: within(logs[1], SMALLEST[1]) }
    }

    /// Learns the sizes that a residual had.
    pub(super) fn learn(&mut self, expected: &Expected, across: f64, along: f64) {
        self.across.learn(&expected.inputs, ln(across * 0.9 + 0.25) - expected.logs[0]);
        self.along.learn(&expected.inputs, ln(along * 1.5 + 0.2) - expected.logs[1]);
    }
}
