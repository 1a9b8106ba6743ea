//! Rate–distortion curves: the points that no other point beats, and the Bjøntegaard delta rate between two curves.
//!
//! G. Bjøntegaard, "Calculation of average PSNR differences between RD-curves", VCEG-M33, 2001. There a cubic is laid through
//! four points; here, as in later practice (JCTVC-L1100 and its successors), a piecewise cubic that keeps the points' order:
//! F. N. Fritsch and J. Butland, "A method for constructing local monotone piecewise cubic interpolants", SIAM J. Sci. Stat.
//! Comput. 5(2), 1984, with its three-point slopes at the ends. The logarithm of the bytes is a function of the psnr; the mean
//! difference of two such functions over the psnr that both reach is the logarithm of the delta rate.

/// One file: what it costs and what it is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RatePoint {
    /// Bytes of the whole file.
    pub bytes: u64,
    /// Its psnr in dB.
    pub psnr: f64,
}

/// A psnr from which on surfaces are equal for every purpose: such a point is on no curve.
pub const PSNR_WITHOUT_LOSS: f64 = 300.0;

impl RatePoint {
    /// Whether the point can be on a curve: it has bytes, and a psnr that is a number and no stand-in for infinity.
    pub fn is_lossy(&self) -> bool {
        self.bytes > 0 && self.psnr < PSNR_WITHOUT_LOSS
    }
}

/// Which points are on the Pareto front: no other has at most as many bytes and at least the same psnr, with one of the two
/// better. Of equal points the first is on it. The places come in the order of growing bytes (and psnr). O(n log n).
pub fn pareto(points: &[RatePoint]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).filter(|&i| !points[i].psnr.is_nan()).collect();
    order.sort_by(|&i, &j| {
        let (a, b) = (points[i], points[j]);
        a.bytes.cmp(&b.bytes).then(b.psnr.total_cmp(&a.psnr)).then(i.cmp(&j))
    });
    let mut best = f64::NEG_INFINITY;
    order.retain(|&i| {
        let is_better = points[i].psnr > best;
        best = best.max(points[i].psnr);
        is_better
    });
    order
}

/// How the bytes of one curve compare with those of another at equal psnr.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BdRate {
    /// Over an interval of psnr that both curves reach.
    Over {
        /// The mean difference of the natural logarithms of the bytes.
        log_ratio: f64,
        /// The interval, in dB.
        psnr: [f64; 2],
    },
    /// No psnr is reached by both.
    NoOverlap,
    /// One of the curves has fewer than two points.
    TooFewPoints,
}

impl BdRate {
    /// The delta rate in percent: −20 says that a fifth of the bytes is saved at equal psnr.
    pub fn percent(&self) -> Option<f64> {
        match self {
            Self::Over { log_ratio, .. } => Some(percent(*log_ratio)),
            _ => None,
        }
    }
}

/// A mean difference of logarithms as a change in percent.
pub(crate) fn percent(log_ratio: f64) -> f64 {
    100.0 * log_ratio.exp_m1()
}

/// The Bjøntegaard delta rate of `other` against `reference`.
///
/// Points that others of their curve beat are left out first, and so are those without loss, whose psnr is no number.
///
/// ```
/// # use gimc::eval::{RatePoint, bd_rate};
/// let curve = |share: u64| [(500, 60.0), (1000, 66.0), (2500, 73.0)].map(|(bytes, psnr)| RatePoint { bytes: bytes * share, psnr });
/// let saved = bd_rate(&curve(10), &curve(8)).percent().unwrap();
/// assert!((saved + 20.0).abs() < 1e-9);
/// ```
pub fn bd_rate(reference: &[RatePoint], other: &[RatePoint]) -> BdRate {
    let (Some(a), Some(b)) = (Cubics::through(reference), Cubics::through(other)) else { return BdRate::TooFewPoints };
    let low = a.ends()[0].max(b.ends()[0]);
    let high = a.ends()[1].min(b.ends()[1]);
    if !(low < high) {
        return BdRate::NoOverlap;
    }
    let log_ratio = (b.integral(low, high) - a.integral(low, high)) / (high - low);
    BdRate::Over { log_ratio, psnr: [low, high] }
}

/// The logarithm of the bytes as a piecewise cubic function of the psnr.
struct Cubics {
    /// Psnr, growing.
    x: Vec<f64>,
    /// Natural logarithm of the bytes.
    y: Vec<f64>,
    /// Slopes at the points.
    slopes: Vec<f64>,
}

