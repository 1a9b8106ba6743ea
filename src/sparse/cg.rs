//! Conjugate gradients (Hestenes and Stiefel 1952) with the diagonal as preconditioner: symmetric positive definite systems
//! that need few digits.

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Conjugate {
    /// Stop when the residual has fallen to this share of the right side.
    pub(crate) tolerance: f64,
    /// Stop after so many steps.
    pub(crate) steps: usize,
}

/// Goes from zero towards the solution of `A x = b`; `times` is `A`. The best point after the allowed steps is returned.
///
/// Sums run in one fixed order, so that the result does not depend on the number of threads as long as `times` does not.
pub(crate) fn conjugate_gradients(
    b: &[f64],
    diagonal: &[f64],
    options: Conjugate,
    mut times: impl FnMut(&[f64]) -> Vec<f64>,
) -> Vec<f64> {
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
    let mut x = vec![0.0; b.len()];
    let mut r = b.to_vec();
    let goal = options.tolerance * options.tolerance * dot(b, b);
    let scaled = |r: &[f64]| -> Vec<f64> { r.iter().zip(diagonal).map(|(r, d)| if *d > 0.0 { r / d } else { *r }).collect() };
    let mut z = scaled(&r);
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    for _ in 0..options.steps {
        if !(dot(&r, &r) > goal) || !(rz > 0.0) {
            break;
        }
        let q = times(&p);
        let curvature = dot(&p, &q);
        if !(curvature > 0.0) {
            break;
        }
        let step = rz / curvature;
        for i in 0..x.len() {
            x[i] += step * p[i];
            r[i] -= step * q[i];
        }
        z = scaled(&r);
        let next = dot(&r, &z);
        let turn = next / rz;
        rz = next;
        for i in 0..p.len() {
            p[i] = z[i] + turn * p[i];
        }
    }
    x
}
