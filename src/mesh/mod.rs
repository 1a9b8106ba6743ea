//! Meshes: what users hold, how the triangles hang together, and the files they come from.

mod attribute;
pub(crate) mod half_edge;
mod inspect;
pub(crate) mod io;
mod polygon_mesh;

pub use attribute::{Attribute, AttributeKind, Domain, Label, LabelKind, Scalar};
pub(crate) use half_edge::HalfEdges;
pub use inspect::Inspection;
pub use io::{Format, Loaded};
pub use polygon_mesh::{Faces, Mesh};
