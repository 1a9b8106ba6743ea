//! Writes the fields that [`Reader`](super::Reader) reads.

use byteorder::{LittleEndian, WriteBytesExt};

/// A growing list of bytes.
#[derive(Debug, Default, Clone)]
pub(crate) struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    pub(crate) fn u8(&mut self, value: u8) {
        self.bytes.push(value);
    }

    pub(crate) fn f32(&mut self, value: f32) {
        self.bytes.write_f32::<LittleEndian>(value).ok();
    }

    pub(crate) fn f64(&mut self, value: f64) {
        self.bytes.write_f64::<LittleEndian>(value).ok();
    }

    /// Seven bits a byte, lowest first; see [`Reader::varint`](super::Reader::varint).
    pub(crate) fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.bytes.push(value as u8);
    }

    pub(crate) fn signed(&mut self, value: i64) {
        self.varint((value << 1 ^ value >> 63) as u64);
    }

    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}
