//! Regions of interest: where a surface matters most, and how much more.

use super::{Accuracy, Codec, EncodeOptions, Method, Quality};
use crate::error::{Error, Place, Result};
pub use crate::gim::Closer;
use crate::limits::Limits;
use crate::mesh::{Mesh, Region};
use crate::surface::Effort;

/// A region of interest of a mesh or a geometry image.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Roi {
    /// Where it is.
    pub place: RoiPlace,
    /// Exact connectivity, codec surface: bits of the lattice at all corners of the region's faces; those of all others are [`Accuracy::Bits`](crate::Accuracy::Bits).
    pub bits: Option<u32>,
    /// Geometry images: how samples come to be closer together there. Default: lines twice as dense.
    pub closer: Closer,
    /// Geometry images: away from it, quantiser steps are 2 to this times as large, 0 to 8. Default: 2. JPEG 2000 always has 2.
    pub coarser: u8,
}

/// Where a region of interest is.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum RoiPlace {
    /// Where normals differ most: about 15 % of the surface, connected.
    Auto,
    /// Vertices of the mesh, counted from 0, and the faces around them.
    Vertices(Vec<u32>),
    /// Vertices in a box, and the faces around them.
    Box([[f64; 3]; 2]),
    /// Pixels of the square that the surface is flattened onto, row by row; of any size.
    Mask {
        /// Pixels a row.
        columns: usize,
        /// Whether each is inside.
        inside: Vec<bool>,
    },
}

impl Roi {
    /// A region with the usual choices.
    pub fn new(place: RoiPlace) -> Self {
        Self { place, bits: None, closer: Closer::default(), coarser: 2 }
    }

    /// The same with a lattice of more bits inside.
    pub fn bits(mut self, bits: u32) -> Self {
        self.bits = Some(bits);
        self
    }

    /// The same with samples gathered in another way.
    pub fn closer(mut self, closer: Closer) -> Self {
        self.closer = closer;
        self
    }

    /// The same with other steps outside.
    pub fn coarser(mut self, coarser: u8) -> Self {
        self.coarser = coarser;
        self
    }

    pub(super) fn check(&self) -> Result<()> {
        let refuse = |why: String| Err(Error::Parameter(why));
        if self.coarser > 8 {
            return refuse(format!("steps 2^{} times as large outside a region of interest; at most 2^8", self.coarser));
        }
        match self.closer {
            Closer::Lines(times) if !(1.0..=16.0).contains(&times) => {
                refuse(format!("lines {times} times as dense in a region of interest; 1 to 16 times are possible"))
            }
            Closer::Weights(weights) if !weights.iter().all(|w| *w > 0.0 && w.is_finite()) => {
                refuse(format!("weights {weights:?} of a region of interest; all must be positive"))
            }
            _ => Ok(()),
        }
    }
}

impl RoiPlace {
    /// Reads a region from a file: a PNG picture, whose pixels that are not black are inside; or a text, of vertices' numbers (from 0,
    /// with blanks, commas or lines between) or the word `box` and six numbers, the lower corner and the upper one. What follows a `#`
    /// is a remark.
    ///
    /// # Errors
    /// Files that are neither, with the line in question; pictures beyond the limits.
    pub fn read(bytes: &[u8], limits: Limits) -> Result<Self> {
        if bytes.starts_with(b"\x89PNG") {
            return Self::of_picture(bytes, limits);
        }
        let text = std::str::from_utf8(bytes)
            .map_err(|_| Error::malformed(Place::Whole, "a region of interest is a PNG picture or a text"))?;
        let words = text.lines().enumerate().flat_map(|(i, line)| {
            let line = line.split('#').next().unwrap_or("");
            line.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty()).map(move |w| (i as u64 + 1, w))
        });
        let mut words = words.peekable();
        let expected = |line: u64, word: &str, what: &str| {
            Error::malformed(Place::Line(line), format!("`{word}` in a region of interest, {what} expected"))
        };
        if words.next_if(|(_, word)| *word == "box").is_some() {
            let numbers = words.map(|(line, word)| match word.parse::<f64>() {
                Ok(x) if x.is_finite() => Ok(x),
                _ => Err(expected(line, word, "a number")),
            });
            return match numbers.collect::<Result<Vec<f64>>>()?[..] {
                [a, b, c, d, e, f] if a <= d && b <= e && c <= f => Ok(Self::Box([[a, b, c], [d, e, f]])),
                [_, _, _, _, _, _] => Err(Error::malformed(Place::Whole, "a box whose lower corner is above its upper one")),
                ref other => Err(Error::malformed(Place::Whole, format!("a box of {} numbers, 6 expected", other.len()))),
            };
        }
        let vertices = words.map(|(line, word)| word.parse().map_err(|_| expected(line, word, "the number of a vertex")));
        Ok(Self::Vertices(vertices.collect::<Result<_>>()?))
    }

    /// The region of a mesh. Refuses masks, which need the square that the mesh is flattened onto.
    pub(crate) fn on(&self, mesh: &Mesh) -> Result<Region> {
        match self {
            Self::Auto => Region::found(mesh),
            Self::Vertices(list) => Region::of_vertices(mesh, list),
            Self::Box(corners) => Region::in_box(mesh, *corners),
            Self::Mask { .. } => Err(Error::Parameter(
                "a picture is a region of the square that a mesh is flattened onto; here take a list of vertices or a box"
                    .into(),
            )),
        }
    }

    #[cfg(feature = "png")]
    fn of_picture(bytes: &[u8], limits: Limits) -> Result<Self> {
        let mask = crate::plane::read_mask(bytes, &mut crate::limits::Budget::new(limits))?;
        Ok(Self::Mask { columns: mask.shape().width(), inside: mask.iter().collect() })
    }

    #[cfg(not(feature = "png"))]
    fn of_picture(_: &[u8], _: Limits) -> Result<Self> {
        Err(Error::Unsupported { what: "format", id: "png".into() })
    }
}

