//! Meshes: what users hold, how the triangles hang together, and the files they come from.

mod attribute;
mod corners;
pub(crate) mod half_edge;
pub(crate) mod io;
mod polygon_mesh;
mod topology;
mod union;

pub use attribute::{Attribute, AttributeKind, Domain, Label, LabelKind, Scalar};
pub(crate) use corners::Corners;
pub(crate) use half_edge::{HalfEdges, NONE};
pub use io::{Format, Loaded};
pub use polygon_mesh::{Faces, Mesh};
pub use topology::{Inspection, Places};
pub(crate) use union::Union;
