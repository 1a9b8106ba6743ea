//! Seams: the border of a geometry image glued to itself side by side, as the border of a surface that was cut open.
//!
//! The border is walked once, from the first sample down the first column, along the last row, up the last column and back along
//! the first row. It falls into *sides*, each glued to another of the same length that runs the other way. Every image whose
//! squares a side are a multiple of the *grain* can be glued so: lengths are counted in grains.
//!
//! Sides of five grains or more, none glued to its neighbour, make a closed surface of triangles whatever its points are: no
//! two copies of a point are then within four samples of each other, so no two triangles can be the same.

use super::Shape;
use crate::error::{Error, Result};

/// A piece of the border and the one that it is glued to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BorderSide {
    /// In grains.
    pub(crate) length: u32,
    pub(crate) mate: u32,
}

/// How the border of a square image is glued to itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Seams {
    grains: u32,
    start: u32,
    sides: Vec<BorderSide>,
}

impl Seams {
    /// The fewest grains of a side.
    pub(crate) const SHORTEST: u32 = 5;
    /// Grains a side of an image at most.
    pub(crate) const FINEST: u32 = 1 << 16;

    /// Seams of an image of `grains` grains a side whose first side begins `start` grains after the first sample.
    pub(crate) fn new(grains: u32, start: u32, sides: Vec<BorderSide>) -> Result<Self> {
        let refuse = |why: String| Err(Error::Parameter(format!("seams that make no surface: {why}")));
        if !(1..=Self::FINEST).contains(&grains) || start >= 4 * grains {
            return refuse(format!("{grains} grains a side, the first side after {start}"));
        }
        for (i, side) in sides.iter().enumerate() {
            let Some(mate) = sides.get(side.mate as usize) else { return refuse(format!("side {i} is glued to none")) };
            if mate.mate as usize != i || mate.length != side.length || side.length < Self::SHORTEST {
                return refuse(format!("side {i} of {} grains is glued to one of {}", side.length, mate.length));
            }
            let apart = (side.mate as usize).abs_diff(i);
            if apart <= 1 || apart + 1 == sides.len() {
                return refuse(format!("side {i} is glued to its neighbour"));
            }
        }
        let around: u64 = sides.iter().map(|side| u64::from(side.length)).sum();
        if around != 4 * u64::from(grains) {
            return refuse(format!("sides of {around} grains around a square of {}", 4 * grains));
        }
        Ok(Self { grains, start, sides })
    }

    /// Grains a side of the image.
    pub(crate) fn grains(&self) -> u32 {
        self.grains
    }

    /// Grains before the first side.
    pub(crate) fn start(&self) -> u32 {
        self.start
    }

    /// The sides in their order around the border.
    pub(crate) fn sides(&self) -> &[BorderSide] {
        &self.sides
    }

    /// Whether an image of this shape can be glued so, or why not.
    pub(crate) fn check(&self, shape: Shape) -> Result<()> {
        let squares = shape.width() - 1;
        if shape.width() != shape.height() || !squares.is_multiple_of(self.grains as usize) || squares == 0 {
            let why = "its seams need a square of one sample more than a multiple of";
            return Err(Error::Parameter(format!("a geometry image of {shape} samples; {why} {}", self.grains)));
        }
        Ok(())
    }

    /// How often an image of a shape that fits can be halved so that it still fits.
    pub(crate) fn levels(&self, shape: Shape) -> u8 {
        ((shape.width() - 1) / self.grains as usize).trailing_zeros() as u8
    }

    /// Vertices of an image of `squares` squares a side.
    pub(crate) fn vertices(&self, squares: u64) -> u64 {
        let inner = squares.saturating_sub(1) * squares.saturating_sub(1);
        // Each seam but its ends, once; then the ends.
        inner + 2 * squares - self.sides.len() as u64 / 2 + self.ends().len() as u64
    }

    /// For every point at which sides end, the sides that begin there: the end of a side is the beginning of the next, and both sides
    /// of a seam run against each other.
    fn ends(&self) -> Vec<Vec<usize>> {
        let count = self.sides.len();
        let mut seen = vec![false; count];
        let mut ends = Vec::new();
        for first in 0..count {
            let (mut side, mut around) = (first, Vec::new());
            while !std::mem::replace(&mut seen[side], true) {
                around.push(side);
                side = (self.sides[side].mate as usize + 1) % count;
            }
            if !around.is_empty() {
                ends.push(around);
            }
        }
        ends
    }

