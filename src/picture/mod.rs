//! Pictures of what a file holds: the planes of an image, what resizing sees, and a shaded view of the mesh.

#[cfg(feature = "exr")]
pub mod grid;
pub mod resize;
mod shade;
mod vertex_image;

pub use shade::{Camera, shade};
pub use vertex_image::VertexImage;
