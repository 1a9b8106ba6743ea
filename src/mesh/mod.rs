//! Meshes: what users hold, how the triangles hang together, and the files they come from.

mod attribute;
mod boundary;
mod corners;
mod cut;
#[cfg(feature = "encode")]
mod front;
pub(crate) mod half_edge;
pub(crate) mod io;
#[cfg(any(feature = "png", feature = "encode"))]
mod normals;
mod orient;
mod polygon_mesh;
#[cfg(feature = "encode")]
mod region;
mod repair;
mod topology;
mod union;

pub use attribute::{Attribute, AttributeKind, Domain, Label, LabelKind, Scalar};
pub(crate) use boundary::{boundary_loops, close};
pub(crate) use corners::Corners;
pub(crate) use cut::{CutGraph, Paths, part};
#[cfg(feature = "encode")]
pub(crate) use front::Front;
pub(crate) use half_edge::{HalfEdges, NONE, next, prev};
pub use io::{Format, Loaded};
#[cfg(any(feature = "png", feature = "encode"))]
pub(crate) use normals::vertex_normals;
pub use polygon_mesh::{Faces, Mesh};
#[cfg(feature = "encode")]
pub(crate) use region::Region;
pub use repair::{Repair, Repaired};
pub use topology::{Inspection, Places};
pub(crate) use union::Union;
