//! Attributes: values on vertices, corners or faces (spec/attributes.md).
//!
//! Values become integers ([`form`]): as they are, on a lattice, on an octahedron (normals), or as the bits of floats. When all
//! of the mesh is known, a walk over its faces ([`walk`]) meets every corner once. It says whether a corner shares
//! the value of a neighbour across an edge — if not, there is a seam —, and codes values that are new as residuals of what
//! geometry and neighbours suggest ([`guess`]).

pub(crate) mod form;
mod guess;
mod normals;
mod octahedral;
mod residual;
mod walk;

pub(crate) use form::Form;

#[cfg(feature = "encode")]
use crate::entropy::BitWriter;
use crate::entropy::{BitCoder, BitReader};
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::mesh::{AttributeKind, Corners, Domain, Faces, Scalar};

/// No value.
pub(crate) const NONE: u32 = u32::MAX;

/// The mesh that values sit on, as a reader has it before its order is restored.
#[derive(Debug)]
pub(crate) struct Ground<'a> {
    pub(crate) faces: &'a Faces,
    pub(crate) positions: &'a [[i32; 3]],
    corners: Corners,
    /// Where each counted face starts among all corners.
    starts: Vec<u32>,
}

impl<'a> Ground<'a> {
    /// O(n log n) in corners.
    pub(crate) fn new(faces: &'a Faces, positions: &'a [[i32; 3]]) -> Self {
        let corners = Corners::new(positions.len(), faces);
        let mut start = 0;
        let mut all = faces.iter().map(|face| {
            start += face.len() as u32;
            (face.len(), start - face.len() as u32)
        });
        let starts = std::iter::from_fn(|| all.find(|&(n, _)| n >= 3)).map(|(_, start)| start).collect();
        Self { faces, positions, corners, starts }
    }

    /// Bytes of memory that [`Ground::new`] takes for so many corners and faces.
    pub(crate) fn memory(corners: u64, faces: u64) -> u64 {
        48 * corners + 12 * faces
    }

    /// How many elements a domain has.
    pub(crate) fn elements(&self, domain: Domain) -> usize {
        match domain {
            Domain::Vertex => self.positions.len(),
            Domain::Corner => self.faces.corners().len(),
            Domain::Face => self.faces.len(),
        }
    }

    /// The number among all corners that corner `c` of the counted faces has.
    fn corner(&self, c: u32) -> usize {
        let f = self.corners.face(c);
        (self.starts[f as usize] + c - self.corners.first(f)) as usize
    }
}

/// What is known of an attribute before its values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Shape {
    pub(crate) kind: AttributeKind,
    pub(crate) domain: Domain,
    pub(crate) scalar: Scalar,
    pub(crate) form: Form,
    /// Integers a value.
    pub(crate) components: usize,
    /// Whether some elements have no value.
    pub(crate) has_gaps: bool,
}

/// Values as integers, and the one that each element has.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Values {
    /// `components` integers a value.
    pub(crate) integers: Vec<i64>,
    /// By element; [`NONE`] for none.
    pub(crate) of: Vec<u32>,
}

/// Bytes of memory that reading takes beside the ground.
pub(crate) fn memory(elements: u64, vertices: u64, faces: u64, components: u64) -> u64 {
    elements.saturating_mul(components.saturating_mul(8) + 4 + 8 + 16 + 40) + 28 * vertices + 24 * faces + (8 << 20)
}

/// Steps that reading takes.
pub(crate) fn work(elements: u64, components: u64) -> u64 {
    elements.saturating_mul(components.saturating_mul(64) + 64)
}

/// Writes values.
#[cfg(feature = "encode")]
pub(crate) fn write(ground: &Ground<'_>, shape: &Shape, values: &Values) -> Result<Vec<u8>> {
    let mut coder = BitWriter::default();
    walk::walk(&mut coder, ground, shape, values)?;
    Ok(coder.finish())
}

/// Reads what [`write`] wrote. Values come in the order in which they were met.
pub(crate) fn read(bytes: &[u8], ground: &Ground<'_>, shape: &Shape, budget: &mut Budget) -> Result<Values> {
    let (vertices, faces) = (ground.positions.len() as u64, ground.faces.len() as u64);
    let (elements, components) = (ground.elements(shape.domain) as u64, shape.components as u64);
    budget.reserve(memory(elements, vertices, faces, components))?;
    budget.spend(work(elements, components))?;
    walk::walk(&mut BitReader::new(bytes), ground, shape, &Values::default())
}

#[cold]
fn error(why: &str) -> Error {
    Error::malformed(Place::Chunk(*b"ATTR", 0), format!("attributes: {why}"))
}

/// Refuses a stream that has ended.
fn check<C: BitCoder>(coder: &C) -> Result<()> {
    if coder.is_exhausted() { Err(error("the stream ends too soon")) } else { Ok(()) }
}
