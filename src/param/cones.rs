//! Where a closed surface gets its cones: four vertices that are far from each other.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use crate::mesh::{HalfEdges, NONE};

/// Shortest paths along edges.
pub(super) struct Reach {
    pub(super) distance: Vec<f64>,
    /// The half-edge that leads to each vertex; [`NONE`] at the sources and where nothing leads.
    arrive: Vec<u32>,
}

impl Reach {
    /// Dijkstra's algorithm from all `sources`, over vertices that `may` be passed. O(n log n).
    pub(super) fn new(mesh: &HalfEdges, positions: &[DVec3], sources: &[u32], may: impl Fn(u32) -> bool) -> Self {
        let mut distance = vec![f64::INFINITY; mesh.vertices()];
        let mut arrive = vec![NONE; mesh.vertices()];
        // Lengths are not negative, so their bits sort as they do.
        let mut open: BinaryHeap<Reverse<(u64, u32)>> = BinaryHeap::new();
        for &s in sources {
            distance[s as usize] = 0.0;
            open.push(Reverse((0, s)));
        }
        while let Some(Reverse((bits, v))) = open.pop() {
            if bits != distance[v as usize].to_bits() {
                continue;
            }
            for h in mesh.fan(v) {
                let to = mesh.to(h);
                let d = distance[v as usize] + positions[v as usize].distance(positions[to as usize]);
                if d < distance[to as usize] && may(to) {
                    distance[to as usize] = d;
                    arrive[to as usize] = h;
                    open.push(Reverse((d.to_bits(), to)));
                }
            }
        }
        Self { distance, arrive }
    }

    /// The half-edges that lead to `v`, the last first.
    pub(super) fn back_from<'a>(&'a self, mesh: &'a HalfEdges, v: u32) -> impl Iterator<Item = u32> + 'a {
        let arrive = move |v: u32| Some(self.arrive[v as usize]).filter(|&h| h != NONE);
        std::iter::successors(arrive(v), move |&h| arrive(mesh.from(h)))
    }

    fn farthest(&self) -> u32 {
        let finite = self.distance.iter().enumerate().filter(|d| d.1.is_finite());
        finite.fold((0, -1.0), |best, (v, &d)| if d > best.1 { (v as u32, d) } else { best }).0
    }
}

/// Four vertices, each as far as can be from those before it; the first is far from the middle of the surface.
pub(super) fn far_apart(mesh: &HalfEdges, positions: &[DVec3]) -> [u32; 4] {
    let used = || (0..mesh.vertices() as u32).filter(|&v| mesh.outgoing(v).is_some());
    let middle = used().map(|v| positions[v as usize]).sum::<DVec3>() / used().count().max(1) as f64;
    let distance = |v: u32| positions[v as usize].distance_squared(middle);
    let start = used().fold((NONE, -1.0), |best, v| if distance(v) > best.1 { (v, distance(v)) } else { best }).0;
    let mut cones = vec![Reach::new(mesh, positions, &[start], |_| true).farthest()];
    let mut nearest = Reach::new(mesh, positions, &cones, |_| true);
    while cones.len() < 4 {
        let mut next = nearest.farthest();
        if cones.contains(&next) {
            // All at one place: any other vertex will do.
            next = used().find(|v| !cones.contains(v)).unwrap_or(next);
        }
        cones.push(next);
        let from_next = Reach::new(mesh, positions, &[next], |_| true);
        for (near, d) in nearest.distance.iter_mut().zip(from_next.distance) {
            *near = near.min(d);
        }
    }
    [cones[0], cones[1], cones[2], cones[3]]
}
