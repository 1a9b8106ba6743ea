//! The doors of images: a mesh to the streams of an image codec, and back.
//!
//! One of the few rooms that see both wings. On the way in: half-edges → levels → matrix → planes, or index map
//! and base colours. On the way out: planes or map → regions → triangles → mesh.

mod borders;
mod mbcim;
mod planes;
#[cfg(feature = "encode")]
mod rate;

#[cfg(feature = "encode")]
pub(crate) use mbcim::{ImageOptions, write_mbcim};
pub(crate) use mbcim::{cost, read_mbcim};
#[cfg(feature = "encode")]
pub(crate) use planes::{BorderChoice, Draft, NormalPlanes, Written};
pub(crate) use planes::{planes_cost, read_planes};
#[cfg(feature = "encode")]
pub(crate) use rate::{Goal, Target, write_lossy};

#[cfg(feature = "encode")]
use crate::cgim::{Recipe, Search, image};
#[cfg(feature = "encode")]
use crate::error::Result;
#[cfg(feature = "encode")]
use crate::format::RecipeChunk;
#[cfg(feature = "encode")]
use crate::limits::{Budget, Limits};
#[cfg(feature = "encode")]
use crate::mesh::HalfEdges;
#[cfg(feature = "encode")]
use crate::task::Task;

/// An image file before it is packed.
#[cfg(feature = "encode")]
pub(crate) struct Streams {
    /// Chunks, in order.
    pub(crate) chunks: Vec<([u8; 4], Vec<u8>)>,
    /// The triangles as they come back.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The vertex of the mesh that each vertex of them was.
    pub(crate) order: Vec<u32>,
}

/// A decoded mesh on its lattice.
#[derive(Debug)]
pub(crate) struct Decoded {
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) positions: Vec<[i32; 3]>,
    /// The octahedral normal of each vertex, if there are normals.
    pub(crate) normals: Vec<[i32; 2]>,
    /// The image, if the file holds one.
    pub(crate) pixels: Option<Pixels>,
}

/// Which vertex each pixel is.
#[derive(Debug)]
pub(crate) struct Pixels {
    pub(crate) columns: usize,
    /// Row by row; `u32::MAX` where a hole was filled.
    pub(crate) vertices: Vec<u32>,
}

/// Searches for a small image of a mesh as a decoder will have it.
#[cfg(feature = "encode")]
pub(crate) fn search_recipe(mesh: &HalfEdges, search: &Search, task: Task<'_>) -> Result<RecipeChunk> {
    let image = image(mesh, search, &task)?;
    let (rows, columns) = (image.matrix.rows() as u32, image.matrix.columns() as u32);
    Ok(RecipeChunk { rows, columns, recipes: image.recipes.iter().map(Recipe::pack).collect() })
}

#[cfg(feature = "encode")]
fn unlimited() -> Budget {
    Budget::new(Limits::default().memory(u64::MAX).work(u64::MAX).vertices(u64::MAX).pixels(u64::MAX))
}
