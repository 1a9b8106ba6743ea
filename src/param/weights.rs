//! What a vertex's neighbours weigh: one weight from each corner of a triangle to each of the other two.

use glam::DVec3;

use super::chart::Chart;

/// `[corner][0]`: to the next corner of the triangle, `[corner][1]`: to the one after it.
pub(super) type Weights = Vec<[[f64; 2]; 3]>;

/// No weight is further from the usual than this.
const SPREAD: f64 = 1e6;

/// All alike: each vertex becomes the mean of its neighbours (Tutte).
pub(super) fn uniform(chart: &Chart) -> Weights {
    vec![[[0.5; 2]; 3]; chart.faces()]
}

/// Mean-value coordinates (Floater 2003): the tangent of half the angle at the corner, over the edge's length. Positive, not symmetric.
pub(super) fn mean_value(chart: &Chart) -> Weights {
    let area: f64 = (0..chart.faces()).map(|f| chart.stretch2(f).0).sum();
    // An edge of the size of the triangles, so that what is clamped does not depend on units.
    let edge = (area / chart.faces().max(1) as f64).sqrt().max(f64::MIN_POSITIVE);
    let of = |[p, q, r]: [DVec3; 3]| {
        let (a, b) = (q - p, r - p);
        let (m, n) = (a.length().max(edge / SPREAD), b.length().max(edge / SPREAD));
        let half = a.cross(b).length() / (m * n + a.dot(b));
        let half = if half.is_finite() { half.clamp(1.0 / SPREAD, SPREAD) } else { SPREAD };
        [half * edge / m, half * edge / n]
    };
    let weights = (0..chart.faces()).map(|f| {
        let [p, q, r] = chart.solid(f);
        [of([p, q, r]), of([q, r, p]), of([r, p, q])]
    });
    weights.collect()
}

/// Mean-value coordinates with both directions of an edge added within each triangle: positive and symmetric.
pub(super) fn symmetric_mean_value(chart: &Chart) -> Weights {
    let mut weights = mean_value(chart);
    for w in &mut weights {
        for k in 0..3 {
            let sum = w[k][0] + w[(k + 1) % 3][1];
            w[k][0] = sum;
            w[(k + 1) % 3][1] = sum;
        }
    }
    weights
}
