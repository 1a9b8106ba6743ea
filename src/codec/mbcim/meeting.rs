//! Which colours meet: the half-cells of an index map as a table of neighbours.
//!
//! A half-cell in which three colours meet says that they are near each other, and two half-cells
//! that share two colours lie side by side. Nothing more is asked of them: any list of triples will do.

const NONE: u32 = u32::MAX;

/// The half-cells around every colour, and across every side.
pub(crate) struct Meetings<'a> {
    pub(super) cells: &'a [[u32; 3]],
    /// `ends[c]` is one past the last corner of colour `c` in `corners`.
    ends: Vec<u32>,
    /// Corners `3 · cell + k`, by colour.
    corners: Vec<u32>,
    /// For the side opposite each corner the corner that lies across it, or [`NONE`].
    across: Vec<u32>,
}

impl<'a> Meetings<'a> {
    /// Bytes that it takes for each triple and each colour.
    pub(crate) const BYTES: u64 = 40;

    /// The neighbourhood of `colours` colours; triples name none beyond. O(n log n).
    pub(crate) fn new(cells: &'a [[u32; 3]], colours: usize) -> Self {
        let mut ends = vec![0_u32; colours];
        for &c in cells.iter().flatten() {
            ends[c as usize] += 1;
        }
        let mut sum = 0;
        for end in &mut ends {
            sum += std::mem::replace(end, sum);
        }
        let mut corners = vec![0; 3 * cells.len()];
        for (corner, &c) in cells.iter().flatten().enumerate() {
            corners[ends[c as usize] as usize] = corner as u32;
            ends[c as usize] += 1;
        }
        let mut sides: Vec<([u32; 2], u32)> = (0..corners.len() as u32)
            .map(|corner| {
                let cell = cells[corner as usize / 3];
                let (a, b) = (cell[(corner as usize + 1) % 3], cell[(corner as usize + 2) % 3]);
                ([a.min(b), a.max(b)], corner)
            })
            .collect();
        sides.sort_unstable();
        let mut across = vec![NONE; corners.len()];
        for side in sides.chunk_by(|x, y| x.0 == y.0) {
            if let [(_, c), (_, d)] = *side {
                across[c as usize] = d;
                across[d as usize] = c;
            }
        }
        Self { cells, ends, corners, across }
    }

    /// How many colours there are.
    pub(super) fn colours(&self) -> usize {
        self.ends.len()
    }

    /// The corners of a colour.
    pub(super) fn around(&self, colour: u32) -> &[u32] {
        let start = if colour == 0 { 0 } else { self.ends[colour as usize - 1] };
        &self.corners[start as usize..self.ends[colour as usize] as usize]
    }

    /// The other two colours of a corner's half-cell.
    #[inline]
    pub(super) fn side(&self, corner: u32) -> [u32; 2] {
        let cell = self.cells[corner as usize / 3];
        [cell[(corner as usize + 1) % 3], cell[(corner as usize + 2) % 3]]
    }

    /// The colour across the side opposite a corner.
    #[inline]
    pub(super) fn beyond(&self, corner: u32) -> Option<u32> {
        let d = self.across[corner as usize];
        (d != NONE).then(|| self.cells[d as usize / 3][d as usize % 3])
    }
}
