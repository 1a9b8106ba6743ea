//! Columns handed out while the sweep goes on, so that it widens no further than it must.
//!
//! Seen from one row, an edge of the level that is kept may move by about one vertex, but new edges
//! need columns of their own: under a vertex `w` columns wide, `w` of them find room. So a fan that is too wide for its
//! vertex has to wait, as under Algorithm 2's α, and meanwhile its vertex is given more columns.
//! α is thus a different number for each vertex and row, and the matrix stays as narrow as was asked for.
//!
//! The columns handed out here only steer the sweep: the alignment afterwards finds its own, not more.

use crate::plane::Step;

/// The columns of the current level.
#[derive(Debug, Clone)]
pub(super) struct Room {
    columns: u32,
    /// For each edge of the level the last column of its left end.
    leaves: Vec<u32>,
    /// Positions as far left as can be, for the next level.
    leftmost: Vec<(u32, u32)>,
}

impl Room {
    /// `edges` edges spread evenly over `columns` columns, or more if there are more edges.
    pub(super) fn new(columns: usize, edges: usize) -> Self {
        let columns = columns.max(edges + 1) as u32;
        let leaves = (1..=edges).map(|k| (k * columns as usize / (edges + 1)) as u32 - 1).collect();
        Self { columns, leaves, leftmost: Vec::new() }
    }

    /// The columns in which a new edge below the `k`-th vertex may end: first and one past the last.
    pub(super) fn window(&self, k: usize) -> (u32, u32) {
        let first = if k == 0 { 0 } else { self.leaves[k - 1] };
        (first, self.leaves.get(k).copied().unwrap_or(self.columns - 1))
    }

    /// Makes the level wider by a quarter, for the case that nothing else helps.
    pub(super) fn widen(&mut self) {
        let more = |x: u32, k: usize| x + x / 4 + k as u32 + 1;
        for (k, x) in self.leaves.iter_mut().enumerate() {
            *x = more(*x, k);
        }
        self.columns = more(self.columns, self.leaves.len());
    }

    /// Gives the next level its columns. `weights[p]` is the share that its `p`-th vertex would like.
    pub(super) fn advance(&mut self, word: &[Step], weights: &[u32]) {
        self.leftmost.clear();
        let (mut k, mut next) = (0, 0);
        for &step in word {
            let (first, _) = self.window(k);
            // The last column of a kept edge is that of the vertex after it.
            let last = match step {
                Step::Top => None,
                Step::Bottom => Some(self.window(k).1),
                Step::Both => Some(self.window(k + 1).1),
            };
            if let Some(last) = last {
                let x = first.max(next);
                self.leftmost.push((x, last));
                next = x + 1;
            }
            if step != Step::Bottom {
                k += 1;
            }
        }
        // Rightmost positions from the right, then the wish clamped between the two.
        let mut bound = self.columns - 1;
        for (_, last) in self.leftmost.iter_mut().rev() {
            bound = bound.min(*last);
            *last = bound;
            bound = bound.saturating_sub(1);
        }
        let total: u64 = weights.iter().map(|&w| u64::from(w)).sum();
        let (mut sum, mut next) = (0, 0);
        self.leaves.clear();
        for (&(leftmost, end), &weight) in self.leftmost.iter().zip(weights) {
            sum += u64::from(weight);
            let wish = (sum * u64::from(self.columns) / total.max(1)).saturating_sub(1) as u32;
            let x = wish.min(end.saturating_sub(1)).max(leftmost.max(next));
            self.leaves.push(x);
            next = x + 1;
        }
    }
}
