//! How large a residual will be: two learned numbers, across the normal and along it.

use super::Scene;
use super::features::View;
use super::least_squares::LeastSquares;
use super::math::{exp, ln};
use super::ring::Ring;

/// Logarithms that a scale is learned from.
const INPUTS: usize = 16;
/// With the logarithm of the unit, where vertices slide.
const WITH_UNIT: usize = INPUTS + 1;

/// Learns the logarithms of |residual| across and along the normal.
#[derive(Debug, Clone)]
pub(super) struct Scale {
    across: Model,
    along: Model,
}

#[derive(Debug, Clone)]
enum Model {
    Plain(LeastSquares<INPUTS>),
    /// Of residuals in a unit that changes from vertex to vertex.
    InUnits(LeastSquares<WITH_UNIT>),
}

impl Model {
    fn predict(&self, inputs: &[f64; INPUTS], log_unit: f64) -> f64 {
        match self {
            Self::Plain(model) => model.predict(inputs),
            Self::InUnits(model) => model.predict(&with(inputs, log_unit)),
        }
    }

    fn learn(&mut self, inputs: &[f64; INPUTS], log_unit: f64, error: f64) {
        match self {
            Self::Plain(model) => model.learn(inputs, error),
            Self::InUnits(model) => model.learn(&with(inputs, log_unit), error),
        }
    }
}

fn with(inputs: &[f64; INPUTS], log_unit: f64) -> [f64; WITH_UNIT] {
    let mut all = [log_unit; WITH_UNIT];
    all[..INPUTS].copy_from_slice(inputs);
    all
}

/// What a scale is made from, and the residuals' expected sizes.
#[derive(Debug, Clone)]
pub(super) struct Expected {
    inputs: [f64; INPUTS],
    logs: [f64; 2],
    /// What residuals across and along are counted in, and the logarithm of the first.
    units: [f64; 2],
    log_unit: f64,
    /// Expected |residual| across the normal.
    pub(super) across: f64,
    /// Expected |residual| along the normal.
    pub(super) along: f64,
}

const FORGETTING: f64 = 0.9992;
const VARIANCE: f64 = 0.05;
/// The first weight of a unit's logarithm, across.
const UNIT_ACROSS: f64 = -0.5;

/// Rounding to the lattice alone moves a coordinate by this much.
const SMALLEST: [f64; 2] = [0.05, 0.03];

impl Scale {
    pub(super) fn new([across, along]: [[f64; INPUTS]; 2]) -> Self {
        let model = |start| Model::Plain(LeastSquares::new(start, FORGETTING, VARIANCE));
        Self { across: model(across), along: model(along) }
    }

    /// The same for residuals in units.
    pub(super) fn in_units([across, along]: [[f64; INPUTS]; 2]) -> Self {
        // What a larger unit takes off the logarithm across.
        let model = |start, unit| Model::InUnits(LeastSquares::new(with(start, unit), FORGETTING, VARIANCE));
        Self { across: model(&across, UNIT_ACROSS), along: model(&along, 0.0) }
    }

    /// What to expect of a vertex that is predicted `shift` away from the mean parallelogram. `units` are 1 where
    /// vertices do not slide.
    pub(super) fn expect(&self, scene: &Scene<'_>, ring: &Ring, view: &View, shift: f64, units: [f64; 2], v: u32) -> Expected {
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
        let log_unit = ln(units[0]);
        let logs = [self.across.predict(&inputs, log_unit), self.along.predict(&inputs, log_unit)];
        let within = |i: usize| (exp(logs[i]) * units[i]).clamp(SMALLEST[i], scene.largest);
        Expected { inputs, logs, units, log_unit, across: within(0), along: within(1) }
    }

    /// Learns the sizes that a residual had.
    pub(super) fn learn(&mut self, expected: &Expected, across: f64, along: f64) {
        let Expected { inputs, logs, units, log_unit, .. } = expected;
        self.across.learn(inputs, *log_unit, ln(across / units[0] * 0.9 + 0.25) - logs[0]);
        self.along.learn(inputs, *log_unit, ln(along / units[1] * 1.5 + 0.2) - logs[1]);
    }
}
