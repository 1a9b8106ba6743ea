//! Which pixels are one vertex, found from their colours (CGIM §3, "elements with different coordinates").
//!
//! Every vertex of a V-matrix is one connected set of pixels, if neighbours along the slash count
//! too. So pixels are joined where neighbours have one colour. Two vertices that lie side by side
//! with the same colour would be joined wrongly: such places (*walls*) are listed beside the image.

use super::vmatrix::VMatrix;
use crate::mesh::NONE;
use crate::plane::Block;

/// The neighbours that a pixel is compared with: to the right, below, and below to the left.
const DIRECTIONS: u64 = 3;
/// The first two of them.
pub(super) const RIGHT: u64 = 0;
pub(super) const BELOW: u64 = 1;
/// The third.
const SLASH: u64 = 2;

/// The pixel and the direction of a wall.
pub(super) fn wall(number: u64) -> (u64, u64) {
    (number / DIRECTIONS, number % DIRECTIONS)
}

/// For each pair of neighbours the number of their wall and the two pixels.
fn pairs(rows: usize, columns: usize, blocks: &[Block]) -> impl Iterator<Item = (u64, usize, usize)> {
    let mut last_row = vec![false; rows];
    let mut end = 0;
    for block in blocks {
        end += block.rows as usize;
        if let Some(last) = end.checked_sub(1).and_then(|i| last_row.get_mut(i)) {
            *last = true;
        }
    }
    (0..rows).flat_map(move |i| {
        let below = i + 1 < rows && !last_row[i];
        (0..columns).flat_map(move |j| {
            let p = i * columns + j;
            let right = (j + 1 < columns).then_some((RIGHT, p + 1));
            let down = below.then_some((BELOW, p + columns));
            let slash = (below && j > 0).then(|| (SLASH, p + columns - 1));
            [right, down, slash].into_iter().flatten().map(move |(d, q)| (DIRECTIONS * p as u64 + d, p, q))
        })
    })
}

/// Where neighbours have one colour and are different vertices.
pub(crate) fn walls(matrix: &VMatrix, blocks: &[Block], same_colour: impl Fn(usize, usize) -> bool) -> Vec<u64> {
    let entries = matrix.entries();
    let pairs = pairs(matrix.rows(), matrix.columns(), blocks);
    pairs.filter(|&(_, p, q)| entries[p] != entries[q] && same_colour(p, q)).map(|(wall, ..)| wall).collect()
}

/// The walls that stand between neighbours in a row or a column.
pub(crate) fn straight(walls: Vec<u64>) -> Vec<u64> {
    walls.into_iter().filter(|&number| wall(number).1 != SLASH).collect()
}

/// The regions of an image: neighbours of one colour without a wall between them. Regions are
/// numbered by first occurrence. `None` if a wall stands where there is nothing to part.
///
/// O(pixels · α(pixels)).
pub(crate) fn regions(
    rows: usize,
    columns: usize,
    blocks: &[Block],
    walls: &[u64],
    same_colour: impl Fn(usize, usize) -> bool,
) -> Option<(Vec<u32>, u32)> {
    let mut parent: Vec<u32> = (0..(rows * columns) as u32).collect();
    let find = |parent: &mut Vec<u32>, mut p: usize| {
        while parent[p] as usize != p {
            parent[p] = parent[parent[p] as usize];
            p = parent[p] as usize;
        }
        p
    };
    let mut walls = walls.iter().copied().peekable();
    for (wall, p, q) in pairs(rows, columns, blocks) {
        if same_colour(p, q) && walls.next_if_eq(&wall).is_none() {
            let (a, b) = (find(&mut parent, p), find(&mut parent, q));
            parent[a.max(b)] = a.min(b) as u32;
        }
    }
    if walls.next().is_some() {
        return None;
    }
    let mut region = vec![NONE; parent.len()];
    let mut count = 0;
    for p in 0..parent.len() {
        let root = find(&mut parent, p);
        if region[root] == NONE {
            region[root] = count;
            count += 1;
        }
        region[p] = region[root];
    }
    Some((region, count))
}
