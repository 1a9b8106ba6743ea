//! A geometry image to look at: its points and its normals.

use crate::charts;
use crate::error::{Error, Result};
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
    write_png(&normals(image, |_, bright| bright)?)
}

/// The normals as a picture, black where a sample is not `inside`: what a region of interest became, and one to be read as such.
///
/// # Errors
/// An image that is too large for a picture, and another number of samples.
pub fn roi_png(image: &GeometryImage, inside: &[bool]) -> Result<Vec<u8>> {
    if inside.len() != image.points().len() {
        return Err(Error::Parameter(format!("{} samples of a region in an image of {}", inside.len(), image.shape())));
    }
    write_png(&normals(image, |at, bright| if inside[at] { bright.max(1) } else { 0 })?)
}

fn normals(image: &GeometryImage, shade: impl Fn(usize, i32) -> i32) -> Result<Planes> {
    let of_vertices = vertex_normals(&charts::mesh(&[image], Scalar::F64)?);
    let mut normals = vec![[0.0; 3]; image.points().len()];
    charts::surface(image).0.iter().zip(of_vertices).for_each(|(&at, normal)| normals[at as usize] = normal);
    let of = image.representatives();
    let plane = |i: usize| {
        let sample = |(at, &of): (usize, &u32)| {
            let bright = ((normals[of as usize][i] + 1.0) * 127.5 + 0.5).clamp(0.0, 255.0) as i32;
            shade(at, bright)
        };
        Plane::new(image.shape(), 8, of.iter().enumerate().map(sample).collect())
    };
    Planes::new(vec![plane(0)?, plane(1)?, plane(2)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::{Gluing, read_rgb};

    #[test]
    fn what_is_not_inside_is_black() {
        let points = (0..35).map(|p| [f64::from(p % 7), f64::from(p / 7), 3.0]).collect();
        let image = GeometryImage::new(7, 5, Gluing::Open, points).unwrap();
        let inside: Vec<bool> = (0..35).map(|at| at % 3 == 0).collect();
        let (all, some) = (read_rgb(&normals_png(&image).unwrap()), read_rgb(&roi_png(&image, &inside).unwrap()));
        assert!((0..35).all(|at| some[at] == if inside[at] { all[at].map(|x| x.max(1)) } else { [0; 3] }));
        assert!(roi_png(&image, &inside[1..]).is_err());
    }

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
