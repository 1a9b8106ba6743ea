//! What makes a file of a mesh and reads it again.

use super::SweepMesh;
use crate::decode::Decoder;
use crate::error::Result;
use crate::mesh::{Mesh, Repair};
use crate::options::{EncodeOptions, Method, Quality};
use crate::task::Task;

/// What makes a file of a mesh and reads it again.
pub trait Coder: Send + Sync {
    /// The program and its version: points of another version are not those of this one.
    fn program(&self) -> String;

    /// How the mesh is kept: `cgim`, `gim`, or `peer` for other programs.
    fn method(&self) -> String;

    /// How it becomes bytes.
    fn codec(&self) -> String;

    /// About how long a point takes in comparison with others; only progress depends on it.
    fn weight(&self) -> f64 {
        1.0
    }

    /// A file there and back.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io) and [`Error::Cancelled`](crate::Error::Cancelled) end the sweep; all others say why this mesh
    /// or setting is refused.
    fn round_trip(&self, mesh: &SweepMesh, task: Task<'_>) -> Result<RoundTrip>;
}

/// A file there and back.
#[derive(Debug, Clone)]
pub struct RoundTrip {
    /// Bytes of the file.
    pub bytes: u64,
    /// What came back.
    pub mesh: Mesh,
    /// The certified bound on the distance of the two surfaces, if the file has one.
    pub bound: Option<f64>,
    /// Seconds to make the file and to read it.
    pub seconds: [f64; 2],
}

/// This library.
#[derive(Debug, Clone)]
pub struct OwnCoder {
    /// How the mesh is encoded.
    pub options: EncodeOptions,
    /// What is repaired first, if anything. Distances are measured to the mesh as it was.
    pub repair: Option<Repair>,
    /// Seconds since any fixed moment; the library itself reads no clock.
    pub clock: fn() -> f64,
}

impl OwnCoder {
    /// A coder that measures seconds with `clock`.
    pub fn new(options: EncodeOptions, clock: fn() -> f64) -> Self {
        Self { options, repair: None, clock }
    }
}

impl Coder for OwnCoder {
    fn program(&self) -> String {
        concat!("gimc ", env!("CARGO_PKG_VERSION")).into()
    }

    fn method(&self) -> String {
        format!("{:?}", self.options.method).to_lowercase()
    }

    fn codec(&self) -> String {
        format!("{:?}", self.options.codec).to_lowercase()
    }

    fn weight(&self) -> f64 {
        // Measured on a mesh of 10,000 vertices.
        match (self.options.method, self.options.j2k.quality) {
            (Method::Gim, _) => 10.0,
            (_, Quality::Psnr(_)) => 3.0,
            _ => 1.0,
        }
    }

    fn round_trip(&self, mesh: &SweepMesh, task: Task<'_>) -> Result<RoundTrip> {
        let repaired = self.repair.as_ref().map(|repair| mesh.mesh.clone().repaired(repair).0);
        let start = (self.clock)();
        let encoded = self.options.encode_with(repaired.as_ref().unwrap_or(&mesh.mesh), task)?;
        let middle = (self.clock)();
        let back = Decoder::new(&encoded.bytes)?.decode_with(task.without_progress())?;
        let seconds = [middle - start, (self.clock)() - middle];
        let bound = Some(encoded.info.bound).filter(|bound| bound.is_finite());
        Ok(RoundTrip { bytes: encoded.bytes.len() as u64, mesh: back, bound, seconds })
    }
}
