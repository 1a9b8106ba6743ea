//! Which entries of a square matrix may differ from zero.

/// The slot of an entry that the matrix does not have.
pub(crate) const NOWHERE: u32 = u32::MAX;

/// The entries of a square matrix, in compressed columns: rows rise within a column.
#[derive(Debug, Clone)]
pub(crate) struct Pattern {
    pub(super) ends: Vec<usize>,
    pub(super) rows: Vec<usize>,
}

impl Pattern {
    /// The pattern of all `(row, column)` and for each the slot of its entry; pairs may repeat. Pairs with a [`NOWHERE`] have no
    /// entry. O(n + pairs log of the longest column).
    pub(crate) fn new(side: usize, pairs: &[(u32, u32)]) -> (Self, Vec<u32>) {
        let real = |&(row, column): &(u32, u32)| row != NOWHERE && column != NOWHERE;
        let mut starts = vec![0_usize; side + 1];
        for &(_, column) in pairs.iter().filter(|&p| real(p)) {
            starts[column as usize + 1] += 1;
        }
        for c in 0..side {
            starts[c + 1] += starts[c];
        }
        let mut next = starts.clone();
        let mut sorted = vec![(0_u32, 0_u32); starts[side]];
        for (i, &(row, column)) in pairs.iter().enumerate().filter(|(_, p)| real(p)) {
            sorted[next[column as usize]] = (row, i as u32);
            next[column as usize] += 1;
        }
        let mut slots = vec![NOWHERE; pairs.len()];
        let (mut ends, mut rows) = (vec![0], Vec::new());
        for c in 0..side {
            let column = &mut sorted[starts[c]..starts[c + 1]];
            column.sort_unstable();
            let mut last = NOWHERE;
            for &(row, i) in column.iter() {
                if row != last {
                    rows.push(row as usize);
                    last = row;
                }
                slots[i as usize] = rows.len() as u32 - 1;
            }
            ends.push(rows.len());
        }
        (Self { ends, rows }, slots)
    }

    /// Rows, and columns.
    pub(crate) fn side(&self) -> usize {
        self.ends.len() - 1
    }

    /// The number of entries.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// `A x` for the matrix of these values; with `symmetric` only its lower triangle is stored.
    pub(crate) fn times(&self, values: &[f64], x: &[f64], symmetric: bool) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for column in 0..self.side() {
            for slot in self.ends[column]..self.ends[column + 1] {
                let row = self.rows[slot];
                y[row] += values[slot] * x[column];
                if symmetric && row != column {
                    y[column] += values[slot] * x[row];
                }
            }
        }
        y
    }

    /// The largest entry of `b − A x`, and of `b`.
    pub(super) fn residual(&self, values: &[f64], x: &[f64], b: &[f64], symmetric: bool) -> (f64, f64) {
        let product = self.times(values, x, symmetric);
        let worst = product.iter().zip(b).map(|(p, b)| (p - b).abs());
        // A maximum that keeps what is no number.
        let largest = |m: f64, x: f64| if x <= m { m } else { x };
        (worst.fold(0.0, largest), b.iter().map(|b| b.abs()).fold(0.0, largest))
    }

    /// Multiplies every row by its factor.
    pub(crate) fn scale_rows(&self, values: &mut [f64], factors: &[f64]) {
        for (value, &row) in values.iter_mut().zip(&self.rows) {
            *value *= factors[row];
        }
    }

    /// Adds this share of the mean of the diagonal to all of it.
    pub(crate) fn raise_diagonal(&self, values: &mut [f64], share: f64) {
        let diagonal = |column: usize| (self.ends[column]..self.ends[column + 1]).find(|&slot| self.rows[slot] == column);
        let slots: Vec<usize> = (0..self.side()).filter_map(diagonal).collect();
        let mean = slots.iter().map(|&s| values[s]).sum::<f64>() / slots.len().max(1) as f64;
        slots.into_iter().for_each(|s| values[s] += share * mean);
    }

    /// The diagonal.
    pub(crate) fn diagonal(&self, values: &[f64]) -> Vec<f64> {
        let entry = |column: usize| (self.ends[column]..self.ends[column + 1]).find(|&slot| self.rows[slot] == column);
        (0..self.side()).map(|column| entry(column).map_or(0.0, |slot| values[slot])).collect()
    }
}
