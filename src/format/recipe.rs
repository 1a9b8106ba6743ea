//! Chunk `rcpe`: from what the image of a mesh can be made again (spec/format.md, "rcpe").

use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;

/// The size of the image, and eight bytes for each connected piece.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RecipeChunk {
    pub(crate) rows: u32,
    pub(crate) columns: u32,
    pub(crate) recipes: Vec<u64>,
}

impl RecipeChunk {
    pub(crate) const TAG: [u8; 4] = *b"rcpe";

    #[cfg(feature = "encode")]
    pub(crate) fn write(&self) -> Vec<u8> {
        let mut w = Writer::default();
        w.varint(self.rows.into());
        w.varint(self.columns.into());
        for recipe in &self.recipes {
            w.bytes(&recipe.to_le_bytes());
        }
        w.into_bytes()
    }

    pub(crate) fn read(mut r: Reader<'_>) -> Result<Self> {
        let mut side = |what| {
            let n = r.varint(what)?;
            u32::try_from(n).map_err(|_| r.error(format!("{what} do not fit 32 bits: {n}")))
        };
        let (rows, columns) = (side("the rows")?, side("the columns")?);
        let bytes = r.rest();
        if !bytes.len().is_multiple_of(8) {
            return Err(r.error(format!("recipes of {} bytes, 8 each expected", bytes.len())));
        }
        let (recipes, _) = bytes.as_chunks::<8>();
        let recipes = recipes.iter().map(|&bytes| u64::from_le_bytes(bytes)).collect();
        Ok(Self { rows, columns, recipes })
    }
}
