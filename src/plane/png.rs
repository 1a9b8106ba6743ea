//! Planes as PNG pictures, and PNG pictures as masks; the only file that names the crate `image`.
//!
//! A plane of up to 8 bits becomes an 8-bit picture, a deeper one a 16-bit picture. Samples are moved up to the top
//! of the picture's depth, so that dark and bright keep their meaning; planes deeper than 16 bits lose their lowest bits.

use std::io::Cursor;

use image::codecs::png::{PngDecoder, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, Limits};

use super::{Mask, Plane, Planes, Shape};
use crate::error::{Error, Place, Result};
use crate::limits::Budget;

/// One plane as a grey picture, or three as red, green and blue.
pub(crate) fn write_png(planes: &Planes) -> Result<Vec<u8>> {
    let deep = planes.iter().any(|p| p.depth() > 8);
    let color = match (planes.len(), deep) {
        (1, false) => ExtendedColorType::L8,
        (1, true) => ExtendedColorType::L16,
        (3, false) => ExtendedColorType::Rgb8,
        (3, true) => ExtendedColorType::Rgb16,
        (n, _) => return Err(Error::Parameter(format!("a picture of {n} planes; PNG holds 1 or 3 of them"))),
    };
    let mut bytes = Vec::with_capacity(planes.shape().pixels() * planes.len() * if deep { 2 } else { 1 });
    for at in 0..planes.shape().pixels() {
        for plane in planes.iter() {
            let sample = (plane.samples()[at] as u32) << (32 - u32::from(plane.depth()));
            if deep {
                bytes.extend_from_slice(&((sample >> 16) as u16).to_ne_bytes());
            } else {
                bytes.push((sample >> 24) as u8);
            }
        }
    }
    let mut png = Vec::new();
    let (width, height) = (planes.shape().width() as u32, planes.shape().height() as u32);
    PngEncoder::new(&mut png)
        .write_image(&bytes, width, height, color)
        .map_err(|e| Error::Parameter(format!("the picture cannot be written: {e}")))?;
    Ok(png)
}

/// The pixels of a picture that are not black (and not transparent).
pub(crate) fn read_mask(png: &[u8], budget: &mut Budget) -> Result<Mask> {
    let malformed = |e: image::ImageError| Error::malformed(Place::Whole, format!("not a PNG picture: {e}"));
    let mut decoder = PngDecoder::new(Cursor::new(png)).map_err(malformed)?;
    let (width, height) = decoder.dimensions();
    let shape = Shape::new(width, height)?;
    budget.check_pixels(shape.pixels() as u64)?;
    budget.reserve(decoder.total_bytes())?;
    decoder.set_limits(Limits::no_limits()).map_err(malformed)?;
    let picture = DynamicImage::from_decoder(decoder).map_err(malformed)?.into_luma_alpha16();
    Mask::from_bits(shape, picture.pixels().map(|p| p.0[0] > 0 && p.0[1] > 0))
}

/// The pixels of a picture in colour, as three planes of 16 bits.
pub(crate) fn read_planes(png: &[u8], budget: &mut Budget) -> Result<Planes> {
    let malformed = |e: image::ImageError| Error::malformed(Place::Whole, format!("not a PNG picture: {e}"));
    let mut decoder = PngDecoder::new(Cursor::new(png)).map_err(malformed)?;
    let (width, height) = decoder.dimensions();
    let shape = Shape::new(width, height)?;
    budget.check_pixels(shape.pixels() as u64)?;
    budget.reserve(decoder.total_bytes().saturating_add(shape.pixels() as u64 * 18))?;
    budget.spend(shape.pixels() as u64 * 8)?;
    decoder.set_limits(Limits::no_limits()).map_err(malformed)?;
    let picture = DynamicImage::from_decoder(decoder).map_err(malformed)?.into_rgb16();
    let plane = |i: usize| Plane::new(shape, 16, picture.pixels().map(|p| p.0[i].into()).collect());
    Planes::new(vec![plane(0)?, plane(1)?, plane(2)?])
}

/// The pixels of a picture, for tests that look at one.
#[cfg(test)]
pub(crate) fn read_rgb(png: &[u8]) -> Vec<[u8; 3]> {
    let decoder = PngDecoder::new(Cursor::new(png)).expect("a PNG picture");
    DynamicImage::from_decoder(decoder).expect("a whole picture").into_rgb8().pixels().map(|p| p.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_of_one_bit_comes_back_as_the_same_mask() {
        let shape = Shape::new(7, 5).unwrap();
        let plane = Plane::new(shape, 1, (0..35).map(|i| i * i % 3 % 2).collect()).unwrap();
        let png = write_png(&Planes::new(vec![plane.clone()]).unwrap()).unwrap();
        let mask = read_mask(&png, &mut Budget::new(crate::Limits::default())).unwrap();
        assert_eq!(mask.shape(), shape);
        assert!(mask.iter().eq(plane.samples().iter().map(|&s| s == 1)));
    }

    #[test]
    fn a_deep_picture_keeps_sixteen_bits_of_each_sample() {
        let shape = Shape::new(2, 1).unwrap();
        let plane = |depth, a, b| Plane::new(shape, depth, vec![a, b]).unwrap();
        let png = write_png(&Planes::new(vec![plane(12, 1, 4095), plane(16, 2, 40000), plane(20, 16, 17)]).unwrap()).unwrap();
        let picture = DynamicImage::from_decoder(PngDecoder::new(Cursor::new(&png)).unwrap()).unwrap().into_rgb16();
        assert_eq!(picture.into_raw(), [16, 2, 1, 4095 << 4, 40000, 1]);
    }

    #[test]
    fn a_picture_beyond_the_limit_is_refused_before_it_is_read() {
        let shape = Shape::new(100, 100).unwrap();
        let png = write_png(&Planes::new(vec![Plane::new(shape, 8, vec![0; 10_000]).unwrap()]).unwrap()).unwrap();
        assert!(matches!(
            read_mask(&png, &mut Budget::new(crate::Limits::default().pixels(9_999))),
            Err(Error::Limit { which: "pixels", .. })
        ));
        assert!(read_mask(&png[..40], &mut Budget::new(crate::Limits::default())).is_err());
    }
}
