//! Geometry images: rectangles of points, and how their borders are glued.
//!
//! Four neighbouring samples are two triangles (Gu, Gortler and Hoppe; papers 000 and 004 call them GIM). What the
//! rectangle's border means is its [`Gluing`]: the border of a disk, or a seam of a closed surface at which both
//! sides hold the same points; an open border may be glued further along [`Seams`]. Samples that are glued are one vertex, whose
//! *representative* is the first of them. Squares that are *holes* are not part of the surface.

use std::collections::BTreeMap;

use super::{Mask, Seams, Shape};
use crate::error::{Error, Result};

/// How the border of a geometry image is glued.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub enum Gluing {
    /// Not at all: the image is a disk, and its border the border of the surface.
    #[default]
    Open,
    /// Half of each side to its other half, reflected at the middle of the side: a closed surface of genus 0 with
    /// four cones there ("pillow"). Both sides of the image are odd.
    Orbifold,
}

impl Gluing {
    /// Whether an image of this shape can be glued so, or why not.
    pub(crate) fn check(self, shape: Shape) -> Result<()> {
        let (width, height) = (shape.width(), shape.height());
        let least = if self == Self::Orbifold { 3 } else { 2 };
        if width < least || height < least {
            return Err(Error::Parameter(format!("a geometry image of {shape} samples; each side must be {least} or more")));
        }
        if self == Self::Orbifold && (width % 2 == 0 || height % 2 == 0) {
            return Err(Error::Parameter(format!(
                "a geometry image of {shape} samples; its sides are glued at their middle and must be odd"
            )));
        }
        Ok(())
    }

    /// The sample that stands for the sample in `row` and `column`: itself, or the first that it is glued to.
    #[inline]
    pub(crate) fn representative(self, shape: Shape, row: usize, column: usize) -> (usize, usize) {
        let (last_row, last_column) = (shape.height() - 1, shape.width() - 1);
        let on_side = row == 0 || row == last_row || column == 0 || column == last_column;
        if self == Self::Open || !on_side {
            return (row, column);
        }
        let (at_row_end, at_column_end) = (row == 0 || row == last_row, column == 0 || column == last_column);
        match (at_row_end, at_column_end) {
            (true, true) => (0, 0),
            (true, false) => (row, column.min(last_column - column)),
            _ => (row.min(last_row - row), column),
        }
    }
}

/// A surface as a rectangle of points.
#[derive(Clone, PartialEq, Debug)]
pub struct GeometryImage {
    shape: Shape,
    gluing: Gluing,
    seams: Option<Seams>,
    /// Which squares are holes; all of them belong to the surface if there is none.
    holes: Option<Mask>,
    points: Vec<[f64; 3]>,
}

impl GeometryImage {
    /// An image of the given points, row by row, in the units of the mesh.
    ///
    /// Where samples are glued, all take the point of the first. Refuses shapes that cannot be glued so, another
    /// number of points than the shape has, and points that are not finite.
    pub fn new(width: usize, height: usize, gluing: Gluing, points: Vec<[f64; 3]>) -> Result<Self> {
        let mut image = Self::unglued(width, height, gluing, points)?;
        image.weld();
        Ok(image)
    }

    /// The same, but samples that are glued take their mean.
    pub(crate) fn averaging(width: usize, height: usize, gluing: Gluing, points: Vec<[f64; 3]>) -> Result<Self> {
        let mut image = Self::unglued(width, height, gluing, points)?;
        image.average();
        Ok(image)
    }

