//! The hall between the wings: rectangles of integer samples.
//!
//! The surface wing fills planes and reads them back; the byte wing turns them into bytes. Neither needs to know
//! what the other does with them: a sample is an unsigned integer of a stated depth, and what it means (a coordinate
//! on a lattice, a normal's angle, an index) is said elsewhere.

mod geometry_image;
mod level;
mod mask;
mod normal;
#[cfg(feature = "png")]
mod png;
mod quantise;
mod region;
mod seams;
mod side;

pub use geometry_image::{GeometryImage, Gluing};
pub(crate) use level::{Levels, Step};
pub(crate) use mask::Mask;
pub(crate) use normal::{from_octahedral, octahedral};
#[cfg(all(test, feature = "png"))]
pub(crate) use png::read_rgb;
#[cfg(feature = "png")]
pub(crate) use png::{read_mask, read_planes, write_png};
pub use quantise::Lattice;
pub(crate) use quantise::bounding_box;
pub(crate) use region::RegionCells;
pub(crate) use seams::{BorderSide, Seams};
pub(crate) use side::{Block, RunCounts, Seam, SideInformation};

use crate::error::{Error, Result};

/// The longest side of a plane.
pub(crate) const MAX_SIDE: u32 = 1 << 20;
/// The deepest sample, in bits.
pub(crate) const MAX_DEPTH: u8 = 24;

/// How many columns and rows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Shape {
    width: u32,
    height: u32,
}

impl Shape {
    /// A shape of `width` columns and `height` rows, each 1 to [`MAX_SIDE`].
    pub(crate) fn new(width: u32, height: u32) -> Result<Self> {
        let sides = 1..=MAX_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) {
            return Err(Error::Parameter(format!("an image of {width} x {height} samples; each side must be 1 to {MAX_SIDE}")));
        }
        if usize::try_from(u64::from(width) * u64::from(height)).is_err() {
            return Err(Error::Parameter(format!(
                "an image of {width} x {height} samples is more than this machine can address"
            )));
        }
        Ok(Self { width, height })
    }

    /// Columns.
    pub(crate) fn width(self) -> usize {
        self.width as usize
    }

    /// Rows.
    pub(crate) fn height(self) -> usize {
        self.height as usize
    }

    /// Samples of one plane.
    pub(crate) fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The samples at every second column and row, from the first on.
    pub(crate) fn halved(self) -> Self {
        Self { width: self.width.div_ceil(2), height: self.height.div_ceil(2) }
    }

    /// The same image turned so that rows are columns.
    #[cfg(test)]
    pub(crate) fn transposed(self) -> Self {
        Self { width: self.height, height: self.width }
    }
}

impl std::fmt::Display for Shape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} x {}", self.width, self.height)
    }
}

/// One rectangle of unsigned samples, row by row, each below `2^depth`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Plane {
    shape: Shape,
    depth: u8,
    samples: Vec<i32>,
}

impl Plane {
    /// A plane of the given samples, row by row.
    pub(crate) fn new(shape: Shape, depth: u8, samples: Vec<i32>) -> Result<Self> {
        if !(1..=MAX_DEPTH).contains(&depth) {
            return Err(Error::Parameter(format!("samples of {depth} bits; a plane has 1 to {MAX_DEPTH}")));
        }
        if samples.len() != shape.pixels() {
            return Err(Error::Parameter(format!("{} samples for a plane of {shape}", samples.len())));
        }
        if let Some(at) = samples.iter().position(|s| !(0..1 << depth).contains(s)) {
            let (row, column) = (at / shape.width(), at % shape.width());
            let found = samples[at];
            return Err(Error::Parameter(format!("sample {found} in row {row}, column {column} of a plane of {depth} bits")));
        }
        Ok(Self { shape, depth, samples })
    }

    /// Columns and rows.
    pub(crate) fn shape(&self) -> Shape {
        self.shape
    }

    /// Bits of a sample: 1 to [`MAX_DEPTH`].
    pub(crate) fn depth(&self) -> u8 {
        self.depth
    }

    /// All samples, row by row.
    pub(crate) fn samples(&self) -> &[i32] {
        &self.samples
    }

    /// The samples of one row.
    #[cfg(test)]
    pub(crate) fn row(&self, row: usize) -> &[i32] {
        let width = self.shape.width();
        &self.samples[row * width..][..width]
    }
}

/// Planes of one shape: the components of one image. Their depths may differ.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Planes {
    planes: Vec<Plane>,
}

impl Planes {
    /// The most planes of one image.
    pub(crate) const MAX: usize = 16;

    /// An image of 1 to [`Planes::MAX`] planes, all of one shape.
    pub(crate) fn new(planes: Vec<Plane>) -> Result<Self> {
        if planes.is_empty() || planes.len() > Self::MAX {
            return Err(Error::Parameter(format!("an image of {} planes; 1 to {} can be held", planes.len(), Self::MAX)));
        }
        let shape = planes[0].shape;
        if let Some((i, other)) = planes.iter().enumerate().find(|(_, p)| p.shape != shape) {
            return Err(Error::Parameter(format!("plane {i} is {}, and plane 0 is {shape}", other.shape)));
        }
        Ok(Self { planes })
    }

    /// Columns and rows of every plane.
    pub(crate) fn shape(&self) -> Shape {
        self.planes[0].shape
    }

    /// How many planes.
    pub(crate) fn len(&self) -> usize {
        self.planes.len()
    }

    /// The planes in order.
    pub(crate) fn iter(&self) -> std::slice::Iter<'_, Plane> {
        self.planes.iter()
    }

    /// The depth of each plane, in order.
    pub(crate) fn depths(&self) -> Vec<u8> {
        self.planes.iter().map(Plane::depth).collect()
    }
}

impl std::ops::Index<usize> for Planes {
    type Output = Plane;

    fn index(&self, plane: usize) -> &Plane {
        &self.planes[plane]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_deeper_than_its_plane_is_refused_with_its_place() {
        let shape = Shape::new(3, 2).unwrap();
        assert!(Plane::new(shape, 4, vec![0, 1, 2, 3, 15, 0]).is_ok());
        let why = Plane::new(shape, 4, vec![0, 1, 2, 3, 16, 0]).unwrap_err().to_string();
        assert_eq!(why, "sample 16 in row 1, column 1 of a plane of 4 bits");
        assert!(Plane::new(shape, 4, vec![0, 1, 2, 3, -1, 0]).is_err());
        assert!(Plane::new(shape, 4, vec![0; 5]).is_err());
        assert!(Plane::new(shape, 25, vec![0; 6]).is_err());
    }

    #[test]
    fn planes_of_two_shapes_are_refused() {
        let plane = |w, h| Plane::new(Shape::new(w, h).unwrap(), 8, vec![7; (w * h) as usize]).unwrap();
        assert!(Planes::new(vec![plane(3, 2), plane(3, 2)]).is_ok());
        assert!(Planes::new(vec![plane(3, 2), plane(2, 3)]).is_err());
        assert!(Planes::new(vec![]).is_err());
        assert!(Shape::new(0, 1).is_err() && Shape::new(1, MAX_SIDE + 1).is_err());
    }
}
