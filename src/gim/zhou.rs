//! Samples drawn towards vertices: our reading of the baseline that paper 000 names after Zhou et al. (`spec/readings.md`).
//!
//! In each round the vertices in every square of four samples are counted, and each inner sample moves to the mean of its eight
//! neighbours, weighted by one plus the vertices in the squares that touch the neighbour. Samples of the border move along their
//! side, where the border is not glued; corners stay. A move that would turn a square over is halved until it does not, or dropped.

use glam::DVec2;

use crate::geom::Bvh;
use crate::plane::{Gluing, Shape};

/// Halvings of a move before it is dropped.
const HALVINGS: usize = 4;

pub(super) fn draw(points: Vec<DVec2>, shape: Shape, gluing: Gluing, vertices: &[DVec2], rounds: usize) -> Vec<DVec2> {
    let mut points = points;
    for _ in 0..rounds {
        let weights = weights(&points, shape, vertices);
        for row in 0..shape.height() {
            for column in 0..shape.width() {
                move_one(&mut points, &weights, shape, gluing, row, column);
            }
        }
    }
    points
}

/// For each sample one plus the number of vertices in the squares that touch it.
fn weights(points: &[DVec2], shape: Shape, vertices: &[DVec2]) -> Vec<f64> {
    let (width, height) = (shape.width(), shape.height());
    let corner = |row: usize, column: usize| points[row * width + column].extend(0.0);
    let mut triangles = Vec::with_capacity(2 * (width - 1) * (height - 1));
    for row in 0..height - 1 {
        for column in 0..width - 1 {
            let [a, b, c, d] =
                [corner(row, column), corner(row, column + 1), corner(row + 1, column + 1), corner(row + 1, column)];
            triangles.extend([[a, d, c], [a, c, b]]);
        }
    }
    let tree = Bvh::new(&triangles);
    let mut weights = vec![1.0; points.len()];
    let mut hint = 0;
    for v in vertices {
        let Some(hit) = tree.closest(v.extend(0.0), hint) else { continue };
        hint = hit.slot;
        let square = tree.id(hit.slot) as usize / 2;
        let (row, column) = (square / (width - 1), square % (width - 1));
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            weights[(row + i) * width + column + j] += 1.0;
        }
    }
    weights
}

fn move_one(points: &mut [DVec2], weights: &[f64], shape: Shape, gluing: Gluing, row: usize, column: usize) {
    let (last_row, last_column) = (shape.height() - 1, shape.width() - 1);
    let (on_row, on_column) = (row == 0 || row == last_row, column == 0 || column == last_column);
    if (on_row && on_column) || ((on_row || on_column) && gluing != Gluing::Open) {
        return;
    }
    let (mut sum, mut total) = (DVec2::ZERO, 0.0);
    for i in row.saturating_sub(1)..=(row + 1).min(last_row) {
        for j in column.saturating_sub(1)..=(column + 1).min(last_column) {
            // On a side, only its own samples draw.
            let here = (i, j) == (row, column) || (on_row && i != row) || (on_column && j != column);
            if !here {
                let weight = weights[i * shape.width() + j];
                sum += weight * points[i * shape.width() + j];
                total += weight;
            }
        }
    }
    let at = row * shape.width() + column;
    let (from, goal) = (points[at], sum / total);
    for halving in 0..HALVINGS {
        points[at] = from + (goal - from) * 0.5_f64.powi(halving as i32);
        if upright(points, shape, row, column) {
            return;
        }
    }
    points[at] = from;
}

/// Whether the squares that touch a sample are convex and not turned over.
pub(super) fn upright(points: &[DVec2], shape: Shape, row: usize, column: usize) -> bool {
    let p = |i: usize, j: usize| points[i * shape.width() + j];
    let positive = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a) > 0.0;
    (row.saturating_sub(1)..=row.min(shape.height() - 2)).all(|i| {
        (column.saturating_sub(1)..=column.min(shape.width() - 2)).all(|j| {
            let (a, b, c, d) = (p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1));
            positive(a, b, c) && positive(b, c, d) && positive(c, d, a) && positive(d, a, b)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_gather_where_vertices_are_and_no_square_turns_over() {
        let side = 17;
        let shape = Shape::new(17, 17).unwrap();
        let regular: Vec<DVec2> =
            (0..side * side).map(|i| DVec2::new((i / side) as f64, (i % side) as f64) / (side - 1) as f64).collect();
        // A crowd of vertices by the middle of the first row.
        let vertices: Vec<DVec2> =
            (0..400).map(|i| DVec2::new(0.005 * f64::from(i % 20), 0.45 + 0.005 * f64::from(i / 20))).collect();
        let near = |points: &[DVec2]| points.iter().filter(|p| p.distance(DVec2::new(0.05, 0.5)) < 0.15).count();
        for gluing in [Gluing::Open, Gluing::Orbifold] {
            let drawn = draw(regular.clone(), shape, gluing, &vertices, 5);
            assert!(near(&drawn) > near(&regular));
            assert!((0..side).all(|i| (0..side).all(|j| upright(&drawn, shape, i, j))));
            let border = |i: usize| [i / side, i % side].iter().any(|&x| x == 0 || x == side - 1);
            let still = (0..side * side).filter(|&i| border(i)).all(|i| drawn[i] == regular[i]);
            assert_eq!(still, gluing == Gluing::Orbifold);
        }
    }
}