impl Cubics {
    fn through(points: &[RatePoint]) -> Option<Self> {
        let lossy: Vec<RatePoint> = points.iter().copied().filter(RatePoint::is_lossy).collect();
        let front = pareto(&lossy);
        if front.len() < 2 {
            return None;
        }
        let x: Vec<f64> = front.iter().map(|&i| lossy[i].psnr).collect();
        let y: Vec<f64> = front.iter().map(|&i| (lossy[i].bytes as f64).ln()).collect();
        let slopes = slopes(&x, &y);
        Some(Self { x, y, slopes })
    }

    fn ends(&self) -> [f64; 2] {
        [self.x[0], self.x[self.x.len() - 1]]
    }

    /// From `low` to `high`, both between the ends.
    fn integral(&self, low: f64, high: f64) -> f64 {
        let mut sum = 0.0;
        for i in 0..self.x.len() - 1 {
            let (from, to) = (low.max(self.x[i]), high.min(self.x[i + 1]));
            if from < to {
                sum += self.primitive(i, to) - self.primitive(i, from);
            }
        }
        sum
    }

    /// The integral over piece `i` from its start to `x`, of the cubic in Hermite's form.
    fn primitive(&self, i: usize, x: f64) -> f64 {
        let h = self.x[i + 1] - self.x[i];
        let t = (x - self.x[i]) / h;
        let (t2, t3, t4) = (t * t, t * t * t, t * t * t * t);
        let of_values = self.y[i] * (t4 / 2.0 - t3 + t) + self.y[i + 1] * (t3 - t4 / 2.0);
        let of_slopes = self.slopes[i] * (t4 / 4.0 - 2.0 * t3 / 3.0 + t2 / 2.0) + self.slopes[i + 1] * (t4 / 4.0 - t3 / 3.0);
        h * (of_values + h * of_slopes)
    }
}

