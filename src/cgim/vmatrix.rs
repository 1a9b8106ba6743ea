//! The V-matrix (CGIM §4): a matrix of vertices that holds the triangles of a disk.
//!
//! Four neighbouring entries `a b / d e` stand for the triangles `(a, b, d)` and `(b, e, d)`, each
//! where its three vertices differ. So reading the triangles back is one pass over the cells, and
//! the edges are the horizontal, the vertical and the `b`–`d` ("slash") neighbours.

use crate::plane::{Levels, Step};

/// A matrix of vertices, row after row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct VMatrix {
    columns: usize,
    vertices: Vec<u32>,
}

impl VMatrix {
    /// From the entries, row after row; their number is a multiple of `columns`.
    pub(crate) fn new(columns: usize, vertices: Vec<u32>) -> Self {
        assert!(columns > 0 && vertices.len().is_multiple_of(columns), "{} entries in rows of {columns}", vertices.len());
        Self { columns, vertices }
    }

    pub(crate) fn rows(&self) -> usize {
        self.vertices.len() / self.columns
    }

    pub(crate) fn columns(&self) -> usize {
        self.columns
    }

    /// All entries, row after row.
    pub(crate) fn entries(&self) -> &[u32] {
        &self.vertices
    }

    pub(crate) fn row(&self, i: usize) -> &[u32] {
        &self.vertices[i * self.columns..(i + 1) * self.columns]
    }

    #[cfg(test)]
    /// The triangles of all cells, from left to right and from top to bottom.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.cells().map(|(_, triangle)| triangle)
    }

    /// The triangles of all cells, each with the number of the half-cell that holds it:
    /// twice the index of the entry `a`, plus one for the lower right half.
    pub(crate) fn cells(&self) -> impl Iterator<Item = (u64, [u32; 3])> + '_ {
        self.cells_of(0..self.rows())
    }

    /// The cells between some rows.
    pub(crate) fn cells_of(&self, rows: std::ops::Range<usize>) -> impl Iterator<Item = (u64, [u32; 3])> + '_ {
        (rows.start + 1..rows.end).flat_map(move |i| {
            let (top, bottom) = (self.row(i - 1), self.row(i));
            let first = 2 * ((i - 1) * self.columns) as u64;
            (1..self.columns).flat_map(move |j| {
                let [a, b, d, e] = [top[j - 1], top[j], bottom[j - 1], bottom[j]];
                let half = first + 2 * (j as u64 - 1);
                let upper = (a != b && a != d && b != d).then_some((half, [a, b, d]));
                let lower = (b != e && e != d && b != d).then_some((half + 1, [b, e, d]));
                [upper, lower].into_iter().flatten()
            })
        })
    }

    /// Rows become columns. Every triangle turns over.
    pub(crate) fn transposed(&self) -> Self {
        let (rows, columns) = (self.rows(), self.columns);
        let mut vertices = Vec::with_capacity(self.vertices.len());
        for j in 0..columns {
            vertices.extend((0..rows).map(|i| self.vertices[i * columns + j]));
        }
        Self { columns: rows, vertices }
    }

    /// Turned by half a turn. Every triangle stays as it is.
    pub(crate) fn half_turned(mut self) -> Self {
        self.vertices.reverse();
        self
    }

    /// The rows as levels, and the words that lead from each to the next.
    ///
    /// Where both rows change at once, the upper one goes first, as the cell has it. Where the two go
    /// along a common edge, in whichever order, the step is [`Step::Both`].
    pub(crate) fn levels(&self) -> Levels {
        let mut levels = Levels::default();
        let mut word = Vec::new();
        for i in 0..self.rows() {
            let row = self.row(i);
            levels.push_level(row.chunk_by(|x, y| x == y).map(|run| run[0]));
            if i > 0 {
                word.clear();
                let top = self.row(i - 1);
                // The pair on which the two rows stood before the last step, if the last step was one alone.
                let mut before: Option<[u32; 2]> = None;
                for j in 1..self.columns {
                    for step in [Step::Top, Step::Bottom] {
                        let (from, to) = match step {
                            Step::Top => ([top[j - 1], row[j - 1]], [top[j], row[j - 1]]),
                            _ => ([top[j], row[j - 1]], [top[j], row[j]]),
                        };
                        if from == to {
                            continue;
                        }
                        let other = word.last().is_some_and(|&last| last != step);
                        if other && before.is_some_and(|[t, b]| t == b) && to[0] == to[1] {
                            word.pop();
                            word.push(Step::Both);
                            before = None;
                        } else {
                            word.push(step);
                            before = Some(from);
                        }
                    }
                }
                levels.push_strip(word.iter().copied());
            }
        }
        levels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The matrix at the end of §4.4, with A, B, C … as 0, 1, 2 ….
    fn worked_guide() -> VMatrix {
        let rows = ["ABCDDDE", "AGCDJJE", "AGCDJLE", "FFHIIKK"];
        VMatrix::new(7, rows.concat().bytes().map(|c| u32::from(c - b'A')).collect())
    }

    #[test]
    fn the_matrix_of_the_papers_guide_holds_the_triangles_of_its_figure() {
        let names = |t: [u32; 3]| t.map(|v| char::from(b'A' + v as u8)).iter().collect::<String>();
        let found: Vec<_> = worked_guide().triangles().map(names).collect();
        let expected = ["BGA", "BCG", "DEJ", "JEL", "AGF", "GCF", "CHF", "CDH", "DIH", "DJI", "JLI", "LKI", "LEK"];
        assert_eq!(found, expected);
    }

    #[test]
    fn transposing_turns_the_triangles_over_and_half_a_turn_keeps_them() {
        let canonical = |mut t: [u32; 3]| {
            while t[0] != *t.iter().min().unwrap() {
                t.rotate_left(1);
            }
            t
        };
        let sorted = |m: &VMatrix, flip: bool| {
            let mut all: Vec<_> = m.triangles().map(|[a, b, c]| canonical(if flip { [a, c, b] } else { [a, b, c] })).collect();
            all.sort_unstable();
            all
        };
        let m = worked_guide();
        assert_eq!(sorted(&m, false), sorted(&m.transposed(), true));
        assert_eq!(sorted(&m, false), sorted(&m.clone().half_turned(), false));
    }
}
