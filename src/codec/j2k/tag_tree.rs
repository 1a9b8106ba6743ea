//! Tag trees (Annex B.10.2): a grid of numbers told bit by bit, each from below.
//!
//! Every node holds the least of its four children. To say whether a leaf is below a threshold, the path from the
//! root is walked; at each node zeros count up to its value and a one ends the count. What was said before is not
//! said again.

use super::packet::BitWriter;

/// A tag tree over a grid, on the encoder's side.
#[derive(Clone)]
pub(super) struct TagTree {
    /// Across, and where the nodes begin, for each level from the leaves up.
    levels: Vec<(usize, usize)>,
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Node {
    value: u32,
    /// The value is known not to be below this.
    low: u32,
    /// Whether the one that ends the count was written.
    told: bool,
}

impl TagTree {
    /// A tree over a grid whose values are not known yet, and greater than any threshold.
    pub(super) fn new(across: usize, down: usize) -> Self {
        let mut levels = vec![(across, 0)];
        let (mut across, mut down, mut nodes) = (across, down, across * down);
        while across * down > 1 {
            (across, down) = (across.div_ceil(2), down.div_ceil(2));
            levels.push((across, nodes));
            nodes += across * down;
        }
        Self { levels, nodes: vec![Node { value: u32::MAX, low: 0, told: false }; nodes] }
    }

    fn node(&mut self, level: usize, x: usize, y: usize) -> &mut Node {
        let (across, first) = self.levels[level];
        &mut self.nodes[first + (y >> level) * across + (x >> level)]
    }

    /// Makes the value at (`x`, `y`) known.
    pub(super) fn set(&mut self, x: usize, y: usize, value: u32) {
        for level in 0..self.levels.len() {
            let node = self.node(level, x, y);
            node.value = node.value.min(value);
        }
    }

    /// Writes what is still needed to tell the value at (`x`, `y`).
    pub(super) fn tell(&mut self, x: usize, y: usize, out: &mut BitWriter) {
        let value = self.node(0, x, y).value;
        self.encode(x, y, value + 1, out);
    }

    /// Writes what is still needed to tell whether the value at (`x`, `y`) is below `threshold`.
    pub(super) fn encode(&mut self, x: usize, y: usize, threshold: u32, out: &mut BitWriter) {
        let mut low = 0;
        for level in (0..self.levels.len()).rev() {
            let node = self.node(level, x, y);
            // No child is below its parent.
            low = low.max(node.low);
            while low < threshold && !node.told {
                node.told = low >= node.value;
                out.bit(u32::from(node.told));
                low += u32::from(!node.told);
            }
            node.low = low;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_of_the_standard_is_written_bit_for_bit() {
        // Figure B.12 and the text under it: q(0,0) = 1, q(1,0) = 3, q(2,0) = 2 of a 6 x 3 grid.
        let values = [1, 3, 2, 3, 2, 3, 2, 2, 1, 4, 3, 2, 2, 2, 2, 2, 1, 2];
        let mut tree = TagTree::new(6, 3);
        for (i, value) in values.into_iter().enumerate() {
            tree.set(i % 6, i / 6, value);
        }
        let mut out = BitWriter::default();
        tree.tell(0, 0, &mut out);
        assert_eq!(out.text(), "01111");
        let mut out = BitWriter::default();
        tree.tell(1, 0, &mut out);
        assert_eq!(out.text(), "001");
        let mut out = BitWriter::default();
        tree.tell(2, 0, &mut out);
        assert_eq!(out.text(), "101");
    }
}
