//! The door in: a mesh to a file.
//!
//! Mesh → half-edges → filled surface → lattice → streams → chunks.

use crate::cgim::{Contact, Search};
#[cfg(feature = "exr")]
use crate::codec::Exr;
use crate::codec::{PlaneCodec, Raw};
use crate::decode::{Decoder, Info};
use crate::error::{Error, MeshDefect, Result};
use crate::format::{ChunkWriter, Header, LatticeForm, MAX_EXTENT, RecipeChunk, SurfaceChunk};
use crate::images;
use crate::limits::Limits;
use crate::mesh::{HalfEdges, Mesh, Scalar};
use crate::options::{Accuracy, Codec, EncodeOptions};
use crate::plane::{Lattice, bounding_box};
use crate::surface::{self, Effort, Filled};
use crate::task::Task;

/// A file, what it says of itself, and what was left out of it.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Encoded {
    /// The file.
    pub bytes: Vec<u8>,
    /// What its header says.
    pub info: Info,
    /// What the mesh had and the file has not, in plain words.
    pub notes: Vec<String>,
}

impl EncodeOptions {
    /// Encodes a mesh.
    ///
    /// O(n log n) in its faces.
    ///
    /// # Errors
    /// A mesh that is not an oriented manifold, coordinates that are not finite, options that contradict each
    /// other, or a bound that cannot be held.
    pub fn encode(&self, mesh: &Mesh) -> Result<Vec<u8>> {
        Ok(self.encode_with(mesh, Task::default())?.bytes)
    }

    /// Encodes a mesh under the eyes of a [`Task`], and tells more of the result.
    ///
    /// # Errors
    /// As [`EncodeOptions::encode`], and [`Error::Cancelled`].
    pub fn encode_with(&self, mesh: &Mesh, task: Task<'_>) -> Result<Encoded> {
        self.check()?;
        task.step(0.0)?;
        mesh.check()?;
        let triangles = mesh.faces.triangles();
        if triangles.is_empty() {
            return Err(MeshDefect::Empty.into());
        }
        let faces = triangles.len() as u32;
        let half_edges = HalfEdges::new(mesh.positions.len(), triangles)?;
        let filled = Filled::new(&half_edges);
        let codec = match self.codec {
            Codec::Surface => Header::SURFACE,
            Codec::Mbcim => Header::MBCIM,
            Codec::Raw => Header::RAW,
            #[cfg(feature = "exr")]
            Codec::Exr => Header::EXR,
        };
        let draft = Header {
            codec,
            double: mesh.precision == Scalar::F64,
            vertices: filled.census.vertices,
            faces,
            lattice: LatticeForm::Free(Lattice { origin: [0.0; 3], step: 1.0 }),
            low: [0; 3],
            extent: [0; 3],
            bound: 0.0,
        };
        let (header, positions) = place(self.accuracy, draft, mesh, &half_edges)?;
        let mut writer = ChunkWriter::new();
        writer.chunk(Header::TAG, &header.write());
        match self.codec {
            Codec::Surface => {
                let streams = surface::write(&filled, &positions, header.extent, self.effort, task)?;
                let census = [filled.census.holes, filled.census.components, filled.census.handles];
                writer.chunk(
                    SurfaceChunk::TAG,
                    &SurfaceChunk::write(self.effort as u8, census, &streams.connectivity, &streams.positions),
                );
            }
            Codec::Mbcim => {
                let streams = images::write_mbcim(&half_edges, &positions, header.extent, &self.image_options(), task)?;
                streams.chunks.iter().for_each(|(tag, payload)| writer.chunk(*tag, payload));
            }
            Codec::Raw => self.write_planes(&mut writer, &half_edges, &positions, &header, &Raw, task)?,
            #[cfg(feature = "exr")]
            Codec::Exr => self.write_planes(&mut writer, &half_edges, &positions, &header, &Exr, task)?,
        }
        let mut bytes = writer.into_bytes();
        if self.image.search > 1 && matches!(self.codec, Codec::Surface | Codec::Mbcim) {
            let recipe = self.recipe(&bytes, task)?;
            let mut writer = ChunkWriter::after(&bytes);
            writer.chunk(RecipeChunk::TAG, &recipe);
            bytes = writer.into_bytes();
        }
        let info = Decoder::new(&bytes)?.info().clone();
        Ok(Encoded { info, bytes, notes: notes(mesh, filled.census.vertices as usize) })
    }
}

