//! Disks: the boundary loop goes around the square's border (Gu, Gortler and Hoppe 2002).
//!
//! An inner edge between two vertices of the boundary ("chord") would lie on a side of the square together with what it cuts off, so
//! it is split in the middle first; that also takes care of ears.

use glam::DVec2;

use super::chart::{Chart, Freedom};
use super::sheet::Sheet;
use super::{Param, yoshizawa};
use crate::error::Result;
use crate::mesh::boundary_loops;
use crate::plane::Gluing;
use crate::task::Task;

/// No edge of the boundary counts as shorter than this share of their mean.
const SHORTEST: f64 = 1e-3;

/// Places of the first corner that are tried, evenly over a side, on surfaces of so many triangles at most.
const STARTS: usize = 4;
const TURNED: usize = 200_000;

/// A start is taken if its stretch is below this share of the best before: less says nothing of distances.
const WORTH: f64 = 0.95;

const SQUARE: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];

pub(super) fn lay_out(sheet: Sheet, param: Param, task: &Task<'_>) -> Result<Chart> {
    let Sheet { mesh, positions, filling } = prepare(sheet)?;
    let w = vec![DVec2::splat(0.5); positions.len()];
    let freedom = vec![Freedom::Free; positions.len()];
    let mut chart = Chart { mesh, positions, filling, gluing: Gluing::Open, seams: None, lifts: Vec::new(), w, freedom };
    let mut best: Option<(f64, Chart)> = None;
    for start in 0..rounds(param, chart.faces()) {
        pin(&mut chart, start as f64 / (4 * STARTS) as f64);
        yoshizawa::lay_out(&mut chart, param, task)?;
        let stretch = chart.stretch();
        if best.as_ref().is_none_or(|(least, _)| stretch < WORTH * *least) {
            best = Some((stretch, chart.clone()));
        }
    }
    Ok(best.map_or(chart, |(_, chart)| chart))
}

/// How many places of the first corner are tried. Which vertices become corners matters by decibels.
pub(super) fn rounds(param: Param, faces: usize) -> usize {
    if matches!(param, Param::Yoshizawa | Param::Stretch) && faces <= TURNED { STARTS } else { 1 }
}

/// Splits what could not lie in a square: chords, and boundary loops that are too short to have four sides.
pub(super) fn prepare(mut sheet: Sheet) -> Result<Sheet> {
    while boundary_loops(&sheet.mesh).first().is_some_and(|around| around.len() < 4) {
        sheet = sheet.split(|_| true)?;
    }
    let mesh = &sheet.mesh;
    let chord = |h: u32| mesh.opposite(h).is_some() && mesh.is_boundary(mesh.from(h)) && mesh.is_boundary(mesh.to(h));
    if (0..3 * mesh.triangles().len() as u32).any(chord) { sheet.split(chord) } else { Ok(sheet) }
}

/// The point of the square's border after so many of its sides.
pub(super) fn at_border(sides: f64) -> DVec2 {
    let side = sides.floor();
    let corner = |k: f64| SQUARE[k.rem_euclid(4.0) as usize];
    corner(side).lerp(corner(side + 1.0), sides - side)
}

/// Puts the boundary onto the square by length, the first corner after this share of the loop's vertices.
fn pin(chart: &mut Chart, start: f64) {
    let Some(around) = boundary_loops(&chart.mesh).into_iter().next() else { return };
    let count = around.len();
    let start = (start * count as f64) as usize;
    let vertices: Vec<u32> = (0..count).map(|i| chart.mesh.from(around[(start + i) % count])).collect();
    let at = |i: usize| chart.positions[vertices[i % count] as usize];
    let lengths: Vec<f64> = (0..count).map(|i| at(i).distance(at(i + 1))).collect();
    let least = (SHORTEST * lengths.iter().sum::<f64>() / count as f64).max(f64::MIN_POSITIVE);
    let mut reach = vec![0.0];
    for length in lengths {
        reach.push(reach[reach.len() - 1] + length.max(least));
    }
    let corners = corners(&reach);
    for side in 0..4 {
        let (first, last) = (corners[side], corners[side + 1]);
        for i in first..last {
            let v = vertices[i] as usize;
            let share = (reach[i] - reach[first]) / (reach[last] - reach[first]);
            chart.w[v] = SQUARE[side] + share * (SQUARE[(side + 1) % 4] - SQUARE[side]);
            chart.freedom[v] = if i == first { Freedom::Fixed } else { Freedom::Along(side as u8 % 2) };
        }
    }
}

/// Which vertices of the loop become corners: those nearest to the quarters of its length, all different.
fn corners(reach: &[f64]) -> [usize; 5] {
    let count = reach.len() - 1;
    let mut corners = [0, 0, 0, 0, count];
    for k in 1..4 {
        let goal = reach[count] * k as f64 / 4.0;
        let after = reach.partition_point(|&r| r < goal);
        let nearest = if after > 0 && goal - reach[after - 1] <= reach[after] - goal { after - 1 } else { after };
        corners[k] = nearest.clamp(corners[k - 1] + 1, count - (4 - k));
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_at_the_quarters_and_always_differ() {
        assert_eq!(corners(&[0.0, 1.0, 2.0, 3.0, 4.0]), [0, 1, 2, 3, 4]);
        assert_eq!(corners(&[0.0, 100.0, 101.0, 102.0, 103.0]), [0, 1, 2, 3, 4]);
        assert_eq!(corners(&[0.0, 1.0, 2.0, 3.0, 100.0]), [0, 1, 2, 3, 4]);
        assert_eq!(corners(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]), [0, 2, 4, 6, 8]);
    }
}
