//! Which vertices of the surface are copies of earlier ones.
//!
//! A copy lies where its original lies, so a vertex whose lattice point was not met before is none, and that costs nothing.

use std::collections::HashMap;

use super::super::topology::Skin;
use super::{Source, error};
use crate::entropy::{AdaptiveBit, BitCoder, Numbers};
use crate::error::Result;
use crate::limits::Budget;

/// Originals at one lattice point that have a rank; beyond, the number of the original is written out.
const RANKS: u32 = 32;

pub(super) const BYTES_A_VERTEX: u64 = 4 + 4 + 4 + 64;
pub(super) const STEPS_A_VERTEX: u64 = 1 + RANKS as u64;

/// The number of the mesh's vertex for every vertex of the skin; appends the positions of those that are new.
pub(super) fn code<C: BitCoder, S: Source>(
    coder: &mut C,
    skin: &Skin,
    positions: &[[i32; 3]],
    are_there: bool,
    source: &mut S,
    met: &mut Vec<[i32; 3]>,
    budget: &mut Budget,
) -> Result<Vec<u32>> {
    let mut number = Vec::with_capacity(positions.len());
    if !are_there {
        for (v, &position) in positions.iter().enumerate() {
            let next = met.len() as u32;
            number.push(source.vertex(v as u32, next));
            met.push(position);
        }
        return Ok(number);
    }
    let on_boundary = skin.boundary_vertices(positions.len());
    // The last original met at each lattice point, and for each original the one met there before.
    let mut last: HashMap<[i32; 3], u32> = HashMap::new();
    let mut before: Vec<u32> = Vec::new();
    let mut is_copy = [AdaptiveBit::default(); 4];
    let mut ranks = Numbers::new(1);
    let mut lately = 0;
    for (v, &position) in positions.iter().enumerate() {
        budget.spend(1)?;
        let next = met.len() as u32;
        let wanted = source.vertex(v as u32, next);
        let newest = last.get(&position).copied();
        if let Some(newest) = newest {
            let context = 2 * usize::from(on_boundary[v]) + lately;
            lately = usize::from(is_copy[context].code(coder, wanted < next));
            if lately == 1 {
                let original = code_original(coder, &mut ranks, newest, wanted, &before, budget)?;
                if original >= next {
                    return Err(error("a copy of a vertex that was not met yet"));
                }
                number.push(original);
                continue;
            }
        }
        number.push(next);
        met.push(position);
        before.push(newest.unwrap_or(u32::MAX));
        last.insert(position, next);
    }
    Ok(number)
}

/// Which of the originals at one lattice point is meant: its rank, the newest first.
fn code_original<C: BitCoder>(
    coder: &mut C,
    ranks: &mut Numbers,
    newest: u32,
    wanted: u32,
    before: &[u32],
    budget: &mut Budget,
) -> Result<u32> {
    let older = |v: u32| before.get(v as usize).copied().unwrap_or(u32::MAX);
    let mut rank = 0;
    if C::WRITES {
        let mut at = newest;
        while rank < RANKS && at != wanted {
            at = older(at);
            rank += 1;
        }
    }
    if older(newest) == u32::MAX {
        return Ok(newest);
    }
    rank = ranks.code(coder, rank, 0);
    if rank >= RANKS {
        let bits = 32 - (before.len() as u32).leading_zeros();
        return Ok(coder.raw(wanted, bits));
    }
    budget.spend(rank.into())?;
    let original = (0..rank).fold(newest, |at, _| older(at));
    if original == u32::MAX { Err(error("a copy of a vertex that is not there")) } else { Ok(original) }
}
