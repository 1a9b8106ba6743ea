//! Align2Levels and AlignAllLevels (CGIM §4.1), as one longest path.
//!
//! The paper repeats vertices in each pair of neighbouring levels until both have the same length,
//! and then goes up and down the levels until all agree. Here the columns themselves are the
//! unknowns. Level `i` leaves its `p`-th vertex after column `x(i, p)`; then
//!
//! - `x(i, p + 1) ≥ x(i, p) + 1` along a level;
//! - a step of the top comes at least one column after the last step of the bottom before it;
//! - a step of the bottom may share the column of the last step of the top before it, because a cell
//!   holds the top's triangle first.
//!
//! The least solution is a longest path in an acyclic graph, found in linear time, and its width is
//! the least that these words allow (`spec/readings.md`, alignment). The paper's own construction is
//! in `paper.rs`: as valid, and 13–36 % wider on scans.

use super::vmatrix::VMatrix;
use crate::plane::{Levels, Step};

/// How the pixels of one vertex hang together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Contact {
    /// Through equal neighbours in rows, columns and along the slash. The smallest matrices.
    #[default]
    Slash,
    /// Through equal neighbours in rows and columns alone, as the cluster phase of §5.2 needs.
    Overlap,
}

const NONE: u32 = u32::MAX;

/// The steps of all levels ("events") with the order that they must keep.
struct Events {
    /// The first event of each level, and the number of all events at the end.
    first: Vec<usize>,
    /// The earliest step of the level below that must not come before this one, and by how many columns it is later.
    below: Vec<(u32, bool)>,
    /// The earliest step of the level above that must come after this one.
    above: Vec<u32>,
}

impl Events {
    fn new(levels: &Levels, contact: Contact) -> Self {
        let mut first = Vec::with_capacity(levels.len() + 1);
        first.extend((0..levels.len()).map(|i| levels.level_start(i) - i));
        first.push(first.last().map_or(0, |&f| f + levels.level(levels.len() - 1).len() - 1));
        let count = *first.last().unwrap_or(&0);
        let mut events = Self { below: vec![(NONE, false); count], above: vec![NONE; count], first };
        for i in 0..levels.len().saturating_sub(1) {
            events.add_strip(levels, i, contact);
        }
        events
    }

    /// Later steps of the same side follow along their level, so only the first after each is kept.
    fn add_strip(&mut self, levels: &Levels, i: usize, contact: Contact) {
        let (top, bottom) = (levels.level(i), levels.level(i + 1));
        let (top_first, bottom_first) = (self.first[i], self.first[i + 1]);
        let (mut t, mut b) = (0, 0);
        let (mut last_top, mut last_bottom) = (None, None);
        for &step in levels.strip(i) {
            let later = contact == Contact::Overlap && top[t] == bottom[b];
            let (top_event, bottom_event) = (top_first + t, bottom_first + b);
            if step != Step::Bottom {
                if let Some(before) = last_bottom.take() {
                    self.above[before] = top_event as u32;
                }
                t += 1;
            }
            if step != Step::Top {
                if let Some(before) = last_top.take() {
                    self.below[before] = (bottom_event as u32, later);
                }
                b += 1;
            }
            if step != Step::Bottom {
                last_top = Some(top_event);
            }
            if step != Step::Top {
                last_bottom = Some(bottom_event);
            }
        }
        debug_assert_eq!((t + 1, b + 1), (top.len(), bottom.len()), "the word of strip {i} does not span its levels");
    }

    /// The events that follow `e` in level `i`, with the columns between them.
    fn following(&self, e: usize, end: usize) -> impl Iterator<Item = (usize, u32)> {
        let along = (e + 1 < end).then_some((e + 1, 1));
        let (below, later) = self.below[e];
        let below = (below != NONE).then_some((below as usize, u32::from(later)));
        let above = (self.above[e] != NONE).then_some((self.above[e] as usize, 1));
        [along, below, above].into_iter().flatten()
    }

    /// The least columns, by Kahn's topological order.
    fn columns(&self) -> Vec<u32> {
        let count = self.above.len();
        let mut level_end = vec![0_u32; count];
        let mut waiting = vec![0_u8; count];
        for ends in self.first.windows(2) {
            level_end[ends[0]..ends[1]].fill(ends[1] as u32);
        }
        for (e, &end) in level_end.iter().enumerate() {
            for (f, _) in self.following(e, end as usize) {
                waiting[f] += 1;
            }
        }
        let mut columns = vec![0_u32; count];
        let mut ready: Vec<u32> = (0..count as u32).filter(|&e| waiting[e as usize] == 0).collect();
        let mut done = 0;
        while let Some(e) = ready.pop() {
            done += 1;
            let e = e as usize;
            for (f, gap) in self.following(e, level_end[e] as usize) {
                columns[f] = columns[f].max(columns[e] + gap);
                waiting[f] -= 1;
                if waiting[f] == 0 {
                    ready.push(f as u32);
                }
            }
        }
        assert_eq!(done, count, "steps of neighbouring levels wait for each other");
        columns
    }
}

/// The least number of columns for these words.
pub(crate) fn width(levels: &Levels, contact: Contact) -> usize {
    Events::new(levels, contact).columns().into_iter().max().map_or(1, |x| x as usize + 2)
}

/// The V-matrix of least width for these words. O(steps + entries).
pub(crate) fn align(levels: &Levels, contact: Contact) -> VMatrix {
    let events = Events::new(levels, contact);
    let columns = events.columns();
    let width = columns.iter().max().map_or(1, |&x| x as usize + 2);
    let mut vertices = Vec::with_capacity(width * levels.len());
    for i in 0..levels.len() {
        let leaves = &columns[events.first[i]..events.first[i + 1]];
        for (p, &v) in levels.level(i).iter().enumerate() {
            let end = leaves.get(p).map_or(width, |&x| x as usize + 1);
            vertices.resize(i * width + end, v);
        }
    }
    VMatrix::new(width, vertices)
}
