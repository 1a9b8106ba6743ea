//! Neighbours that were coded before, for what is told of vertices and faces one by one.

use crate::mesh::Faces;

/// No vertex, no number.
pub(super) const NONE: u32 = u32::MAX;

/// For each vertex the latest of those before it that a side of a face joins it with.
pub(super) fn latest_neighbours(faces: &Faces, vertices: usize) -> Vec<u32> {
    let mut latest = vec![NONE; vertices];
    for face in faces.iter() {
        for (i, &v) in face.iter().enumerate() {
            let w = face[if i + 1 == face.len() { 0 } else { i + 1 }];
            let (before, after) = (v.min(w), v.max(w) as usize);
            if before < after as u32 && (latest[after] == NONE || latest[after] < before) {
                latest[after] = before;
            }
        }
    }
    latest
}

/// A number of the last face at each vertex.
#[derive(Debug)]
pub(super) struct LastFaces(Vec<u32>);

impl LastFaces {
    pub(super) fn new(vertices: usize) -> Self {
        Self(vec![NONE; vertices])
    }

    pub(super) fn set(&mut self, face: &[u32], number: u32) {
        face.iter().for_each(|&v| self.0[v as usize] = number);
    }

    /// The number that two corners which follow each other have both, else that of the first corner that has any.
    pub(super) fn near(&self, face: &[u32]) -> Option<u32> {
        let last = |i: usize| self.0[face[i % face.len()] as usize];
        let mut found = (0..face.len()).filter(|&i| last(i) != NONE);
        found.clone().find(|&i| last(i) == last(i + 1)).or(found.next()).map(last)
    }
}
