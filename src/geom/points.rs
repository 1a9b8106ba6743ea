//! A tree over points: which lie within a distance, and which is nearest.
//!
//! Distance here is the largest difference of a coordinate, so that a lattice step is a distance and
//! no square can overflow. A range of points is split at its median along its longest side, which
//! stays in the middle of the range: the tree is the order of the points, and needs no links.

use super::aabb::Aabb;
use glam::DVec3;

/// Points in tree order.
#[derive(Debug, Clone)]
pub(crate) struct PointTree {
    points: Vec<DVec3>,
    ids: Vec<u32>,
    /// For the middle of each range the axis along which the range is split.
    axes: Vec<u8>,
}

/// The largest difference of a coordinate.
#[inline]
fn difference(p: DVec3, q: DVec3) -> f64 {
    (p - q).abs().max_element()
}

impl PointTree {
    /// The tree over points without NaN. O(n log n).
    pub(crate) fn new(points: &[DVec3]) -> Self {
        let mut ids: Vec<u32> = (0..points.len() as u32).collect();
        let mut axes = vec![0; points.len()];
        let mut open = vec![(0, points.len())];
        while let Some((start, end)) = open.pop() {
            if end - start < 2 {
                continue;
            }
            let range = &mut ids[start..end];
            let axis = Aabb::of(range.iter().map(|&i| points[i as usize])).longest_axis();
            let half = range.len() / 2;
            range.select_nth_unstable_by(half, |&i, &j| {
                points[i as usize][axis].total_cmp(&points[j as usize][axis]).then(i.cmp(&j))
            });
            axes[start + half] = axis as u8;
            open.push((start, start + half));
            open.push((start + half + 1, end));
        }
        Self { points: ids.iter().map(|&i| points[i as usize]).collect(), ids, axes }
    }

    /// Calls `visit` with the number of every point within `radius` of `p`, as long as it wants more.
    pub(crate) fn within(&self, p: DVec3, radius: f64, mut visit: impl FnMut(u32) -> bool) {
        let mut open = vec![(0, self.points.len())];
        while let Some((start, end)) = open.pop() {
            if start == end {
                continue;
            }
            let middle = start + (end - start) / 2;
            let (q, axis) = (self.points[middle], self.axes[middle] as usize);
            if difference(p, q) <= radius && !visit(self.ids[middle]) {
                return;
            }
            // Coordinates left of the middle are at most, right of it at least, that of the middle.
            if p[axis] - q[axis] <= radius {
                open.push((start, middle));
            }
            if q[axis] - p[axis] <= radius {
                open.push((middle + 1, end));
            }
        }
    }

    /// The number of a nearest point and its distance. Which of several at the same distance depends on the tree alone.
    pub(crate) fn nearest(&self, p: DVec3) -> Option<(u32, f64)> {
        let mut best = None::<(u32, f64)>;
        let mut open = vec![(0, self.points.len(), 0.0)];
        while let Some((start, end, gap)) = open.pop() {
            if start == end || best.is_some_and(|(_, d)| gap >= d) {
                continue;
            }
            let middle = start + (end - start) / 2;
            let (q, axis, id) = (self.points[middle], self.axes[middle] as usize, self.ids[middle]);
            let d = difference(p, q);
            if best.is_none_or(|(_, least)| d < least) {
                best = Some((id, d));
            }
            let (left, right) = ((start, middle), (middle + 1, end));
            let side = p[axis] - q[axis];
            let (near, far) = if side <= 0.0 { (left, right) } else { (right, left) };
            open.push((far.0, far.1, side.abs()));
            open.push((near.0, near.1, 0.0));
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = DVec3> {
        [-3..4_i32, -3..4_i32, -3..4_i32].prop_map(|p| DVec3::from(p.map(|x| f64::from(x) * 0.25)))
    }

    proptest! {
        #[test]
        fn the_tree_finds_what_asking_every_point_finds(
            points in prop::collection::vec(point(), 0..80),
            p in point(),
            radius in prop_oneof![Just(0.0), Just(0.25), 0.0..1.0],
        ) {
            let tree = PointTree::new(&points);
            let mut found = Vec::new();
            tree.within(p, radius, |i| {
                found.push(i);
                true
            });
            found.sort_unstable();
            let all = (0..points.len() as u32).filter(|&i| difference(points[i as usize], p) <= radius);
            prop_assert_eq!(found, all.collect::<Vec<_>>());
            let least = points.iter().map(|&q| difference(p, q)).min_by(f64::total_cmp);
            let nearest = tree.nearest(p);
            prop_assert_eq!(nearest.map(|x| x.1), least);
            prop_assert!(nearest.is_none_or(|(i, d)| difference(points[i as usize], p) == d));
        }
    }
}
