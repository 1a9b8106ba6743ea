//! Which pixels are one vertex: a matrix to what a file says of it, and back.

use crate::cgim::{Contact, VMatrix, align, width};
use crate::codec::mbcim::{index_map, ladder::Ladder};
use crate::entropy::BitReader;
#[cfg(feature = "encode")]
use crate::entropy::BitWriter;
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::plane::{Block, Levels};

/// The words of some blocks as bytes.
#[cfg(feature = "encode")]
pub(super) fn write_words(blocks: &[Levels], regions: u32, budget: &mut Budget) -> Result<Vec<u8>> {
    let mut coder = BitWriter::default();
    let mut ladder = Ladder::new(regions as usize);
    for levels in blocks {
        ladder.code(&mut coder, Some(levels), levels.len() as u32, regions, budget)?;
    }
    Ok(coder.finish())
}

/// What [`write_words`] wrote.
pub(super) fn read_words(stream: &[u8], blocks: &[Block], regions: u32, budget: &mut Budget) -> Result<Vec<Levels>> {
    budget.reserve(Ladder::bytes(regions as usize))?;
    let mut ladder = Ladder::new(regions as usize);
    let mut coder = BitReader::new(stream);
    let levels = blocks.iter().map(|block| ladder.code(&mut coder, None, block.rows, regions, budget));
    let levels = levels.collect::<Result<Vec<_>>>()?;
    if ladder.ids() != regions {
        let why = format!("an index map of {} regions, {regions} expected", ladder.ids());
        return Err(Error::malformed(Place::Whole, why));
    }
    Ok(levels)
}

/// A map pixel by pixel as bytes.
#[cfg(feature = "encode")]
pub(super) fn write_map(matrix: &VMatrix, regions: u32, budget: &mut Budget) -> Result<Vec<u8>> {
    let mut coder = BitWriter::default();
    index_map::code(&mut coder, Some(matrix.entries()), [matrix.rows(), matrix.columns()], regions, budget)?;
    Ok(coder.finish())
}

/// What [`write_map`] wrote.
pub(super) fn read_map(stream: &[u8], [rows, columns]: [usize; 2], regions: u32, budget: &mut Budget) -> Result<VMatrix> {
    let entries = index_map::code(&mut BitReader::new(stream), None, [rows, columns], regions, budget)?;
    Ok(VMatrix::new(columns, entries))
}

/// The words of each block, if they are all that is needed to have the matrix again.
#[cfg(feature = "encode")]
pub(super) fn words_of(matrix: &VMatrix, blocks: &[Block]) -> Option<Vec<Levels>> {
    let mut first = 0;
    let mut all = Vec::new();
    for block in blocks {
        let rows = first..first + block.rows as usize;
        first = rows.end;
        let block = VMatrix::new(matrix.columns(), rows.flat_map(|i| matrix.row(i).iter().copied()).collect());
        all.push(block.levels());
    }
    let again = stacked(&all, matrix.columns())?;
    (again == *matrix).then_some(all)
}

/// The matrix of these words: each block as narrow as can be, and its last column repeated up to `columns`.
/// `None` if one is wider.
pub(super) fn stacked(blocks: &[Levels], columns: usize) -> Option<VMatrix> {
    // Widths first: they may be anything.
    if blocks.iter().any(|levels| width(levels, Contact::Slash) > columns) {
        return None;
    }
    let mut entries = Vec::new();
    for levels in blocks {
        let matrix = align(levels, Contact::Slash);
        for i in 0..matrix.rows() {
            let row = matrix.row(i);
            entries.extend_from_slice(row);
            entries.resize(entries.len() + columns - row.len(), row[row.len() - 1]);
        }
    }
    Some(VMatrix::new(columns, entries))
}
