//! Stages: which bits of the coordinates come first, and chunk `stge`: one of the later ones (spec/format.md, "Stages").

use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;

/// The tag of a stage after the first; a file that ends before one decodes to what is there.
pub(crate) const STAGE: [u8; 4] = *b"stge";

/// Writes the bits that each stage after the first adds.
#[cfg(feature = "encode")]
pub(crate) fn write_stages(w: &mut Writer, stages: &[u8]) {
    w.u8(stages.len() as u8);
    w.bytes(stages);
}

/// Reads what [`write_stages`] wrote.
pub(crate) fn read_stages(r: &mut Reader<'_>) -> Result<Vec<u8>> {
    let count = r.u8("the stages")?;
    let stages = r.take(count.into(), "the bits of the stages")?.to_vec();
    let bits: u32 = stages.iter().map(|&b| u32::from(b)).sum();
    if bits > super::MAX_BITS || stages.contains(&0) {
        return Err(r.error(format!("stages of {stages:?} bits, 1 to {} together expected", super::MAX_BITS)));
    }
    Ok(stages)
}
