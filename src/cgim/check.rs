//! Whether a matrix holds a mesh, and what it takes to say so where it does not.
//!
//! The paper claims that the *edges* are preserved. That is not enough: a cycle of three edges that
//! bounds no triangle may stand in a cell, and two cells may hold one triangle, or hold it turned
//! over (`spec/readings.md`, faces). So the judge here is the multiset of oriented triangles.

use super::vmatrix::VMatrix;

/// The differences between the cells of a matrix and the triangles that it should hold.
/// Both empty for the matrices made here; any other matrix can be stored with them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Escape {
    /// Half-cells (see [`VMatrix::cells`]) whose triangle is to be left out; ascending.
    pub(crate) extra: Vec<u64>,
    /// Triangles that no half-cell holds.
    pub(crate) missing: Vec<[u32; 3]>,
}

#[cfg(test)]
impl Escape {
    pub(crate) fn is_empty(&self) -> bool {
        self.extra.is_empty() && self.missing.is_empty()
    }
}

/// The same oriented triangle, its least vertex first.
pub(crate) fn canonical([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Compares the cells with `triangles`, after `vertex` has been applied to every entry. O(n log n).
pub(crate) fn compare(matrix: &VMatrix, vertex: impl Fn(u32) -> u32, triangles: &[[u32; 3]]) -> Escape {
    let mut found: Vec<([u32; 3], u64)> = matrix.cells().map(|(half, t)| (canonical(t.map(&vertex)), half)).collect();
    let mut wanted: Vec<[u32; 3]> = triangles.iter().copied().map(canonical).collect();
    found.sort_unstable();
    wanted.sort_unstable();
    let mut escape = Escape::default();
    let mut wanted = wanted.into_iter().peekable();
    for (triangle, half) in found {
        while let Some(missing) = wanted.next_if(|w| *w < triangle) {
            escape.missing.push(missing);
        }
        if wanted.next_if_eq(&triangle).is_none() {
            escape.extra.push(half);
        }
    }
    escape.missing.extend(wanted);
    escape.extra.sort_unstable();
    escape
}
