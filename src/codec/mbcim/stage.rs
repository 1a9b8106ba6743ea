//! Stages: finer base colours, a few bits at a time (spec/mbcim.md, "Stages").
//!
//! A stage splits the cell of every coarse colour into 2^b parts for each component and says which part it
//! is. By now all colours are known coarsely, so where in its cell a colour lies is guessed from the
//! parallelograms all around it, those that were refined already at their finer values.

use super::meeting::Meetings;
use crate::entropy::{AdaptiveBit, BitCoder};
use crate::error::{Error, Place, Result};

/// Guesses are told apart by eighths of the cell, and before and after it.
const PLACES: usize = 10;

/// Adds `bits` bits to each component: `colours` hold the coarse values, and become the finer ones. A writer
/// gives the finer ones in `finer`.
pub(crate) fn code<C: BitCoder>(
    coder: &mut C,
    meetings: &Meetings<'_>,
    bits: u32,
    extent: [i32; 3],
    colours: &mut [[i32; 3]],
    finer: Option<&[[i32; 3]]>,
) -> Result<()> {
    let mut models = vec![[AdaptiveBit::default(); 8]; 3 * PLACES];
    let half = (1 << bits) >> 1;
    // Coarse values stand in the middle of their cells.
    colours.iter_mut().flatten().for_each(|x| *x = (*x << bits) + half);
    for c in 0..colours.len() {
        let guess = guess(meetings, colours, c as u32);
        for axis in 0..3 {
            let low = colours[c][axis] - half;
            let place = ((i64::from(guess[axis]) - i64::from(low)) * 8).div_euclid(1 << bits).clamp(-1, 8) + 1;
            let model = &mut models[axis * PLACES + place as usize];
            let wanted = finer.map_or(0, |f| f[c][axis] - low);
            let mut value = 0;
            for depth in 0..bits {
                let bit = wanted >> (bits - 1 - depth) & 1 != 0;
                let bit = match depth {
                    0..3 => model[((1 << depth) + value) as usize].code(coder, bit),
                    _ => coder.code(bit, 1 << 15),
                };
                value = value << 1 | i32::from(bit);
            }
            colours[c][axis] = low + value;
            if colours[c][axis] > extent[axis] {
                return Err(Error::malformed(Place::Whole, format!("a stage moves base colour {c} out of its box")));
            }
        }
        if c.is_multiple_of(1 << 14) && coder.is_exhausted() {
            break;
        }
    }
    if coder.is_exhausted() {
        return Err(Error::malformed(Place::Whole, "a stage ends too soon"));
    }
    Ok(())
}

/// The mean of the parallelograms around a colour; the middle of its cell if there is none.
fn guess(meetings: &Meetings<'_>, colours: &[[i32; 3]], colour: u32) -> [i32; 3] {
    let (mut sum, mut count) = ([0_i64; 3], 0);
    for &corner in meetings.around(colour) {
        let [a, b] = meetings.side(corner);
        if let Some(c) = meetings.beyond(corner) {
            let at = |c: u32, i: usize| i64::from(colours[c as usize][i]);
            (0..3).for_each(|i| sum[i] += at(a, i) + at(b, i) - at(c, i));
            count += 1;
        }
    }
    if count == 0 {
        return colours[colour as usize];
    }
    sum.map(|s| s.div_euclid(count) as i32)
}
