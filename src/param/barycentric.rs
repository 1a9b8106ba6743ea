//! Each free vertex in a weighted mean of its neighbours (Tutte 1963, Floater 1997): one sparse system for both coordinates.
//!
//! With positive weights and a convex border, or on an orbifold, no triangle is turned over: it is a theorem, up to rounding.

use glam::DVec2;

use super::chart::{Chart, Freedom};
use super::weights::Weights;
use crate::error::Result;
use crate::sparse::{Cholesky, General, NOWHERE, Pattern};

/// The unknowns of a chart and the pattern of their system.
pub(super) struct Barycentric {
    /// For each vertex its unknown.
    unknown: Vec<u32>,
    count: usize,
    /// For each corner's two entries, in the order of [`Weights`].
    slots: Vec<u32>,
    diagonal: Vec<u32>,
    solver: Solver,
}

enum Solver {
    Symmetric(Cholesky),
    General(General),
}

impl Barycentric {
    /// For weights of both directions of an edge that are equal (`symmetric`), or for any.
    pub(super) fn new(chart: &Chart, symmetric: bool) -> Result<Self> {
        let mut unknown = vec![NOWHERE; chart.w.len()];
        let mut count = 0;
        for (v, freedom) in chart.freedom.iter().enumerate() {
            if *freedom == Freedom::Free && chart.mesh.outgoing(v as u32).is_some() {
                unknown[v] = count;
                count += 1;
            }
        }
        let mut pairs = Vec::with_capacity(6 * chart.faces() + count as usize);
        for t in chart.mesh.triangles() {
            for k in 0..3 {
                for o in 1..3 {
                    let (row, column) = (unknown[t[k] as usize], unknown[t[(k + o) % 3] as usize]);
                    // Of a symmetric matrix only the lower triangle is kept.
                    pairs.push(if symmetric && row < column { (NOWHERE, NOWHERE) } else { (row, column) });
                }
            }
        }
        pairs.extend((0..count).map(|i| (i, i)));
        let (pattern, mut slots) = Pattern::new(count as usize, &pairs);
        let diagonal = slots.split_off(6 * chart.faces());
        let solver =
            if symmetric { Solver::Symmetric(Cholesky::new(pattern)?) } else { Solver::General(General::new(pattern)?) };
        Ok(Self { unknown, count: count as usize, slots, diagonal, solver })
    }

    /// Lays the chart out with these weights, each divided by its neighbour's `stretch`: w/σ. Where the weights themselves are
    /// symmetric, so is the system once each row is divided by its own vertex's stretch too.
    pub(super) fn solve(&self, chart: &mut Chart, weights: &Weights, stretch: &[f64]) -> Result<()> {
        let pattern = match &self.solver {
            Solver::Symmetric(cholesky) => cholesky.pattern(),
            Solver::General(general) => general.pattern(),
        };
        let mut values = vec![0.0; pattern.len()];
        let mut right = vec![DVec2::ZERO; self.count];
        let mut sums = vec![0.0; self.count];
        for (f, t) in chart.mesh.triangles().iter().enumerate() {
            for k in 0..3 {
                let row = self.unknown[t[k] as usize];
                if row == NOWHERE {
                    continue;
                }
                let here = chart.lift(f, k);
                for o in 0..2 {
                    let l = (k + o + 1) % 3;
                    let (there, v) = (chart.lift(f, l), t[l] as usize);
                    let weight = weights[f][k][o] / stretch[v];
                    sums[row as usize] += weight;
                    let sign = here.sign * there.sign;
                    right[row as usize] += weight * here.sign * (there.shift - here.shift);
                    if self.unknown[v] == NOWHERE {
                        right[row as usize] += weight * sign * chart.w[v];
                    } else if self.slots[6 * f + 2 * k + o] != NOWHERE {
                        values[self.slots[6 * f + 2 * k + o] as usize] -= weight * sign;
                    }
                }
            }
        }
        // Each row is scaled by its vertex's stretch, which keeps symmetry, or by its sum.
        let mut scale: Vec<f64> = sums.iter().map(|s| 1.0 / s).collect();
        if let Solver::Symmetric(_) = self.solver {
            self.unknown.iter().zip(stretch).filter(|u| *u.0 != NOWHERE).for_each(|(&u, s)| scale[u as usize] = 1.0 / s);
        }
        for i in 0..self.count {
            values[self.diagonal[i] as usize] += sums[i];
            right[i] *= scale[i];
        }
        pattern.scale_rows(&mut values, &scale);
        let mut columns: Vec<f64> = right.iter().map(|r| r.x).chain(right.iter().map(|r| r.y)).collect();
        match &self.solver {
            Solver::Symmetric(cholesky) => cholesky.solve(&values, &mut columns)?,
            Solver::General(general) => general.solve(&values, &mut columns)?,
        }
        for (v, &u) in self.unknown.iter().enumerate().filter(|x| *x.1 != NOWHERE) {
            chart.w[v] = DVec2::new(columns[u as usize], columns[self.count + u as usize]);
        }
        Ok(())
    }
}
