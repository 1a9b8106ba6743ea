//! A geometry image to look at: its points and its normals.

use crate::charts;
use crate::error::Result;
use crate::mesh::{Scalar, vertex_normals};
use crate::plane::{GeometryImage, Plane, Planes, write_png};

/// The points as a 16-bit picture: red, green and blue are x, y and z, one scale for all three.
///
/// # Errors
/// An image that is too large for a picture.
pub fn points_png(image: &GeometryImage) -> Result<Vec<u8>> {
    Ok(image.to_png()?.0)
}

/// The normals as a picture: −1 is black and 1 is bright in each of red, green and blue.
///
/// # Errors
/// An image that is too large for a picture.
pub fn normals_png(image: &GeometryImage) -> Result<Vec<u8>> {
    let normals = vertex_normals(&charts::mesh(image, Scalar::F64)?);
    let mut vertex = vec![0; image.points().len()];
    let mut next = 0;
    for (at, of) in image.representatives().into_iter().enumerate() {
        let of = of as usize;
        if of == at {
            vertex[at] = next;
            next += 1;
        } else {
            vertex[at] = vertex[of];
        }
    }
    let plane = |i: usize| {
        let sample = |&v: &usize| ((normals[v][i] + 1.0) * 127.5 + 0.5).clamp(0.0, 255.0) as i32;
        Plane::new(image.shape(), 8, vertex.iter().map(sample).collect())
    };
    write_png(&Planes::new(vec![plane(0)?, plane(1)?, plane(2)?])?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::{Gluing, read_rgb};

    #[test]
    fn a_flat_image_has_one_normal_everywhere() {
        let points = (0..35).map(|p| [f64::from(p % 7), f64::from(p / 7), 3.0]).collect();
        let image = GeometryImage::new(7, 5, Gluing::Open, points).unwrap();
        let pixels = read_rgb(&normals_png(&image).unwrap());
        assert_eq!(pixels.len(), 35);
        assert!(pixels.iter().all(|&p| p == [128, 128, 255] || p == [128, 128, 0]), "{pixels:?}");
        assert!(pixels.iter().all(|p| *p == pixels[0]));
    }
}
