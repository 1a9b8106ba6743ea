//! The side information of an image, as fields (spec/format.md, "Side information").

use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;
use crate::limits::Budget;
use crate::plane::{Block, Seam, SideInformation};

#[cfg(feature = "encode")]
pub(super) fn write(w: &mut Writer, side: &SideInformation) {
    w.varint(side.blocks.len() as u64);
    for block in &side.blocks {
        w.varint(2 * u64::from(block.rows) + u64::from(block.mirrored));
    }
    w.varint(side.seams.len() as u64);
    for seam in &side.seams {
        w.varint(seam.first.into());
        w.varint(seam.partner.into());
        w.varint(seam.length.into());
    }
    ascending(w, side.dummies.iter().map(|&d| d.into()));
    ascending(w, side.extra.iter().copied());
    w.varint(side.missing.len() as u64);
    for &v in side.missing.iter().flatten() {
        w.varint(v.into());
    }
}

/// How many, the first, then the steps between neighbours less one.
#[cfg(feature = "encode")]
pub(super) fn ascending(w: &mut Writer, numbers: impl ExactSizeIterator<Item = u64>) {
    w.varint(numbers.len() as u64);
    let mut next = 0;
    for number in numbers {
        w.varint(number - next);
        next = number + 1;
    }
}

pub(super) fn read(r: &mut Reader<'_>, budget: &mut Budget) -> Result<SideInformation> {
    let mut side = SideInformation::default();
    let count = count(r, "blocks", budget)?;
    for _ in 0..count {
        let packed = r.varint("a block")?;
        let rows = number(r, packed >> 1, "the rows of a block")?;
        if rows == 0 {
            return Err(r.error("a block without rows"));
        }
        side.blocks.push(Block { rows, mirrored: packed & 1 != 0 });
    }
    for _ in 0..self::count(r, "seams", budget)? {
        let mut field = |what| r.varint(what).and_then(|n| number(r, n, what));
        let (first, partner, length) = (field("the start of a seam")?, field("its partner")?, field("its length")?);
        side.seams.push(Seam { first, partner, length });
    }
    let dummies = ascending_from(r, "dummies", budget)?;
    side.dummies = dummies.into_iter().map(|d| number(r, d, "a dummy")).collect::<Result<_>>()?;
    side.extra = ascending_from(r, "half-cells left out", budget)?;
    for _ in 0..self::count(r, "explicit triangles", budget)? {
        let mut corner = || r.varint("a corner").and_then(|n| number(r, n, "a corner"));
        side.missing.push([corner()?, corner()?, corner()?]);
    }
    Ok(side)
}

fn number(r: &Reader<'_>, n: u64, what: &str) -> Result<u32> {
    u32::try_from(n).map_err(|_| r.error(format!("{what} does not fit 32 bits: {n}")))
}

/// A count of things that take at least a byte each.
fn count(r: &mut Reader<'_>, what: &str, budget: &mut Budget) -> Result<u64> {
    let n = r.varint(what)?;
    let left = r.clone().rest().len() as u64;
    if n > left {
        return Err(r.error(format!("{n} {what} in {left} bytes")));
    }
    budget.reserve(n * 16)?;
    Ok(n)
}

pub(super) fn ascending_from(r: &mut Reader<'_>, what: &str, budget: &mut Budget) -> Result<Vec<u64>> {
    let mut next = 0_u64;
    let mut numbers = Vec::new();
    for _ in 0..count(r, what, budget)? {
        let step = r.varint(what)?;
        let n =
            next.checked_add(step).filter(|&n| n < u64::MAX).ok_or_else(|| r.error(format!("{what} do not fit 64 bits")))?;
        numbers.push(n);
        next = n + 1;
    }
    Ok(numbers)
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;

    #[test]
    fn side_information_comes_back_and_is_refused_when_cut() {
        let side = SideInformation {
            blocks: vec![Block { rows: 3, mirrored: true }, Block { rows: 300, mirrored: false }],
            seams: vec![Seam { first: 0, partner: 700, length: 12 }],
            dummies: vec![3, 4, 900],
            extra: vec![0, 1 << 40],
            missing: vec![[5, 1, 2], [70000, 3, 0]],
        };
        let mut w = Writer::default();
        write(&mut w, &side);
        let bytes = w.into_bytes();
        let read = |bytes: &[u8]| {
            let mut r = Reader::new(bytes, *b"TEST");
            let side = super::read(&mut r, &mut Budget::new(crate::Limits::default()))?;
            r.finish().map(|()| side)
        };
        assert_eq!(read(&bytes).unwrap(), side);
        assert!((0..bytes.len()).all(|end| read(&bytes[..end]).is_err()));
    }
}
