//! A surface and where its triangles lie in the plane.

use glam::{DVec2, DVec3};

use crate::mesh::HalfEdges;
use crate::plane::{Gluing, Seams};

/// What may be done with a vertex in the plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Freedom {
    /// It stays where it is: a corner of the square, a cone.
    Fixed,
    /// It may slide along an axis (0 or 1): on a side of the square.
    Along(u8),
    /// It may go anywhere.
    Free,
}

/// How a corner of a triangle sees its vertex: at `sign · w + shift`, for the vertex's unknown `w`.
///
/// On a closed surface these are the half-turns and translations that map one copy of it onto the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lift {
    pub(super) sign: f64,
    pub(super) shift: DVec2,
}

impl Lift {
    pub(super) const IDENTITY: Self = Self { sign: 1.0, shift: DVec2::ZERO };

    /// After this, the half-turn about `centre`.
    pub(super) fn then_half_turn(self, centre: DVec2) -> Self {
        Self { sign: -self.sign, shift: 2.0 * centre - self.shift }
    }

    #[inline]
    pub(super) fn of(self, w: DVec2) -> DVec2 {
        self.sign * w + self.shift
    }

    /// The unknown that is seen at `u`.
    pub(super) fn back(self, u: DVec2) -> DVec2 {
        self.sign * (u - self.shift)
    }
}

/// A surface laid out in the plane.
#[derive(Debug, Clone)]
pub(crate) struct Chart {
    pub(crate) mesh: HalfEdges,
    pub(crate) positions: Vec<DVec3>,
    /// Which triangles only fill a hole; empty if none does.
    pub(super) filling: Vec<bool>,
    pub(crate) gluing: Gluing,
    /// How an open border is glued: that of a surface that was cut.
    pub(crate) seams: Option<Seams>,
    /// For every corner of every triangle; empty if all are the identity.
    pub(super) lifts: Vec<[Lift; 3]>,
    /// The unknown of each vertex.
    pub(super) w: Vec<DVec2>,
    pub(super) freedom: Vec<Freedom>,
}

/// Twice the signed area.
#[inline]
pub(crate) fn cross([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}

impl Chart {
    #[inline]
    pub(super) fn lift(&self, face: usize, corner: usize) -> Lift {
        if self.lifts.is_empty() { Lift::IDENTITY } else { self.lifts[face][corner] }
    }

    /// Where the corners of a triangle lie in the plane, counter-clockwise.
    #[inline]
    pub(crate) fn flat(&self, face: usize) -> [DVec2; 3] {
        let t = self.mesh.triangles()[face];
        [0, 1, 2].map(|k| self.lift(face, k).of(self.w[t[k] as usize]))
    }

    /// The corners of a triangle in space.
    #[inline]
    pub(crate) fn solid(&self, face: usize) -> [DVec3; 3] {
        self.mesh.triangles()[face].map(|v| self.positions[v as usize])
    }

    /// Whether a triangle only fills a hole of the surface.
    pub(crate) fn is_filling(&self, face: usize) -> bool {
        self.filling.get(face).is_some_and(|&filling| filling)
    }

    /// The triangles of the surface itself, in space.
    pub(crate) fn solids(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        (0..self.faces()).filter(|&f| !self.is_filling(f)).map(|f| self.solid(f))
    }

    /// Triangles.
    pub(crate) fn faces(&self) -> usize {
        self.mesh.triangles().len()
    }

    /// How many triangles are turned over or flat in the plane.
    pub(crate) fn folds(&self) -> usize {
        (0..self.faces()).filter(|&f| !(cross(self.flat(f)) > 0.0)).count()
    }

    /// The area of a triangle and the square of its stretch from the plane to space: half the squared length of the images of two
    /// perpendicular unit vectors. Infinite where the triangle is turned over.
    pub(super) fn stretch2(&self, face: usize) -> (f64, f64) {
        let ([p, q, r], [u, v, w]) = (self.solid(face), self.flat(face));
        let (e, f) = (q - p, r - p);
        let (a, b) = (v - u, w - u);
        let area = 0.5 * e.cross(f).length();
        let det = a.perp_dot(b);
        if !(det > 0.0) {
            return (area, f64::INFINITY);
        }
        let (s, t) = ((e * b.y - f * a.y) / det, (f * a.x - e * b.x) / det);
        (area, 0.5 * (s.length_squared() + t.length_squared()))
    }

    /// The stretch of the whole: 1 for a map that only scales, infinite if a triangle is turned over (Sander et al. 2001).
    pub(crate) fn stretch(&self) -> f64 {
        let (mut area, mut weighted, mut flat) = (0.0, 0.0, 0.0);
        for f in 0..self.faces() {
            let (a, s2) = self.stretch2(f);
            if s2.is_infinite() {
                return s2;
            }
            area += a;
            weighted += a * s2;
            flat += 0.5 * cross(self.flat(f));
        }
        // What has no area is not stretched.
        if area > 0.0 { (weighted * flat).sqrt() / area } else { 1.0 }
    }

    /// Triangles that cover the unit square, each with the number of the surface's triangle that it is a copy of.
    pub(crate) fn cover(&self) -> (Vec<[DVec2; 3]>, Vec<u32>) {
        let flat = (0..self.faces()).map(|f| self.flat(f));
        match self.gluing {
            Gluing::Orbifold => super::orbifold::unroll(flat),
            _ => (flat.collect(), (0..self.faces() as u32).collect()),
        }
    }

    /// Where the vertices lie in the square, for counting: on a closed surface each is there once.
    pub(crate) fn flat_vertices(&self) -> Vec<DVec2> {
        let used = (0..self.w.len()).filter(|&v| self.mesh.outgoing(v as u32).is_some());
        let points = used.map(|v| self.w[v]);
        match self.gluing {
            Gluing::Orbifold => points.map(super::orbifold::into_square).collect(),
            _ => points.collect(),
        }
    }
}
