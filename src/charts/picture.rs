//! Geometry images as pictures, for other programs: OpenEXR with the coordinates as they are, or PNG of 16 bits on a lattice.

use crate::error::Result;
use crate::limits::{Budget, Limits};
use crate::plane::{GeometryImage, Gluing, Lattice, Plane, Planes, Shape, bounding_box, read_planes, write_png};

/// The first bytes of a PNG picture.
const PNG: [u8; 4] = [0x89, b'P', b'N', b'G'];
/// The largest sample.
const WHITE: f64 = 65535.0;

impl GeometryImage {
    /// An image from a picture: OpenEXR with coordinates in its channels R, G and B, or a PNG whose samples are points of a
    /// lattice (without one, from 0 to 1).
    ///
    /// Without `gluing` an image is an orbifold if its border is that of one to the last bit, and open else.
    ///
    /// # Errors
    /// Bytes that are not such a picture, one beyond the limits, coordinates that are not finite, or a shape that cannot be
    /// glued so.
    pub fn from_picture(bytes: &[u8], lattice: Option<Lattice>, gluing: Option<Gluing>, limits: Limits) -> Result<Self> {
        let mut budget = Budget::new(limits);
        let (shape, points) = if bytes.starts_with(&PNG) {
            let planes = read_planes(bytes, &mut budget)?;
            let lattice = lattice.unwrap_or(Lattice { origin: [0.0; 3], step: 1.0 / WHITE });
            let point = |at: usize| lattice.point([0, 1, 2].map(|i| i64::from(planes[i].samples()[at])));
            (planes.shape(), (0..planes.shape().pixels()).map(point).collect())
        } else {
            crate::codec::read_points(bytes, &mut budget)?
        };
        let gluing = gluing.unwrap_or_else(|| if is_orbifold(shape, &points) { Gluing::Orbifold } else { Gluing::Open });
        Self::new(shape.width(), shape.height(), gluing, points)
    }

    /// The image as an OpenEXR picture of 32-bit floats.
    ///
    /// # Errors
    /// An image too large for the format.
    pub fn to_exr(&self) -> Result<Vec<u8>> {
        crate::codec::write_points(self.shape(), self.points())
    }

    /// The image as a PNG of 16 bits, and the lattice of its samples.
    ///
    /// # Errors
    /// An image too large for the format.
    pub fn to_png(&self) -> Result<(Vec<u8>, Lattice)> {
        let [low, high] = bounding_box(self.points().iter().copied()).unwrap_or([[0.0; 3]; 2]);
        let longest = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
        let lattice = Lattice { origin: low, step: if longest > 0.0 { longest / WHITE } else { 1.0 } };
        let plane = |axis: usize| {
            let sample = |p: &[f64; 3]| lattice.index(p[axis], axis).clamp(0.0, WHITE) as i32;
            Plane::new(self.shape(), 16, self.points().iter().map(sample).collect())
        };
        Ok((write_png(&Planes::new(vec![plane(0)?, plane(1)?, plane(2)?])?)?, lattice))
    }
}

/// Whether all samples that an orbifold glues are the same.
fn is_orbifold(shape: Shape, points: &[[f64; 3]]) -> bool {
    let width = shape.width();
    Gluing::Orbifold.check(shape).is_ok()
        && (0..points.len()).all(|at| {
            let (row, column) = Gluing::Orbifold.representative(shape, at / width, at % width);
            points[row * width + column] == points[at]
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(gluing: Gluing) -> GeometryImage {
        let points = (0..9 * 5).map(|p| [f64::from(p) * 0.5, f64::from(p * p % 13) - 4.0, 100.25]).collect();
        GeometryImage::new(9, 5, gluing, points).unwrap()
    }

    #[test]
    fn a_picture_of_floats_gives_the_image_back_with_its_gluing() {
        for gluing in [Gluing::Open, Gluing::Orbifold] {
            let image = image(gluing);
            assert_eq!(GeometryImage::from_picture(&image.to_exr().unwrap(), None, None, Limits::default()).unwrap(), image);
        }
    }

    #[test]
    fn a_png_gives_the_image_back_to_half_a_step() {
        for gluing in [Gluing::Open, Gluing::Orbifold] {
            let image = image(gluing);
            let (png, lattice) = image.to_png().unwrap();
            let back = GeometryImage::from_picture(&png, Some(lattice), None, Limits::default()).unwrap();
            assert_eq!(back.gluing(), gluing);
            let far = |(p, q): (&[f64; 3], &[f64; 3])| (0..3).map(|i| (p[i] - q[i]).abs()).fold(0.0, f64::max);
            let farthest = image.points().iter().zip(back.points()).map(far).fold(0.0, f64::max);
            assert!(farthest <= 0.5001 * lattice.step, "{farthest}");
        }
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        for bytes in [&b""[..], b"ply", &PNG] {
            assert!(GeometryImage::from_picture(bytes, None, None, Limits::default()).is_err());
        }
        let exr = image(Gluing::Open).to_exr().unwrap();
        assert!(GeometryImage::from_picture(&exr, None, None, Limits::default().pixels(44)).is_err());
    }
}
