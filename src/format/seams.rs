//! How the border of a geometry image is glued along seams, as it stands in `GIMG` (spec/format.md, "Seams").

use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;
use crate::plane::{BorderSide, Seams};

/// Grains of a side of the image at most.
const FINEST: u64 = Seams::FINEST as u64;

/// Pairs of sides at most.
const MOST: u64 = 1 << 12;

/// Writes a glued border: a side that is the first of its pair has its length, the other one says how many of those that still
/// wait for theirs began after it.
#[cfg(feature = "encode")]
pub(super) fn write(seams: &Seams, w: &mut Writer) {
    w.varint(seams.grains().into());
    w.varint(seams.start().into());
    w.varint(seams.sides().len() as u64 / 2);
    let mut waiting: Vec<u32> = Vec::new();
    for (i, side) in seams.sides().iter().enumerate() {
        match waiting.iter().rev().position(|&j| j == side.mate) {
            Some(after) => {
                w.varint(1 + after as u64);
                waiting.remove(waiting.len() - 1 - after);
            }
            None => {
                w.varint(0);
                w.varint(u64::from(side.length - Seams::SHORTEST));
                waiting.push(i as u32);
            }
        }
    }
}

pub(super) fn read(r: &mut Reader<'_>) -> Result<Seams> {
    let mut number = |what: &str, most: u64| {
        let n = r.varint(what)?;
        if n <= most { Ok(n as u32) } else { Err(r.error(format!("{what} of {n}, at most {most} expected"))) }
    };
    let (grains, start) = (number("the grains", FINEST)?, number("the first side", 4 * FINEST)?);
    let pairs = number("seams", MOST)?;
    let (mut sides, mut waiting): (Vec<BorderSide>, Vec<u32>) = (Vec::new(), Vec::new());
    for i in 0..2 * pairs {
        match number("a side", waiting.len() as u64)? {
            0 => {
                waiting.push(i);
                sides.push(BorderSide { length: Seams::SHORTEST + number("a side's length", 4 * FINEST)?, mate: i });
            }
            after => {
                let mate = waiting.remove(waiting.len() - after as usize);
                sides.push(BorderSide { length: sides[mate as usize].length, mate });
                sides[mate as usize].mate = i;
            }
        }
    }
    Seams::new(grains, start, sides).map_err(|why| r.error(why.to_string()))
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;

    #[test]
    fn seams_come_back_and_what_makes_no_surface_is_refused() {
        let side = |length, mate| BorderSide { length, mate };
        let torus = Seams::new(8, 31, vec![side(7, 2), side(9, 3), side(7, 0), side(9, 1)]).unwrap();
        let pairs = [(0, 3, 5), (1, 4, 6), (2, 6, 9), (5, 8, 8), (7, 9, 6)];
        let mut sides = vec![side(0, 0); 10];
        for (i, j, length) in pairs {
            (sides[i], sides[j]) = (side(length, j as u32), side(length, i as u32));
        }
        let large = Seams::new(17, 67, sides).unwrap();
        for seams in [torus, large] {
            let mut w = Writer::default();
            write(&seams, &mut w);
            let bytes = w.into_bytes();
            assert_eq!(read(&mut Reader::new(&bytes, *b"GIMG")).unwrap(), seams);
            for end in 0..bytes.len() {
                assert!(read(&mut Reader::new(&bytes[..end], *b"GIMG")).is_err());
            }
            for at in 0..bytes.len() {
                for bit in 0..8 {
                    let mut changed = bytes.clone();
                    changed[at] ^= 1 << bit;
                    drop(read(&mut Reader::new(&changed, *b"GIMG")));
                }
            }
        }
    }
}
