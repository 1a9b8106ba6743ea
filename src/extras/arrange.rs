//! A decoded mesh put into another order.

use crate::mesh::{Domain, Faces};
use crate::surface::attributes::{NONE, Values};

/// Where vertices and faces go.
#[derive(Debug, Default)]
pub(super) struct Arrangement {
    /// The new number of each vertex; empty if they stay.
    pub(super) vertices: Vec<u32>,
    /// The old number of each face.
    pub(super) faces: Vec<u32>,
    /// By old face: which corner becomes the first; empty if all stay.
    pub(super) turns: Vec<u32>,
}

/// Bytes of the mesh in its new order.
pub(super) fn memory(vertices: u32, faces: u32, corners: u64) -> u64 {
    24 * u64::from(vertices) + 8 * u64::from(faces) + 4 * corners
}

impl Arrangement {
    fn turn(&self, f: u32) -> usize {
        self.turns.get(f as usize).map_or(0, |&turn| turn as usize)
    }

    pub(super) fn positions(&self, old: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
        if self.vertices.is_empty() {
            return old;
        }
        let mut positions = vec![[0.0; 3]; old.len()];
        for (position, &new) in old.iter().zip(&self.vertices) {
            positions[new as usize] = *position;
        }
        positions
    }

    pub(super) fn faces(&self, old: &Faces) -> Faces {
        let number = |&v: &u32| self.vertices.get(v as usize).copied().unwrap_or(v);
        let (mut faces, mut face) = (Faces::default(), Vec::new());
        for &f in &self.faces {
            let (corners, turn) = (old.get(f as usize), self.turn(f));
            face.clear();
            face.extend(corners[turn..].iter().chain(&corners[..turn]).map(number));
            faces.push(&face);
        }
        faces
    }

    /// Values of elements go where the elements go. `faces` are the old ones.
    pub(super) fn values(&self, domain: Domain, faces: &Faces, values: &mut Values) {
        let old = std::mem::take(&mut values.of);
        values.of = match domain {
            Domain::Vertex if self.vertices.is_empty() => old,
            Domain::Vertex => {
                let mut of = vec![NONE; old.len()];
                for (&value, &new) in old.iter().zip(&self.vertices) {
                    of[new as usize] = value;
                }
                of
            }
            Domain::Face => self.faces.iter().map(|&f| old[f as usize]).collect(),
            Domain::Corner => {
                let mut of = Vec::with_capacity(old.len());
                for &f in &self.faces {
                    let (range, turn) = (faces.range(f as usize), self.turn(f));
                    let corners = &old[range];
                    of.extend(corners[turn..].iter().chain(&corners[..turn]));
                }
                of
            }
        };
    }
}
