//! The codec alone, for measurements and fuzzing.

use super::{Layout, decode, quantise, write};
use crate::error::Result;
use crate::limits::{Budget, Limits};
use crate::plane::{GeometryImage, Gluing, Shape, bounding_box};
use crate::task::Task;

/// Bytes of an image at a step, and what a decoder makes of them.
pub fn encode(image: &GeometryImage, step: f64) -> Result<(Vec<u8>, GeometryImage)> {
    let layout = Layout::new(image.shape(), image.gluing(), step);
    let (quantised, decoded) = quantise(image, layout, &Task::default())?;
    let bounds = bounding_box(decoded.points().iter().copied()).unwrap_or_default();
    Ok((write(&quantised, bounds)?, decoded))
}

/// Decodes the bytes of an image of known layout.
pub fn decoded(bytes: &[u8], like: &GeometryImage, step: f64, bounds: [[f64; 3]; 2], level: u8) -> Result<GeometryImage> {
    let layout = Layout::new(like.shape(), like.gluing(), step);
    decode(bytes, &layout, bounds, level, &mut Budget::new(Limits::default()), &Task::default())
}

/// Decodes bytes whose first ones choose the layout.
pub fn any(bytes: &[u8]) {
    let Some((&[w, h, kind, levels], rest)) = bytes.split_first_chunk::<4>() else { return };
    let (Ok(shape), gluing) =
        (Shape::new(u32::from(w) + 1, u32::from(h) + 1), if kind & 1 == 0 { Gluing::Open } else { Gluing::Orbifold })
    else {
        return;
    };
    let layout = Layout { shape, gluing, levels: levels & 15, step: f64::from(kind >> 1) / 64.0, zones: None };
    let limits = Limits::default().memory(1 << 26).work(1 << 24);
    drop(decode(rest, &layout, [[-1.0; 3], [1.0; 3]], levels >> 4, &mut Budget::new(limits), &Task::default()));
}
