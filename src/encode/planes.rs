//! The door in for images of vertices as planes: without loss, or with, and then with an honest header.

use super::{Source, fidelity, round_up};
#[cfg(feature = "exr")]
use crate::codec::Exr;
use crate::codec::{PlaneCodec, Raw};
use crate::error::{Error, Result};
use crate::format::{Extras, Header};
use crate::images::{self, BorderChoice, Decoded, Draft, Goal, NormalPlanes, Target, Written};
use crate::mesh::{Mesh, Region, vertex_normals};
use crate::options::{Accuracy, Boundaries, Codec, EncodeOptions, Quality};
use crate::plane::{bounding_box, octahedral};
use crate::task::Task;

impl EncodeOptions {
    /// An image of vertices as planes. The header changes where lossy planes move vertices, or lose the connectivity.
    pub(super) fn write_planes(
        &self,
        source: &Source<'_>,
        header: &mut Header,
        notes: &mut Vec<String>,
        task: Task<'_>,
    ) -> Result<Written> {
        let choice = match (self.codec, self.j2k.boundaries) {
            (Codec::J2k, Boundaries::Implied) => BorderChoice::Implied,
            (Codec::J2k, Boundaries::Exact) if self.j2k.quality != Quality::Lossless => BorderChoice::Exact,
            // Removing rows as printed may leave a vertex in several places, which colours would not show.
            _ if self.image.paper => BorderChoice::Exact,
            _ => BorderChoice::Colours,
        };
        let vertex = |v: u32| source.front.vertex[v as usize];
        let normals = self.image.normals.map(|depth| {
            let of_mesh = vertex_normals(source.mesh);
            let normals = source.front.vertex.iter().map(|&v| octahedral(of_mesh[v as usize], depth));
            (normals.collect::<Vec<_>>(), depth)
        });
        let normals = normals.as_ref().map(|(normals, depth)| NormalPlanes { normals, depth: *depth });
        let surface = &source.front.surface;
        let draft = Draft::new(surface, source.positions, header.extent, normals, choice, &self.search(), task)?;
        let plain = |codec: &dyn PlaneCodec| draft.pack(&codec.encode(&draft.planes, &task)?, codec);
        let (written, irreversible) = match self.codec {
            #[cfg(feature = "exr")]
            Codec::Exr => (plain(&Exr)?, false),
            Codec::J2k => {
                let goal = match self.j2k.quality {
                    Quality::Lossless => Goal::Lossless,
                    Quality::BitsPerPixel(bpp) => Goal::BitsPerPixel(bpp),
                    Quality::Psnr(psnr) => Goal::Psnr(psnr),
                };
                let psnr = |decoded: &Decoded| fidelity::psnr(source.mesh, &placed(header, decoded), &task);
                let region = self.roi.as_ref().map(|roi| roi.place.on(source.mesh)).transpose()?;
                let inside = |region: Region| {
                    let corners = region.corners(source.mesh);
                    draft.pixels(|v: u32| source.front.vertex.get(v as usize).is_some_and(|&v| corners[v as usize]))
                };
                let mask = region.map(inside).filter(|mask| mask.count() > 0);
                let target = Target { goal, layers: self.j2k.layers, region: mask.as_ref(), psnr: &psnr };
                images::write_lossy(&draft, choice, &target, task)?
            }
            _ => (plain(&Raw)?, false),
        };
        if self.codec != Codec::J2k || self.j2k.quality == Quality::Lossless {
            return Ok(written);
        }
        let decoded = placed(header, &written.decoded);
        let bound = if written.exact {
            let origin: Vec<u32> = written.origin.iter().map(|&v| vertex(v)).collect();
            fidelity::farthest(source.mesh, &decoded, &origin)
        } else {
            self.without_connectivity(header, &decoded, notes)?;
            fidelity::hausdorff(source.mesh, &decoded, &task)?
        };
        // Decoders may differ by one in each sample.
        let slack = if irreversible { header.lattice.lattice().step * 3_f64.sqrt() } else { 0.0 };
        header.bound = round_up(bound + slack);
        match self.allowed_error(source.mesh) {
            Some(allowed) if f64::from(header.bound) > allowed => {
                Err(Error::Parameter(format!("an error of {allowed} is not held at this rate, but {}", header.bound)))
            }
            _ => Ok(written),
        }
    }

    /// The cluster phase finds another mesh: the header is that of this one.
    fn without_connectivity(&self, header: &mut Header, decoded: &Mesh, notes: &mut Vec<String>) -> Result<()> {
        if self.keep_order {
            let why = "the order of a mesh whose connectivity the cluster phase does not find; take a higher rate";
            return Err(Error::Parameter(why.into()));
        }
        notes.push("the cluster phase does not find the exact connectivity at this rate".into());
        if header.extras.labels {
            notes.push("names of objects, groups and materials were left out".into());
        }
        header.extras = Extras::default();
        header.vertices = decoded.positions.len() as u32;
        header.faces = decoded.faces.len() as u32;
        Ok(())
    }

    /// The error that was asked for, in the units of the mesh.
    fn allowed_error(&self, mesh: &Mesh) -> Option<f64> {
        match self.accuracy {
            Accuracy::Error(bound) => Some(bound),
            Accuracy::RelativeError(share) => {
                let [low, high] = bounding_box(mesh.positions.iter().copied())?;
                Some(share * (0..3).map(|i| (high[i] - low[i]).powi(2)).sum::<f64>().sqrt())
            }
            _ => None,
        }
    }
}

/// A decoded mesh in its place.
fn placed(header: &Header, decoded: &Decoded) -> Mesh {
    let lattice = header.lattice.lattice();
    let positions = decoded.positions.iter().map(|&q| header.position(&lattice, q)).collect();
    Mesh::from_triangles(positions, decoded.triangles.iter().copied())
}
