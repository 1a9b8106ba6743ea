//! Regions of interest by maxshift (Annex H).
//!
//! Every coefficient that has a part in a pixel of the region is shifted up by s bits, more than any coefficient of the
//! background has. So all of the region comes in bit-planes above all of the background, whatever the shape of the region,
//! and a decoder tells the two apart by magnitude alone: no mask is sent.
//!
//! Which coefficients those are follows from the lifting steps, run backwards: a step made its target from two neighbours,
//! so where the target is needed the neighbours are (H.3.1 prints the outcome for both kernels).

use super::bitplane::MAX_PLANES;
use super::codestream::{MAX_SIGNALLED_PLANES, Transform};
use super::dwt::{Half, synthesis_steps};
use super::quantise::Quantisation;
use crate::error::{Error, Result};
use crate::plane::Mask;

/// Which coefficients, laid out as the transform leaves them, have a part in a pixel of the mask.
pub(super) fn coefficients(mask: &Mask, transform: Transform, levels: u8) -> Vec<bool> {
    let across = mask.shape().width();
    let (mut width, mut height) = (across, mask.shape().height());
    let mut needed: Vec<bool> = mask.iter().collect();
    for _ in 0..levels {
        // Columns: a row of the plane is a group.
        let mut halves = [Vec::new(), Vec::new()];
        for (y, row) in needed.chunks_exact(across).take(height).enumerate() {
            halves[y % 2].extend_from_slice(&row[..width]);
        }
        trace(&mut halves, transform, width);
        for (row, from) in needed.chunks_exact_mut(across).zip(halves.iter().flat_map(|h| h.chunks_exact(width))) {
            row[..width].copy_from_slice(from);
        }
        for row in needed.chunks_exact_mut(across).take(height) {
            let row = &mut row[..width];
            let mut halves = [0, 1].map(|first| row.iter().copied().skip(first).step_by(2).collect::<Vec<bool>>());
            trace(&mut halves, transform, 1);
            for (to, from) in row.iter_mut().zip(halves.iter().flatten()) {
                *to = *from;
            }
        }
        (width, height) = (width.div_ceil(2), height.div_ceil(2));
    }
    needed
}

/// From which samples of the two halves are needed after synthesis, which are before.
fn trace([low, high]: &mut [Vec<bool>; 2], transform: Transform, group: usize) {
    if high.is_empty() {
        return;
    }
    for &half in synthesis_steps(transform).iter().rev() {
        let (target, source) = match half {
            Half::Low => (&*low, &mut *high),
            Half::High => (&*high, &mut *low),
        };
        let sources = source.len() / group;
        for (i, row) in target.chunks_exact(group).enumerate() {
            for neighbour in half.neighbours(i, sources) {
                for (s, t) in source[neighbour * group..][..group].iter_mut().zip(row) {
                    *s |= *t;
                }
            }
        }
    }
}

/// By how many bits to shift the region up, when the largest magnitudes of the region and of the background are these.
///
/// One bit more than the background has: some decoders compare magnitudes with a half bit below them.
pub(super) fn shift(region: u32, background: u32) -> Result<u8> {
    let bits = |magnitude: u32| u32::BITS - magnitude.leading_zeros();
    let shift = bits(background) + 1;
    if region > 0 && bits(region) + shift > MAX_PLANES {
        return Err(Error::Parameter(format!(
            "a region of interest takes {} bit-planes above {shift} of the background, and decoders take {MAX_PLANES} in all; \
             use samples of fewer bits",
            bits(region)
        )));
    }
    Ok(shift as u8)
}

/// Refuses what a header cannot state to all decoders.
pub(super) fn check_planes(quantisation: &Quantisation, shift: u8) -> Result<()> {
    let stated = quantisation.planes().max().unwrap_or(0) + u32::from(shift);
    if stated > MAX_SIGNALLED_PLANES {
        return Err(Error::Parameter(format!(
            "a region of interest makes {stated} bit-planes, and decoders take {MAX_SIGNALLED_PLANES}; use samples of fewer bits"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::dwt::{Coefficients, synthesis};
    use super::*;
    use crate::plane::Shape;

    /// Synthesis with lifting steps that only add, so that nothing can cancel by chance.
    fn adding(transform: Transform, low: &[f64], high: &[f64]) -> Vec<f64> {
        let n = low.len() + high.len();
        let mut x: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { low[i / 2] } else { high[i / 2] }).collect();
        let passes = if transform == Transform::Reversible53 { 1 } else { 2 };
        for parity in (0..2 * passes).map(|pass| pass % 2) {
            for i in (parity..n).step_by(2).filter(|_| n > 1) {
                // Whole-sample symmetric extension, as F.3.7 defines it.
                let mirrored = |i: isize| if i < 0 { -i as usize } else { (i as usize).min(2 * (n - 1) - i as usize) };
                x[i] += x[mirrored(i as isize - 1)] + x[mirrored(i as isize + 1)];
            }
        }
        x
    }

    /// The same by brute force: change one coefficient after another and see whether a pixel of the mask changes.
    fn as_defined(mask: &Mask, transform: Transform, levels: u8) -> Vec<bool> {
        let (width, height) = (mask.shape().width(), mask.shape().height());
        (0..width * height)
            .map(|i| {
                let mut values = vec![0.0; width * height];
                values[i] = 1.0;
                let mut plane = Coefficients { width, height, values };
                synthesis::plane(&mut plane, levels, |l, h| adding(transform, l, h));
                plane.values.iter().zip(mask.iter()).any(|(v, inside)| inside && *v > 0.0)
            })
            .collect()
    }

    #[test]
    fn the_coefficients_of_a_mask_are_those_that_change_a_pixel_of_it() {
        for transform in [Transform::Reversible53, Transform::Irreversible97] {
            for (width, height, levels) in [(1, 1, 0), (2, 7, 1), (16, 9, 2), (23, 18, 3), (37, 5, 2)] {
                let shape = Shape::new(width, height).unwrap();
                for (row, column) in
                    [(0, 0), (height as usize / 2, width as usize / 2), (height as usize - 1, width as usize - 1)]
                {
                    let mask = Mask::from_fn(shape, |r, c| (r, c) == (row, column) || (r, c) == (row / 2, column / 3));
                    let (found, defined) = (coefficients(&mask, transform, levels), as_defined(&mask, transform, levels));
                    let differ: Vec<usize> = (0..found.len()).filter(|&i| found[i] != defined[i]).collect();
                    assert_eq!(differ, [0; 0], "{transform:?} {shape} pixel {row}, {column}");
                }
            }
        }
    }

    #[test]
    fn a_shift_beyond_the_bit_planes_of_decoders_is_refused() {
        assert_eq!(shift(4095, 4095).unwrap(), 13);
        assert!(shift(65535, 65535).is_err());
        assert_eq!(shift(65535, 0).unwrap(), 1);
    }
}
