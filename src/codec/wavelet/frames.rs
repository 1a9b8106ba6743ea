//! Local frames: the normal and two tangents of the surface as the coarser level has it (spec/wavelet.md, "Frames").
//!
//! Details of a smooth surface point along its normal, and what lies in the tangent plane matters less to its shape. Frames
//! are made of what a decoder has already: the coarser level, doubled without details.

use super::lifting::{Grid, reach};
use crate::plane::Gluing;

/// Normal and two tangents, each of length 1.
pub(super) type Frame = [[f64; 3]; 3];

const AXES: Frame = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `None` of what has no direction.
fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(a, a).sqrt();
    (length > 0.0).then(|| a.map(|x| x / length))
}

/// The frame at a sample of the grid; the axes where the surface has no normal.
pub(super) fn frame(grid: &Grid, row: usize, column: usize) -> Frame {
    let (width, height, glued) = (grid.shape.width(), grid.shape.height(), grid.gluing != Gluing::Open);
    let own = grid.points[row * width + column];
    // Behind the border of a disk the surface goes on straight, so that the difference there is one-sided.
    let across = |d: isize| {
        let (i, turned) = reach(column as isize + d, width);
        let r = if turned && glued { height - 1 - row } else { row };
        let point = grid.points[r * width + i];
        if turned && !glued { [0, 1, 2].map(|i| 2.0 * own[i] - point[i]) } else { point }
    };
    let down = |d: isize| {
        let (i, turned) = reach(row as isize + d, height);
        let c = if turned && glued { width - 1 - column } else { column };
        let point = grid.points[i * width + c];
        if turned && !glued { [0, 1, 2].map(|i| 2.0 * own[i] - point[i]) } else { point }
    };
    let difference = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let (du, dv) = (difference(across(1), across(-1)), difference(down(1), down(-1)));
    let made = || {
        let normal = unit(cross(du, dv))?;
        let along = dot(du, normal);
        let tangent = unit([0, 1, 2].map(|i| du[i] - along * normal[i]))?;
        Some([normal, tangent, cross(normal, tangent)])
    };
    made().unwrap_or(AXES)
}

/// A vector in a frame.
pub(super) fn into_frame(frame: &Frame, v: [f64; 3]) -> [f64; 3] {
    [dot(frame[0], v), dot(frame[1], v), dot(frame[2], v)]
}

/// And back.
pub(super) fn out_of_frame(frame: &Frame, c: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| c[0] * frame[0][i] + c[1] * frame[1][i] + c[2] * frame[2][i])
}

#[cfg(test)]
mod tests {
    use super::super::lifting::tests::random;
    use super::*;
    use crate::plane::Shape;

    #[test]
    fn frames_are_orthonormal_and_bring_every_vector_back() {
        for gluing in [Gluing::Open, Gluing::Orbifold] {
            let grid = random(33, 17, gluing, 5);
            for (row, column) in (0..17).flat_map(|row| (0..33).map(move |column| (row, column))) {
                let frame = frame(&grid, row, column);
                for i in 0..3 {
                    for j in 0..3 {
                        let wanted = if i == j { 1.0 } else { 0.0 };
                        assert!((dot(frame[i], frame[j]) - wanted).abs() < 1e-12, "row {row}, column {column}");
                    }
                }
                let v = [0.3, -2.0, 1.1];
                let back = out_of_frame(&frame, into_frame(&frame, v));
                assert!((0..3).all(|i| (v[i] - back[i]).abs() < 1e-11));
            }
        }
    }

    #[test]
    fn a_plane_has_its_normal_everywhere_and_a_point_has_the_axes() {
        let points = (0..25).map(|p| [(p % 5) as f64, (p / 5) as f64, 1.0]).collect();
        let mut grid = Grid { shape: Shape::new(5, 5).unwrap(), gluing: Gluing::Open, points };
        for at in 0..25 {
            assert_eq!(frame(&grid, at / 5, at % 5), [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        }
        grid.points.fill([1.0; 3]);
        assert_eq!(frame(&grid, 2, 2), AXES);
    }
}
