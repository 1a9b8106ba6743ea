//! The point of a triangle that is closest to a given point, and which feature it lies on.
//!
//! Where the point's projection falls inside, the distance is the height over the plane; everywhere
//! else it is the least distance to the three edges. Triangles without area are their edges, so any
//! three finite points will do.

use glam::DVec3;

/// Three corners, counter-clockwise seen from outside.
pub(crate) type Triangle = [DVec3; 3];

/// Points of a triangle that stand for all of it where distances are looked at, by the weights of its corners: the corners, the
/// middles of the edges, the centre.
#[cfg(feature = "encode")]
pub(crate) const PLACES: [[f64; 3]; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
];

/// What part of a triangle a point lies on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Feature {
    /// Corner 0, 1 or 2.
    Vertex(u8),
    /// The edge from corner `e` to the next.
    Edge(u8),
    /// The inside.
    Face,
}

/// The closest point of a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Closest {
    pub(crate) point: DVec3,
    pub(crate) distance2: f64,
    pub(crate) feature: Feature,
}

/// Below this squared sine of its angle at corner 0 a triangle is narrow: its normal has lost up to
/// half of its digits, and heights are measured from the nearest edge instead of from corner 0.
const NARROW: f64 = 1e-12;

/// Below this squared sine the triangle is its edges: they miss at most 1e-12 of its length,
/// and the normal would be wrong by more than 1e-4.
const FLAT: f64 = 1e-24;

/// The closest point of the segment from `a` to `b`, as a share of the way.
#[inline]
fn along(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let d = b - a;
    let length2 = d.length_squared();
    if length2 > 0.0 { ((p - a).dot(d) / length2).clamp(0.0, 1.0) } else { 0.0 }
}

/// The difference from the closest point of the segment `a b` to `p`. The end `b` gives `p − b` exactly.
#[inline]
fn from_segment(p: DVec3, a: DVec3, b: DVec3) -> DVec3 {
    match along(p, a, b) {
        1.0 => p - b,
        t => (p - a) - t * (b - a),
    }
}

/// The normal (its length twice the area) and its squared length, if the projection of `p` falls inside.
#[inline]
fn above(p: DVec3, [a, b, c]: Triangle) -> Option<(DVec3, f64, bool)> {
    let (u, v) = (b - a, c - a);
    let n = u.cross(v);
    let nn = n.length_squared();
    let scale = u.length_squared() * v.length_squared();
    if !(nn > FLAT * scale && nn > 0.0) {
        return None;
    }
    let q = p - a;
    let inside = n.cross(u).dot(q) >= 0.0 && v.cross(n).dot(q) >= 0.0 && n.cross(c - b).dot(p - b) >= 0.0;
    inside.then_some((n, nn, nn < NARROW * scale))
}

/// Squared distance from a point to a triangle; exactly zero at its corners.
#[inline]
pub(crate) fn distance2(p: DVec3, t: Triangle) -> f64 {
    let inside = above(p, t);
    if let Some((n, nn, false)) = inside {
        // A corner's projection may fall inside by rounding, and its height be the rounding of zero.
        let h = if t.contains(&p) { 0.0 } else { n.dot(p - t[0]) };
        return h * h / nn;
    }
    let [a, b, c] = t;
    let edges = [from_segment(p, a, b), from_segment(p, b, c), from_segment(p, c, a)];
    let nearest = edges.into_iter().min_by(|x, y| x.length_squared().total_cmp(&y.length_squared())).unwrap_or(DVec3::ZERO);
    let least = nearest.length_squared();
    match inside {
        Some((n, nn, _)) => {
            let h = n.dot(nearest);
            least.min(h * h / nn)
        }
        None => least,
    }
}

