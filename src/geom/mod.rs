//! Plain geometry in f64: boxes, triangles, and trees that find what is near.
//!
//! Nothing here knows of meshes: triangles come as three points each.

mod aabb;
#[allow(dead_code)] // until the floors above move in
mod bvh;
#[allow(dead_code)]
mod points;
#[allow(dead_code)]
mod triangle;

pub(crate) use aabb::Aabb;
pub(crate) use bvh::{Bvh, Hit};
#[allow(unused_imports)] // what asks which points are near
pub(crate) use points::PointTree;
#[cfg(feature = "encode")]
pub(crate) use triangle::PLACES;
#[allow(unused_imports)] // floors above ask for the point and its feature
pub(crate) use triangle::{Closest, Feature, Triangle, distance2};
