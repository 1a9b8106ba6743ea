//! The door in: a mesh to a file.
//!
//! Mesh → oriented manifold → filled surface → lattice → streams → chunks.

mod fidelity;
mod image;
mod planes;
mod sliding;

use crate::cgim::Search;
use crate::decode::{Decoder, Info};
use crate::error::{Error, MeshDefect, Result};
use crate::extras::{self, Coded};
use crate::format::{
    self, ChunkWriter, Extras, Header, LatticeForm, MAX_EXTENT, PlanesChunk, RecipeChunk, STAGE, SurfaceChunk,
};
use crate::images;
use crate::limits::Limits;
use crate::mesh::{Attribute, AttributeKind, Domain, Front, HalfEdges, Mesh, Scalar};
use crate::options::{Accuracy, Codec, EncodeOptions, Method, Metric, Quality, Roi};
use crate::plane::{Lattice, bounding_box};
use crate::surface::attributes::Form;
use crate::surface::{self, Effort, Filled};
use crate::task::Task;

use self::sliding::{Sliding, Trial};

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
    /// A mesh without vertices, coordinates that are not finite, options that contradict each
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
        if self.method == Method::Gim {
            return self.encode_as_image(mesh, task);
        }
        let (Ok(vertices), Ok(faces)) = (u32::try_from(mesh.positions.len()), u32::try_from(mesh.faces.len())) else {
            return Err(Error::Parameter("more vertices or faces than 32 bits count".into()));
        };
        let front = Front::new(mesh.positions.len(), &mesh.faces);
        task.step(0.0)?;
        let is_plain = front.is_plain(mesh.positions.len(), &mesh.faces);
        self.check_image(&front, is_plain)?;
        let (attributes, mut notes) = self.chosen_attributes(mesh);
        let codec = match self.codec {
            Codec::Surface => Header::SURFACE,
            Codec::Mbcim => Header::MBCIM,
            Codec::Raw => Header::RAW,
            #[cfg(feature = "exr")]
            Codec::Exr => Header::EXR,
            Codec::J2k => Header::J2K,
            Codec::Wavelet => return Err(self.codec.not_for_meshes()),
        };
        let draft = Header {
            codec,
            double: mesh.precision == Scalar::F64,
            extras: Extras {
                fixes: !is_plain,
                order: self.keep_order,
                labels: self.attributes.groups && !mesh.labels.is_empty(),
                attributes: !attributes.is_empty(),
                exact: self.accuracy == Accuracy::Exact,
            },
            vertices,
            faces,
            lattice: LatticeForm::Free(Lattice { origin: [0.0; 3], step: 1.0 }),
            low: [0; 3],
            extent: [0; 3],
            bound: 0.0,
        };
        if self.metric == Metric::Surface {
            return self.encode_sliding(mesh, &front, is_plain, draft, &attributes, notes, task);
        }
        let inside = self.inside(mesh)?;
        let (mut header, mut positions) = match &inside {
            Some((bits, ..)) => place(Accuracy::Bits(*bits), draft, mesh)?,
            None => place(self.accuracy, draft, mesh)?,
        };
        if let Some((_, shift, inside)) = &inside {
            coarsen(&mut header, &mut positions, inside, *shift, mesh);
        }
        let on_surface: Vec<[i32; 3]> = front.vertex.iter().map(|&v| positions[v as usize]).collect();
        let inside = inside.map(|(_, shift, inside)| (shift, front.vertex.iter().map(|&v| inside[v as usize]).collect()));
        let source = Source { mesh, front: &front, positions: &on_surface, inside };
        let (body, coded) = self.write_surface(&source, &mut header, &mut notes, task)?;
        let coded = if header.extras == Extras::default() { None } else { Some(coded()?) };
        let bytes = self.assemble(&source, &header, body, &positions, coded.as_ref(), &attributes, task)?;
        let info = Decoder::new(&bytes)?.info().clone();
        Ok(Encoded { info, bytes, notes })
    }

    /// The same for vertices that may slide.
    #[allow(clippy::too_many_arguments)]
    fn encode_sliding(
        &self,
        mesh: &Mesh,
        front: &Front,
        is_plain: bool,
        draft: Header,
        attributes: &[(usize, Form)],
        mut notes: Vec<String>,
        task: Task<'_>,
    ) -> Result<Encoded> {
        if !is_plain {
            let why =
                "the metric surface is for oriented manifolds of triangles, and this mesh is none: `gimc inspect` tells why";
            return Err(Error::Parameter(why.into()));
        }
        let sliding = Sliding::new(self, mesh, front, draft, task)?;
        let coded = Coded::by_walk(&sliding.walked);
        let source = Source { mesh, front, positions: &[], inside: None };
        let assemble = |trial: &Trial| {
            let Trial { header, positions, .. } = trial;
            self.assemble(&source, header, sliding.chunks(trial), positions, Some(&coded), attributes, task)
        };
        let found = sliding.find(|trial| Ok(assemble(trial)?.len()))?;
        sliding.notes(&found, &mut notes);
        let bytes = assemble(&found)?;
        let info = Decoder::new(&bytes)?.info().clone();
        Ok(Encoded { info, bytes, notes })
    }

    /// The file of what was made.
    #[allow(clippy::too_many_arguments)]
    fn assemble(
        &self,
        source: &Source<'_>,
        header: &Header,
        body: Chunks,
        positions: &[[i32; 3]],
        coded: Option<&Coded>,
        attributes: &[(usize, Form)],
        task: Task<'_>,
    ) -> Result<Vec<u8>> {
        let mut writer = ChunkWriter::new();
        writer.chunk(Header::TAG, &header.write());
        // Stages last, so that whatever is cut off is only finer positions.
        let (stages, body): (Chunks, Chunks) = body.into_iter().partition(|(tag, _)| *tag == STAGE);
        body.iter().for_each(|(tag, payload)| writer.chunk(*tag, payload));
        if let Some(coded) = coded.filter(|_| header.extras != Extras::default()) {
            extras::write(&mut writer, header, source.mesh, positions, source.front, coded, attributes)?;
        }
        stages.iter().for_each(|(tag, payload)| writer.chunk(*tag, payload));
        let mut bytes = writer.into_bytes();
        if self.image.search > 1 && matches!(self.codec, Codec::Surface | Codec::Mbcim) && !self.image.paper {
            let recipe = self.recipe(&bytes, task)?;
            let mut writer = ChunkWriter::after(&bytes);
            writer.chunk(RecipeChunk::TAG, &recipe);
            bytes = writer.into_bytes();
        }
        Ok(bytes)
    }
}

