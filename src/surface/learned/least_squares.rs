//! Recursive least squares with exponential forgetting: weights that follow the data
//! (L. Ljung and T. Söderström, "Theory and Practice of Recursive Identification", 1983).

/// Weights w for y ≈ w · x, learned one pair at a time. O(N²) an update.
#[derive(Debug, Clone)]
pub(super) struct LeastSquares<const N: usize> {
    weights: [f64; N],
    /// The inverse of the weighted sum of x xᵀ.
    inverse: Box<[[f64; N]; N]>,
    /// The weight of the past is multiplied by this at every update.
    forgetting: f64,
    updates: u32,
}

/// Rounding makes the inverse slowly lose its symmetry, and forgetting would multiply that without end:
/// so it is made symmetric again after this many updates.
const UPDATES_A_REPAIR: u32 = 32;

/// A feature that stays 0 would let its variance grow without end: above this trace everything is halved.
const LARGEST_TRACE: f64 = 1e6;

impl<const N: usize> LeastSquares<N> {
    /// Starts from the given weights, which may be off by `variance` each.
    pub(super) fn new(weights: [f64; N], forgetting: f64, variance: f64) -> Self {
        let mut inverse = Box::new([[0.0; N]; N]);
        for (i, row) in inverse.iter_mut().enumerate() {
            row[i] = variance;
        }
        Self { weights, inverse, forgetting, updates: 0 }
    }

    /// w · x
    #[inline]
    pub(super) fn predict(&self, x: &[f64; N]) -> f64 {
        let mut sum = 0.0;
        for i in 0..N {
            sum += self.weights[i] * x[i];
        }
        sum
    }

    /// Learns that x gave an answer that is `error` above the prediction.
    #[inline]
    pub(super) fn learn(&mut self, x: &[f64; N], error: f64) {
        // k = P x, by columns: every element has its own sum, so the order of additions is fixed and
        // the loop still runs several elements at a time.
        let mut k = [0.0; N];
        for (row, &x) in self.inverse.iter().zip(x) {
            for i in 0..N {
                k[i] += row[i] * x;
            }
        }
        let mut d = self.forgetting;
        for i in 0..N {
            d += x[i] * k[i];
        }
        let inverse_d = 1.0 / d;
        let inverse_forgetting = 1.0 / self.forgetting;
        let gain = error * inverse_d;
        let mut trace = 0.0;
        for (i, row) in self.inverse.iter_mut().enumerate() {
            self.weights[i] += k[i] * gain;
            let scaled = k[i] * inverse_d;
            for j in 0..N {
                row[j] = (row[j] - scaled * k[j]) * inverse_forgetting;
            }
            trace += row[i];
        }
        self.updates = self.updates.wrapping_add(1);
        if self.updates.is_multiple_of(UPDATES_A_REPAIR) {
            for i in 1..N {
                for j in 0..i {
                    self.inverse[i][j] = self.inverse[j][i];
                }
            }
        }
        if !(trace <= LARGEST_TRACE) {
            self.calm(trace.is_finite());
        }
    }

    #[cold]
    fn calm(&mut self, is_finite: bool) {
        if is_finite && self.weights.iter().all(|w| w.is_finite()) {
            self.inverse.iter_mut().flatten().for_each(|p| *p *= 0.5);
        } else {
            *self = Self::new([0.0; N], self.forgetting, 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_the_weights_of_a_linear_law() {
        let law = [0.5, -1.25, 3.0];
        let mut model = LeastSquares::<3>::new([0.0; 3], 0.999, 100.0);
        let mut state = 1_u32;
        for _ in 0..300 {
            let x = [(); 3].map(|()| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(state >> 16) / 65536.0 - 0.5
            });
            let y: f64 = (0..3).map(|i| law[i] * x[i]).sum();
            let error = y - model.predict(&x);
            model.learn(&x, error);
        }
        for i in 0..3 {
            assert!((model.weights[i] - law[i]).abs() < 1e-2, "{:?}", model.weights);
        }
    }

    #[test]
    fn features_that_stay_zero_or_numbers_that_run_off_do_not_break_it() {
        let mut model = LeastSquares::<2>::new([0.0; 2], 0.9, 1.0);
        for _ in 0..10_000 {
            model.learn(&[0.0, 1.0], 0.5);
        }
        model.learn(&[1e200, 1e200], 1e200);
        model.learn(&[1.0, 1.0], 1.0);
        assert!(model.predict(&[1.0, 1.0]).is_finite());
    }
}