    fn unglued(width: usize, height: usize, gluing: Gluing, points: Vec<[f64; 3]>) -> Result<Self> {
        let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let shape = Shape::new(side(width), side(height))?;
        gluing.check(shape)?;
        if points.len() != shape.pixels() {
            return Err(Error::Parameter(format!("{} points for a geometry image of {shape} samples", points.len())));
        }
        if let Some(at) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            let (row, column, [x, y, z]) = (at / width, at % width, points[at]);
            return Err(Error::Parameter(format!("the point ({x}, {y}, {z}) in row {row}, column {column} is not finite")));
        }
        Ok(Self { shape, gluing, seams: None, holes: None, points })
    }

    /// The same with its open border glued along seams: samples that are glued take the point of the first.
    pub(crate) fn with_seams(self, seams: Seams) -> Result<Self> {
        let mut image = self.sewn(seams)?;
        image.weld();
        Ok(image)
    }

    /// The same, but they take their mean.
    pub(crate) fn averaging_seams(self, seams: Seams) -> Result<Self> {
        let mut image = self.sewn(seams)?;
        image.average();
        Ok(image)
    }

    fn sewn(mut self, seams: Seams) -> Result<Self> {
        seams.check(self.shape)?;
        if self.gluing != Gluing::Open {
            return Err(Error::Parameter("an image whose border is glued already has no seams".into()));
        }
        self.seams = Some(seams);
        Ok(self)
    }

    /// The same with squares that are no part of the surface.
    pub(crate) fn with_holes(mut self, holes: Mask) -> Result<Self> {
        let (columns, rows) = (self.width() - 1, self.height() - 1);
        let shape = holes.shape();
        if (shape.width(), shape.height()) != (columns, rows) || holes.count() == columns * rows {
            return Err(Error::Parameter(format!(
                "{} holes of {shape} squares in an image of {} samples",
                holes.count(),
                self.shape
            )));
        }
        self.holes = (holes.count() > 0).then_some(holes);
        Ok(self)
    }

    /// The same surface with other points, glued alike.
    pub(crate) fn with_points(&self, points: Vec<[f64; 3]>) -> Result<Self> {
        let other = Self::new(self.width(), self.height(), self.gluing, points)?;
        let mut other = Self { seams: self.seams.clone(), holes: self.holes.clone(), ..other };
        other.weld();
        Ok(other)
    }

    /// Gives samples that are glued and differ their mean: the sum of the first and the others in their order, divided by how
    /// many they are.
    fn average(&mut self) {
        let of = self.representatives();
        let mut sums = BTreeMap::new();
        for at in (0..of.len()).filter(|&at| of[at] as usize != at) {
            let first = self.points[of[at] as usize];
            let (sum, count, alike) = sums.entry(of[at]).or_insert((first, 1.0, true));
            (0..3).for_each(|i| sum[i] += self.points[at][i]);
            *count += 1.0;
            *alike &= self.points[at] == first;
        }
        // The mean of numbers that are the same may round to another one.
        for (of, (sum, count, _)) in sums.into_iter().filter(|(_, (_, _, alike))| !alike) {
            self.points[of as usize] = sum.map(|x| x / count);
        }
        self.weld();
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.shape.width()
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.shape.height()
    }

    /// How its border is glued.
    pub fn gluing(&self) -> Gluing {
        self.gluing
    }

    /// The seams along which an open border is glued.
    pub(crate) fn seams(&self) -> Option<&Seams> {
        self.seams.as_ref()
    }

    /// Which squares are holes.
    pub(crate) fn holes(&self) -> Option<&Mask> {
        self.holes.as_ref()
    }

    /// How many seams an open border is glued along.
    pub fn seam_count(&self) -> usize {
        self.seams.as_ref().map_or(0, |seams| seams.sides().len() / 2)
    }

    /// Whether the square of samples whose first corner is in `row` and `column` is no part of the surface.
    #[inline]
    pub fn is_hole(&self, row: usize, column: usize) -> bool {
        self.holes.as_ref().is_some_and(|holes| holes.contains(row, column))
    }

    /// All points, row by row.
    pub fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// The point in `row` and `column`.
    #[inline]
    pub fn point(&self, row: usize, column: usize) -> [f64; 3] {
        self.points[row * self.shape.width() + column]
    }

    pub(crate) fn shape(&self) -> Shape {
        self.shape
    }

    /// The index (row by row) of the sample that stands for each sample.
    pub(crate) fn representatives(&self) -> Vec<u32> {
        let width = self.width();
        let of = |p: usize| self.gluing.representative(self.shape, p / width, p % width);
        let mut representatives: Vec<u32> =
            (0..self.shape.pixels()).map(of).map(|(row, column)| (row * width + column) as u32).collect();
        if let Some(seams) = &self.seams {
            seams.glue(self.shape, &mut representatives);
        }
        representatives
    }

    /// Its triangles, as indices of representatives, row by row; O(samples).
    ///
    /// Each four neighbours are cut along their shorter diagonal, the one from the first row's first column where
    /// both are equal. At the eight squares around the cones of an orbifold the diagonal through the cone is taken:
    /// else two squares could make the same triangle twice; and, where there are seams, at the four corners. Holes have none.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let (width, height, of) = (self.width(), self.height(), self.representatives());
        let mut triangles = Vec::with_capacity(2 * (width - 1) * (height - 1));
        for row in 0..height - 1 {
            for column in (0..width - 1).filter(|&column| !self.is_hole(row, column)) {
                let at = row * width + column;
                let [a, b, c, d] = [at, at + 1, at + width + 1, at + width].map(|p| of[p]);
                let falling = self.forced_diagonal(row, column).unwrap_or_else(|| self.square(a, c) <= self.square(b, d));
                triangles.extend(if falling { [[a, d, c], [a, c, b]] } else { [[a, d, b], [b, d, c]] });
            }
        }
        triangles
    }

    /// Whether the diagonal from the first corner is forced (`true`), the other one, or none.
    pub(crate) fn forced_diagonal(&self, row: usize, column: usize) -> Option<bool> {
        let (last_row, last_column) = (self.height() - 2, self.width() - 2);
        if self.gluing == Gluing::Open {
            let corner = (row == 0 || row == last_row) && (column == 0 || column == last_column);
            // Through the corner of the image.
            return (corner && self.seams.is_some()).then_some((row == 0) == (column == 0));
        }
        let (middle_row, middle_column) = (self.height() / 2, self.width() / 2);
        let beside = |at: usize, middle: usize| match at {
            at if at + 1 == middle => Some(false),
            at if at == middle => Some(true),
            _ => None,
        };
        // Cones at the ends of the middle column, then at those of the middle row. In a 3 x 3 image a square is beside two.
        let vertical = |first: bool| beside(column, middle_column).map(|after| after == first);
        let horizontal = |first: bool| beside(row, middle_row).map(|after| after == first);
        let on_column = if row == 0 {
            vertical(true)
        } else if row == last_row {
            vertical(false)
        } else {
            None
        };
        let on_row = if column == 0 {
            horizontal(true)
        } else if column == last_column {
            horizontal(false)
        } else {
            None
        };
        on_column.or(on_row)
    }

    fn square(&self, p: u32, q: u32) -> f64 {
        let (p, q) = (self.points[p as usize], self.points[q as usize]);
        (0..3).map(|i| (p[i] - q[i]) * (p[i] - q[i])).sum()
    }

    fn weld(&mut self) {
        if self.gluing != Gluing::Open || self.seams.is_some() {
            let of = self.representatives();
            (0..of.len()).for_each(|p| self.points[p] = self.points[of[p] as usize]);
        }
    }
}