impl EncodeOptions {
    /// Refuses what images of vertices, and stages, cannot hold.
    fn check_image(&self, front: &Front, is_plain: bool) -> Result<()> {
        if self.codec != Codec::Surface && front.surface.triangles().is_empty() {
            return Err(MeshDefect::Empty.into());
        }
        let lossy = self.codec == Codec::J2k && self.j2k.quality != Quality::Lossless;
        let only = if self.roi.as_ref().is_some_and(|roi| roi.bits.is_some()) {
            "regions of interest are"
        } else if !self.image.stages.is_empty() {
            "stages are"
        } else if lossy {
            "lossy planes are"
        } else if self.image.normals.is_some() {
            "planes of normals are"
        } else {
            return Ok(());
        };
        if !is_plain {
            let why = "for oriented manifolds of triangles, and this mesh is none: `gimc inspect` tells why";
            return Err(Error::Parameter(format!("{only} {why}")));
        }
        if self.keep_order && self.image.normals.is_some() {
            return Err(Error::Parameter("planes of normals and the order of a mesh cannot be kept together".into()));
        }
        if self.accuracy == Accuracy::Exact {
            return Err(Error::Parameter(format!("{only} not for coordinates bit by bit")));
        }
        Ok(())
    }

    /// Whether the codec takes more of the mesh than where vertices are and how they hang together, or less: then nothing
    /// else can be told from that.
    fn is_special_image(&self) -> bool {
        let lossy = self.codec == Codec::J2k && self.j2k.quality != Quality::Lossless;
        !self.image.stages.is_empty() || lossy || self.image.normals.is_some() || self.roi.is_some()
    }

    /// For a region of interest with a finer lattice: its bits, how many of them all others lack, and whether each vertex is inside.
    fn inside(&self, mesh: &Mesh) -> Result<Option<(u32, u32, Vec<bool>)>> {
        match (&self.roi, self.accuracy) {
            (Some(Roi { place, bits: Some(bits), .. }), Accuracy::Bits(outside)) => {
                Ok(Some((*bits, bits - outside, place.on(mesh)?.corners(mesh))))
            }
            _ => Ok(None),
        }
    }

