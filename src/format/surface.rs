//! Chunk `SURF`: the streams of the surface codec (spec/format.md, "SURF").

use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;

/// What the surface codec needs beside the header.
#[derive(Debug, Clone)]
pub(crate) struct SurfaceChunk<'a> {
    /// How the streams are coded: 0 fast, 1 default, 2 best.
    pub(crate) effort: u8,
    pub(crate) holes: u32,
    pub(crate) components: u32,
    pub(crate) handles: u32,
    pub(crate) connectivity: &'a [u8],
    /// What follows the connectivity: the position streams, one after the other.
    positions: Reader<'a>,
}

impl<'a> SurfaceChunk<'a> {
    pub(crate) const TAG: [u8; 4] = *b"SURF";

    #[cfg(feature = "encode")]
    pub(crate) fn write(
        effort: u8,
        [holes, components, handles]: [u32; 3],
        connectivity: &[u8],
        positions: &[Vec<u8>],
    ) -> Vec<u8> {
        let mut w = Writer::default();
        w.u8(effort);
        w.varint(holes.into());
        w.varint(components.into());
        w.varint(handles.into());
        w.varint(connectivity.len() as u64);
        w.bytes(connectivity);
        if let Some((last, others)) = positions.split_last() {
            for stream in others {
                w.varint(stream.len() as u64);
                w.bytes(stream);
            }
            w.bytes(last);
        }
        w.into_bytes()
    }

    pub(crate) fn read(mut r: Reader<'a>) -> Result<Self> {
        let effort = r.u8("the effort")?;
        let mut count = |what| {
            let n = r.varint(what)?;
            u32::try_from(n).map_err(|_| r.error(format!("{what} do not fit 32 bits: {n}")))
        };
        let (holes, components, handles) = (count("the holes")?, count("the components")?, count("the handles")?);
        let length = r.varint("the length of the connectivity")?;
        let connectivity = r.take(usize::try_from(length).unwrap_or(usize::MAX), "the connectivity")?;
        Ok(Self { effort, holes, components, handles, connectivity, positions: r })
    }

    /// The bytes of the position streams, with their lengths.
    pub(crate) fn positions_size(&self) -> u64 {
        self.positions.clone().rest().len() as u64
    }

    /// The position streams; the last takes all that is left.
    pub(crate) fn positions(&self, count: usize) -> Result<Vec<&'a [u8]>> {
        let mut r = self.positions.clone();
        let mut streams = Vec::new();
        for _ in 1..count {
            let length = r.varint("the length of a position stream")?;
            streams.push(r.take(usize::try_from(length).unwrap_or(usize::MAX), "a position stream")?);
        }
        streams.push(r.rest());
        Ok(streams)
    }
}