/// The closest point of a triangle and the feature it lies on.
pub(crate) fn closest(p: DVec3, t: Triangle) -> Closest {
    let distance2 = distance2(p, t);
    if let Some((n, nn, _)) = above(p, t) {
        let point = p - n * (n.dot(p - t[0]) / nn);
        return Closest { point, distance2, feature: Feature::Face };
    }
    let mut best = Closest { point: t[0], distance2: f64::INFINITY, feature: Feature::Vertex(0) };
    for e in 0..3_u8 {
        let (from, to) = (t[e as usize], t[(e as usize + 1) % 3]);
        let s = along(p, from, to);
        let d = from_segment(p, from, to).length_squared();
        if d < best.distance2 {
            let (point, feature) = match s {
                0.0 => (from, Feature::Vertex(e)),
                1.0 => (to, Feature::Vertex((e + 1) % 3)),
                _ => (from + s * (to - from), Feature::Edge(e)),
            };
            best = Closest { point, distance2: d, feature };
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The slow twin: ever finer grids of points around the best so far.
    fn by_search(p: DVec3, [a, b, c]: Triangle) -> f64 {
        let at = |u: f64, v: f64| a + (b - a) * u + (c - a) * v;
        let (mut u0, mut v0, mut width, mut best) = (0.0, 0.0, 1.0, f64::INFINITY);
        for _ in 0..40 {
            let (cu, cv) = (u0, v0);
            for i in -8..=8 {
                for j in -8..=8 {
                    let u = f64::clamp(cu + width * f64::from(i) / 8.0, 0.0, 1.0);
                    let v = f64::clamp(cv + width * f64::from(j) / 8.0, 0.0, 1.0 - u);
                    let d = at(u, v).distance_squared(p);
                    if d < best {
                        (best, u0, v0) = (d, u, v);
                    }
                }
            }
            width *= 0.6;
        }
        best.sqrt()
    }

    fn point() -> impl Strategy<Value = DVec3> {
        prop_oneof![
            [-2.0..2.0, -2.0..2.0, -2.0..2.0].prop_map(|[x, y, z]: [f64; 3]| DVec3::new(x, y, z)),
            [-2..3_i32, -2..3_i32, -2..3_i32].prop_map(|p| DVec3::from(p.map(f64::from))),
        ]
    }

    proptest! {
        #[test]
        fn the_closest_point_is_as_near_as_a_search_finds(p in point(), a in point(), b in point(), c in point()) {
            let found = closest(p, [a, b, c]);
            let searched = by_search(p, [a, b, c]);
            prop_assert!((found.distance2.sqrt() - searched).abs() < 1e-6, "{} and {searched}", found.distance2.sqrt());
            prop_assert!((found.point.distance(p) - searched).abs() < 1e-6);
            prop_assert!((distance2(p, [a, b, c]) - found.distance2).abs() <= 1e-12);
        }

        #[test]
        fn a_corner_is_at_distance_zero(a in point(), b in point(), c in point()) {
            for p in [a, b, c] {
                prop_assert_eq!(distance2(p, [a, b, c]), 0.0);
            }
        }
    }

    #[test]
    fn each_feature_is_named() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let feature = |x: f64, y: f64| closest(DVec3::new(x, y, 1.0), t).feature;
        assert_eq!(feature(0.2, 0.2), Feature::Face);
        assert_eq!(feature(-1.0, -1.0), Feature::Vertex(0));
        assert_eq!(feature(3.0, 0.0), Feature::Vertex(1));
        assert_eq!(feature(0.0, 3.0), Feature::Vertex(2));
        assert_eq!(feature(0.5, -1.0), Feature::Edge(0));
        assert_eq!(feature(1.0, 1.0), Feature::Edge(1));
        assert_eq!(feature(-1.0, 0.5), Feature::Edge(2));
    }

    #[test]
    fn triangles_without_area_are_segments_and_points() {
        let p = DVec3::new(0.5, 1.0, 0.0);
        assert_eq!(distance2(p, [DVec3::ZERO, DVec3::X, DVec3::X * 0.25]), 1.0);
        assert_eq!(distance2(p, [DVec3::X, DVec3::X, DVec3::X]), 1.25);
        assert_eq!(closest(p, [DVec3::X, DVec3::X, DVec3::X]).feature, Feature::Vertex(0));
    }

    #[test]
    fn a_needle_is_measured_to_its_width_and_not_to_the_error_of_its_normal() {
        for width in [1e-3, 1e-6, 1e-9, 1e-11, 1e-13, 0.0] {
            let t = [DVec3::ZERO, DVec3::new(1.0, 1.0, 0.3), DVec3::new(0.5, 0.5 + width, 0.15)];
            let above = DVec3::new(0.41, 0.41, 0.123 + 1e-6);
            let edge = from_segment(above, t[0], t[1]).length();
            let d = distance2(above, t).sqrt();
            assert!(d <= edge * (1.0 + 1e-12) && d >= edge - 2.0 * width - 1e-14, "width {width}: {d}, edge {edge}");
        }
    }
}