    /// How each attribute is kept, by its number, and what is not kept.
    fn chosen_attributes(&self, mesh: &Mesh) -> (Vec<(usize, Form)>, Vec<String>) {
        let mut notes = Vec::new();
        let mut attributes = extras::choose_attributes(&mesh.attributes, &self.attributes, &mut notes);
        if self.is_special_image() {
            let has_plane = self.image.normals.is_some();
            let is_plane = |a: &Attribute| has_plane && a.kind == AttributeKind::Normal && a.domain == Domain::Vertex;
            let left_out = attributes.drain(..).map(|(i, _)| &mesh.attributes[i]).filter(|a| !is_plane(a));
            notes.extend(left_out.map(|a| {
                format!("attribute `{}` was left out: files in stages or with a region of interest, lossy planes and planes of normals have none", a.name)
            }));
        }
        if !self.attributes.groups && !mesh.labels.is_empty() {
            notes.push("names of objects, groups and materials were left out, as asked".into());
        }
        (attributes, notes)
    }

    /// What the codec keeps, as chunks; the second part tells, if asked, what a reader will make of it. The header may
    /// change: lossy planes move vertices.
    fn write_surface<'a>(
        &self,
        source: &Source<'a>,
        header: &mut Header,
        notes: &mut Vec<String>,
        task: Task<'_>,
    ) -> Result<(Chunks, impl FnOnce() -> Result<Coded> + 'a)> {
        let surface = &source.front.surface;
        let (chunks, order) = match self.codec {
            Codec::Surface => {
                let filled = Filled::new(surface);
                let shift = source.inside.as_ref().map(|(shift, _)| vec![*shift as u8]);
                let stages = shift.as_deref().unwrap_or(&self.image.stages);
                let inside = source.inside.as_ref().map(|(_, inside)| &inside[..]);
                let plan = surface::Plan { effort: self.effort, stages, has_region: inside.is_some() };
                let (streams, walked) = surface::write(&filled, source.positions, header.extent, plan, inside, task)?;
                let census = [filled.census.holes, filled.census.components, filled.census.handles];
                let mut stages = streams.positions.iter();
                let first = stages.next().map_or(&[][..], Vec::as_slice);
                let slide = None;
                let chunk = SurfaceChunk::write(
                    plan.effort as u8,
                    plan.stages,
                    plan.has_region,
                    slide,
                    census,
                    &streams.connectivity,
                    first,
                );
                let later = stages.map(|streams| (STAGE, format::write_stage(streams)));
                (std::iter::once((SurfaceChunk::TAG, chunk)).chain(later).collect(), Err(walked))
            }
            Codec::Mbcim => {
                let search = self.search();
                let options = self.image_options(self.image.paper.then_some(&search));
                let streams = images::write_mbcim(surface, source.positions, header.extent, &options, task)?;
                (streams.chunks, Ok((streams.triangles, streams.order)))
            }
            _ => {
                let written = self.write_planes(source, header, notes, task)?;
                (vec![(PlanesChunk::TAG, written.chunk)], Ok((written.decoded.triangles, written.origin)))
            }
        };
        let coded = move || match order {
            Ok((triangles, order)) => Coded::by_image(surface, triangles, order),
            Err(walked) => Ok(Coded::by_walk(&walked)),
        };
        Ok((chunks, coded))
    }

    fn search(&self) -> Search {
        let choices = &self.image;
        let keep = choices.keep.map(|share| ((share * 256.0).round() as i32 - 1).clamp(0, 255) as u8);
        let (trials, seed) = (choices.search, choices.seed);
        Search { trials, seed, alpha: choices.alpha, keep, as_printed: choices.paper, ..Search::default() }
    }

    /// From what the image of the mesh in a file can be made again.
    fn recipe(&self, file: &[u8], task: Task<'_>) -> Result<Vec<u8>> {
        let limits = Limits::default().memory(u64::MAX).work(u64::MAX).vertices(u64::MAX);
        let mesh = Decoder::with_limits(file, limits)?.decode_surface(task)?;
        let half_edges = HalfEdges::new(mesh.positions.len(), mesh.faces.triangles())?;
        Ok(images::search_recipe(&half_edges, &self.search(), task)?.write())
    }

    fn image_options<'a>(&'a self, image: Option<&'a Search>) -> images::ImageOptions<'a> {
        let sweeps = match self.effort {
            Effort::Fast => 1,
            Effort::Default => 4,
            Effort::Best => 24,
        };
        images::ImageOptions { sweeps, stages: &self.image.stages, image }
    }
}

