//! One point of a sweep: what was asked for, and all that was measured.

use super::RoundTrip;
use crate::eval::curve::RatePoint;
use crate::eval::measure::Comparison;
use crate::eval::same::Verdict;

/// One point of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepPoint {
    /// How the mesh is called.
    pub mesh: String,
    /// The file it is from.
    pub file: String,
    /// Bytes of that file.
    pub file_bytes: u64,
    /// Their CRC-32.
    pub file_crc32: u32,
    /// Vertices of the mesh.
    pub vertices: u64,
    /// Faces of the mesh.
    pub faces: u64,
    /// The curve that the point belongs to.
    pub way: String,
    /// All that was told to the program, beside the names of files.
    pub setting: String,
    /// The program, with its version if that is known.
    pub program: String,
    /// How the mesh is kept: `cgim`, `gim`, or `peer` for other programs.
    pub method: String,
    /// How it becomes bytes.
    pub codec: String,
    /// The command that makes the file.
    pub command: String,
    /// What was measured, or why the mesh or the setting was refused.
    pub result: Result<Measured, String>,
}

/// What was measured, under the names of `measures.md`; lengths are in the units of the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Bytes of the whole file.
    pub bytes: u64,
    /// Bits of the file for each vertex of the original.
    pub bpv: f64,
    /// Root mean square distance, both directions pooled.
    pub rms: f64,
    /// The larger of the two one-sided rms values.
    pub rms_max: f64,
    /// The greatest distance of a sampled point or a vertex.
    pub hausdorff: f64,
    /// `20·log10(diag / rms)` in dB; 999 if the surfaces are equal to double precision.
    pub psnr: f64,
    /// The same of the vertex displacement, where the vertices correspond.
    pub psnr_vertex: Option<f64>,
    /// Root mean square angle between normals in degrees.
    pub normal_rms: Option<f64>,
    /// Points sampled, both directions together.
    pub samples: u64,
    /// Box diagonal of the original.
    pub diag: f64,
    /// Whether the connectivity is that of the original, up to renumbering.
    pub same_connectivity: Verdict,
    /// Vertices of the decoded mesh.
    pub vertices_b: u64,
    /// Faces of the decoded mesh.
    pub faces_b: u64,
    /// The bound on the distance of the two surfaces that the file certifies, if it has one.
    pub bound: Option<f64>,
    /// Seconds to make the file, and to read it.
    pub seconds: [f64; 2],
}

impl Measured {
    pub(super) fn new(trip: &RoundTrip, compared: &Comparison, vertices: usize) -> Self {
        // Tenths of milliseconds: no clock is worth more here.
        let rounded = |seconds: f64| (seconds * 1e4).round() / 1e4;
        Self {
            bytes: trip.bytes,
            bpv: 8.0 * trip.bytes as f64 / vertices.max(1) as f64,
            rms: compared.rms,
            rms_max: compared.rms_max,
            hausdorff: compared.hausdorff,
            psnr: compared.psnr,
            psnr_vertex: compared.psnr_vertex,
            normal_rms: compared.normal_rms,
            samples: compared.samples as u64,
            diag: compared.diag,
            same_connectivity: compared.same_connectivity,
            vertices_b: compared.vertices[1] as u64,
            faces_b: compared.faces[1] as u64,
            bound: trip.bound,
            seconds: trip.seconds.map(rounded),
        }
    }

    /// The point as curves see it.
    pub fn rate(&self) -> RatePoint {
        RatePoint { bytes: self.bytes, psnr: self.psnr }
    }
}
