//! What users hold: positions, polygons, and whatever else a mesh file said.

use super::attribute::{Attribute, Domain, Label, Scalar};
use crate::error::{Error, MeshDefect, Result};

/// A mesh: vertices, faces with any number of corners, attributes and labels.
///
/// Everything is kept as it was read: the order of vertices, faces and corners, and the values
/// (`f32` values are held as the `f64` of the same value; [`Mesh::precision`] remembers).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions, in the units of the file.
    pub positions: Vec<[f64; 3]>,
    /// The type that the positions had in the file, and that a writer gives them.
    pub precision: Scalar,
    /// The faces.
    pub faces: Faces,
    /// Values on vertices, corners or faces: normals, texture coordinates, colours, anything named.
    pub attributes: Vec<Attribute>,
    /// Named stretches of faces: objects, groups, materials, smoothing groups.
    pub labels: Vec<Label>,
}

/// Faces as lists of vertex indices, counter-clockwise seen from outside.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Faces {
    corners: Vec<u32>,
    /// `ends[f]` is one past the last corner of face `f`.
    ends: Vec<u32>,
}

impl Faces {
    /// Adds a face at the end.
    ///
    /// # Panics
    /// If all faces together would have 2^32 corners.
    pub fn push(&mut self, corners: &[u32]) {
        self.corners.extend_from_slice(corners);
        assert!(self.corners.len() < u32::MAX as usize, "a mesh of more corners than u32 counts");
        self.ends.push(self.corners.len() as u32);
    }

    /// The number of faces.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there are no faces.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The vertices of face `f`, in order.
    ///
    /// # Panics
    /// If there is no face `f`.
    pub fn get(&self, f: usize) -> &[u32] {
        &self.corners[self.range(f)]
    }

    /// Where the corners of face `f` stand among all corners.
    ///
    /// # Panics
    /// If there is no face `f`.
    pub fn range(&self, f: usize) -> std::ops::Range<usize> {
        let start = if f == 0 { 0 } else { self.ends[f - 1] as usize };
        start..self.ends[f] as usize
    }

    /// All faces, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.len()).map(|f| self.get(f))
    }

    /// The vertices of all faces, one face after the other.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// Whether every face has three corners.
    pub fn are_triangles(&self) -> bool {
        self.corners.len() == 3 * self.len() && self.iter().all(|f| f.len() == 3)
    }

    /// The faces as triangles: a polygon becomes the fan from its first corner,
    /// `(0, 1, 2), (0, 2, 3), …`. Faces of fewer than three corners give none.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(self.corners.len().saturating_sub(2 * self.len()));
        for face in self.iter().filter(|f| f.len() >= 3) {
            triangles.extend(face[1..].windows(2).map(|edge| [face[0], edge[0], edge[1]]));
        }
        triangles
    }
}

impl FromIterator<[u32; 3]> for Faces {
    fn from_iter<I: IntoIterator<Item = [u32; 3]>>(triangles: I) -> Self {
        let mut faces = Self::default();
        for t in triangles {
            faces.push(&t);
        }
        faces
    }
}

impl Mesh {
    /// A mesh of triangles and nothing else; `f32` positions if that changes none of them, or else `f64`.
    pub fn from_triangles(positions: Vec<[f64; 3]>, triangles: impl IntoIterator<Item = [u32; 3]>) -> Self {
        let are_single = positions.as_flattened().iter().all(|&x| f64::from(x as f32) == x || x.is_nan());
        let precision = if are_single { Scalar::F32 } else { Scalar::F64 };
        Self { positions, precision, faces: triangles.into_iter().collect(), ..Self::default() }
    }

    /// How many vertices, corners or faces there are.
    pub fn count(&self, domain: Domain) -> usize {
        match domain {
            Domain::Vertex => self.positions.len(),
            Domain::Corner => self.faces.corners().len(),
            Domain::Face => self.faces.len(),
        }
    }

    /// Refuses coordinates that are not finite, and indices, attributes and labels that do not fit the mesh.
    ///
    /// O(vertices + corners + values).
    ///
    /// # Errors
    /// [`Error::Mesh`] with the first such place; [`Error::Parameter`] about an attribute or a label.
    pub fn check(&self) -> Result<()> {
        self.check_references()?;
        match self.positions.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            Some(vertex) => Err(MeshDefect::NonFinite { vertex: vertex as u32 }.into()),
            None => Ok(()),
        }
    }

    /// The part of [`Mesh::check`] that does not look at coordinates.
    pub(crate) fn check_references(&self) -> Result<()> {
        let vertices = self.positions.len() as u64;
        for (face, corners) in self.faces.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&v| u64::from(v) >= vertices) {
                return Err(MeshDefect::IndexOutOfRange { face: face as u32, index: index.into(), vertices }.into());
            }
        }
        if let Some(why) = self.attributes.iter().find_map(|a| a.misfit(self.count(a.domain))) {
            return Err(Error::Parameter(why));
        }
        match self.labels.iter().find(|label| label.first_face as usize > self.faces.len()) {
            Some(label) => Err(Error::Parameter(format!(
                "label `{}` starts at face {}, and there are {} faces",
                label.name,
                label.first_face,
                self.faces.len()
            ))),
            None => Ok(()),
        }
    }
}
