//! Boxes whose sides are parallel to the axes.

use glam::DVec3;

/// A box from its lowest to its highest corner; [`Aabb::EMPTY`] holds nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Aabb {
    pub(crate) lo: DVec3,
    pub(crate) hi: DVec3,
}

impl Aabb {
    /// The box of no points.
    pub(crate) const EMPTY: Self = Self { lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY };

    /// The smallest box around points.
    pub(crate) fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { lo: b.lo.min(p), hi: b.hi.max(p) })
    }

    /// The smallest box around two boxes.
    pub(crate) fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Whether it holds no point at all.
    pub(crate) fn is_empty(&self) -> bool {
        !self.lo.cmple(self.hi).all()
    }

    /// Side lengths; zero for the empty box.
    pub(crate) fn size(&self) -> DVec3 {
        if self.is_empty() { DVec3::ZERO } else { self.hi - self.lo }
    }

    /// The middle; the origin for the empty box.
    pub(crate) fn centre(&self) -> DVec3 {
        if self.is_empty() { DVec3::ZERO } else { self.lo * 0.5 + self.hi * 0.5 }
    }

    /// The axis of the longest side, the first of equals.
    pub(crate) fn longest_axis(&self) -> usize {
        let s = self.size();
        if s.x >= s.y && s.x >= s.z {
            0
        } else if s.y >= s.z {
            1
        } else {
            2
        }
    }

    /// Squared distance from a point to the box, zero inside.
    #[inline]
    pub(crate) fn distance2(&self, p: DVec3) -> f64 {
        (self.lo - p).max(p - self.hi).max(DVec3::ZERO).length_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_to_a_box_is_zero_inside_and_that_of_the_nearest_corner_outside() {
        let b = Aabb::of([DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)]);
        assert_eq!(b.distance2(DVec3::new(0.5, 0.5, 0.5)), 0.0);
        assert_eq!(b.distance2(DVec3::new(2.0, 4.0, 5.0)), 1.0 + 4.0 + 4.0);
        assert_eq!(b.longest_axis(), 2);
    }

    #[test]
    fn the_empty_box_has_no_size_and_adds_nothing() {
        assert!(Aabb::EMPTY.is_empty());
        assert_eq!(Aabb::EMPTY.size(), DVec3::ZERO);
        let b = Aabb::of([DVec3::ONE]);
        assert_eq!(Aabb::EMPTY.union(b), b);
    }
}