    /// Replaces each border sample's representative (itself) by the first sample that it is glued to.
    pub(super) fn glue(&self, shape: Shape, representatives: &mut [u32]) {
        let scale = (shape.width() - 1) / self.grains as usize;
        let around = 4 * (shape.width() - 1);
        let starts: Vec<usize> = (self.sides.iter())
            .scan(self.start as usize * scale, |at, side| {
                let from = *at;
                *at += side.length as usize * scale;
                Some(from)
            })
            .collect();
        let sample = |at: usize| along_border(shape, at % around);
        for around in self.ends() {
            let copies = || around.iter().map(|&side| sample(starts[side]));
            let least = copies().min().unwrap_or(0);
            copies().for_each(|p| representatives[p] = least as u32);
        }
        for (i, side) in self.sides.iter().enumerate() {
            let (length, mate) = (side.length as usize * scale, starts[side.mate as usize]);
            for k in 1..length {
                let (p, q) = (sample(starts[i] + k), sample(mate + length - k));
                representatives[p] = p.min(q) as u32;
            }
        }
    }
}

/// The sample at a place of the border, counted along its walk.
fn along_border(shape: Shape, at: usize) -> usize {
    let (width, last) = (shape.width(), shape.width() - 1);
    let (row, column) = match (at / last, at % last) {
        (0, k) => (k, 0),
        (1, k) => (last, k),
        (2, k) => (last - k, last),
        (_, k) => (0, last - k),
    };
    row * width + column
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square whose opposite borders are glued: a torus.
    pub(crate) fn torus(grains: u32, start: u32) -> Seams {
        let side = |mate| BorderSide { length: grains, mate };
        Seams::new(grains, start, vec![side(2), side(3), side(0), side(1)]).unwrap()
    }

    #[test]
    fn vertices_are_as_many_as_samples_that_stand_for_themselves() {
        let hexagon = |lengths: [u32; 3]| {
            let sides = (0..6).map(|i| BorderSide { length: lengths[i % 3], mate: (i as u32 + 3) % 6 }).collect();
            Seams::new(lengths.iter().sum::<u32>() / 2, 3, sides).unwrap()
        };
        for (seams, genus) in [(torus(5, 0), 1), (torus(8, 13), 1), (hexagon([5, 8, 7]), 1)] {
            for scale in 1..4 {
                let side = seams.grains() * scale + 1;
                let shape = Shape::new(side, side).unwrap();
                let mut of: Vec<u32> = (0..side * side).collect();
                seams.glue(shape, &mut of);
                assert!(of.iter().all(|&r| of[r as usize] == r));
                let vertices = (0..side * side).filter(|&p| of[p as usize] == p).count() as u64;
                assert_eq!(vertices, seams.vertices(u64::from(side - 1)));
                // V − E + F with F squares and two edges a square.
                let squares = i64::from(side - 1) * i64::from(side - 1);
                assert_eq!(vertices as i64 - 2 * squares + squares, 2 - 2 * genus);
            }
        }
    }

    #[test]
    fn seams_that_make_no_surface_are_refused() {
        let side = |length, mate| BorderSide { length, mate };
        let refused = |grains, start, sides: &[BorderSide]| Seams::new(grains, start, sides.to_vec()).is_err();
        assert!(refused(0, 0, &[]));
        assert!(refused(5, 20, &[side(5, 2), side(5, 3), side(5, 0), side(5, 1)]), "a start behind the border");
        assert!(refused(5, 0, &[side(5, 2), side(5, 3), side(5, 0), side(5, 4)]), "glued to none");
        assert!(refused(5, 0, &[side(5, 1), side(5, 0), side(5, 3), side(5, 2)]), "neighbours");
        assert!(refused(5, 0, &[side(5, 2), side(5, 3), side(5, 0), side(5, 0)]), "no pairs");
        assert!(refused(4, 0, &[side(4, 2), side(4, 3), side(4, 0), side(4, 1)]), "too short");
        assert!(refused(6, 0, &[side(5, 2), side(5, 3), side(5, 0), side(5, 1)]), "not all around");
        assert!(torus(8, 0).check(Shape::new(17, 17).unwrap()).is_ok());
        assert!(torus(8, 0).check(Shape::new(17, 25).unwrap()).is_err());
        assert!(torus(8, 0).check(Shape::new(13, 13).unwrap()).is_err());
        assert_eq!(torus(8, 0).levels(Shape::new(33, 33).unwrap()), 2);
    }
}
