//! Surfaces that distances are measured to, in one common frame.

use glam::DVec3;

use crate::geom::{Aabb, Bvh, Hit, Triangle};

/// Lengths in a frame below this are the rounding of zero.
pub(super) const ROUNDING: f64 = 1.0 / (1_u64 << 48) as f64;

/// The distance of a hit: zero where surfaces touch, and not the rounding of a projection.
#[inline]
pub(super) fn measured(hit: Hit) -> f64 {
    let d = hit.distance2.sqrt();
    if d <= ROUNDING { 0.0 } else { d }
}

/// Points of one comparison are moved and scaled together so that they lie around the origin with
/// coordinates of about one: digits are not lost to far-away origins, and squares cannot overflow.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    origin: DVec3,
    /// A power of two, so that scaling is exact.
    scale: f64,
}

impl Frame {
    /// The frame around the middle of `first`, wide enough for both boxes.
    pub(crate) fn around(first: Aabb, second: Aabb) -> Self {
        let origin = first.centre();
        let both = first.union(second);
        let reach = if both.is_empty() { 0.0 } else { (both.lo - origin).abs().max((both.hi - origin).abs()).max_element() };
        // 2^-k with 2^k just above the reach; kept within what a normal number can be.
        let exponent = if reach > 0.0 && reach.is_finite() { reach.log2().ceil().clamp(-1000.0, 1000.0) } else { 0.0 };
        Self { origin, scale: (-exponent).exp2() }
    }

    /// From the units of the meshes into the frame.
    pub(crate) fn inside(&self, p: DVec3) -> DVec3 {
        (p - self.origin) * self.scale
    }

    /// A length back into the units of the meshes.
    pub(crate) fn length_outside(&self, length: f64) -> f64 {
        length / self.scale
    }
}

/// Triangles in a frame, with the tree that finds the closest.
#[derive(Debug)]
pub(crate) struct Surface {
    tree: Bvh,
    /// The corners, each vertex once.
    vertices: Vec<DVec3>,
    left_out: usize,
}

impl Surface {
    /// The surface of indexed triangles. Those with a corner that is not finite (or not there) are left out.
    pub(crate) fn new(frame: Frame, positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Self {
        let corner = |v: u32| positions.get(v as usize).map(|&p| DVec3::from(p)).filter(|p| p.is_finite());
        let mut used = vec![false; positions.len()];
        let mut kept: Vec<Triangle> = Vec::with_capacity(triangles.len());
        for &[a, b, c] in triangles {
            if let (Some(p), Some(q), Some(r)) = (corner(a), corner(b), corner(c)) {
                kept.push([p, q, r].map(|x| frame.inside(x)));
                for v in [a, b, c] {
                    used[v as usize] = true;
                }
            }
        }
        let vertices = positions.iter().zip(&used).filter(|&(_, &u)| u).map(|(&p, _)| frame.inside(p.into())).collect();
        Self { left_out: triangles.len() - kept.len(), tree: Bvh::new(&kept), vertices }
    }

    /// Whether there is nothing to measure.
    pub(crate) fn is_empty(&self) -> bool {
        self.triangles().is_empty()
    }

    /// Triangles in an order in which neighbours are near in space.
    pub(crate) fn triangles(&self) -> &[Triangle] {
        self.tree.triangles()
    }

    /// The vertices of the triangles, each once, in the mesh's order.
    pub(crate) fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// How many triangles were left out.
    pub(crate) fn left_out(&self) -> usize {
        self.left_out
    }

    /// The triangle closest to `p`; `hint` is one that may be near. The surface must not be empty.
    #[inline]
    pub(crate) fn closest(&self, p: DVec3, hint: u32) -> Hit {
        self.tree.closest(p, hint).unwrap_or(Hit { slot: 0, distance2: f64::INFINITY })
    }
}
