//! The codec `exr `: planes as an OpenEXR picture of 32-bit floats, without loss; the only file that names the crate `exr`.
//!
//! A sample of a plane `d` bits deep is stored as `sample / 2^d`, so that any viewer shows it from black to bright;
//! for up to 24 bits that is exact. Three planes are the channels R, G and B.

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels, ReadLayers, WritableImage,
    read,
};

use super::PlaneCodec;
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::plane::{Plane, Planes, Shape};
use crate::task::Task;

/// Planes as an OpenEXR picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Exr;

/// Bytes a sample that reading takes, decompression included.
const BYTES_A_SAMPLE: u64 = 16;

/// The name of the `i`-th of `n` channels.
fn name(i: usize, n: usize) -> String {
    match n {
        1 => "Y".into(),
        3 => ["R", "G", "B"][i].into(),
        // Positions, and octahedral normals as a layer of their own.
        5 => ["R", "G", "B", "normal.X", "normal.Y"][i].into(),
        _ => format!("plane{i:02}"),
    }
}

impl PlaneCodec for Exr {
    fn encode(&self, planes: &Planes, _: &Task) -> Result<Vec<u8>> {
        let channels = planes.iter().enumerate().map(|(i, plane)| {
            let scale = 1.0 / (1_u32 << plane.depth()) as f32;
            let samples = plane.samples().iter().map(|&s| s as f32 * scale).collect();
            AnyChannel::new(name(i, planes.len()).as_str(), FlatSamples::F32(samples))
        });
        let size = (planes.shape().width(), planes.shape().height());
        let channels = AnyChannels::sort(channels.collect());
        let layer = Layer::new(size, LayerAttributes::default(), Encoding::SMALL_FAST_LOSSLESS, channels);
        let mut bytes = Cursor::new(Vec::new());
        let written = Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes);
        written.map_err(|e| Error::Parameter(format!("the EXR picture cannot be written: {e}")))?;
        Ok(bytes.into_inner())
    }

    fn decode(&self, bytes: &[u8], shape: Shape, depths: &[u8], budget: &mut Budget) -> Result<Planes> {
        let malformed = |why: String| Error::malformed(Place::Whole, why);
        // Sizes first: a header may promise anything.
        let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false);
        let meta = meta.map_err(|e| malformed(format!("not an EXR picture: {e}")))?;
        let [header] = meta.headers.as_slice() else {
            return Err(malformed(format!("an EXR picture of {} layers, one expected", meta.headers.len())));
        };
        let size = (header.layer_size.width(), header.layer_size.height());
        if size != (shape.width(), shape.height()) || header.channels.list.len() != depths.len() {
            let channels = header.channels.list.len();
            return Err(malformed(format!(
                "an EXR picture of {} x {} pixels and {channels} channels, {shape} and {} expected",
                size.0,
                size.1,
                depths.len()
            )));
        }
        budget.reserve(BYTES_A_SAMPLE * depths.len() as u64 * shape.pixels() as u64)?;
        budget.spend(8 * depths.len() as u64 * shape.pixels() as u64)?;
        let picture = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
        let picture = picture.non_parallel().from_buffered(Cursor::new(bytes));
        let picture = picture.map_err(|e| malformed(format!("not an EXR picture: {e}")))?;
        let plane = |(i, &depth): (usize, &u8)| {
            let wanted = name(i, depths.len());
            let channel = picture.layer_data.channel_data.list.iter().find(|channel| channel.name.eq(wanted.as_str()));
            let Some(FlatSamples::F32(samples)) = channel.map(|channel| &channel.sample_data) else {
                return Err(malformed(format!("the EXR picture has no channel {wanted} of 32-bit floats")));
            };
            let scale = (1_u32 << depth) as f32;
            let sample = |&x: &f32| {
                let s = x * scale;
                if s >= 0.0 && s < scale && s.fract() == 0.0 {
                    Ok(s as i32)
                } else {
                    Err(malformed(format!("an EXR sample of {x}")))
                }
            };
            Plane::new(shape, depth, samples.iter().map(sample).collect::<Result<_>>()?)
        };
        Planes::new(depths.iter().enumerate().map(plane).collect::<Result<_>>()?)
    }
}

/// Points as a picture of 32-bit floats: R, G and B are x, y and z, as they are.
pub(crate) fn write_points(shape: Shape, points: &[[f64; 3]]) -> Result<Vec<u8>> {
    let channel = |i: usize| {
        let samples = points.iter().map(|p| p[i] as f32).collect();
        AnyChannel::new(name(i, 3).as_str(), FlatSamples::F32(samples))
    };
    let channels = AnyChannels::sort([0, 1, 2].map(channel).into_iter().collect());
    let layer =
        Layer::new((shape.width(), shape.height()), LayerAttributes::default(), Encoding::SMALL_FAST_LOSSLESS, channels);
    let mut bytes = Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes);
    written.map_err(|e| Error::Parameter(format!("the EXR picture cannot be written: {e}")))?;
    Ok(bytes.into_inner())
}

