//! Chunk `MBCI`: an image as index map and base colours (spec/format.md).

use super::side;
use super::stage::read_stages;
#[cfg(feature = "encode")]
use super::stage::write_stages;
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

    #[cfg(feature = "encode")]
    pub(crate) fn write(&self) -> Vec<u8> {
        let mut w = Writer::default();
        side::write(&mut w, &self.side, &[]);
        w.varint(self.regions.into());
        write_stages(&mut w, &self.stages);
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
        let stages = read_stages(&mut r)?;
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
