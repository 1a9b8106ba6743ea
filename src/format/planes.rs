//! Chunk `PLNS`: an image of vertices as planes of samples (spec/format.md, "PLNS").

use super::side;
use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;
use crate::limits::Budget;
use crate::plane::SideInformation;

/// What an image of samples needs beside the header.
#[derive(Debug, Clone)]
pub(crate) struct PlanesChunk<'a> {
    pub(crate) columns: u32,
    pub(crate) rows: u32,
    /// Bits of a sample, in all three planes.
    pub(crate) depth: u8,
    pub(crate) side: SideInformation,
    /// The bytes that shape, side information and walls take.
    pub(crate) side_size: usize,
    /// Between which neighbours there is a border that the colours do not show.
    pub(crate) walls: Vec<u64>,
    /// The planes, as their codec has them.
    pub(crate) samples: &'a [u8],
}

impl<'a> PlanesChunk<'a> {
    pub(crate) const TAG: [u8; 4] = *b"PLNS";

    #[cfg(feature = "encode")]
    pub(crate) fn write(&self) -> Vec<u8> {
        let mut w = Writer::default();
        w.varint(self.columns.into());
        w.varint(self.rows.into());
        w.u8(self.depth);
        side::write(&mut w, &self.side, &self.walls);
        w.bytes(self.samples);
        w.into_bytes()
    }

    pub(crate) fn read(mut r: Reader<'a>, budget: &mut Budget) -> Result<Self> {
        let before = r.clone().rest().len();
        let mut length = |what| {
            let n = r.varint(what)?;
            u32::try_from(n).map_err(|_| r.error(format!("{what} do not fit 32 bits: {n}")))
        };
        let (columns, rows) = (length("the columns")?, length("the rows")?);
        let depth = r.u8("the depth")?;
        let (side, walls) = side::read(&mut r, budget)?;
        let samples = r.rest();
        Ok(Self { columns, rows, depth, side, side_size: before - samples.len(), walls, samples })
    }
}
