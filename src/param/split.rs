//! Splitting edges at their midpoints.

use glam::DVec3;

use crate::error::Result;
use crate::mesh::{HalfEdges, NONE};

/// The surface with a new vertex in the middle of every edge for which `wanted` says so of one of its half-edges: a triangle with 1, 2 or 3
/// of them becomes 2, 3 or 4. For each new triangle also the one that it is a piece of.
pub(crate) fn split_edges(
    mesh: &HalfEdges,
    positions: &[DVec3],
    wanted: impl Fn(u32) -> bool,
) -> Result<(HalfEdges, Vec<DVec3>, Vec<u32>)> {
    let mut middle = vec![NONE; 3 * mesh.triangles().len()];
    let mut positions = positions.to_vec();
    for h in 0..middle.len() as u32 {
        let other = mesh.opposite(h);
        if middle[h as usize] == NONE && (wanted(h) || other.is_some_and(&wanted)) {
            let new = positions.len() as u32;
            positions.push(0.5 * (positions[mesh.from(h) as usize] + positions[mesh.to(h) as usize]));
            middle[h as usize] = new;
            if let Some(g) = other {
                middle[g as usize] = new;
            }
        }
    }
    let (mut triangles, mut origin) = (Vec::with_capacity(mesh.triangles().len()), Vec::new());
    for (f, t) in mesh.triangles().iter().enumerate() {
        let m = [0, 1, 2].map(|k| middle[3 * f + k]);
        let split = m.iter().filter(|&&v| v != NONE).count();
        // Turned so that the edge that differs from the others is the first.
        let odd = (0..3).find(|&k| (m[k] != NONE) == (split == 1)).unwrap_or(0);
        let [a, b, c] = [0, 1, 2].map(|k| t[(odd + k) % 3]);
        let [ab, bc, ca] = [0, 1, 2].map(|k| m[(odd + k) % 3]);
        let before = triangles.len();
        match split {
            0 => triangles.push(*t),
            1 => triangles.extend([[a, ab, c], [ab, b, c]]),
            2 => triangles.extend([[bc, c, ca], [a, b, bc], [a, bc, ca]]),
            _ => triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]),
        }
        origin.resize(origin.len() + triangles.len() - before, f as u32);
    }
    Ok((HalfEdges::new(positions.len(), triangles)?, positions, origin))
}
