//! The side information of an image: numbers through the arithmetic coder (spec/format.md, "Side information").
//!
//! Each kind of number has a context of its own. Seams are mostly told by what is left: the next one begins
//! at the first boundary edge that no seam before it has glued, so that its start costs next to nothing.

use std::collections::BTreeMap;

use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
#[cfg(feature = "encode")]
use crate::entropy::BitWriter;
use crate::entropy::{BitCoder, BitReader, Numbers};
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::plane::{Block, Seam, SideInformation};

/// The contexts.
mod kind {
    pub(super) const COUNT: usize = 0;
    pub(super) const ROWS: usize = 1;
    pub(super) const MIRRORED: usize = 2;
    pub(super) const SEAM_START: usize = 3;
    pub(super) const SEAM_LENGTH: usize = 4;
    pub(super) const SEAM_DISTANCE: usize = 5;
    pub(super) const DUMMY: usize = 6;
    pub(super) const EXTRA: usize = 7;
    pub(super) const MISSING: usize = 8;
    pub(super) const WALL: usize = 9;
    /// The upper halves of numbers of 64 bits.
    pub(super) const HIGH: usize = 10;
    pub(super) const ALL: usize = 11;
}

/// Side information and walls, with their length before them.
#[cfg(feature = "encode")]
pub(super) fn write(w: &mut Writer, side: &SideInformation, walls: &[u64]) {
    let mut coder = BitWriter::default();
    // A writer's budget is never used up, and what it writes is never refused.
    let mut budget = Budget::new(crate::Limits::default().memory(u64::MAX).work(u64::MAX));
    let done = Side { coder: &mut coder, numbers: Numbers::new(kind::ALL), budget: &mut budget }.code(Some((side, walls)));
    debug_assert!(done.is_ok_and(|(s, w)| s == *side && w == walls));
    let bytes = coder.finish();
    w.varint(bytes.len() as u64);
    w.bytes(&bytes);
}

pub(super) fn read(r: &mut Reader<'_>, budget: &mut Budget) -> Result<(SideInformation, Vec<u64>)> {
    let length = r.varint("the length of the side information")?;
    let bytes = r.take(usize::try_from(length).unwrap_or(usize::MAX), "the side information")?;
    let mut coder = BitReader::new(bytes);
    Side { coder: &mut coder, numbers: Numbers::new(kind::ALL), budget }.code(None)
}

struct Side<'a, C: BitCoder> {
    coder: &'a mut C,
    numbers: Numbers,
    budget: &'a mut Budget,
}

