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
    pub(crate) fn write(side: &SideInformation, regions: u32, stages: &[u8], map: &[u8], colours: &[u8]) -> Vec<u8> {
        let mut w = Writer::default();
        side::write(&mut w, side, &[]);
        w.varint(regions.into());
        w.u8(stages.len() as u8);
        w.bytes(stages);
        w.varint(map.len() as u64);
        w.bytes(map);
        w.bytes(colours);
        w.into_bytes()
    }

    pub(crate) fn read(mut r: Reader<'a>, budget: &mut Budget) -> Result<Self> {
        let before = r.clone().rest().len();
        let (side, _) = side::read(&mut r, budget)?;
        let side_size = before - r.clone().rest().len();
        let regions = r.varint("the regions")?;
        let Ok(regions) = u32::try_from(regions) else {
            return Err(r.error(format!("{regions} regions do not fit 32 bits")));
        };
        let count = r.u8("the stages")?;
        let stages = r.take(count.into(), "the bits of the stages")?.to_vec();
        let bits: u32 = stages.iter().map(|&b| u32::from(b)).sum();
        if bits > super::MAX_BITS || stages.contains(&0) {
            return Err(r.error(format!("stages of {stages:?} bits, 1 to {} together expected", super::MAX_BITS)));
        }
        let length = r.varint("the length of the index map")?;
        let map = r.take(usize::try_from(length).unwrap_or(usize::MAX), "the index map")?;
        Ok(Self { side, side_size, regions, stages, map, colours: r.rest() })
    }
}
