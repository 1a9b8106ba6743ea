//! Where writers put text and bytes: a buffer in front of any `Write`.

use std::io::Write;

use super::text::{Syntax, Text};
use crate::error::Result;
use crate::mesh::Scalar;

/// Bytes on their way out.
pub(super) struct Sink<'a> {
    out: &'a mut dyn Write,
    buffer: Vec<u8>,
}

/// The buffer is passed on when it is about this long.
const FULL: usize = 1 << 16;

impl<'a> Sink<'a> {
    pub(super) fn new(out: &'a mut dyn Write) -> Self {
        Self { out, buffer: Vec::with_capacity(FULL + FULL / 4) }
    }

    pub(super) fn bytes(&mut self, bytes: &[u8]) {
        self.buffer.extend_from_slice(bytes);
    }

    pub(super) fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }

    pub(super) fn integer(&mut self, n: u64) {
        if n < 10 {
            self.buffer.push(b'0' + n as u8);
        } else {
            // Writing to a vector cannot fail.
            let _ = write!(self.buffer, "{n}");
        }
    }

    /// `x` as the shortest decimal that gives it back in its type.
    pub(super) fn number(&mut self, x: f64, scalar: Scalar) {
        let start = self.buffer.len();
        let _ = match scalar {
            Scalar::F64 => write!(self.buffer, "{x:?}"),
            Scalar::F32 => write!(self.buffer, "{:?}", x as f32),
            integer => write!(self.buffer, "{}", integer.nearest(x) as i64),
        };
        if self.buffer[start..].ends_with(b".0") {
            self.buffer.truncate(self.buffer.len() - 2);
        }
    }

    /// Value `i` of a list, as text; see [`Print`].
    pub(super) fn value(&mut self, values: &[f64], i: usize, print: Print) {
        let start = self.buffer.len();
        self.number(values[i], print.scalar);
        if print.first_wide == Some(i) {
            let looks_single =
                Text::new(&self.buffer[start..], Syntax::Plain).number().ok().flatten().is_some_and(|n| n.is_single);
            if looks_single {
                self.buffer.truncate(start);
                let _ = write!(self.buffer, "{:.9e}", values[i]);
            }
        }
    }

    /// `x` in the bytes of its type, the least first.
    pub(super) fn binary(&mut self, x: f64, scalar: Scalar) {
        let x = scalar.nearest(x);
        match scalar {
            Scalar::I8 => self.bytes(&(x as i8).to_le_bytes()),
            Scalar::U8 => self.bytes(&(x as u8).to_le_bytes()),
            Scalar::I16 => self.bytes(&(x as i16).to_le_bytes()),
            Scalar::U16 => self.bytes(&(x as u16).to_le_bytes()),
            Scalar::I32 => self.bytes(&(x as i32).to_le_bytes()),
            Scalar::U32 => self.bytes(&(x as u32).to_le_bytes()),
            Scalar::F32 => self.bytes(&(x as f32).to_le_bytes()),
            Scalar::F64 => self.bytes(&x.to_le_bytes()),
        }
    }

    /// The end of a line or a record: a good moment to pass bytes on.
    pub(super) fn rest(&mut self) -> Result<()> {
        if self.buffer.len() >= FULL {
            self.out.write_all(&self.buffer)?;
            self.buffer.clear();
        }
        Ok(())
    }

    pub(super) fn finish(self) -> Result<()> {
        self.out.write_all(&self.buffer)?;
        self.out.flush()?;
        Ok(())
    }
}

/// How the numbers of one kind are printed so that a reader can tell their type.
#[derive(Debug, Clone, Copy)]
pub(super) struct Print {
    scalar: Scalar,
    /// The number that is printed with ten digits at least: the first that is no `f32`.
    first_wide: Option<usize>,
}

impl Print {
    pub(super) fn new(values: &[f64], scalar: Scalar) -> Self {
        let is_wide = |&x: &f64| f64::from(x as f32) != x && !x.is_nan();
        Self { scalar, first_wide: if scalar == Scalar::F64 { values.iter().position(is_wide) } else { None } }
    }
}
