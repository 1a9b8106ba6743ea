//! Decoding, by the crate `hayro-jpeg2000`; the only file that names it.
//!
//! The header is read and held against what the container states before the crate sees a byte, and what a decode costs
//! is taken from the budget before it begins.

use hayro_jpeg2000::{DecodeSettings, DecoderContext, Image};

use super::codestream::{Header, Profile};
use super::partition::Partition;
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::plane::{Plane, Planes};

/// Coding passes that a bit-plane has, each of which may visit every coefficient.
const PASSES_OF_A_PLANE: u64 = 3;

/// What a codestream says it is, if it is of the profile.
pub(crate) fn profile(codestream: &[u8]) -> Result<Profile> {
    Ok(Header::read(codestream)?.0.profile)
}

/// The planes of a codestream that must be of the profile `expected`.
pub(crate) fn decode(codestream: &[u8], expected: &Profile, budget: &mut Budget) -> Result<Planes> {
    let (header, _) = Header::read(codestream)?;
    agree(&header.profile, expected)?;
    let Profile { shape, ref depths, levels, layers, .. } = header.profile;

    let samples = shape.pixels() as u64 * depths.len() as u64;
    budget.check_pixels(samples)?;
    let most_planes = header.planes().into_iter().flatten().max().unwrap_or(0);
    budget.spend(samples.saturating_mul(PASSES_OF_A_PLANE * u64::from(most_planes)))?;
    // The decoder holds all components and one component's coefficients, twice, as f32; and a record of each layer of
    // each code-block and of each segment.
    let blocks = Partition::new(shape, levels, header.block).blocks.len() as u64 * depths.len() as u64;
    budget.reserve(samples * 4 + shape.pixels() as u64 * 12 + blocks * (160 + 72 * u64::from(layers)))?;

    let settings = DecodeSettings { strict: true, ..DecodeSettings::default() };
    let malformed = |e| Error::malformed(Place::Whole, format!("in a JPEG 2000 codestream: {e}"));
    let image = Image::new(codestream, &settings).map_err(malformed)?;
    let mut context = DecoderContext::default();
    let decoded = image.decode(&mut context).map_err(malformed)?;
    let mut planes = Vec::with_capacity(depths.len());
    for (component, &depth) in decoded.components().iter().zip(depths) {
        let most = ((1u32 << depth) - 1) as f32;
        let mut samples = budget.vec(shape.pixels(), 0)?;
        for (to, &from) in samples.iter_mut().zip(component.samples()) {
            *to = (from + 0.5).floor().clamp(0.0, most) as i32;
        }
        planes.push(Plane::new(shape, depth, samples)?);
    }
    Planes::new(planes)
}

/// Says where a codestream is not what its container states.
fn agree(found: &Profile, expected: &Profile) -> Result<()> {
    let differ = |what: &str, found: String, expected: String| {
        Err(Error::malformed(Place::Whole, format!("a JPEG 2000 codestream of {what} {found}, and the file states {expected}")))
    };
    if found.shape != expected.shape {
        return differ("size", found.shape.to_string(), expected.shape.to_string());
    }
    if found.depths != expected.depths {
        return differ("depths", format!("{:?}", found.depths), format!("{:?}", expected.depths));
    }
    if found.transform != expected.transform {
        return differ("transform", format!("{:?}", found.transform), format!("{:?}", expected.transform));
    }
    if found.levels != expected.levels {
        return differ("decompositions", found.levels.to_string(), expected.levels.to_string());
    }
    if found.layers != expected.layers {
        return differ("layers", found.layers.to_string(), expected.layers.to_string());
    }
    Ok(())
}
