//! How the squared distance between a point and a triangle changes when either moves (in place of paper 000's equations 9 to 17).
//!
//! Let `p` be the point, `c` the closest point of the triangle and `w` the weights of its corners that give `c`. Whatever `c` lies
//! on, corner, edge or face, the `w` may be held while the corners move (envelope theorem), so that
//!
//! ```text
//! ∂d²/∂qᵢ = 2 wᵢ (c − p)   for the triangle's corners q
//! ∂d²/∂pᵢ = 2 αᵢ (p − c)   for the corners of the triangle in which p has the weights α
//! ```

use glam::DVec3;

/// By corners of the closest triangle.
pub(super) fn of_triangle(p: DVec3, c: DVec3, w: [f64; 3]) -> [DVec3; 3] {
    w.map(|w| 2.0 * w * (c - p))
}

/// By corners of the triangle that the point is on.
pub(super) fn of_point(p: DVec3, c: DVec3, alpha: [f64; 3]) -> [DVec3; 3] {
    alpha.map(|a| 2.0 * a * (p - c))
}

#[cfg(test)]
mod tests {
    use super::super::fit::barycentric;
    use super::*;
    use crate::geom::{Bvh, Triangle, distance2};
    use proptest::prelude::*;

    fn point(size: f64) -> impl Strategy<Value = DVec3> {
        [-size..size, -size..size, -size..size].prop_map(DVec3::from)
    }

    fn closest(p: DVec3, t: Triangle) -> DVec3 {
        Bvh::new(&[t]).on(0, p).point
    }

    /// Central differences of `f` by each coordinate of each corner.
    fn differences(t: Triangle, f: impl Fn(Triangle) -> f64) -> [DVec3; 3] {
        const H: f64 = 1e-6;
        [0, 1, 2].map(|k| {
            DVec3::from([0, 1, 2].map(|axis| {
                let (mut more, mut less) = (t, t);
                more[k][axis] += H;
                less[k][axis] -= H;
                (f(more) - f(less)) / (2.0 * H)
            }))
        })
    }

    fn agree(exact: [DVec3; 3], approximate: [DVec3; 3]) -> bool {
        let scale = exact.iter().map(|g| g.length()).fold(1.0, f64::max);
        (0..3).all(|k| exact[k].distance(approximate[k]) < 1e-7 * scale)
    }

    /// Where the closest point passes from one feature to another the second derivative jumps, and differences see both.
    fn far_from_other_features(p: DVec3, t: Triangle) -> bool {
        let w = barycentric(closest(p, t), t);
        let area = (t[1] - t[0]).cross(t[2] - t[0]).length();
        area > 0.1 && w.iter().all(|w| *w == 0.0 || *w > 1e-3)
    }

    proptest! {
        #[test]
        fn gradients_agree_with_central_differences(
            p in point(2.0),
            q in [point(1.0), point(1.0), point(1.0)],
            t in [point(1.0), point(1.0), point(1.0)],
            (a, b) in (0.0..1.0_f64, 0.0..1.0_f64),
        ) {
            prop_assume!(far_from_other_features(p, q));
            let c = closest(p, q);
            prop_assert!(agree(of_triangle(p, c, barycentric(c, q)), differences(q, |q| distance2(p, q))));
            let alpha = [(1.0 - a) * b, a * b, 1.0 - b];
            let at = |t: Triangle| (0..3).map(|k| alpha[k] * t[k]).sum::<DVec3>();
            prop_assume!(far_from_other_features(at(t), q));
            let c = closest(at(t), q);
            prop_assert!(agree(of_point(at(t), c, alpha), differences(t, |t| distance2(at(t), q))));
        }
    }
}
