//! Chunk `MBCI`: an image as index map and base colours, and `STGE`: what refines them (spec/format.md).

use super::side;
use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;
use crate::limits::Budget;
use crate::plane::SideInformation;

/// What the codec mbcim needs beside the header.
#[derive(Debug, Clone)]
pub(crate) struct MbcimChunk<'a> {
    pub(crate) side: SideInformation,
    /// The bytes that the side information takes.
    pub(crate) side_size: usize,
    /// Ids of the index map.
    pub(crate) regions: u32,
    /// Rows and columns, if the map is there pixel by pixel and not as words.
    pub(crate) raster: Option<[u32; 2]>,
    /// Bits that each stage adds to the base colours.
    pub(crate) stages: Vec<u8>,
    pub(crate) map: &'a [u8],
    pub(crate) colours: &'a [u8],
}

impl<'a> MbcimChunk<'a> {
    pub(crate) const TAG: [u8; 4] = *b"MBCI";
    /// One stage, in order; a file that ends before one decodes to what is there.
    pub(crate) const STAGE: [u8; 4] = *b"stge";

    #[cfg(feature = "encode")]
    pub(crate) fn write(&self) -> Vec<u8> {
        let mut w = Writer::default();
        side::write(&mut w, &self.side, &[]);
        w.varint(self.regions.into());
        w.u8(self.stages.len() as u8);
        w.bytes(&self.stages);
        w.u8(u8::from(self.raster.is_some()));
        self.raster.iter().flatten().for_each(|&n| w.varint(n.into()));
        w.varint(self.map.len() as u64);
        w.bytes(self.map);
        w.bytes(self.colours);
        w.into_bytes()
    }

    pub(crate) fn read(mut r: Reader<'a>, budget: &mut Budget) -> Result<Self> {
        let before = r.clone().rest().len();
        let (side, walls) = side::read(&mut r, budget)?;
        if !walls.is_empty() {
            return Err(r.error("walls beside an index map"));
        }
        let side_size = before - r.clone().rest().len();
        let regions = number(&mut r, "the regions")?;
        let count = r.u8("the stages")?;
        let stages = r.take(count.into(), "the bits of the stages")?.to_vec();
        let bits: u32 = stages.iter().map(|&b| u32::from(b)).sum();
        if bits > super::MAX_BITS || stages.contains(&0) {
            return Err(r.error(format!("stages of {stages:?} bits, 1 to {} together expected", super::MAX_BITS)));
        }
        let raster = match r.u8("the form of the index map")? {
            0 => None,
            1 => Some([number(&mut r, "the rows")?, number(&mut r, "the columns")?]),
            other => return Err(r.error(format!("an index map of form 0 or 1, found {other}"))),
        };
        let length = r.varint("the length of the index map")?;
        let map = r.take(usize::try_from(length).unwrap_or(usize::MAX), "the index map")?;
        Ok(Self { side, side_size, regions, raster, stages, map, colours: r.rest() })
    }
}

fn number(r: &mut Reader<'_>, what: &str) -> Result<u32> {
    let n = r.varint(what)?;
    u32::try_from(n).map_err(|_| r.error(format!("{what} do not fit 32 bits: {n}")))
}
