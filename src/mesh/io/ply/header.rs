//! The header: which tables follow, and what a record of each consists of.

use crate::error::{Error, Place, Result};
use crate::mesh::Scalar;
use crate::mesh::io::text::{name, show};

/// How the tables are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

/// The type of a number in a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    /// A type of the standard.
    Scalar(Scalar),
    /// A 64-bit integer, with or without sign.
    Long { signed: bool },
}

impl Type {
    fn parse(word: &str) -> Option<Self> {
        Some(Self::Scalar(match word {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            "int64" | "long" => return Some(Self::Long { signed: true }),
            "uint64" | "ulong" => return Some(Self::Long { signed: false }),
            _ => return None,
        }))
    }

    /// The name that a header gives it.
    pub(super) fn name(scalar: Scalar) -> &'static str {
        match scalar {
            Scalar::I8 => "char",
            Scalar::U8 => "uchar",
            Scalar::I16 => "short",
            Scalar::U16 => "ushort",
            Scalar::I32 => "int",
            Scalar::U32 => "uint",
            Scalar::F32 => "float",
            Scalar::F64 => "double",
        }
    }

    /// Bytes of one number in a binary table.
    pub(super) fn size(self) -> usize {
        match self {
            Self::Scalar(scalar) => scalar.size(),
            Self::Long { .. } => 8,
        }
    }

    /// The type that holds its numbers in a mesh.
    pub(super) fn scalar(self) -> Scalar {
        match self {
            Self::Scalar(scalar) => scalar,
            Self::Long { .. } => Scalar::F64,
        }
    }
}

/// A part of a record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    /// The type of the number, or of the list's numbers.
    pub(super) of: Type,
    /// For lists, the type of the number that says how many follow.
    pub(super) counted_by: Option<Type>,
}

/// A table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) records: u64,
    pub(super) properties: Vec<Property>,
    /// The header line that announces it.
    pub(super) line: u64,
}

impl Element {
    /// The least number of bytes that a record can take.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> u64 {
        let numbers = self.properties.iter().map(|p| p.counted_by.unwrap_or(p.of));
        match encoding {
            // Not more than a line: lines that are too short are better named one by one.
            Encoding::Text => numbers.count().min(1) as u64,
            Encoding::Little | Encoding::Big => numbers.map(|number| number.size() as u64).sum(),
        }
    }
}

/// A header, and where the tables begin.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// The name of a picture, from a comment `TextureFile`.
    pub(super) texture: Option<String>,
    pub(super) body: usize,
    pub(super) body_line: u64,
    pub(super) end_of_line: u8,
}

impl Header {
    pub(super) fn read(bytes: &[u8]) -> Result<Self> {
        if !bytes.starts_with(b"ply") {
            let found = show(&bytes[..bytes.len().min(3)]);
            return Err(Error::malformed(Place::Line(1), format!("expected ply, found {found}")));
        }
        let end_of_line = match bytes.get(3..) {
            Some([b'\r', b'\n', ..]) => b'\n',
            Some([b'\r', ..]) => b'\r',
            _ => b'\n',
        };
        let mut encoding = None;
        let mut header =
            Self { encoding: Encoding::Text, elements: Vec::new(), texture: None, body: 0, body_line: 0, end_of_line };
        let mut line = 0;
        while header.body < bytes.len() {
            let rest = &bytes[header.body..];
            let length = rest.iter().position(|&b| b == end_of_line).unwrap_or(rest.len());
            header.body = (header.body + length + 1).min(bytes.len());
            line += 1;
            let text = name(&rest[..length]);
            let words = text.split_ascii_whitespace().collect::<Vec<_>>();
            let error = |why: String| Error::malformed(Place::Line(line), why);
            match words.as_slice() {
                [] | ["ply"] | ["obj_info", ..] => {}
                ["comment", "TextureFile", texture @ ..] => header.texture = Some(texture.join(" ")),
                ["comment", ..] => {}
                ["format", which, ..] => {
                    encoding = Some(match *which {
                        "ascii" => Encoding::Text,
                        "binary_little_endian" => Encoding::Little,
                        "binary_big_endian" => Encoding::Big,
                        other => return Err(error(format!("unknown PLY format {}", show(other.as_bytes())))),
                    });
                }
                ["element", name, records] => {
                    let records = records.parse().map_err(|_| {
                        error(format!("expected the number of records of `{name}`, found {}", show(records.as_bytes())))
                    })?;
                    header.elements.push(Element { name: (*name).to_owned(), records, properties: Vec::new(), line });
                }
                ["property", rest @ ..] => {
                    let element =
                        header.elements.last_mut().ok_or_else(|| error("a property before any element".to_owned()))?;
                    element.properties.push(property(rest).map_err(error)?);
                }
                ["end_header"] => {
                    header.encoding = encoding.ok_or_else(|| error("the header has no `format` line".to_owned()))?;
                    header.body_line = line + 1;
                    return Ok(header);
                }
                other => return Err(error(format!("unexpected header line {}", show(other.join(" ").as_bytes())))),
            }
        }
        Err(Error::malformed(Place::Line(line), "expected end_header, found the end of the file"))
    }
}

fn property(words: &[&str]) -> Result<Property, String> {
    let parse = |word: &str| Type::parse(word).ok_or_else(|| format!("unknown type {}", show(word.as_bytes())));
    match words {
        ["list", count, of, name] => Ok(Property { name: (*name).to_owned(), of: parse(of)?, counted_by: Some(parse(count)?) }),
        [of, name] if *of != "list" => Ok(Property { name: (*name).to_owned(), of: parse(of)?, counted_by: None }),
        _ => Err(format!("expected a property's type and name, found {}", show(words.join(" ").as_bytes()))),
    }
}
