//! The door out: a file to a mesh.
//!
//! Opening a file reads its header and checks its chunks; nothing large is made before [`Decoder::decode`].

#[cfg(feature = "exr")]
use crate::codec::Exr;
use crate::codec::{PlaneCodec, Raw};
use crate::error::{Error, Place, Result};
use crate::format::{Chunks, Header, LatticeForm, MbcimChunk, PlanesChunk, RecipeChunk, SurfaceChunk};
use crate::images;
use crate::limits::{Budget, Limits};
use crate::mesh::{Mesh, Scalar};
use crate::surface::{self, Census, Effort};
use crate::task::Task;

/// A file that was opened.
#[derive(Debug)]
pub struct Decoder<'a> {
    header: Header,
    body: Body<'a>,
    #[cfg_attr(not(feature = "png"), allow(dead_code))]
    recipe: Option<RecipeChunk>,
    limits: Limits,
    info: Info,
}

/// What the codec of a file needs.
#[derive(Debug)]
enum Body<'a> {
    Surface(SurfaceChunk<'a>),
    Mbcim { chunk: MbcimChunk<'a>, stages: Vec<&'a [u8]> },
    Planes { chunk: PlanesChunk<'a>, codec: &'static dyn PlaneCodec, name: &'static str },
}

/// What a file says of itself before it is decoded.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Info {
    /// The version of the format.
    pub version: u8,
    /// `cgim`: the connectivity is kept exactly.
    pub method: &'static str,
    /// How the mesh became bytes.
    pub codec: &'static str,
    /// How much time was given for the size.
    pub effort: Effort,
    /// Vertices of the mesh.
    pub vertices: u32,
    /// Faces of the mesh.
    pub faces: u32,
    /// The lowest and the highest corner of its box.
    pub bounds: [[f64; 3]; 2],
    /// Where the lattice of the positions begins.
    pub origin: [f64; 3],
    /// The distance of lattice points.
    pub step: f64,
    /// log₂ of the lattice points on the longest side of the box, if the lattice was chosen so.
    pub bits: Option<u32>,
    /// No point of the original surface is farther than this from the decoded one, nor the other way round.
    pub bound: f64,
    /// The number type of the positions.
    pub precision: Scalar,
    /// The chunks in the order of the file.
    pub chunks: Vec<ChunkInfo>,
    /// The bytes by what they are for; they add up to the size of the file.
    pub parts: Vec<(&'static str, u64)>,
    /// Rows and columns of the image of vertices, if the file says how to make one.
    pub image: Option<[u32; 2]>,
    /// Bits that each stage after the first adds to every coordinate; one entry a stage.
    pub stages: Vec<u8>,
    /// How many of the stages the file still has.
    pub stages_present: usize,
    /// Bytes of memory that decoding takes at most.
    pub memory: u64,
    /// Steps of work that decoding takes, as far as the header tells.
    pub work: u64,
}

/// A chunk of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct ChunkInfo {
    /// Its four-letter tag.
    pub tag: String,
    /// Its bytes, tag, length and checksum included.
    pub bytes: u64,
}

impl<'a> Decoder<'a> {
    /// Opens a file under the default [`Limits`].
    ///
    /// # Errors
    /// Bytes that are not a file of this format, or not of a version that this library reads.
    pub fn new(bytes: &'a [u8]) -> Result<Self> {
        Self::with_limits(bytes, Limits::default())
    }

    /// Opens a file under the caller's limits.
    ///
    /// # Errors
    /// As [`Decoder::new`], and [`Error::Limit`].
    pub fn with_limits(bytes: &'a [u8], limits: Limits) -> Result<Self> {
        let chunks = Chunks::read(bytes)?;
        chunks.check_known(&[Header::TAG, SurfaceChunk::TAG, MbcimChunk::TAG, PlanesChunk::TAG])?;
        let header = Header::read(chunks.one(Header::TAG)?.reader())?;
        let body = match header.codec {
            Header::SURFACE => {
                let surface = SurfaceChunk::read(chunks.one(SurfaceChunk::TAG)?.reader())?;
                if header.vertices.checked_add(surface.holes).is_none() {
                    let why = format!("{} vertices and {} holes do not fit 32 bits", header.vertices, surface.holes);
                    return Err(Error::malformed(Place::Whole, why));
                }
                Body::Surface(surface)
            }
            Header::MBCIM => {
                let chunk = MbcimChunk::read(chunks.one(MbcimChunk::TAG)?.reader(), &mut Budget::new(limits))?;
                let stages = chunks.iter().filter(|chunk| chunk.tag == MbcimChunk::STAGE).map(|chunk| chunk.payload);
                Body::Mbcim { chunk, stages: stages.collect() }
            }
            codec => {
                let (codec, name) = plane_codec(codec)?;
                let chunk = PlanesChunk::read(chunks.one(PlanesChunk::TAG)?.reader(), &mut Budget::new(limits))?;
                Body::Planes { chunk, codec, name }
            }
        };
        let recipe = chunks.iter().find(|chunk| chunk.tag == RecipeChunk::TAG);
        let recipe = recipe.map(|chunk| RecipeChunk::read(chunk.reader())).transpose()?;
        let info = Info::new(bytes, &chunks, &header, &body, recipe.as_ref())?;
        Ok(Self { header, body, recipe, limits, info })
    }

    /// Decodes no more than the first `count` stages beside the base; all of them if there are fewer.
    pub fn stages(mut self, count: usize) -> Self {
        if let Body::Mbcim { stages, .. } = &mut self.body {
            stages.truncate(count);
        }
        self
    }

