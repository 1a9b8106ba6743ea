//! Sets that are joined one pair at a time (union–find, Tarjan 1975).

/// Numbers `0 .. n`, each in one set.
#[derive(Debug, Clone)]
pub(crate) struct Union {
    parent: Vec<u32>,
}

impl Union {
    /// Every number in a set of its own.
    pub(crate) fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect() }
    }

    /// The number that stands for the set of `x`.
    #[inline]
    pub(crate) fn find(&mut self, mut x: u32) -> u32 {
        while self.parent[x as usize] != x {
            // Halving: every other number on the way skips its parent.
            let up = self.parent[self.parent[x as usize] as usize];
            self.parent[x as usize] = up;
            x = up;
        }
        x
    }

    /// Joins the sets of two numbers; the smaller representative stands for both.
    pub(crate) fn join(&mut self, x: u32, y: u32) {
        let (x, y) = (self.find(x), self.find(y));
        self.parent[x.max(y) as usize] = x.min(y);
    }

    /// For each number that of its set, counted from 0 in order of first members, and how many sets there are.
    pub(crate) fn numbered(mut self) -> (Vec<u32>, usize) {
        let mut sets = 0;
        let mut number = vec![0; self.parent.len()];
        for x in 0..self.parent.len() as u32 {
            let r = self.find(x);
            // The representative is the least of its set, so it comes first.
            number[x as usize] = if r == x {
                sets += 1;
                sets - 1
            } else {
                number[r as usize]
            };
        }
        (number, sets as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_numbers_are_in_one_set() {
        let mut sets = Union::new(6);
        for (x, y) in [(4, 2), (5, 4), (0, 3)] {
            sets.join(x, y);
        }
        assert_eq!(sets.numbered(), (vec![0, 1, 2, 0, 2, 2], 3));
    }
}