impl EncodeOptions {
    fn write_planes(
        &self,
        writer: &mut ChunkWriter,
        mesh: &HalfEdges,
        positions: &[[i32; 3]],
        header: &Header,
        codec: &dyn PlaneCodec,
        task: Task<'_>,
    ) -> Result<()> {
        if !self.image.stages.is_empty() {
            return Err(Error::Parameter("stages are for the codec mbcim".into()));
        }
        let streams = images::write_planes(mesh, positions, header.extent, codec, &self.search(), task)?;
        streams.chunks.iter().for_each(|(tag, payload)| writer.chunk(*tag, payload));
        Ok(())
    }

    fn search(&self) -> Search {
        let choices = &self.image;
        Search { trials: choices.search, seed: choices.seed, alpha: choices.alpha, contact: Contact::Slash }
    }

    /// From what the image of the mesh in a file can be made again.
    fn recipe(&self, file: &[u8], task: Task<'_>) -> Result<Vec<u8>> {
        let limits = Limits::default().memory(u64::MAX).work(u64::MAX).vertices(u64::MAX);
        let mesh = Decoder::with_limits(file, limits)?.decode()?;
        let half_edges = HalfEdges::new(mesh.positions.len(), mesh.faces.triangles())?;
        Ok(images::search_recipe(&half_edges, &self.search(), task)?.write())
    }

    fn image_options(&self) -> images::ImageOptions<'_> {
        let sweeps = match self.effort {
            Effort::Fast => 1,
            Effort::Default => 4,
            Effort::Best => 24,
        };
        images::ImageOptions { sweeps, stages: &self.image.stages }
    }
}

/// Chooses the lattice, puts every vertex on it, and measures how far they move.
fn place(accuracy: Accuracy, draft: Header, mesh: &Mesh, used: &HalfEdges) -> Result<(Header, Vec<[i32; 3]>)> {
    let [low, high] = bounding_box(mesh.positions.iter().copied()).ok_or(MeshDefect::Empty)?;
    let sides = [0, 1, 2].map(|i| high[i] - low[i]);
    let diagonal = sides.iter().map(|s| s * s).sum::<f64>().sqrt();
    if !diagonal.is_finite() {
        return Err(Error::Parameter("the box of the mesh is larger than numbers go".into()));
    }
    let free = |step| LatticeForm::Free(Lattice { origin: low, step });
    // A vertex moves at most half a step on each axis.
    let for_bound = |bound: f64| 2.0 * bound / 3_f64.sqrt() * (1.0 - 1e-9);
    match accuracy {
        Accuracy::Bits(bits) => {
            let axis = (0..3).fold(0, |best, i| if sides[i] > sides[best] { i } else { best });
            // In single precision the corners of the box take half the bytes; they may then lie a little outside.
            let outward = |x: f64, up: bool| {
                let x32 = x as f32;
                match (draft.double, up) {
                    (true, _) => x,
                    (_, true) => f64::from(if f64::from(x32) < x { x32.next_up() } else { x32 }),
                    (_, false) => f64::from(if f64::from(x32) > x { x32.next_down() } else { x32 }),
                }
            };
            let low = low.map(|x| outward(x, false));
            on_lattice(LatticeForm::Box { bits, low, axis, high: outward(high[axis], true) }, draft, mesh, used)
        }
        Accuracy::Step(step) => on_lattice(free(step), draft, mesh, used),
        Accuracy::Lattice(lattice) => on_lattice(LatticeForm::Free(lattice), draft, mesh, used),
        Accuracy::RelativeError(_) if diagonal == 0.0 => on_lattice(free(1.0), draft, mesh, used),
        Accuracy::Error(_) | Accuracy::RelativeError(_) => {
            let bound = if let Accuracy::RelativeError(share) = accuracy {
                share * diagonal
            } else if let Accuracy::Error(e) = accuracy {
                e
            } else {
                0.0
            };
            let (header, positions) = on_lattice(free(for_bound(bound)), draft, mesh, used)?;
            if f64::from(header.bound) > bound {
                return Err(Error::Parameter(format!(
                    "an error of {bound} cannot be held: rounding the coordinates to {} already costs {}",
                    if header.double { "f64" } else { "f32" },
                    header.bound
                )));
            }
            Ok((header, positions))
        }
    }
}

