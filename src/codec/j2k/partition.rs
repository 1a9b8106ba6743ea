//! How a plane is divided (Annex B.5 to B.7): resolutions, sub-bands, precincts, code-blocks.
//!
//! The image begins at the origin of the reference grid and is one tile, so every rectangle follows from the size
//! alone and is the same for all components.

use crate::plane::Shape;

/// Which filter made a sub-band in each direction, horizontal first.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(clippy::upper_case_acronyms)] // as the standard writes them
pub(super) enum Orientation {
    LL,
    HL,
    LH,
    HH,
}

/// The largest precinct, 2^15 (PPx = PPy = 15): the one that holds when none is signalled.
const PRECINCT: usize = 1 << 15;

/// A sub-band, and where it lies among the coefficients of its plane.
#[derive(Clone, Debug)]
pub(super) struct Band {
    pub(super) orientation: Orientation,
    /// Decompositions that led to it: 1 for the largest bands.
    pub(super) level: u8,
    pub(super) x: usize,
    pub(super) y: usize,
    pub(super) width: usize,
    pub(super) height: usize,
}

/// A code-block, and where it lies among the coefficients of its plane.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// Index into [`Partition::bands`].
    pub(super) band: usize,
    pub(super) x: usize,
    pub(super) y: usize,
    pub(super) width: usize,
    pub(super) height: usize,
}

/// The code-blocks of one sub-band inside one precinct, row by row.
#[derive(Clone, Debug)]
pub(super) struct BlockGrid {
    /// The first one's index into [`Partition::blocks`].
    pub(super) first: usize,
    pub(super) across: usize,
    pub(super) down: usize,
}

/// The division of one plane.
#[derive(Debug)]
pub(super) struct Partition {
    /// LL, and then HL, LH, HH of each resolution, the order of QCD.
    pub(super) bands: Vec<Band>,
    pub(super) blocks: Vec<Block>,
    /// For each resolution its precincts, and for each precinct one grid a sub-band.
    pub(super) resolutions: Vec<Vec<Vec<BlockGrid>>>,
}

/// The most decompositions of an image: no sub-band is ever empty.
pub(super) fn most_levels(shape: Shape) -> u8 {
    shape.width().min(shape.height()).ilog2() as u8
}

impl Partition {
    /// Divides a plane; code-blocks have sides of 2^`block`.
    pub(super) fn new(shape: Shape, levels: u8, block: u8) -> Self {
        let mut partition = Self { bands: Vec::new(), blocks: Vec::new(), resolutions: Vec::new() };
        for resolution in 0..=levels {
            // Size of a level's low band, which is a resolution of the image.
            let low = |level: u8, side: usize| side.div_ceil(1 << level);
            let level = if resolution == 0 { levels } else { levels - resolution + 1 };
            let (low_width, low_height) = (low(level, shape.width()), low(level, shape.height()));
            let first = partition.bands.len();
            let (whole_width, whole_height, precinct);
            if resolution == 0 {
                (whole_width, whole_height, precinct) = (low_width, low_height, PRECINCT);
                partition.bands.push(Band {
                    orientation: Orientation::LL,
                    level,
                    x: 0,
                    y: 0,
                    width: low_width,
                    height: low_height,
                });
            } else {
                (whole_width, whole_height) = (low(level - 1, shape.width()), low(level - 1, shape.height()));
                precinct = PRECINCT / 2;
                for (orientation, right, lower) in
                    [(Orientation::HL, true, false), (Orientation::LH, false, true), (Orientation::HH, true, true)]
                {
                    let (x, width) = if right { (low_width, whole_width - low_width) } else { (0, low_width) };
                    let (y, height) = if lower { (low_height, whole_height - low_height) } else { (0, low_height) };
                    partition.bands.push(Band { orientation, level, x, y, width, height });
                }
            }
            let mut precincts = Vec::new();
            for row in 0..whole_height.div_ceil(PRECINCT) {
                for column in 0..whole_width.div_ceil(PRECINCT) {
                    let grids = (first..partition.bands.len())
                        .map(|band| partition.grid(band, column * precinct, row * precinct, precinct, 1 << block))
                        .collect();
                    precincts.push(grids);
                }
            }
            partition.resolutions.push(precincts);
        }
        partition
    }

    /// How many decompositions there are.
    pub(super) fn levels(&self) -> u8 {
        self.resolutions.len() as u8 - 1
    }

    /// The code-blocks of a band inside the square of `side` at (`left`, `top`) of the band.
    fn grid(&mut self, band: usize, left: usize, top: usize, side: usize, block: usize) -> BlockGrid {
        let Band { x, y, width, height, .. } = self.bands[band];
        let (width, height) = (width.saturating_sub(left).min(side), height.saturating_sub(top).min(side));
        let first = self.blocks.len();
        for dy in (0..height).step_by(block) {
            for dx in (0..width).step_by(block) {
                self.blocks.push(Block {
                    band,
                    x: x + left + dx,
                    y: y + top + dy,
                    width: block.min(width - dx),
                    height: block.min(height - dy),
                });
            }
        }
        let (mut across, mut down) = (width.div_ceil(block), height.div_ceil(block));
        if across == 0 || down == 0 {
            (across, down) = (0, 0);
        }
        BlockGrid { first, across, down }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_blocks_cover_every_coefficient_once() {
        for (width, height, levels, block) in
            [(1, 1, 0, 6), (5, 3, 1, 5), (300, 200, 5, 5), (70_000, 9, 3, 6), (1541, 300, 5, 6)]
        {
            let shape = Shape::new(width, height).unwrap();
            let partition = Partition::new(shape, levels, block);
            assert_eq!(partition.bands.len(), 3 * usize::from(levels) + 1);
            let mut seen = vec![0u8; shape.pixels()];
            for b in &partition.blocks {
                for y in b.y..b.y + b.height {
                    for x in b.x..b.x + b.width {
                        seen[y * shape.width() + x] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1), "{shape}");
            let in_grids: usize = partition.resolutions.iter().flatten().flatten().map(|g| g.across * g.down).sum();
            assert_eq!(in_grids, partition.blocks.len());
        }
    }
}