impl<C: BitCoder> Side<'_, C> {
    fn number(&mut self, value: u32, kind: usize) -> Result<u32> {
        self.budget.spend(8)?;
        if self.coder.is_exhausted() {
            return Err(malformed("the side information ends too soon"));
        }
        Ok(self.numbers.code(self.coder, value, kind))
    }

    fn wide(&mut self, value: u64, kind: usize) -> Result<u64> {
        let low = self.number(value as u32 & (u32::MAX >> 1), kind)? & (u32::MAX >> 1);
        Ok(u64::from(self.number((value >> 31) as u32, kind::HIGH)?) << 31 | u64::from(low))
    }

    fn code(&mut self, known: Option<(&SideInformation, &[u64])>) -> Result<(SideInformation, Vec<u64>)> {
        let side = known.map(|k| k.0);
        let blocks = self.list(side.map(|s| &s.blocks[..]), |this, block: Option<&Block>, _| {
            let rows = this.number(block.map_or(0, |b| b.rows.saturating_sub(1)), kind::ROWS)?;
            let mirrored = this.number(block.map_or(0, |b| u32::from(b.mirrored)), kind::MIRRORED)?;
            match (rows.checked_add(1), mirrored) {
                (Some(rows), 0 | 1) => Ok(Block { rows, mirrored: mirrored == 1 }),
                _ => Err(malformed("a block of too many rows")),
            }
        })?;
        let mut free = Free::default();
        let seams = self.list(side.map(|s| &s.seams[..]), |this, seam: Option<&Seam>, _| this.seam(seam, &mut free))?;
        let dummies = self.ascending(side.map(|s| s.dummies.iter().map(|&d| d.into()).collect()), kind::DUMMY)?;
        let dummies = dummies.into_iter().map(|d| u32::try_from(d).map_err(|_| malformed("a dummy beyond all regions")));
        let dummies = dummies.collect::<Result<_>>()?;
        let extra = self.ascending(side.map(|s| s.extra.clone()), kind::EXTRA)?;
        let missing = self.list(side.map(|s| &s.missing[..]), |this, triangle: Option<&[u32; 3]>, _| {
            let mut corner = |i: usize| this.number(triangle.map_or(0, |t| t[i]), kind::MISSING);
            Ok([corner(0)?, corner(1)?, corner(2)?])
        })?;
        let walls = self.ascending(known.map(|k| k.1.to_vec()), kind::WALL)?;
        Ok((SideInformation { blocks, seams, dummies, extra, missing }, walls))
    }

    /// A count, then the items; each may look at those before it.
    fn list<T>(
        &mut self,
        known: Option<&[T]>,
        mut item: impl FnMut(&mut Self, Option<&T>, &[T]) -> Result<T>,
    ) -> Result<Vec<T>> {
        let count = self.number(known.map_or(0, |k| k.len() as u32), kind::COUNT)?;
        let mut items = Vec::new();
        for i in 0..count as usize {
            self.budget.reserve(2 * size_of::<T>() as u64)?;
            let next = item(self, known.and_then(|k| k.get(i)), &items)?;
            items.push(next);
        }
        Ok(items)
    }

    /// The steps between neighbours, less one.
    fn ascending(&mut self, known: Option<Vec<u64>>, kind: usize) -> Result<Vec<u64>> {
        self.list(known.as_deref(), |this, number: Option<&u64>, before| {
            let next = before.last().map_or(0, |n| n + 1);
            let step = this.wide(number.map_or(0, |n| n.wrapping_sub(next)), kind)?;
            next.checked_add(step).filter(|&n| n < 1 << 62).ok_or_else(|| malformed("a place beyond all pixels"))
        })
    }

    fn seam(&mut self, seam: Option<&Seam>, free: &mut Free) -> Result<Seam> {
        let beyond = || malformed("a seam beyond all edges");
        let skip = self.number(seam.map_or(0, |s| s.first.wrapping_sub(free.next)), kind::SEAM_START)?;
        let first = free.next.checked_add(skip).ok_or_else(beyond)?;
        let length = self.number(seam.map_or(0, |s| s.length.wrapping_sub(1)), kind::SEAM_LENGTH)?;
        let length = length.checked_add(1).ok_or_else(beyond)?;
        let end = first.checked_add(length).ok_or_else(beyond)?;
        // The partner's edges begin after those of the seam; between them lie `distance` others.
        let distance = seam.map_or(0, |s| s.partner.wrapping_sub(length - 1).wrapping_sub(end));
        let distance = self.number(distance, kind::SEAM_DISTANCE)?;
        let partner = end.checked_add(distance).and_then(|p| p.checked_add(length - 1)).ok_or_else(beyond)?;
        free.take(first, length, partner);
        Ok(Seam { first, partner, length })
    }
}

/// Which boundary edges are not glued yet.
#[derive(Default)]
struct Free {
    next: u32,
    /// First and one past the last of the partners that lie ahead.
    partners: BTreeMap<u32, u32>,
}

impl Free {
    fn take(&mut self, first: u32, length: u32, partner: u32) {
        self.partners.insert(partner + 1 - length, partner.saturating_add(1));
        self.next = first + length;
        while let Some(entry) = self.partners.first_entry().filter(|entry| *entry.key() <= self.next) {
            self.next = self.next.max(entry.remove());
        }
    }
}

fn malformed(why: &str) -> Error {
    Error::malformed(Place::Whole, why)
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn there_and_back(side: &SideInformation, walls: &[u64]) -> usize {
        let mut w = Writer::default();
        write(&mut w, side, walls);
        let bytes = w.into_bytes();
        let mut r = Reader::new(&bytes, *b"TEST");
        let back = read(&mut r, &mut Budget::new(crate::Limits::default()));
        assert_eq!(back.ok(), Some((side.clone(), walls.to_vec())));
        assert!(r.finish().is_ok());
        bytes.len()
    }

    #[test]
    fn side_information_comes_back() {
        let side = SideInformation {
            blocks: vec![Block { rows: 3, mirrored: true }, Block { rows: 300, mirrored: false }],
            seams: vec![Seam { first: 0, partner: 700, length: 12 }, Seam { first: 14, partner: 20, length: 3 }],
            dummies: vec![3, 4, 900],
            extra: vec![0, 1 << 40],
            missing: vec![[5, 1, 2], [70000, 3, 0]],
        };
        there_and_back(&side, &[7, 8, 1 << 35]);
        there_and_back(&SideInformation::default(), &[]);
    }

    #[test]
    fn seams_that_follow_each_other_cost_about_two_bytes() {
        let seams = (0..100).map(|k| Seam { first: 5 * k, partner: 999 - 5 * k, length: 5 });
        let side = SideInformation { seams: seams.collect(), ..SideInformation::default() };
        assert!(there_and_back(&side, &[]) < 220);
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let mut budget = Budget::new(crate::Limits::default().memory(1 << 20).work(1 << 20));
            drop(read(&mut Reader::new(&bytes, *b"TEST"), &mut budget));
        }
    }
}
