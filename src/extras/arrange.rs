//! A decoded mesh put into the order that it had.

use crate::mesh::{Faces, Mesh};
use crate::surface::renumber::Renumbering;

/// Bytes of the mesh in its new order.
pub(super) fn memory(vertices: u32, faces: u32, corners: u64) -> u64 {
    24 * u64::from(vertices) + 8 * u64::from(faces) + 4 * corners
}

/// The mesh with vertices, faces and first corners where they were.
pub(super) fn in_order(mut mesh: Mesh, order: &Renumbering) -> Mesh {
    let mut positions = vec![[0.0; 3]; mesh.positions.len()];
    for (position, &old) in mesh.positions.iter().zip(&order.vertices) {
        positions[old as usize] = *position;
    }
    let mut now = vec![0_u32; mesh.faces.len()];
    for (f, &old) in order.faces.iter().enumerate() {
        now[old as usize] = f as u32;
    }
    let (mut faces, mut face) = (Faces::default(), Vec::new());
    for f in now {
        let (corners, turn) = (mesh.faces.get(f as usize), order.turns[f as usize] as usize);
        face.clear();
        face.extend(corners[turn..].iter().chain(&corners[..turn]).map(|&v| order.vertices[v as usize]));
        faces.push(&face);
    }
    (mesh.positions, mesh.faces) = (positions, faces);
    mesh
}
