//! Which attributes of a mesh are kept, and how exact.

use crate::error::{Error, Result};
use crate::format::MAX_BITS;
use crate::mesh::AttributeKind;

/// Which attributes are kept, and how exact; `None` for those that are not. Integers are always kept as they are.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct AttributeChoices {
    /// Normals; 10 bits make them directions off by less than 0.2 degrees. Default: 10 bits.
    pub normals: Option<Precision>,
    /// Texture coordinates. Default: 12 bits.
    pub uv: Option<Precision>,
    /// Colours as floats. Default: 8 bits.
    pub colours: Option<Precision>,
    /// All others. Default: 16 bits.
    pub scalars: Option<Precision>,
    /// Names of objects, groups, materials, and smoothing groups. Default: kept.
    pub groups: bool,
}

/// How exact the numbers of an attribute are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Precision {
    /// 2^bits lattice points on the longest range of its components; 1 to 24 bits.
    Bits(u32),
    /// Lattice points at this distance.
    Step(f64),
    /// Bit by bit.
    Exact,
}

impl Default for AttributeChoices {
    fn default() -> Self {
        Self {
            normals: Some(Precision::Bits(10)),
            uv: Some(Precision::Bits(12)),
            colours: Some(Precision::Bits(8)),
            scalars: Some(Precision::Bits(16)),
            groups: true,
        }
    }
}

impl AttributeChoices {
    /// No attributes, no names.
    pub fn none() -> Self {
        Self { normals: None, uv: None, colours: None, scalars: None, groups: false }
    }

    /// How attributes of a kind are kept.
    pub(crate) fn precision(&self, kind: AttributeKind) -> Option<Precision> {
        match kind {
            AttributeKind::Normal => self.normals,
            AttributeKind::TexCoord => self.uv,
            AttributeKind::Colour => self.colours,
            AttributeKind::Other => self.scalars,
        }
    }

    pub(super) fn check(&self) -> Result<()> {
        for precision in [self.normals, self.uv, self.colours, self.scalars].into_iter().flatten() {
            match precision {
                Precision::Bits(bits) if !(1..=MAX_BITS).contains(&bits) => {
                    let most = MAX_BITS;
                    return Err(Error::Parameter(format!("bits of attributes must be 1 to {most}, found {bits}")));
                }
                Precision::Step(step) if !(step > 0.0 && step.is_finite()) => {
                    return Err(Error::Parameter(format!("the step of attributes must be a positive number, found {step}")));
                }
                _ => {}
            }
        }
        Ok(())
    }
}