/// The points of a picture that any program may have made: channels R, G, B or X, Y, Z of floats of 32 or 16 bits.
pub(crate) fn read_points(bytes: &[u8], budget: &mut Budget) -> Result<(Shape, Vec<[f64; 3]>)> {
    let malformed = |why: String| Error::malformed(Place::Whole, why);
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false);
    let meta = meta.map_err(|e| malformed(format!("not an EXR picture: {e}")))?;
    let [header] = meta.headers.as_slice() else {
        return Err(malformed(format!("an EXR file of {} pictures, 1 expected", meta.headers.len())));
    };
    let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let shape = Shape::new(side(header.layer_size.width()), side(header.layer_size.height()));
    let shape = shape.map_err(|e| malformed(e.to_string()))?;
    budget.check_pixels(shape.pixels() as u64)?;
    let samples = header.channels.list.len().max(3) as u64 * shape.pixels() as u64;
    budget.reserve(samples.saturating_mul(2 * BYTES_A_SAMPLE))?;
    budget.spend(samples.saturating_mul(8))?;
    let picture = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let picture = picture.non_parallel().from_buffered(Cursor::new(bytes));
    let picture = picture.map_err(|e| malformed(format!("not an EXR picture: {e}")))?;
    let channel = |i: usize| {
        let found = ["RGB", "rgb", "XYZ", "xyz"]
            .iter()
            .find_map(|names| picture.layer_data.channel_data.list.iter().find(|channel| channel.name.eq(&names[i..=i])));
        let found = found.ok_or_else(|| malformed(format!("an EXR picture without a channel {}", name(i, 3))))?;
        match &found.sample_data {
            FlatSamples::F32(samples) => Ok(samples.iter().map(|&x| f64::from(x)).collect::<Vec<_>>()),
            FlatSamples::F16(samples) => Ok(samples.iter().map(|&x| f64::from(x.to_f32())).collect()),
            FlatSamples::U32(_) => Err(malformed("an EXR picture of integers; coordinates are floats".into())),
        }
    };
    let planes = [channel(0)?, channel(1)?, channel(2)?];
    if planes.iter().any(|plane| plane.len() != shape.pixels()) {
        return Err(malformed("an EXR picture whose channels differ in size".into()));
    }
    Ok((shape, (0..shape.pixels()).map(|at| [planes[0][at], planes[1][at], planes[2][at]]).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;

    fn planes(depths: &[u8], shape: Shape) -> Planes {
        let sample = |at: usize, depth: u8| ((at as u32).wrapping_mul(0x9E37_79B1) >> (32 - u32::from(depth))) as i32;
        let plane = |&depth: &u8| Plane::new(shape, depth, (0..shape.pixels()).map(|at| sample(at, depth)).collect());
        Planes::new(depths.iter().map(plane).collect::<Result<_>>().unwrap()).unwrap()
    }

    #[test]
    fn samples_of_up_to_24_bits_come_back_without_loss() {
        let shape = Shape::new(37, 21).unwrap();
        for depths in [&[24, 24, 24][..], &[12, 11, 10], &[1], &[8, 16], &[24, 3, 9, 1, 20]] {
            let planes = planes(depths, shape);
            let bytes = Exr.encode(&planes, &Task::default()).unwrap();
            assert_eq!(bytes[..4], [0x76, 0x2f, 0x31, 0x01], "the magic number of OpenEXR");
            assert_eq!(Exr.decode(&bytes, shape, depths, &mut Budget::new(Limits::default())).unwrap(), planes);
        }
    }

    #[test]
    fn points_come_back_as_they_are_in_single_precision() {
        let shape = Shape::new(9, 4).unwrap();
        let points: Vec<[f64; 3]> = (0..36).map(|i| [f64::from(i) * 0.25, -1e6 - f64::from(i), 0.5]).collect();
        let bytes = write_points(shape, &points).unwrap();
        assert_eq!(read_points(&bytes, &mut Budget::new(Limits::default())).unwrap(), (shape, points));
        let few = Limits::default().pixels(35);
        assert!(matches!(read_points(&bytes, &mut Budget::new(few)), Err(Error::Limit { which: "pixels", .. })));
        for end in 0..bytes.len() {
            drop(read_points(&bytes[..end], &mut Budget::new(Limits::default())));
        }
    }

    #[test]
    fn pictures_of_another_size_and_damaged_ones_are_refused() {
        let (shape, depths) = (Shape::new(16, 9).unwrap(), [10, 10, 10]);
        let bytes = Exr.encode(&planes(&depths, shape), &Task::default()).unwrap();
        let decode = |bytes: &[u8], shape, depths: &[u8]| Exr.decode(bytes, shape, depths, &mut Budget::new(Limits::default()));
        assert!(decode(&bytes, shape.transposed(), &depths).is_err());
        assert!(decode(&bytes, shape, &[10, 10]).is_err());
        assert!(decode(&bytes, shape, &[9, 9, 9]).is_err());
        for end in 0..bytes.len() {
            assert!(decode(&bytes[..end], shape, &depths).is_err(), "cut at {end}");
            let mut changed = bytes.clone();
            changed[end] ^= 0x40;
            drop(decode(&changed, shape, &depths));
        }
    }
}
