//! Pictures of what a file holds: the planes of an image of vertices, and a shaded view of the mesh.

mod shade;
mod vertex_image;

pub use shade::{Camera, shade};
pub use vertex_image::VertexImage;