fn on_lattice(form: LatticeForm, draft: Header, mesh: &Mesh, used: &HalfEdges) -> Result<(Header, Vec<[i32; 3]>)> {
    let lattice = form.lattice();
    let is_used = |v: usize| used.outgoing(v as u32).is_some();
    let index = |p: &[f64; 3]| [0, 1, 2].map(|axis| lattice.index(p[axis], axis));
    let indices: Vec<[f64; 3]> = mesh.positions.iter().map(index).collect();
    let used_indices = indices.iter().enumerate().filter(|&(v, _)| is_used(v)).map(|(_, q)| *q);
    let [low, high] = bounding_box(used_indices).ok_or(MeshDefect::Empty)?;
    let low = if let LatticeForm::Box { .. } = form { [0.0; 3] } else { low };
    let reach = [0, 1, 2].map(|i| high[i] - low[i]);
    if reach.iter().any(|&r| !(0.0..=MAX_EXTENT as f64).contains(&r)) || low.iter().any(|l| l.abs() > (1_i64 << 52) as f64) {
        return Err(Error::Parameter(format!(
            "a step of {} is too small for this mesh: its box would be {:.0} steps wide, and at most {MAX_EXTENT} are possible",
            lattice.step,
            reach.into_iter().fold(0.0, f64::max)
        )));
    }
    let mut header = Header { lattice: form, low: low.map(|l| l as i64), extent: reach.map(|r| r as i32), ..draft };
    let positions: Vec<[i32; 3]> = indices.iter().map(|q| [0, 1, 2].map(|i| (q[i] - low[i]) as i32)).collect();
    let moved = positions.iter().zip(&mesh.positions).enumerate().filter(|&(v, _)| is_used(v)).map(|(_, (q, p))| {
        let decoded = header.position(&lattice, *q);
        [0, 1, 2].map(|i| (decoded[i] - p[i]) * (decoded[i] - p[i])).iter().sum::<f64>()
    });
    header.bound = round_up(moved.fold(0.0, f64::max).sqrt());
    Ok((header, positions))
}

/// The smallest `f32` that is no less than `x`, with the rounding of the sums before it allowed for.
fn round_up(x: f64) -> f32 {
    let x = x * (1.0 + 4.0 * f64::EPSILON);
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

/// What the file does not hold.
fn notes(mesh: &Mesh, used: usize) -> Vec<String> {
    let mut notes = Vec::new();
    let isolated = mesh.positions.len() - used;
    if isolated > 0 {
        notes.push(format!("{isolated} vertices that no face uses were left out"));
    }
    if !mesh.faces.are_triangles() {
        notes.push("polygons were cut into triangles, fanned from their first corner".into());
    }
    for attribute in &mesh.attributes {
        notes.push(format!("attribute \"{}\" was left out", attribute.name));
    }
    if !mesh.labels.is_empty() {
        notes.push("names of objects, groups and materials were left out".into());
    }
    notes
}
