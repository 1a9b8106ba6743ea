//! The queue of gates: which edge of the front the walk crosses next.
//!
//! A front node with few missing edges is closed soon, before a pocket forms around it that the
//! front would have to split at. So the best node has the fewest missing edges; among those, the
//! one whose neighbours have the fewest; among those, the one that changed last.

/// Missing edges of neighbours count up to this.
const NEIGHBOUR_CAP: u32 = 20;
/// Missing edges of the node itself count up to this.
const FREE_CAP: u32 = 14;
/// Keys up to here are ordinary nodes; this one is for the nodes of holes, which come last.
const HOLE: u32 = (FREE_CAP + 1) * (2 * NEIGHBOUR_CAP + 1);
const WORDS: usize = HOLE as usize / 64 + 1;

/// How urgent a node is: small is urgent.
#[inline]
pub(super) fn key(is_hole: bool, free: u32, free_before: u32, free_after: u32) -> u32 {
    if is_hole {
        HOLE
    } else {
        free.min(FREE_CAP) * (2 * NEIGHBOUR_CAP + 1) + free_before.min(NEIGHBOUR_CAP) + free_after.min(NEIGHBOUR_CAP)
    }
}

/// Buckets of nodes by key. A node may stand in several: only the entry with its present key counts.
#[derive(Debug)]
pub(super) struct GateQueue {
    buckets: Vec<Vec<u32>>,
    /// One bit a bucket that may hold something.
    occupied: [u64; WORDS],
}

impl Default for GateQueue {
    fn default() -> Self {
        Self { buckets: vec![Vec::new(); HOLE as usize + 1], occupied: [0; WORDS] }
    }
}

impl GateQueue {
    #[inline]
    pub(super) fn push(&mut self, key: u32, node: u32) {
        self.buckets[key as usize].push(node);
        self.occupied[key as usize / 64] |= 1 << (key % 64);
    }

    /// The most urgent node, left where it is; `is_current` tells whether an entry still counts.
    #[inline]
    pub(super) fn peek(&mut self, is_current: impl Fn(u32, u32) -> bool) -> Option<u32> {
        for word in 0..WORDS {
            while self.occupied[word] != 0 {
                let key = word * 64 + self.occupied[word].trailing_zeros() as usize;
                let bucket = &mut self.buckets[key];
                while let Some(&node) = bucket.last() {
                    if is_current(node, key as u32) {
                        return Some(node);
                    }
                    bucket.pop();
                }
                self.occupied[word] &= self.occupied[word] - 1;
            }
        }
        None
    }
}
