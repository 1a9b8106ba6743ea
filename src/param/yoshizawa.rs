//! Low stretch by solving again and again (Yoshizawa, Belyaev and Seidel 2004, with η = 1).
//!
//! Weights towards vertices that are stretched much are lowered, so that the next layout draws them apart; at the first layout that is
//! no better than the one before, the best is kept. Two to six solves do it.

use super::Param;
use super::barycentric::Barycentric;
use super::chart::Chart;
use super::weights::{self, Weights};
use crate::error::{Error, Result};
use crate::task::Task;

/// Layouts that are tried at most.
const ROUNDS: usize = 30;

/// The furthest that the stretch of a vertex counts from the usual, either way.
const SPREAD: f64 = 1e4;

/// Lays out the free vertices of a chart.
pub(super) fn lay_out(chart: &mut Chart, param: Param, task: &Task<'_>) -> Result<()> {
    let even = vec![1.0; chart.w.len()];
    match param {
        Param::Tutte => Barycentric::new(chart, true)?.solve(chart, &weights::uniform(chart), &even),
        Param::MeanValue => Barycentric::new(chart, false)?.solve(chart, &weights::mean_value(chart), &even),
        Param::Yoshizawa | Param::Stretch => {
            let system = Barycentric::new(chart, true)?;
            if improve(chart, &system, &weights::symmetric_mean_value(chart), task)?.is_infinite() {
                // Slivers can turn over by rounding; equal weights are the kindest to them.
                improve(chart, &system, &weights::uniform(chart), task)?;
            }
            Ok(())
        }
    }
}

/// Rounds from one set of weights; the least stretch, whose layout the chart keeps.
fn improve(chart: &mut Chart, system: &Barycentric, weights: &Weights, task: &Task<'_>) -> Result<f64> {
    let mut sigma = vec![1.0; chart.w.len()];
    let mut best = (f64::INFINITY, chart.w.clone());
    for round in 0..ROUNDS {
        task.step(round as f64 / ROUNDS as f64)?;
        match system.solve(chart, weights, &sigma) {
            Ok(()) => {}
            // What has been found stands, if only later weights were too wild to solve for.
            Err(Error::NoConvergence { .. }) if best.0.is_finite() => break,
            Err(other) => return Err(other),
        }
        let stretch = chart.stretch();
        if stretch < best.0 || (round == 0 && best.0.is_infinite()) {
            best = (stretch, chart.w.clone());
        } else if best.0.is_finite() {
            break;
        }
        let found = vertex_stretch(chart);
        for (s, f) in sigma.iter_mut().zip(found) {
            *s *= f;
        }
    }
    chart.w = best.1;
    Ok(best.0)
}

/// The stretch around each vertex relative to the median; triangles that are turned over count as stretched very much.
fn vertex_stretch(chart: &Chart) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); chart.w.len()];
    for (f, t) in chart.mesh.triangles().iter().enumerate() {
        let (area, s2) = chart.stretch2(f);
        for &v in t {
            sums[v as usize].0 += area * s2.min(1e12);
            sums[v as usize].1 += area;
        }
    }
    let stretch: Vec<f64> = sums.iter().map(|&(s, a)| if a > 0.0 { (s / a).sqrt() } else { 0.0 }).collect();
    let mut sorted: Vec<f64> = stretch.iter().copied().filter(|&s| s > 0.0).collect();
    if sorted.is_empty() {
        return vec![1.0; stretch.len()];
    }
    let middle = sorted.len() / 2;
    let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    stretch.iter().map(|&s| if s > 0.0 { (s / median).clamp(1.0 / SPREAD, SPREAD) } else { 1.0 }).collect()
}
