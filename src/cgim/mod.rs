//! Connectivity-preserving geometry images (paper 002): a mesh as a matrix of its vertices.
//!
//! ```text
//!  disk ─ stratify ─▶ levels ─ align ─▶ V-matrix ─ shrink ─▶ V-matrix ─ check
//! ```
//!
//! One file for each section of the paper: [`stratify`] §4.1 and §4.3, [`align`] and
//! [`paper`] §4.1, [`vmatrix`] §4, [`shrink`] §5.1, [`runs`] and [`cluster`] §5.2.
//! Where ours departs from the paper, `spec/readings.md` says why and names the test that shows it.

mod align;
mod check;
mod cluster;
#[cfg(test)]
mod cluster_tests;
mod open;
mod paper;
#[cfg(test)]
mod random_meshes;
mod rebuild;
mod regions;
mod rng;
mod room;
mod runs;
mod search;
mod shrink;
mod side;
mod stack;
mod stratify;
#[cfg(test)]
mod surface_tests;
#[cfg(test)]
mod sweep_tests;
mod vmatrix;
mod words;

pub(crate) use align::{Contact, align, width};
pub(crate) use cluster::cluster;
pub(crate) use open::Recipe;
pub(crate) use rebuild::{BYTES_A_TRIANGLE, Rebuilt, STEPS_A_TRIANGLE, matrix_triangles, rebuild, word_triangles};
pub(crate) use regions::{regions, straight, walls};
pub(crate) use runs::run_counts;
pub(crate) use search::Search;
pub(crate) use stack::{Image, image, image_again};
pub(crate) use vmatrix::VMatrix;
pub(crate) use words::words;
