//! The numbers of the tables one by one, from text or from binary of either byte order.

use std::marker::PhantomData;

use byteorder::ByteOrder;

use super::header::Type;
use crate::error::{Error, Place, Result};
use crate::mesh::Scalar;
use crate::mesh::io::text::Text;

/// A place in the tables.
pub(super) trait Cells {
    /// Goes to the start of a record; false at the end of the file.
    fn begin(&mut self) -> bool;
    /// The next number, in the value that its type gives it.
    fn real(&mut self, of: Type) -> Result<f64>;
    /// The next number, which must be an integer.
    fn integer(&mut self, of: Type) -> Result<i64>;
    /// Passes `n` numbers.
    fn skip(&mut self, of: Type, n: u64) -> Result<()>;
    /// The record ends.
    fn end(&mut self) -> Result<()>;
    /// Bytes that are left.
    fn left(&self) -> u64;
    /// An error about the number read last.
    fn error(&self, why: String) -> Error;
}

/// Numbers of a binary table.
pub(super) struct Binary<'a, E> {
    bytes: &'a [u8],
    at: usize,
    /// Where the number read last began.
    last: usize,
    order: PhantomData<E>,
}

impl<'a, E: ByteOrder> Binary<'a, E> {
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at, last: at, order: PhantomData }
    }

    #[inline]
    fn take(&mut self, n: usize) -> Result<&'a [u8]> {
        self.last = self.at;
        match self.bytes[self.at..].get(..n) {
            Some(bytes) => {
                self.at += n;
                Ok(bytes)
            }
            None => Err(self.end_of_file(n as u64)),
        }
    }

    #[cold]
    fn end_of_file(&self, wanted: u64) -> Error {
        let left = self.bytes.len() - self.at;
        Error::malformed(Place::Byte(self.at as u64), format!("{wanted} bytes of a record are expected, and {left} follow"))
    }
}

impl<E: ByteOrder> Cells for Binary<'_, E> {
    fn begin(&mut self) -> bool {
        true
    }

    #[inline]
    fn real(&mut self, of: Type) -> Result<f64> {
        let bytes = self.take(of.size())?;
        Ok(match of {
            Type::Scalar(Scalar::I8) => f64::from(bytes[0] as i8),
            Type::Scalar(Scalar::U8) => f64::from(bytes[0]),
            Type::Scalar(Scalar::I16) => f64::from(E::read_i16(bytes)),
            Type::Scalar(Scalar::U16) => f64::from(E::read_u16(bytes)),
            Type::Scalar(Scalar::I32) => f64::from(E::read_i32(bytes)),
            Type::Scalar(Scalar::U32) => f64::from(E::read_u32(bytes)),
            Type::Scalar(Scalar::F32) => f64::from(E::read_f32(bytes)),
            Type::Scalar(Scalar::F64) => E::read_f64(bytes),
            Type::Long { signed: true } => E::read_i64(bytes) as f64,
            Type::Long { signed: false } => E::read_u64(bytes) as f64,
        })
    }

    #[inline]
    fn integer(&mut self, of: Type) -> Result<i64> {
        match of {
            Type::Scalar(Scalar::U8) => Ok(self.take(1)?[0].into()),
            Type::Scalar(Scalar::I32) => Ok(E::read_i32(self.take(4)?).into()),
            Type::Scalar(Scalar::U32) => Ok(E::read_u32(self.take(4)?).into()),
            Type::Long { signed: true } => Ok(E::read_i64(self.take(8)?)),
            Type::Long { signed: false } => Ok(E::read_u64(self.take(8)?).try_into().unwrap_or(i64::MAX)),
            other => {
                let x = self.real(other)?;
                whole(x).ok_or_else(|| self.error(format!("expected an integer, found {x}")))
            }
        }
    }

    fn skip(&mut self, of: Type, n: u64) -> Result<()> {
        let bytes = n.saturating_mul(of.size() as u64);
        if bytes > self.left() {
            return Err(self.end_of_file(bytes));
        }
        self.at += bytes as usize;
        Ok(())
    }

    fn end(&mut self) -> Result<()> {
        Ok(())
    }

    fn left(&self) -> u64 {
        (self.bytes.len() - self.at) as u64
    }

    fn error(&self, why: String) -> Error {
        Error::malformed(Place::Byte(self.last as u64), why)
    }
}

/// Numbers of a text table: each record on a line of its own.
pub(super) struct Lines<'a> {
    text: Text<'a>,
}

impl<'a> Lines<'a> {
    pub(super) fn new(text: Text<'a>) -> Self {
        Self { text }
    }

    #[cold]
    fn short(&self) -> Error {
        self.text.error("the line ends before its record does")
    }
}

impl Cells for Lines<'_> {
    fn begin(&mut self) -> bool {
        self.text.find_word()
    }

    #[inline]
    fn real(&mut self, of: Type) -> Result<f64> {
        let number = self.text.number()?.ok_or_else(|| self.short())?;
        match of {
            Type::Scalar(scalar) => number
                .typed(scalar)
                .ok_or_else(|| self.text.error(format!("{} is no value of type {}", number.value, Type::name(scalar)))),
            Type::Long { .. } => Ok(number.value),
        }
    }

    #[inline]
    fn integer(&mut self, _: Type) -> Result<i64> {
        let number = self.text.number()?.ok_or_else(|| self.short())?;
        whole(number.value).ok_or_else(|| self.text.error(format!("expected an integer, found {}", number.value)))
    }

    fn skip(&mut self, _: Type, n: u64) -> Result<()> {
        for _ in 0..n {
            self.text.word().ok_or_else(|| self.short())?;
        }
        Ok(())
    }

    fn end(&mut self) -> Result<()> {
        match self.text.count_words() {
            0 => Ok(()),
            more => Err(self.text.error(format!("the line goes on after its record, for {more} more values"))),
        }
    }

    fn left(&self) -> u64 {
        self.text.left() as u64
    }

    fn error(&self, why: String) -> Error {
        self.text.error(why)
    }
}

/// `x` as an integer if it is one.
fn whole(x: f64) -> Option<i64> {
    const MOST: f64 = 9_007_199_254_740_992.0;
    (x.fract() == 0.0 && x.abs() <= MOST).then_some(x as i64)
}