    /// What the file says of itself.
    pub fn info(&self) -> &Info {
        &self.info
    }

    /// How the image of the mesh can be made again, if the file says so.
    #[cfg(feature = "png")]
    pub(crate) fn recipe(&self) -> Option<&RecipeChunk> {
        self.recipe.as_ref()
    }

    /// Decodes the mesh.
    ///
    /// # Errors
    /// A stream that describes no mesh, or one that would pass the limits.
    pub fn decode(&self) -> Result<Mesh> {
        self.decode_with(Task::default())
    }

    /// Decodes the mesh under the eyes of a [`Task`].
    ///
    /// # Errors
    /// As [`Decoder::decode`], and [`Error::Cancelled`].
    pub fn decode_with(&self, task: Task<'_>) -> Result<Mesh> {
        task.step(0.0)?;
        let mut budget = Budget::new(self.limits);
        let header = &self.header;
        budget.check_vertices(header.vertices.into())?;
        let (triangles, positions) = match &self.body {
            Body::Surface(chunk) => {
                let census = census(header, chunk);
                let streams = chunk.positions(surface::ranges(census).len())?;
                let (surface, positions) =
                    surface::read(chunk.connectivity, &streams, census, header.extent, self.info.effort, &mut budget, task)?;
                (surface.real_triangles(), positions)
            }
            Body::Mbcim { chunk, stages } => {
                let decoded = images::read_mbcim(chunk, stages, header.vertices, header.extent, &mut budget, task)?;
                (decoded.triangles, decoded.positions)
            }
            Body::Planes { chunk, codec, .. } => {
                let decoded = images::read_planes(chunk, *codec, header.vertices, header.extent, &mut budget, task)?;
                (decoded.triangles, decoded.positions)
            }
        };
        if triangles.len() != header.faces as usize {
            let why = format!("{} faces were decoded, the header says {}", triangles.len(), header.faces);
            return Err(Error::malformed(Place::Whole, why));
        }
        let lattice = header.lattice.lattice();
        let positions = positions.into_iter().map(|q| header.position(&lattice, q)).collect();
        let mut mesh = Mesh::from_triangles(positions, triangles);
        mesh.precision = self.info.precision;
        Ok(mesh)
    }
}

/// The codec of planes that a header names.
fn plane_codec(id: u8) -> Result<(&'static dyn PlaneCodec, &'static str)> {
    match id {
        Header::RAW => Ok((&Raw, "raw")),
        #[cfg(feature = "exr")]
        Header::EXR => Ok((&Exr, "exr")),
        other => Err(Error::Unsupported { what: "codec", id: other.to_string() }),
    }
}

fn census(header: &Header, surface: &SurfaceChunk<'_>) -> Census {
    Census { vertices: header.vertices, holes: surface.holes, components: surface.components, handles: surface.handles }
}

impl Info {
    fn new(bytes: &[u8], chunks: &Chunks<'_>, header: &Header, body: &Body<'_>, recipe: Option<&RecipeChunk>) -> Result<Self> {
        let lattice = header.lattice.lattice();
        let bits = if let LatticeForm::Box { bits, .. } = header.lattice { Some(bits) } else { None };
        let (codec, effort, connectivity, positions, cost) = match body {
            Body::Surface(chunk) => {
                let effort = match chunk.effort {
                    0 => Effort::Fast,
                    1 => Effort::Default,
                    2 => Effort::Best,
                    other => return Err(Error::Unsupported { what: "effort", id: other.to_string() }),
                };
                let connectivity = chunk.connectivity.len() as u64;
                ("surface", effort, connectivity, chunk.positions_size(), surface::cost(census(header, chunk)))
            }
            Body::Mbcim { chunk, stages } => {
                let positions = chunk.colours.len() + stages.iter().map(|stage| stage.len()).sum::<usize>();
                let connectivity = chunk.map.len() + chunk.side_size;
                ("mbcim", Effort::Default, connectivity as u64, positions as u64, images::cost(header.vertices, header.faces))
            }
            Body::Planes { chunk, name, .. } => {
                let cost = images::planes_cost(chunk, header.faces);
                (*name, Effort::Default, chunk.side_size as u64, chunk.samples.len() as u64, cost)
            }
        };
        let (stages, stages_present) = match body {
            Body::Mbcim { chunk, stages } => (chunk.stages.clone(), stages.len().min(chunk.stages.len())),
            _ => (Vec::new(), 0),
        };
        let image = match body {
            Body::Planes { chunk, .. } => Some([chunk.rows, chunk.columns]),
            _ => recipe.map(|chunk| [chunk.rows, chunk.columns]),
        };
        let header_size = bytes.len() as u64 - connectivity - positions;
        let parts = vec![("header", header_size), ("connectivity", connectivity), ("positions", positions)];
        Ok(Self {
            version: crate::format::VERSION,
            method: "cgim",
            codec,
            effort,
            vertices: header.vertices,
            faces: header.faces,
            bounds: [header.corner(false), header.corner(true)],
            origin: lattice.origin,
            step: lattice.step,
            bits,
            bound: header.bound.into(),
            precision: if header.double { Scalar::F64 } else { Scalar::F32 },
            chunks: chunks
                .iter()
                .map(|chunk| ChunkInfo { tag: chunk.tag.escape_ascii().to_string(), bytes: chunk.size })
                .collect(),
            parts,
            image,
            stages,
            stages_present,
            memory: cost.0,
            work: cost.1,
        })
    }
}
