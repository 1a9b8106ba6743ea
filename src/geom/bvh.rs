//! A tree of boxes over triangles: the closest triangle to a point in O(log n).
//!
//! Each node halves its triangles at the median of their centres along the longest side, so the
//! tree is balanced whatever the triangles are: never deeper than 32, built in O(n log n). The same
//! triangles give the same tree and the same answers on any number of threads.

use glam::DVec3;

use super::aabb::Aabb;
use super::triangle::{self, Closest, Triangle};

/// A node with at most so many triangles is a leaf.
const LEAF: usize = 4;

/// Room for the walk: one entry a level and the root.
const DEPTH: usize = 40;

/// Triangles and the tree over them. Triangles are kept in tree order: neighbours in the list are near in space.
#[derive(Debug, Clone)]
pub(crate) struct Bvh {
    /// Depth first: the left child of node `i` is `i + 1`.
    nodes: Vec<Node>,
    triangles: Vec<Triangle>,
    ids: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    aabb: Aabb,
    /// The right child; for leaves the end of its triangles.
    right: u32,
    /// For leaves the first triangle, otherwise [`Node::INNER`].
    start: u32,
}

impl Node {
    const INNER: u32 = u32::MAX;
}

/// The answer to a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    /// The triangle, counted in tree order.
    pub(crate) slot: u32,
    pub(crate) distance2: f64,
}

impl Bvh {
    /// The tree over triangles with finite corners. O(n log n).
    pub(crate) fn new(triangles: &[Triangle]) -> Self {
        let boxes: Vec<Aabb> = triangles.iter().map(|t| Aabb::of(*t)).collect();
        let centres: Vec<DVec3> = boxes.iter().map(Aabb::centre).collect();
        let mut ids: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut nodes = Vec::with_capacity(triangles.len());
        // Ranges still to be made into nodes, with the parent that waits to learn where its right child is.
        let mut open = vec![(0, triangles.len(), None)];
        while let Some((start, end, parent)) = open.pop() {
            let at = nodes.len();
            if let Some(parent) = parent {
                let parent: &mut Node = &mut nodes[parent as usize];
                parent.right = at as u32;
            }
            let range = &mut ids[start..end];
            let aabb = range.iter().fold(Aabb::EMPTY, |b, &i| b.union(boxes[i as usize]));
            if range.len() <= LEAF {
                nodes.push(Node { aabb, right: end as u32, start: start as u32 });
                continue;
            }
            let axis = Aabb::of(range.iter().map(|&i| centres[i as usize])).longest_axis();
            let half = range.len() / 2;
            // Equal centres are told apart by number, so that the order is one order.
            range.select_nth_unstable_by(half, |&i, &j| {
                centres[i as usize][axis].total_cmp(&centres[j as usize][axis]).then(i.cmp(&j))
            });
            nodes.push(Node { aabb, right: 0, start: Node::INNER });
            open.push((start + half, end, Some(at as u32)));
            open.push((start, start + half, None));
        }
        let triangles = ids.iter().map(|&i| triangles[i as usize]).collect();
        Self { nodes, triangles, ids }
    }

    /// The triangles, in tree order.
    pub(crate) fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// The place that the triangle in `slot` had in the list the tree was made from.
    pub(crate) fn id(&self, slot: u32) -> u32 {
        self.ids[slot as usize]
    }

    /// A triangle closest to `p`; `None` only if there are no triangles.
    ///
    /// `hint` is a slot that may be near (the answer for the point before): it saves time and decides
    /// between triangles at the same distance.
    pub(crate) fn closest(&self, p: DVec3, hint: u32) -> Option<Hit> {
        let first = *self.triangles.get(hint as usize).or(self.triangles.first())?;
        let hint = if (hint as usize) < self.triangles.len() { hint } else { 0 };
        let mut best = Hit { slot: hint, distance2: triangle::distance2(p, first) };
        let mut stack = [(0_u32, 0.0_f64); DEPTH];
        let mut top = 1;
        stack[0] = (0, self.nodes[0].aabb.distance2(p));
        while top > 0 {
            top -= 1;
            let (at, distance2) = stack[top];
            if distance2 >= best.distance2 {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.start != Node::INNER {
                for slot in node.start..node.right {
                    let d = triangle::distance2(p, self.triangles[slot as usize]);
                    if d < best.distance2 {
                        best = Hit { slot, distance2: d };
                    }
                }
                continue;
            }
            let (left, right) = (at + 1, node.right);
            let left = (left, self.nodes[left as usize].aabb.distance2(p));
            let right = (right, self.nodes[right as usize].aabb.distance2(p));
            // The nearer child goes on top.
            let (near, far) = if left.1 <= right.1 { (left, right) } else { (right, left) };
            for child in [far, near] {
                if child.1 < best.distance2 {
                    stack[top] = child;
                    top += 1;
                }
            }
        }
        Some(best)
    }

    /// Where on the triangle in `slot` the point closest to `p` lies.
    pub(crate) fn on(&self, slot: u32, p: DVec3) -> Closest {
        triangle::closest(p, self.triangles[slot as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn by_all(p: DVec3, triangles: &[Triangle]) -> f64 {
        triangles.iter().map(|&t| triangle::distance2(p, t)).fold(f64::INFINITY, f64::min)
    }

    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![-1.0..1.0, (-3..4_i32).prop_map(f64::from), Just(0.0)]
    }

    fn point() -> impl Strategy<Value = DVec3> {
        [coordinate(), coordinate(), coordinate()].prop_map(DVec3::from)
    }

    proptest! {
        #[test]
        fn the_tree_finds_what_asking_every_triangle_finds(
            triangles in prop::collection::vec([point(), point(), point()], 1..60),
            points in prop::collection::vec(point(), 1..20),
            hint in 0..100_u32,
        ) {
            let tree = Bvh::new(&triangles);
            for p in points {
                let hit = tree.closest(p, hint).unwrap();
                // Boxes and triangles may disagree by rounding on which of two is nearer.
                prop_assert!((hit.distance2.sqrt() - by_all(p, &triangles).sqrt()).abs() < 1e-14);
                let id = tree.id(hit.slot) as usize;
                prop_assert_eq!(tree.triangles()[hit.slot as usize], triangles[id]);
                prop_assert!((tree.on(hit.slot, p).distance2 - hit.distance2).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_hundred_thousand_equal_triangles_make_a_tree_of_logarithmic_depth() {
        let triangles = vec![[DVec3::ZERO, DVec3::X, DVec3::Y]; 100_000];
        let tree = Bvh::new(&triangles);
        let mut depth = vec![1; tree.nodes.len()];
        for (i, node) in tree.nodes.iter().enumerate().filter(|(_, n)| n.start == Node::INNER) {
            depth[i + 1] = depth[i] + 1;
            depth[node.right as usize] = depth[i] + 1;
        }
        assert!(depth.into_iter().max().unwrap() <= 17);
        assert_eq!(tree.closest(DVec3::Z, 0).unwrap().distance2, 1.0);
    }

    #[test]
    fn without_triangles_nothing_is_closest() {
        assert_eq!(Bvh::new(&[]).closest(DVec3::ZERO, 0), None);
    }
}
