//! Chunk `ATTR`: values on vertices, corners and faces (spec/attributes.md). Absent where there are none.

use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;

/// One attribute: what it is, and the stream of its values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AttributeRecord<'a> {
    /// 0 normals, 1 texture coordinates, 2 colours, 3 others.
    pub(crate) kind: u8,
    /// 0 vertices, 1 corners, 2 faces.
    pub(crate) domain: u8,
    /// 0–7: i8, u8, i16, u16, i32, u32, f32, f64.
    pub(crate) scalar: u8,
    /// Whether some elements have no value.
    pub(crate) has_gaps: bool,
    /// Numbers a value.
    pub(crate) width: u8,
    pub(crate) name: &'a str,
    pub(crate) numbers: NumberForm,
    pub(crate) stream: &'a [u8],
}

/// How numbers became integers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum NumberForm {
    Integer,
    Lattice { low: Vec<f64>, step: f64 },
    Octahedral { bits: u8 },
    Exact,
}

/// The scalar type `f64`.
const DOUBLE: u8 = 7;

impl<'a> AttributeRecord<'a> {
    pub(crate) const TAG: [u8; 4] = *b"ATTR";

    #[cfg(feature = "encode")]
    pub(crate) fn write(records: &[AttributeRecord<'_>]) -> Vec<u8> {
        let mut w = Writer::default();
        w.varint(records.len() as u64);
        for record in records {
            let form = match record.numbers {
                NumberForm::Integer => 0,
                NumberForm::Lattice { .. } => 1,
                NumberForm::Octahedral { .. } => 2,
                NumberForm::Exact => 3,
            };
            w.u8(record.kind | record.domain << 2 | form << 4);
            w.u8(record.scalar | u8::from(record.has_gaps) << 3);
            w.u8(record.width);
            w.varint(record.name.len() as u64);
            w.bytes(record.name.as_bytes());
            match &record.numbers {
                NumberForm::Lattice { low, step } => {
                    low.iter().for_each(|&x| if record.scalar == DOUBLE { w.f64(x) } else { w.f32(x as f32) });
                    w.f64(*step);
                }
                NumberForm::Octahedral { bits } => w.u8(*bits),
                NumberForm::Integer | NumberForm::Exact => {}
            }
            w.varint(record.stream.len() as u64);
            w.bytes(record.stream);
        }
        w.into_bytes()
    }

    pub(crate) fn read(mut r: Reader<'a>) -> Result<Vec<Self>> {
        let count = r.varint("the attributes")?;
        let mut records = Vec::new();
        for _ in 0..count {
            let what = r.u8("what an attribute is")?;
            let (kind, domain, form) = (what & 3, what >> 2 & 3, what >> 4);
            let number = r.u8("the type of an attribute")?;
            let (scalar, has_gaps) = (number & 7, number & 8 != 0);
            let width = r.u8("the width of an attribute")?;
            if domain > 2 || form > 3 || number > 15 || width == 0 {
                return Err(r.error(format!("an attribute on {domain} of form {form}, type {number} and width {width}")));
            }
            let length = usize::try_from(r.varint("the length of a name")?).unwrap_or(usize::MAX);
            let Ok(name) = std::str::from_utf8(r.take(length, "a name")?) else {
                return Err(r.error("a name that is not UTF-8"));
            };
            let numbers = match form {
                0 => NumberForm::Integer,
                1 => {
                    let mut low = Vec::new();
                    for _ in 0..width {
                        low.push(if scalar == DOUBLE {
                            r.f64("the lowest value")?
                        } else {
                            f64::from(r.f32("the lowest value")?)
                        });
                    }
                    NumberForm::Lattice { low, step: r.f64("the step")? }
                }
                2 => NumberForm::Octahedral { bits: r.u8("the bits of normals")? },
                _ => NumberForm::Exact,
            };
            match &numbers {
                NumberForm::Lattice { low, step } if !(*step > 0.0 && low.iter().chain([step]).all(|x| x.is_finite())) => {
                    return Err(r.error("a lattice of values that are not finite numbers"));
                }
                NumberForm::Octahedral { bits } if !(2..=20).contains(bits) || width != 3 => {
                    return Err(r.error(format!("normals of {width} numbers and {bits} bits; 3, and 2 to 20 bits, expected")));
                }
                _ => {}
            }
            let length = usize::try_from(r.varint("the length of an attribute")?).unwrap_or(usize::MAX);
            let stream = r.take(length, "an attribute")?;
            records.push(Self { kind, domain, scalar, has_gaps, width, name, numbers, stream });
        }
        r.finish()?;
        Ok(records)
    }
}
