//! Reads fields from a slice and says, in every error, where it stood and what it looked for.

use byteorder::{ByteOrder, LittleEndian};

use crate::error::{Error, Place, Result};

/// A cursor over the bytes of one chunk.
#[derive(Debug, Clone)]
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    position: usize,
    chunk: [u8; 4],
}

impl<'a> Reader<'a> {
    /// Starts at the first byte; `chunk` is named in errors.
    pub(crate) fn new(bytes: &'a [u8], chunk: [u8; 4]) -> Self {
        Self { bytes, position: 0, chunk }
    }

    /// An error at the place where the reader stands.
    pub(crate) fn error(&self, why: impl Into<String>) -> Error {
        Error::malformed(Place::Chunk(self.chunk, self.position as u64), why)
    }

    /// The next `n` bytes; `what` names the field in errors.
    pub(crate) fn take(&mut self, n: usize, what: &str) -> Result<&'a [u8]> {
        let left = &self.bytes[self.position..];
        if left.len() < n {
            return Err(self.error(format!("{what} needs {n} bytes, {} left", left.len())));
        }
        self.position += n;
        Ok(&left[..n])
    }

    /// All bytes that are left.
    pub(crate) fn rest(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.position..];
        self.position = self.bytes.len();
        rest
    }

    pub(crate) fn u8(&mut self, what: &str) -> Result<u8> {
        Ok(self.take(1, what)?[0])
    }

    pub(crate) fn f32(&mut self, what: &str) -> Result<f32> {
        Ok(LittleEndian::read_f32(self.take(4, what)?))
    }

    pub(crate) fn f64(&mut self, what: &str) -> Result<f64> {
        Ok(LittleEndian::read_f64(self.take(8, what)?))
    }

    /// An unsigned integer in groups of seven bits, lowest first, the high bit set on all but the last.
    /// Only the shortest form is legal.
    pub(crate) fn varint(&mut self, what: &str) -> Result<u64> {
        let mut value = 0_u64;
        for shift in (0..64).step_by(7) {
            let byte = self.u8(what)?;
            let group = u64::from(byte & 0x7f);
            if shift == 63 && group > 1 {
                break;
            }
            value |= group << shift;
            if byte < 0x80 {
                if byte == 0 && shift > 0 {
                    return Err(self.error(format!("{what} is written with more bytes than it needs")));
                }
                return Ok(value);
            }
        }
        Err(self.error(format!("{what} does not fit 64 bits")))
    }

    /// A signed integer: 0, −1, 1, −2, … as the varints 0, 1, 2, 3, …
    pub(crate) fn signed(&mut self, what: &str) -> Result<i64> {
        let zigzag = self.varint(what)?;
        Ok((zigzag >> 1) as i64 ^ -((zigzag & 1) as i64))
    }

    /// Refuses bytes after the last field.
    pub(crate) fn finish(&self) -> Result<()> {
        match self.bytes.len() - self.position {
            0 => Ok(()),
            left => Err(self.error(format!("{left} bytes after the last field"))),
        }
    }
}
