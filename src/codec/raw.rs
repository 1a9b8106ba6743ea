//! The codec `raw `: samples one after the other, each in as many bits as its plane is deep.
//!
//! Row by row; the planes of a pixel follow each other; bits run from the highest to the lowest, and the last byte
//! is filled up with zeros.

use super::PlaneCodec;
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::plane::{Plane, Planes, Shape};
use crate::task::Task;

/// Samples as they are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Raw;

impl PlaneCodec for Raw {
    fn encode(&self, planes: &Planes, _: &Task) -> Result<Vec<u8>> {
        let (mut bytes, mut held, mut count) = (Vec::new(), 0_u64, 0);
        for at in 0..planes.shape().pixels() {
            for plane in planes.iter() {
                held = held << plane.depth() | plane.samples()[at] as u64;
                count += u32::from(plane.depth());
                while count >= 8 {
                    count -= 8;
                    bytes.push((held >> count) as u8);
                }
            }
        }
        if count > 0 {
            bytes.push((held << (8 - count)) as u8);
        }
        Ok(bytes)
    }

    fn decode(&self, bytes: &[u8], shape: Shape, depths: &[u8], budget: &mut Budget) -> Result<Planes> {
        let pixels = shape.pixels();
        let bits = depths.iter().map(|&d| u64::from(d)).sum::<u64>().saturating_mul(pixels as u64);
        if bits.div_ceil(8) != bytes.len() as u64 {
            let why = format!("{} bytes of raw samples, {} expected", bytes.len(), bits.div_ceil(8));
            return Err(Error::malformed(Place::Whole, why));
        }
        budget.spend(pixels as u64 * depths.len() as u64)?;
        let mut planes = depths.iter().map(|_| budget.vec(pixels, 0)).collect::<Result<Vec<Vec<i32>>>>()?;
        let (mut rest, mut held, mut count) = (bytes.iter(), 0_u64, 0_u32);
        for at in 0..pixels {
            for (plane, &depth) in planes.iter_mut().zip(depths) {
                while count < u32::from(depth) {
                    held = held << 8 | u64::from(rest.next().copied().unwrap_or(0));
                    count += 8;
                }
                count -= u32::from(depth);
                plane[at] = (held >> count & ((1 << depth) - 1)) as i32;
            }
        }
        if held & ((1 << count) - 1) != 0 {
            return Err(Error::malformed(Place::Whole, "the bits after the last raw sample are not zero"));
        }
        let planes = planes.into_iter().zip(depths).map(|(samples, &depth)| Plane::new(shape, depth, samples));
        Planes::new(planes.collect::<Result<_>>()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn samples_of_any_depth_come_back(
            (width, height) in (1_u32..20, 1_u32..20),
            depths in proptest::collection::vec(1_u8..=24, 1..5),
            seed: u32,
        ) {
            let shape = Shape::new(width, height).unwrap();
            let mut x = seed;
            let mut random = |depth: u8| {
                x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (x >> (32 - u32::from(depth))) as i32
            };
            let plane = |&depth: &u8| Plane::new(shape, depth, (0..shape.pixels()).map(|_| random(depth)).collect());
            let planes = Planes::new(depths.iter().map(plane).collect::<Result<_>>().unwrap()).unwrap();
            let bytes = Raw.encode(&planes, &Task::default()).unwrap();
            let mut budget = Budget::new(Limits::default());
            prop_assert_eq!(Raw.decode(&bytes, shape, &depths, &mut budget).unwrap(), planes);
            prop_assert!(Raw.decode(&bytes[1..], shape, &depths, &mut budget).is_err());
        }
    }
}
