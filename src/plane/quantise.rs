//! The lattice: real coordinates as integers, one step for all axes.

/// Points `origin + q · step` with integer q.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lattice {
    /// The point of q = (0, 0, 0).
    pub origin: [f64; 3],
    /// The distance of neighbouring points, in the units of the mesh; positive.
    pub step: f64,
}

impl Lattice {
    /// The lattice point nearest to `x` on one axis; ties go up.
    #[inline]
    pub fn index(&self, x: f64, axis: usize) -> f64 {
        ((x - self.origin[axis]) / self.step + 0.5).floor()
    }

    /// Where the lattice point `q` lies: only + and ×, so the same on every machine.
    #[inline]
    pub fn point(&self, q: [i64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.origin[axis] + q[axis] as f64 * self.step)
    }
}

/// The smallest and the largest coordinate on each axis; `None` without points.
pub(crate) fn bounding_box(points: impl IntoIterator<Item = [f64; 3]>) -> Option<[[f64; 3]; 2]> {
    points.into_iter().fold(None, |bounds, p| {
        let [low, high] = bounds.unwrap_or([p; 2]);
        Some([[0, 1, 2].map(|i| f64::min(low[i], p[i])), [0, 1, 2].map(|i| f64::max(high[i], p[i]))])
    })
}
