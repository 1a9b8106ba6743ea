//! Where in the square samples are taken.

use glam::DVec2;

use super::zhou;
use crate::plane::{Gluing, Shape};

/// How samples are spread over the square.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Sampling {
    /// At equal distances.
    #[default]
    Regular,
    /// From there drawn towards where vertices are, in so many rounds (paper 000's baseline, after Zhou et al.).
    Zhou {
        /// Rounds.
        rounds: usize,
    },
    /// On lines between which there are about equally many vertices (paper 000, section 3.1).
    Equalise,
}

impl Sampling {
    /// Zhou et al. with the usual number of rounds.
    pub const ZHOU: Self = Self::Zhou { rounds: 5 };

    /// Points of the square, row by row; rows rise with the first coordinate. `vertices` are those of the surface.
    pub(super) fn points(self, shape: Shape, gluing: Gluing, vertices: impl Fn() -> Vec<DVec2>) -> Vec<DVec2> {
        let (rows, columns) = (shape.height(), shape.width());
        let cross = |rows: Vec<f64>, columns: Vec<f64>| -> Vec<DVec2> {
            rows.iter().flat_map(|&x| columns.iter().map(move |&y| DVec2::new(x, y))).collect()
        };
        match self {
            Self::Regular => cross(regular(rows), regular(columns)),
            Self::Equalise => {
                let vertices = vertices();
                let lines = |n: usize, of: fn(&DVec2) -> f64| equalise(vertices.iter().map(of).collect(), n, gluing);
                cross(lines(rows, |v| v.x), lines(columns, |v| v.y))
            }
            Self::Zhou { rounds } => zhou::draw(cross(regular(rows), regular(columns)), shape, gluing, &vertices(), rounds),
        }
    }
}

/// `n` lines at equal distances from 0 to 1.
fn regular(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64 / (n - 1) as f64).collect()
}

/// `n` lines from 0 to 1: starting with ⌊n/2⌋ equal slabs, the slab with most vertices (the first of several) is halved until there
/// are n − 1. Where the border is glued to itself the lines are symmetric about the middle, so that glued samples are one point.
fn equalise(coordinates: Vec<f64>, n: usize, gluing: Gluing) -> Vec<f64> {
    if gluing == Gluing::Open {
        return halve(coordinates, n / 2, n - 1, 1.0);
    }
    let folded = coordinates.into_iter().map(|x| x.min(1.0 - x)).collect();
    let half = halve(folded, (n / 4).max(1), (n - 1) / 2, 0.5);
    let mirrored = half.iter().rev().skip(1).map(|x| 1.0 - x);
    half.iter().copied().chain(mirrored).collect()
}

/// From `first` equal slabs of `[0, width]` to `last`; the lines between them and both ends.
fn halve(mut coordinates: Vec<f64>, first: usize, last: usize, width: f64) -> Vec<f64> {
    coordinates.sort_unstable_by(f64::total_cmp);
    let below = |x: f64| coordinates.partition_point(|&c| c < x);
    let first = first.clamp(1, last);
    let mut lines: Vec<f64> = (0..=first).map(|i| width * i as f64 / first as f64).collect();
    let mut counts: Vec<usize> = lines.windows(2).map(|w| below(w[1]) - below(w[0])).collect();
    while counts.len() < last {
        let fullest = (0..counts.len()).fold(0, |best, i| if counts[i] > counts[best] { i } else { best });
        let (from, to) = (lines[fullest], lines[fullest + 1]);
        let middle = 0.5 * (from + to);
        let left = below(middle) - below(from);
        lines.insert(fullest + 1, middle);
        counts.insert(fullest + 1, counts[fullest] - left);
        counts[fullest] = left;
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_with_most_vertices_are_halved() {
        // Ten vertices near 0.1, one near 0.9: all halving happens on the left.
        let mut at = vec![0.1; 10];
        at.push(0.9);
        assert_eq!(equalise(at, 5, Gluing::Open), [0.0, 0.125, 0.25, 0.5, 1.0]);
    }

    #[test]
    fn lines_rise_from_0_to_1_and_are_symmetric_where_the_border_is_glued() {
        let at: Vec<f64> = (0..500).map(|i| (f64::from(i) / 500.0).powi(3)).collect();
        for n in [9, 17, 33, 45, 65] {
            for gluing in [Gluing::Open, Gluing::Orbifold] {
                let lines = equalise(at.clone(), n, gluing);
                assert_eq!((lines.len(), lines[0], lines[n - 1]), (n, 0.0, 1.0));
                assert!(lines.windows(2).all(|w| w[0] < w[1]));
                if gluing == Gluing::Orbifold {
                    assert!((0..n).all(|i| (lines[i] + lines[n - 1 - i] - 1.0).abs() < 1e-15));
                }
            }
        }
    }
}
