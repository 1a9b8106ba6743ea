//! What the pixels that a code-block covers stand for, on average.

use super::partition::{Band, Block};
use crate::plane::Shape;

/// The least mean weight of a code-block: what stands for nothing still has an order among its kind.
const LEAST: f64 = 1e-9;

/// Sums of the weights of all pixels above and to the left, so that a rectangle's sum is that of its four corners.
pub(super) struct Covered {
    shape: Shape,
    sums: Vec<f64>,
}

impl Covered {
    /// Of one weight a pixel, row by row.
    pub(super) fn new(weights: &[f32], shape: Shape) -> Self {
        let across = shape.width() + 1;
        let mut sums = vec![0.0; across];
        for (y, row) in weights.chunks_exact(shape.width()).enumerate() {
            let mut left = 0.0;
            sums.push(0.0);
            for (x, &weight) in row.iter().enumerate() {
                left += f64::from(weight);
                sums.push(sums[y * across + x + 1] + left);
            }
        }
        Self { shape, sums }
    }

    /// The mean weight of the pixels that a code-block of a sub-band covers.
    pub(super) fn mean(&self, block: &Block, band: &Band) -> f64 {
        let across = self.shape.width() + 1;
        // A coefficient of level n stands for a square of 2^n pixels, and a little of those around it.
        let cover = |from: usize, length: usize, side: usize| {
            let (from, to) = (from << band.level, (from + length) << band.level);
            (from.min(side - 1), to.min(side))
        };
        let (left, right) = cover(block.x - band.x, block.width, self.shape.width());
        let (top, bottom) = cover(block.y - band.y, block.height, self.shape.height());
        let at = |x: usize, y: usize| self.sums[y * across + x];
        let sum = at(right, bottom) - at(left, bottom) - at(right, top) + at(left, top);
        (sum / ((right - left) * (bottom - top)) as f64).max(LEAST)
    }
}

#[cfg(test)]
mod tests {
    use super::super::partition::Partition;
    use super::*;

    #[test]
    fn the_mean_of_a_block_is_that_of_the_pixels_it_covers() {
        let shape = Shape::new(150, 97).unwrap();
        let weights: Vec<f32> = (0..shape.pixels()).map(|i| (i * i % 101) as f32).collect();
        let covered = Covered::new(&weights, shape);
        let partition = Partition::new(shape, 3, 5);
        for block in &partition.blocks {
            let band = &partition.bands[block.band];
            let inside = |i: usize, from: usize, length: usize| (from..from + length).contains(&(i >> band.level));
            let found: Vec<f64> = (0..shape.pixels())
                .filter(|i| inside(i % 150, block.x - band.x, block.width) && inside(i / 150, block.y - band.y, block.height))
                .map(|i| f64::from(weights[i]))
                .collect();
            let mean = found.iter().sum::<f64>() / found.len() as f64;
            assert!((covered.mean(block, band) - mean).abs() < 1e-6);
        }
    }
}
