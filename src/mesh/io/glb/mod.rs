//! GLB, the binary form of glTF 2.0: a JSON scene and a block of numbers.
//!
//! Read: all triangles of the default scene, in the order of its nodes, with normals, texture
//! coordinates, colours and the file's own attributes (`_NAME`). Nodes are objects, names of
//! materials are labels; pictures, animations and what else a scene has is noted. Where a node has
//! a transform it is applied to its vertices.
//!
//! glTF has one index for all attributes of a vertex, so that a file must hold a vertex twice where
//! its two sides have different texture coordinates, or different materials. Such vertices (same
//! object and place, other attributes or another primitive) become one again, with attributes on
//! corners. Vertices of one primitive that are the same in everything stay apart, as they do in
//! other formats. Triangles without indices are a soup: there all corners at the same place are one
//! vertex.
//!
//! Written: one mesh for each object, one primitive for each of its materials, positions as `f32`.
//! Faces are therefore sorted by material, and vertices by primitive.
//!
//! The crate `gltf` was looked at for reading; its container reader overflows on a header that
//! announces less than itself, and it decodes accessors without limits. The JSON is parsed by
//! `serde_json`, and everything it says is checked here before it is followed.

mod accessor;
mod container;
mod read;
mod scene;
mod weld;
mod write;

pub(super) use read::read;
pub(super) use write::write;

#[cfg(test)]
mod tests;