/// Slopes that keep the order of the values: inside a weighted harmonic mean of the neighbours' slopes, at the ends the
/// three-point slope, cut where it would overshoot.
fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let h: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
    let rise: Vec<f64> = (0..n - 1).map(|i| (y[i + 1] - y[i]) / h[i]).collect();
    if n == 2 {
        return vec![rise[0]; 2];
    }
    let end = |h0: f64, h1: f64, d0: f64, d1: f64| {
        let slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
        if slope * d0 <= 0.0 {
            0.0
        } else if d0 * d1 <= 0.0 && slope.abs() > 3.0 * d0.abs() {
            3.0 * d0
        } else {
            slope
        }
    };
    let mut slopes = vec![end(h[0], h[1], rise[0], rise[1])];
    for i in 1..n - 1 {
        let (before, after) = (rise[i - 1], rise[i]);
        let (w1, w2) = (2.0 * h[i] + h[i - 1], h[i] + 2.0 * h[i - 1]);
        slopes.push(if before * after <= 0.0 { 0.0 } else { (w1 + w2) / (w1 / before + w2 / after) });
    }
    slopes.push(end(h[n - 2], h[n - 3], rise[n - 2], rise[n - 3]));
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn curve(points: &[(u64, f64)]) -> Vec<RatePoint> {
        points.iter().map(|&(bytes, psnr)| RatePoint { bytes, psnr }).collect()
    }

    fn percent_of(a: &[(u64, f64)], b: &[(u64, f64)]) -> f64 {
        bd_rate(&curve(a), &curve(b)).percent().unwrap()
    }

    const A: [(u64, f64); 5] = [(1000, 54.0), (1700, 61.5), (2600, 66.0), (5000, 72.0), (9000, 77.5)];

    #[test]
    fn four_fifths_of_the_bytes_are_minus_twenty_percent() {
        let b = A.map(|(bytes, psnr)| (bytes / 5 * 4, psnr));
        assert!((percent_of(&A, &b) + 20.0).abs() < 1e-10);
        assert!((percent_of(&b, &A) - 25.0).abs() < 1e-10);
        assert_eq!(percent_of(&A, &A), 0.0);
    }

    #[test]
    fn straight_lines_give_the_mean_of_their_difference() {
        // ln bytes = ln 1024 + (p − 60)·ln 2 / 10 against the same with ln 2 / 5: over 60 to 80 dB the difference grows from 0 to
        // 2 ln 2, and its mean is ln 2: twice the bytes.
        let a = [(1024, 60.0), (2048, 70.0), (4096, 80.0)];
        let b = [(1024, 60.0), (4096, 70.0), (16384, 80.0), (65536, 90.0)];
        assert!((percent_of(&a, &b) - 100.0).abs() < 1e-9);
        // Over 70 to 80 dB alone the mean is 1.5 ln 2.
        assert!((percent_of(&a, &b[1..]) - 100.0 * (2.0_f64.powf(1.5) - 1.0)).abs() < 1e-9);
        assert_eq!(bd_rate(&curve(&a), &curve(&b[1..])), bd_rate(&curve(&a), &curve(&b[1..])));
    }

    #[test]
    fn the_interval_is_what_both_curves_reach_and_no_more() {
        let b = [(900, 58.0), (2000, 70.0), (12000, 90.0)];
        let BdRate::Over { psnr, .. } = bd_rate(&curve(&A), &curve(&b)) else { panic!("no overlap") };
        assert_eq!(psnr, [58.0, 77.5]);
        let beyond = curve(&[(10, 10.0), (20, 54.0)]);
        assert_eq!(bd_rate(&curve(&A), &beyond), BdRate::NoOverlap);
        assert_eq!(bd_rate(&curve(&A), &beyond[..1]), BdRate::TooFewPoints);
        assert_eq!(bd_rate(&[], &curve(&A)), BdRate::TooFewPoints);
    }

    #[test]
    fn points_without_loss_and_points_that_others_beat_change_nothing() {
        let mut more = A.to_vec();
        more.extend([(20_000, 999.0), (4000, 60.0), (9000, 70.0)]);
        let b = [(900, 58.0), (2000, 70.0), (12000, 90.0)];
        assert_eq!(percent_of(&more, &b), percent_of(&A, &b));
    }

    #[test]
    fn the_cubics_are_those_of_another_program() {
        // The integral of scipy.interpolate.PchipInterpolator (1.17) over the common interval of these two curves.
        let b = [(1200, 55.0), (1900, 63.0), (2400, 66.5), (4700, 71.0), (9500, 79.0)];
        let BdRate::Over { log_ratio, psnr } = bd_rate(&curve(&A), &curve(&b)) else { panic!("no overlap") };
        assert_eq!(psnr, [55.0, 77.5]);
        assert!((log_ratio - SCIPY).abs() < 1e-12, "{log_ratio}");
    }

    /// Printed by five lines of Python: `(B.integrate(55, 77.5) - A.integrate(55, 77.5)) / 22.5` with `y = log(bytes)`.
    const SCIPY: f64 = 0.009032063992162876;

    /// The definition, word for word.
    fn front_as_defined(points: &[RatePoint]) -> Vec<usize> {
        let beats = |j: usize, i: usize| {
            let (a, b) = (points[j], points[i]);
            let at_least = a.bytes <= b.bytes && a.psnr >= b.psnr;
            at_least && (a != b || j < i)
        };
        let mut front: Vec<usize> = (0..points.len()).filter(|&i| !(0..points.len()).any(|j| j != i && beats(j, i))).collect();
        front.sort_by_key(|&i| points[i].bytes);
        front
    }

    proptest! {
        #[test]
        fn the_front_is_that_of_the_definition(raw in proptest::collection::vec((1_u64..20, 0_u8..20), 0..40)) {
            let points: Vec<RatePoint> = raw.iter().map(|&(bytes, psnr)| RatePoint { bytes, psnr: psnr.into() }).collect();
            prop_assert_eq!(pareto(&points), front_as_defined(&points));
        }

        #[test]
        fn delta_rates_turn_their_sign_when_the_curves_change_places(
            a in proptest::collection::btree_map(500_u64..9000, 0_u8..40, 2..8),
            b in proptest::collection::btree_map(500_u64..9000, 0_u8..40, 2..8),
        ) {
            let curve = |m: &std::collections::BTreeMap<u64, u8>| -> Vec<RatePoint> {
                m.iter().map(|(&bytes, &psnr)| RatePoint { bytes, psnr: 50.0 + f64::from(psnr) }).collect()
            };
            let (a, b) = (curve(&a), curve(&b));
            match (bd_rate(&a, &b), bd_rate(&b, &a)) {
                (BdRate::Over { log_ratio: x, psnr: p }, BdRate::Over { log_ratio: y, psnr: q }) => {
                    prop_assert!((x + y).abs() < 1e-9);
                    prop_assert_eq!(p, q);
                    // Between the greatest and the least ratio of any two points.
                    prop_assert!(x.abs() <= (9000.0_f64 / 500.0).ln() + 1e-9);
                }
                (x, y) => prop_assert_eq!(x, y),
            }
        }
    }
}
