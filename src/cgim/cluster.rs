//! The cluster phase (CGIM §5.2): which pixels of a lossy image are one vertex. Normative text: `spec/cluster.md`.
//!
//! Beside the pixels there are only the run counts. The largest steps of colour along each row cut it into runs,
//! those along each column say where two rows do *not* hang together; then each run joins the run of the row above
//! that it hangs together with most closely, or starts a new region.
//!
//! All in integers, ties broken by position, so that every reader finds the same regions.

use super::regions::{BELOW, RIGHT, wall};
use crate::mesh::NONE;
use crate::plane::{Block, RunCounts};

/// The regions of an image whose rows belong to `blocks`, numbered by first occurrence, and how many there are.
/// `distance` is how different the colours of two pixels are; `walls` are borders that stand in any case. `None` if
/// counts and walls do not fit the image.
///
/// O(pixels).
pub(crate) fn cluster(
    columns: usize,
    blocks: &[Block],
    counts: &RunCounts,
    walls: &[u64],
    distance: impl Fn(usize, usize) -> u64,
) -> Option<(Vec<u32>, u32)> {
    let rows = blocks.iter().map(|block| block.rows as usize).sum::<usize>();
    if counts.rows.len() != rows || counts.columns.len() != columns * blocks.len() {
        return None;
    }
    let borders = Borders::new(rows, columns, walls)?;
    let mut region = vec![NONE; rows * columns];
    let mut regions = 0;
    let mut steps = Vec::new();
    // For each column of a row where its run begins.
    let (mut runs, mut runs_above): (Vec<u32>, Vec<u32>) = (Vec::new(), Vec::new());
    let mut first = 0;
    for (block, column_counts) in blocks.iter().zip(counts.columns.chunks_exact(columns.max(1))) {
        let end = first + block.rows as usize;
        let mut right = borders.right[first * columns..end * columns].to_vec();
        for i in first..end {
            let row = i * columns;
            let line = &mut right[(i - first) * columns..][..columns];
            steps.clear();
            steps.extend((0..columns - 1).map(|j| distance(row + j, row + j + 1)));
            largest(&steps, counts.rows[i], line, 1)?;
        }
        let mut below = borders.below[first * columns..end * columns].to_vec();
        for (j, &count) in column_counts.iter().enumerate() {
            steps.clear();
            steps.extend((first..end - 1).map(|i| distance(i * columns + j, (i + 1) * columns + j)));
            largest(&steps, count, &mut below[j..], columns)?;
        }
        if below[(end - 1 - first) * columns..].contains(&true) {
            return None;
        }
        for i in first..end {
            let line = (i - first) * columns;
            runs.clear();
            let mut start = 0;
            while start < columns {
                let stop = (start..columns - 1).find(|&j| right[line + j]).unwrap_or(columns - 1) + 1;
                let above = if i > first {
                    let row = (i - 1) * columns;
                    let hangs = |j: &usize| !below[line - columns + j];
                    let run =
                        closest((start..stop).filter(hangs).map(|j| (runs_above[j], distance(row + j, row + columns + j))));
                    run.map(|start| region[row + start as usize])
                } else {
                    None
                };
                let label = above.unwrap_or_else(|| {
                    regions += 1;
                    regions - 1
                });
                region[i * columns + start..i * columns + stop].fill(label);
                runs.resize(stop, start as u32);
                start = stop;
            }
            std::mem::swap(&mut runs, &mut runs_above);
        }
        first = end;
    }
    Some((region, regions))
}

/// Marks the `count` largest steps, those already marked among them; of equal ones those that come first. `None` if
/// there are not that many steps, or more are marked already.
fn largest(steps: &[u64], count: u32, marks: &mut [bool], stride: usize) -> Option<()> {
    let marked = (0..steps.len()).filter(|&k| marks[k * stride]).count();
    let more = (count as usize).checked_sub(marked)?;
    let mut order: Vec<(std::cmp::Reverse<u64>, usize)> =
        (0..steps.len()).filter(|&k| !marks[k * stride]).map(|k| (std::cmp::Reverse(steps[k]), k)).collect();
    if more > order.len() {
        return None;
    }
    if more > 0 && more < order.len() {
        order.select_nth_unstable(more - 1);
    }
    order[..more].iter().for_each(|&(_, k)| marks[k * stride] = true);
    Some(())
}

/// The run whose distances have the least mean; of equal ones the first. A run's distances come one after the other.
fn closest(candidates: impl Iterator<Item = (u32, u64)>) -> Option<u32> {
    let mut best: Option<(u32, u128, u128)> = None;
    let mut current: Option<(u32, u128, u128)> = None;
    let mut settle = |current: Option<(u32, u128, u128)>| {
        let Some((_, sum, count)) = current else { return };
        // sum / count < best sum / best count
        if best.is_none_or(|(_, best_sum, best_count)| sum * best_count < best_sum * count) {
            best = current;
        }
    };
    for (run, distance) in candidates {
        match &mut current {
            Some((of, sum, count)) if *of == run => {
                *sum += u128::from(distance);
                *count += 1;
            }
            _ => settle(current.replace((run, distance.into(), 1))),
        }
    }
    settle(current);
    best.map(|(run, ..)| run)
}

/// Walls as two pictures.
struct Borders {
    right: Vec<bool>,
    below: Vec<bool>,
}

impl Borders {
    fn new(rows: usize, columns: usize, walls: &[u64]) -> Option<Self> {
        let mut borders = Self { right: vec![false; rows * columns], below: vec![false; rows * columns] };
        for &number in walls {
            let (pixel, direction) = wall(number);
            let pixel = usize::try_from(pixel).ok().filter(|&p| p < rows * columns)?;
            match direction {
                RIGHT if pixel % columns + 1 < columns => borders.right[pixel] = true,
                BELOW if pixel + columns < rows * columns => borders.below[pixel] = true,
                _ => return None,
            }
        }
        Some(borders)
    }
}
