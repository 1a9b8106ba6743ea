//! Chunk `PLNS`: an image of vertices as planes of samples (spec/format.md, "PLNS").

use super::{counts, side};
use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;
use crate::limits::Budget;
use crate::plane::{RunCounts, SideInformation};

/// What an image of samples needs beside the header.
#[derive(Debug, Clone)]
pub(crate) struct PlanesChunk<'a> {
    pub(crate) columns: u32,
    pub(crate) rows: u32,
    /// Bits of a sample in the three planes of positions.
    pub(crate) depth: u8,
    /// Bits of a sample in the two planes of normals; 0 if there are none.
    pub(crate) normal_depth: u8,
    pub(crate) borders: Borders<'a>,
    pub(crate) side: SideInformation,
    /// The bytes that all but the samples takes.
    pub(crate) side_size: usize,
    /// Between which neighbours there is a border that the colours do not show.
    pub(crate) walls: Vec<u64>,
    /// The planes, as their codec has them.
    pub(crate) samples: &'a [u8],
}

/// How the pixels of one vertex are told from those of another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Borders<'a> {
    /// By their colours, which are exact.
    Colours,
    /// By an index map: the words of its rows.
    Words { regions: u32, stream: &'a [u8] },
    /// By an index map, pixel by pixel.
    Map { regions: u32, stream: &'a [u8] },
    /// By the cluster phase, from run counts.
    Counts {
        counts: RunCounts,
        /// Whether that finds every vertex of the original.
        exact: bool,
    },
}

impl<'a> PlanesChunk<'a> {
    pub(crate) const TAG: [u8; 4] = *b"PLNS";

    #[cfg(feature = "encode")]
    pub(crate) fn write(&self) -> Vec<u8> {
        let mut w = Writer::default();
        w.varint(self.columns.into());
        w.varint(self.rows.into());
        w.u8(self.depth);
        w.u8(self.normal_depth);
        side::write(&mut w, &self.side, &self.walls);
        match &self.borders {
            Borders::Colours => w.u8(0),
            Borders::Words { regions, stream } | Borders::Map { regions, stream } => {
                w.u8(if matches!(self.borders, Borders::Words { .. }) { 1 } else { 2 });
                w.varint((*regions).into());
                w.varint(stream.len() as u64);
                w.bytes(stream);
            }
            Borders::Counts { counts, exact } => {
                w.u8(if *exact { 3 } else { 4 });
                let stream = counts::write(counts, self.columns);
                w.varint(stream.len() as u64);
                w.bytes(&stream);
            }
        }
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
        let normal_depth = r.u8("the depth of normals")?;
        let (side, walls) = side::read(&mut r, budget)?;
        let blocks = side.blocks.iter().map(|block| u64::from(block.rows)).sum::<u64>();
        if blocks != u64::from(rows) {
            return Err(r.error(format!("blocks of {blocks} rows together in an image of {rows} rows")));
        }
        let form = r.u8("how vertices are told apart")?;
        let regions = if matches!(form, 1 | 2) { r.varint("the regions")? } else { 0 };
        let Ok(regions) = u32::try_from(regions) else {
            return Err(r.error(format!("{regions} regions do not fit 32 bits")));
        };
        let mut stream = &[][..];
        if form > 0 {
            let length = r.varint("the length of the borders")?;
            stream = r.take(usize::try_from(length).unwrap_or(usize::MAX), "the borders")?;
        }
        let borders = match form {
            0 => Borders::Colours,
            1 => Borders::Words { regions, stream },
            2 => Borders::Map { regions, stream },
            3 | 4 => {
                let counts = counts::read(stream, [rows, columns], side.blocks.len(), budget)?;
                Borders::Counts { counts, exact: form == 3 }
            }
            other => return Err(r.error(format!("borders of form 0 to 4, found {other}"))),
        };
        if !walls.is_empty() && matches!(borders, Borders::Words { .. } | Borders::Map { .. }) {
            return Err(r.error("walls beside an index map"));
        }
        let samples = r.rest();
        let side_size = before - samples.len();
        Ok(Self { columns, rows, depth, normal_depth, borders, side, side_size, walls, samples })
    }
}
