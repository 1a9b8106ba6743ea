//! Chunk `LABL`: names on stretches of faces (spec/any-mesh.md, "LABL"). Absent where there are none.

use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;

/// Counts, and the stream.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LabelsChunk<'a> {
    /// Labels.
    pub(crate) count: u32,
    /// Bytes of all their names.
    pub(crate) text: u32,
    pub(crate) stream: &'a [u8],
}

impl<'a> LabelsChunk<'a> {
    pub(crate) const TAG: [u8; 4] = *b"LABL";

    #[cfg(feature = "encode")]
    pub(crate) fn write(&self) -> Vec<u8> {
        let mut w = Writer::default();
        w.varint(self.count.into());
        w.varint(self.text.into());
        w.bytes(self.stream);
        w.into_bytes()
    }

    pub(crate) fn read(mut r: Reader<'a>) -> Result<Self> {
        let counts = [r.varint("the labels")?, r.varint("the bytes of their names")?].map(u32::try_from);
        let [Ok(count), Ok(text)] = counts else {
            return Err(r.error("counts that do not fit 32 bits"));
        };
        Ok(Self { count, text, stream: r.rest() })
    }
}
