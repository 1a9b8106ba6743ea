//! A second opinion from nearby: weights that fit the known vertices around, not the whole past.
//!
//! The learned weights change slowly, while the order of coding runs along a front that is far from
//! local. So for every vertex the residuals of its known neighbours are fitted once more with the
//! first `L` features, by least squares with weights that fall with the distance and a ridge that
//! holds the fit near 0; the fit then says what the residual here might be. (After the locally
//! trained predictors of lossless image coding: X. Wu, K. U. Barthel and W. Zhang, "Piecewise 2D
//! autoregression for predictive image coding", 1998.)
//!
//! Sums run in `f32`: four at a time, and in a fixed order like everything else here.

use super::Scene;
use super::features::View;
use super::vector::Vector;

/// What a vertex taught: its features and the residual of the learned prediction, in edge lengths.
#[derive(Debug, Clone)]
struct Sample<const L: usize> {
    features: [[f32; L]; 3],
    residual: [f32; 3],
    /// One more than its class; 0 if it had no gates.
    class: u8,
}

/// The samples of all vertices of a range.
#[derive(Debug)]
pub(super) struct Local<const L: usize> {
    samples: Vec<Sample<L>>,
}

/// Holds weights near 0 where the neighbours do not settle them.
const RIDGE: f64 = 0.05;
/// A neighbour of another class counts as much less.
const OTHER_CLASS: f32 = 0.5;

impl<const L: usize> Local<L> {
    /// Memory a vertex.
    pub(super) const BYTES: u64 = size_of::<Sample<L>>() as u64;

    pub(super) fn new(vertices: usize) -> Self {
        Self { samples: vec![Sample { features: [[0.0; L]; 3], residual: [0.0; 3], class: 0 }; vertices] }
    }

    /// The residual that the known vertices `nearby` suggest, no longer than `longest`.
    pub(super) fn suggest(&self, scene: &Scene<'_>, nearby: &[u32], view: &View, class: usize, longest: f64) -> Vector {
        let mut normal = [[0.0_f32; L]; L];
        let mut right = [0.0_f32; L];
        let scale = 1.0 / view.length;
        for &u in nearby {
            let sample = &self.samples[(u - scene.first) as usize];
            if sample.class == 0 {
                continue;
            }
            let distance = (scene.at(u) - view.base) * scale;
            let mut weight = (1.0 / (1.0 + distance.dot(distance))) as f32;
            if usize::from(sample.class) != class + 1 {
                weight *= OTHER_CLASS;
            }
            for (x, &residual) in sample.features.iter().zip(&sample.residual) {
                let weighted = x.map(|x| x * weight);
                for i in 0..L {
                    // Whole blocks of four from the diagonal on; what is left of it is not used.
                    let start = i / 4 * 4;
                    let row = &mut normal[i];
                    for j in start..L {
                        row[j] += weighted[i] * x[j];
                    }
                    right[i] += weighted[i] * residual;
                }
            }
        }
        let weights = solve(&normal, &right);
        let mut suggested = Vector::ZERO;
        for axis in 0..3 {
            for i in 0..L {
                suggested.0[axis] += weights[i] * view.features[i][axis];
            }
        }
        let size = suggested.length();
        if !(size < 1e12) {
            Vector::ZERO
        } else if size > longest {
            suggested * (longest / size)
        } else {
            suggested
        }
    }

    /// Keeps what vertex number `i` of the range taught.
    pub(super) fn learn(&mut self, i: usize, view: &View, class: usize, residual: Vector) {
        let sample = &mut self.samples[i];
        let scale = 1.0 / view.length;
        for axis in 0..3 {
            for (x, feature) in sample.features[axis].iter_mut().zip(&view.features) {
                *x = (feature[axis] * scale) as f32;
            }
            sample.residual[axis] = (residual[axis] * scale) as f32;
        }
        sample.class = class as u8 + 1;
    }
}

/// Solves the normal equations with the ridge by L D Lᵀ.
fn solve<const L: usize>(normal: &[[f32; L]; L], right: &[f32; L]) -> [f64; L] {
    let mut m = [[0.0; L]; L];
    let mut b = [0.0; L];
    for i in 0..L {
        for j in i..L {
            m[i][j] = f64::from(normal[i][j]);
        }
        m[i][i] += RIDGE;
        b[i] = f64::from(right[i]);
    }
    for i in 0..L {
        let pivot = 1.0 / m[i][i];
        let row = m[i];
        for r in i + 1..L {
            let factor = row[r] * pivot;
            for c in r..L {
                m[r][c] -= factor * row[c];
            }
            b[r] -= factor * b[i];
        }
    }
    let mut solution = [0.0; L];
    for i in (0..L).rev() {
        let mut sum = b[i];
        for j in i + 1..L {
            sum -= m[i][j] * solution[j];
        }
        solution[i] = sum / m[i][i];
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_solves_the_equations() {
        let normal = [[4.0, 1.0, 0.5, 0.0], [0.0, 3.0, -1.0, 0.25], [0.0, 0.0, 5.0, 2.0], [0.0, 0.0, 0.0, 6.0]];
        let right = [1.0, -2.0, 0.5, 3.0];
        let x = solve(&normal, &right);
        for i in 0..4 {
            let row: f64 = (0..4).map(|j| f64::from(normal[i.min(j)][i.max(j)]) * x[j]).sum::<f64>() + RIDGE * x[i];
            assert!((row - f64::from(right[i])).abs() < 1e-9, "row {i}: {row}");
        }
    }
}