#[cfg(test)]
impl GeometryImage {
    /// An image of points that are all different, so that diagonals fall anywhere.
    #[allow(clippy::unwrap_used)]
    pub(crate) fn rough(width: usize, height: usize, gluing: Gluing, seed: u64) -> Self {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64
        };
        let points = (0..width * height).map(|_| [next(), next(), next()]).collect();
        Self::new(width, height, gluing, points).unwrap()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn an_orbifold_is_a_closed_surface_of_genus_0_whatever_its_points() {
        for seed in 0..50 {
            for (width, height) in [(5, 5), (7, 5), (9, 17), (33, 33)] {
                let image = GeometryImage::rough(width, height, Gluing::Orbifold, seed);
                let triangles = image.triangles();
                let mut edges = HashMap::new();
                for t in &triangles {
                    (0..3).for_each(|i| *edges.entry((t[i], t[(i + 1) % 3])).or_insert(0) += 1);
                }
                assert!(
                    edges.iter().all(|(&(a, b), &n)| n == 1 && a != b && edges.contains_key(&(b, a))),
                    "{width} x {height}, seed {seed}"
                );
                let mut vertices: Vec<_> = triangles.iter().flatten().copied().collect();
                vertices.sort_unstable();
                vertices.dedup();
                assert_eq!(vertices.len(), (width - 1) * (height - 1) + 2);
                assert_eq!(vertices.len() + triangles.len() - edges.len() / 2, 2, "Euler number");
            }
        }
    }

    #[test]
    fn glued_samples_hold_the_same_point() {
        let image = GeometryImage::rough(9, 7, Gluing::Orbifold, 1);
        for k in 0..7 {
            assert_eq!(image.point(k, 0), image.point(6 - k, 0));
            assert_eq!(image.point(k, 8), image.point(6 - k, 8));
        }
        for k in 0..9 {
            assert_eq!(image.point(0, k), image.point(0, 8 - k));
            assert_eq!(image.point(6, k), image.point(6, 8 - k));
        }
    }

    #[test]
    fn a_square_is_cut_along_its_shorter_diagonal() {
        let long_first = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [3.0, 3.0, 0.0]];
        assert_eq!(GeometryImage::new(2, 2, Gluing::Open, long_first).unwrap().triangles(), [[0, 2, 1], [1, 2, 3]]);
    }

    #[test]
    fn shapes_that_cannot_be_glued_and_points_at_infinity_are_refused() {
        assert!(GeometryImage::new(4, 5, Gluing::Orbifold, vec![[0.0; 3]; 20]).is_err());
        assert!(GeometryImage::new(1, 5, Gluing::Open, vec![[0.0; 3]; 5]).is_err());
        assert!(GeometryImage::new(2, 2, Gluing::Open, vec![[0.0; 3]; 3]).is_err());
        let error = GeometryImage::new(2, 2, Gluing::Open, vec![[0.0, f64::NAN, 0.0]; 4]).unwrap_err();
        assert!(error.to_string().contains("row 0, column 0"), "{error}");
    }
}