impl EncodeOptions {
    /// Refuses regions that the other choices have no use for.
    pub(super) fn check_roi(&self) -> Result<()> {
        let Some(roi) = &self.roi else { return Ok(()) };
        roi.check()?;
        let refuse = |why: &str| Err(Error::Parameter(why.into()));
        match (self.method, self.codec, self.accuracy) {
            (Method::Gim, _, _) if roi.bits.is_some() => {
                refuse("lattice bits of a region of interest are for exact connectivity (method cgim)")
            }
            (Method::Gim, _, Accuracy::Error(_) | Accuracy::RelativeError(_)) => {
                refuse("an error holds on all of the surface; a region of interest takes a psnr, a size or a step")
            }
            (Method::Gim, ..) => Ok(()),
            (_, Codec::J2k, _) if roi.bits.is_some() => {
                refuse("the codec j2k has the same lattice everywhere; a region comes first in it")
            }
            (_, Codec::J2k, _) if self.j2k.quality == Quality::Lossless => {
                refuse("without loss there is no region of interest: give the codec j2k a rate or a psnr")
            }
            (_, Codec::J2k, _) => Ok(()),
            (_, Codec::Surface, _) if self.effort == Effort::Fast || !self.image.stages.is_empty() => {
                refuse("a region of interest of the codec surface is a stage of its own, and needs the effort default or best")
            }
            (_, Codec::Surface, Accuracy::Bits(outside)) => match roi.bits {
                Some(bits) if bits > outside && bits <= crate::format::MAX_BITS => Ok(()),
                Some(bits) => Err(Error::Parameter(format!(
                    "{bits} bits in a region of interest and {outside} elsewhere; more are expected, up to {}",
                    crate::format::MAX_BITS
                ))),
                None => refuse("with exact connectivity a region of interest needs its bits"),
            },
            (_, Codec::Surface, _) => {
                refuse("a region of interest has more bits than the rest: give both, and no step or error")
            }
            _ => refuse("regions of interest are for the codecs surface and j2k, and for geometry images (method gim)"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<RoiPlace> {
        RoiPlace::read(text.as_bytes(), Limits::default())
    }

    #[test]
    fn lists_and_boxes_are_read_and_what_is_neither_is_refused_with_its_line() {
        assert_eq!(read("1 2,3\n# a remark\n 17 # another\n").unwrap(), RoiPlace::Vertices(vec![1, 2, 3, 17]));
        assert_eq!(read("box 0 0 -1\n1 2 3").unwrap(), RoiPlace::Box([[0.0, 0.0, -1.0], [1.0, 2.0, 3.0]]));
        for (text, why) in [
            ("1\n2\nthree", "line 3"),
            ("1 -2", "line 1"),
            ("box 1 2 3", "3 numbers"),
            ("box 1 2 3 0 5 6", "above"),
            ("box 1 2 3 4 5 nan", "a number"),
        ] {
            let found = read(text).unwrap_err().to_string();
            assert!(found.contains(why), "{text:?}: {found}");
        }
        assert!(RoiPlace::read(b"\xff\xfe", Limits::default()).is_err());
    }
}
