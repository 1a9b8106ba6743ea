//! Closed surfaces of genus 0: four cones, and the plane folded about them (Tutte's embedding of orbifolds, Aigerman and Lipman 2015).
//!
//! The square's border is glued to itself: each side is folded about its middle, where a cone sits. Half-turns about the cones
//! carry the square to its neighbours, so that copies of the surface tile the plane without a seam. A tree of edges that joins
//! the cones says where one copy ends and the next begins; walking once around it gives every corner beside the tree the motion
//! ([`Lift`]) by which it sees its vertex. Where the tree runs does not matter for the result, only how it winds about the cones.

use glam::{DVec2, DVec3};

use super::chart::{Chart, Freedom, Lift};
use super::cones::{self, Reach};
use super::sheet::Sheet;
use super::{Param, yoshizawa};
use crate::error::{Error, Result};
use crate::mesh::{CutGraph, HalfEdges, next};
use crate::plane::Gluing;
use crate::task::Task;

/// The cones in the square, counter-clockwise.
const CONES: [DVec2; 4] = [DVec2::new(0.5, 0.0), DVec2::new(1.0, 0.5), DVec2::new(0.5, 1.0), DVec2::new(0.0, 0.5)];

/// Copies of triangles this far outside of the square are kept too.
const MARGIN: f64 = 0.02;

pub(super) fn lay_out(mut sheet: Sheet, param: Param, task: &Task<'_>) -> Result<Chart> {
    // Where the cones are neighbours of each other no tree fits between them; one subdivision makes room.
    let mut room = None;
    for attempt in 0..3 {
        if attempt > 0 {
            sheet = sheet.split(|_| true)?;
        }
        let cones = cones::far_apart(&sheet.mesh, &sheet.positions);
        room = join(&sheet.mesh, &sheet.positions, cones).map(|tree| (cones, tree));
        if room.is_some() {
            break;
        }
    }
    let (cones, tree) = room.ok_or_else(unjoined)?;
    let mut chart = fold(sheet, cones, &tree)?;
    yoshizawa::lay_out(&mut chart, param, task)?;
    Ok(chart)
}

fn unjoined() -> Error {
    Error::Unsupported { what: Error::IMAGE_OF, id: "a closed surface whose cones no tree joins".into() }
}

/// A tree of edges whose leaves are the four cones: the first two joined, then the others to what is there.
fn join(mesh: &HalfEdges, positions: &[DVec3], cones: [u32; 4]) -> Option<CutGraph> {
    let mut tree = CutGraph::empty(mesh);
    let mut inner: Vec<u32> = Vec::new();
    for i in 1..4 {
        let sources = if i == 1 { vec![cones[0]] } else { inner.clone() };
        let reach = Reach::new(mesh, positions, &sources, |v| v == cones[i] || !cones.contains(&v));
        if sources.is_empty() || !reach.distance[cones[i] as usize].is_finite() {
            return None;
        }
        for h in reach.back_from(mesh, cones[i]) {
            tree.mark(mesh, h);
            if !cones.contains(&mesh.from(h)) {
                inner.push(mesh.from(h));
            }
        }
    }
    Some(tree)
}

/// Walks around the tree with the surface on the left and gives each corner its motion.
fn fold(sheet: Sheet, cones: [u32; 4], tree: &CutGraph) -> Result<Chart> {
    let Sheet { mesh, positions, filling } = sheet;
    let mut lifts = vec![[Lift::IDENTITY; 3]; mesh.triangles().len()];
    let mut w = vec![DVec2::splat(0.5); mesh.vertices()];
    let mut freedom = vec![Freedom::Free; mesh.vertices()];
    let count = 3 * mesh.triangles().len() as u32;
    let start = (0..count).find(|&h| tree.has(h)).ok_or_else(unjoined)?;
    let (mut lift, mut met, mut h) = (Lift::IDENTITY, 0, start);
    loop {
        let v = mesh.to(h);
        let mut g = next(h);
        loop {
            lifts[g as usize / 3][g as usize % 3] = lift;
            if tree.has(g) {
                break;
            }
            g = next(mesh.opposite(g).ok_or_else(unjoined)?);
        }
        if cones.contains(&v) {
            let centre = *CONES.get(met).ok_or_else(unjoined)?;
            w[v as usize] = lift.back(centre);
            freedom[v as usize] = Freedom::Fixed;
            lift = lift.then_half_turn(centre);
            met += 1;
        }
        h = g;
        if h == start {
            break;
        }
    }
    // Half-turns about all four corners of a walk around them add up to nothing.
    if met != 4 || lift != Lift::IDENTITY {
        return Err(unjoined());
    }
    Ok(Chart { mesh, positions, filling, gluing: Gluing::Orbifold, seams: None, lifts, w, freedom })
}

/// All copies of the triangles that meet the square, and which triangle each is a copy of.
pub(super) fn unroll(flat: impl Iterator<Item = [DVec2; 3]>) -> (Vec<[DVec2; 3]>, Vec<u32>) {
    let (mut copies, mut origin) = (Vec::new(), Vec::new());
    for (f, triangle) in flat.enumerate() {
        for t in [triangle, triangle.map(|p| 2.0 * CONES[0] - p)] {
            let (lo, hi) = (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]));
            let (first, last) = ((-MARGIN - hi).ceil(), (1.0 + MARGIN - lo).floor());
            for dx in first.x as i64..=last.x as i64 {
                // Translations are products of two half-turns: both coordinates together are even.
                for dy in (first.y as i64..=last.y as i64).filter(|dy| (dx + dy) % 2 == 0) {
                    let by = DVec2::new(dx as f64, dy as f64);
                    copies.push(t.map(|p| p + by));
                    origin.push(f as u32);
                }
            }
        }
    }
    (copies, origin)
}

/// The copy of a point that lies in the square.
pub(super) fn into_square(p: DVec2) -> DVec2 {
    for q in [p, 2.0 * CONES[0] - p] {
        let by = q.floor();
        if (by.x + by.y) as i64 % 2 == 0 {
            return q - by;
        }
    }
    p - p.floor()
}
