//! Triangle meshes as compact, certified files.
//!
//! The connectivity comes back exactly, every vertex within a bound that the file states:
//!
//! ```
//! let mesh = gimc::Mesh::open("corpus/meshes/sphere.ply")?;
//! let bytes = gimc::EncodeOptions::cgim().bits(12).encode(&mesh)?;
//! let file = gimc::Decoder::new(&bytes)?; // header read and checked, nothing large allocated
//! println!("{} faces, within {}", file.info().faces, file.info().bound);
//! let back = file.decode()?;
//! # assert_eq!(back.faces.len(), mesh.faces.len());
//! # Ok::<(), gimc::Error>(())
//! ```
//!
//! [`Mesh`] reads and writes OBJ, PLY, OFF, STL and GLB; [`EncodeOptions`] says how exact and how small; [`Decoder`] holds to
//! [`Limits`]; [`Task`] watches and stops long calls; [`eval`] measures. The program `gimc` is a thin skin over these.
//!
//! # The picture
//!
//! Imports only point down; `tests/it/layers.rs` holds the table and fails when one does not.
//!
//! ```text
//!  6  main.rs  cli                      talks: flags, stderr, exit codes. Computes nothing.
//!  5  eval  picture                     every measure, the same-connectivity question, sweeps, reports
//!  4  encode  decode  options           the two doors; the only files that see both wings
//!     images  extras  charts  judge     what both of them say
//!     ─────────────────────────────┬──────────────────────────────────────────────
//!       SURFACE WING               │            BYTE WING
//!       (never sees a byte)        │            (never sees a triangle)
//!  3  surface ── names both ───────┼─────────── mesh and entropy
//!     cgim  gim  resize            │   format
//!  2  mesh  distance  param        │   codec  entropy
//!     ─────────────────────────────┴──────────────────────────────────────────────
//!  1  plane                             the hall: lattice, planes
//!  0  geom  sparse                 │   bits
//!     error  limits  task  par          the ground: imports nothing above
//! ```

#[cfg_attr(not(feature = "encode"), allow(dead_code, unused_imports))] // its writing half
mod bits;
#[cfg_attr(not(feature = "encode"), allow(dead_code, unused_imports))] // its writing half
mod cgim;
#[cfg_attr(not(feature = "encode"), allow(dead_code, unused_imports))] // its writing half
mod charts;
#[cfg_attr(not(feature = "encode"), allow(dead_code, unused_imports))] // its writing half
mod codec;
mod decode;
mod distance;
#[cfg(feature = "encode")]
mod encode;
#[cfg_attr(not(feature = "encode"), allow(dead_code, unused_imports))] // its writing half
mod entropy;
mod error;
pub mod eval;
#[cfg_attr(not(feature = "encode"), allow(dead_code, unused_imports))] // its writing half
mod extras;
#[cfg_attr(not(feature = "encode"), allow(dead_code, unused_imports))] // its writing half
mod format;
mod geom;
#[cfg(feature = "encode")]
mod gim;
#[cfg_attr(not(feature = "encode"), allow(dead_code, unused_imports))] // its writing half
mod images;
#[cfg(feature = "encode")]
mod judge;
mod limits;
#[cfg_attr(not(feature = "encode"), allow(dead_code, unused_imports))] // its writing half
mod mesh;
#[cfg(feature = "encode")]
mod options;
mod par;
#[cfg(feature = "encode")]
mod param;
#[cfg(all(feature = "png", feature = "encode"))]
pub mod picture;
#[cfg_attr(not(feature = "encode"), allow(dead_code, unused_imports))] // its writing half
mod plane;
#[cfg(feature = "encode")]
mod resize;
#[cfg(feature = "encode")]
mod sparse;
#[cfg_attr(not(feature = "encode"), allow(dead_code, unused_imports))] // its writing half
mod surface;
mod task;

pub use decode::{AttributeInfo, ChunkInfo, Decoder, Info, RoiInfo};
#[cfg(feature = "encode")]
pub use encode::Encoded;
pub use error::{Error, MeshDefect, Place, Result};
pub use limits::Limits;
pub use mesh::{
    Attribute, AttributeKind, Domain, Faces, Format, Inspection, Label, LabelKind, Loaded, Mesh, Places, Repair, Repaired,
    Scalar,
};
#[cfg(feature = "encode")]
pub use options::{
    Accuracy, Adjust, AttributeChoices, Border, Boundaries, Closer, Codec, EncodeOptions, GimChoices, Grid, ImageChoices,
    J2kChoices, Method, Metric, Param, Precision, Quality, Roi, RoiPlace, Sampling,
};
pub use par::with_threads;
pub use plane::{GeometryImage, Gluing, Lattice};
#[cfg(feature = "encode")]
pub use resize::{ResizeMethod, ResizeOptions, Resized};
pub use surface::Effort;
pub use task::Task;

/// Meshes sampled anew as geometry images, with every part of the chain to be chosen alone; no file is involved.
#[cfg(feature = "encode")]
pub mod resample {
    pub use crate::gim::{Adjustment, Border, Param, Resample, Sampling};
}

/// Doors into single rooms, for fuzzers. No part of the interface: they may change at any time.
#[cfg(all(feature = "inner", feature = "encode"))]
#[doc(hidden)]
pub mod inner {
    pub use crate::codec::j2k::trial as j2k;
    pub use crate::codec::wavelet::trial as wavelet;
}