/// Chunks without their frames, in order.
type Chunks = Vec<([u8; 4], Vec<u8>)>;

/// What is encoded.
struct Source<'a> {
    mesh: &'a Mesh,
    front: &'a Front,
    /// The lattice position of each vertex of the surface.
    positions: &'a [[i32; 3]],
    /// If there is a region of interest: the bits that all others lack, and whether each vertex of the surface is inside.
    inside: Option<(u32, Vec<bool>)>,
}

/// Bits of the lattice on which exact coordinates are predicted; what is left of them is mostly noise.
const EXACT_BITS: u32 = 18;

/// Chooses the lattice, puts every vertex on it, and measures how far they move.
fn place(accuracy: Accuracy, draft: Header, mesh: &Mesh) -> Result<(Header, Vec<[i32; 3]>)> {
    let [low, high] = bounding_box(mesh.positions.iter().copied()).ok_or(MeshDefect::Empty)?;
    let sides = [0, 1, 2].map(|i| high[i] - low[i]);
    let diagonal = sides.iter().map(|s| s * s).sum::<f64>().sqrt();
    if !diagonal.is_finite() {
        return Err(Error::Parameter("the box of the mesh is larger than numbers go".into()));
    }
    let free = |step| LatticeForm::Free(Lattice { origin: low, step });
    // A vertex moves at most half a step on each axis.
    let for_bound = |bound: f64| 2.0 * bound / 3_f64.sqrt() * (1.0 - 1e-9);
    let bits = if let Accuracy::Bits(bits) = accuracy { bits } else { EXACT_BITS };
    match accuracy {
        Accuracy::Bits(_) | Accuracy::Exact => {
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
            on_lattice(LatticeForm::Box { bits, low, axis, high: outward(high[axis], true) }, draft, mesh)
        }
        Accuracy::Step(step) => on_lattice(free(step), draft, mesh),
        Accuracy::Lattice(lattice) => on_lattice(LatticeForm::Free(lattice), draft, mesh),
        Accuracy::Psnr(_) | Accuracy::Size(_) => Err(Error::Parameter("this target is for the method gim".into())),
        Accuracy::RelativeError(_) if diagonal == 0.0 => on_lattice(free(1.0), draft, mesh),
        Accuracy::Error(_) | Accuracy::RelativeError(_) => {
            let bound = if let Accuracy::RelativeError(share) = accuracy {
                share * diagonal
            } else if let Accuracy::Error(e) = accuracy {
                e
            } else {
                0.0
            };
            let (header, positions) = on_lattice(free(for_bound(bound)), draft, mesh)?;
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

fn on_lattice(form: LatticeForm, draft: Header, mesh: &Mesh) -> Result<(Header, Vec<[i32; 3]>)> {
    let lattice = form.lattice();
    let index = |p: &[f64; 3]| [0, 1, 2].map(|axis| lattice.index(p[axis], axis));
    let indices: Vec<[f64; 3]> = mesh.positions.iter().map(index).collect();
    let [low, high] = bounding_box(indices.iter().copied()).ok_or(MeshDefect::Empty)?;
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
    header.bound = if header.extras.exact { 0.0 } else { farthest_moved(&header, &positions, mesh) };
    Ok((header, positions))
}

/// How far a vertex moves at most.
fn farthest_moved(header: &Header, positions: &[[i32; 3]], mesh: &Mesh) -> f32 {
    let lattice = header.lattice.lattice();
    let moved = positions.iter().zip(&mesh.positions).map(|(q, p)| {
        let decoded = header.position(&lattice, *q);
        [0, 1, 2].map(|i| (decoded[i] - p[i]) * (decoded[i] - p[i])).iter().sum::<f64>()
    });
    round_up(moved.fold(0.0, f64::max).sqrt())
}

/// Takes the lowest `shift` bits from all vertices that are not inside: they stand in the middle of what is left.
fn coarsen(header: &mut Header, positions: &mut [[i32; 3]], inside: &[bool], shift: u32, mesh: &Mesh) {
    for (position, _) in positions.iter_mut().zip(inside).filter(|(_, inside)| !**inside) {
        *position = [0, 1, 2].map(|i| surface::middle(position[i] >> shift, shift, header.extent[i]));
    }
    header.bound = farthest_moved(header, positions, mesh);
}

/// The smallest `f32` that is no less than `x`, with the rounding of the sums before it allowed for.
fn round_up(x: f64) -> f32 {
    let x = x * (1.0 + 4.0 * f64::EPSILON);
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}
