//! Where holes begin: samples beside a hole are drawn onto its edge, so that what is left ends where the surface does.

use glam::DVec2;

use crate::geom::{Bvh, Triangle};
use crate::param::Chart;
use crate::plane::Mask;

/// The edges between the surface and what fills its holes, in the square.
pub(super) struct Rim {
    edges: Bvh,
}

impl Rim {
    /// Of the copies that cover the square; none if the surface has no filling.
    pub(super) fn new(chart: &Chart, cover: &[[DVec2; 3]], origin: &[u32]) -> Option<Self> {
        let mut edges: Vec<Triangle> = Vec::new();
        for (copy, &face) in cover.iter().zip(origin).filter(|(_, face)| !chart.is_filling(**face as usize)) {
            for k in 0..3 {
                let across = chart.mesh.opposite(3 * face + k as u32);
                if across.is_some_and(|g| chart.is_filling(g as usize / 3)) {
                    let (a, b) = (copy[k].extend(0.0), copy[(k + 1) % 3].extend(0.0));
                    edges.push([a, b, b]);
                }
            }
        }
        (!edges.is_empty()).then(|| Self { edges: Bvh::new(&edges) })
    }

    /// Moves the samples that have both a hole and surface around them to the nearest point of the rim.
    pub(super) fn draw(&self, points: &mut [DVec2], holes: &Mask) {
        let (rows, columns) = (holes.shape().height(), holes.shape().width());
        let mut hint = 0;
        for (at, point) in points.iter_mut().enumerate() {
            let (row, column) = (at / (columns + 1), at % (columns + 1));
            let around = (row.saturating_sub(1)..=row.min(rows - 1))
                .flat_map(|r| (column.saturating_sub(1)..=column.min(columns - 1)).map(move |c| (r, c)));
            let (mut all, mut any) = (true, false);
            for (r, c) in around {
                all &= holes.contains(r, c);
                any |= holes.contains(r, c);
            }
            // What lies on the border of the square stays there: it may be glued.
            let on_border = row == 0 || column == 0 || row == rows || column == columns;
            if all || !any || on_border {
                continue;
            }
            let Some(hit) = self.edges.closest(point.extend(0.0), hint) else { continue };
            hint = hit.slot;
            let [a, b, _] = self.edges.triangles()[hit.slot as usize].map(|p| p.truncate());
            let along = (b - a).length_squared();
            let t = if along > 0.0 { ((*point - a).dot(b - a) / along).clamp(0.0, 1.0) } else { 0.0 };
            *point = a.lerp(b, t);
        }
    }
}
