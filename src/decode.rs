//! The door out: a file to a mesh.
//!
//! Opening a file reads its header and checks its chunks; nothing large is made before [`Decoder::decode`].

mod image;
mod info;

pub use crate::extras::AttributeInfo;
pub use info::{ChunkInfo, Info, RoiInfo};

use crate::bits::Reader;
use crate::charts;
#[cfg(feature = "exr")]
use crate::codec::Exr;
use crate::codec::j2k::{self, J2k};
use crate::codec::{PlaneCodec, Raw};
use crate::error::{Error, Place, Result};
use crate::extras::Parts;
use crate::format::{
    Chunks, Header, ImageChunk, MbcimChunk, PlanesChunk, RecipeChunk, STAGE, SlideField, SurfaceChunk, read_stage,
};
use crate::images::{self, Pixels};
use crate::limits::{Budget, Limits};
use crate::mesh::{Attribute, AttributeKind, Domain, Mesh, Scalar};
use crate::plane::from_octahedral;
use crate::surface::{self, Census, Effort, Skin, Slide};
use crate::task::Task;

/// A file that was opened.
#[derive(Debug)]
pub struct Decoder<'a> {
    content: Content<'a>,
    /// Halvings of a geometry image that are not undone.
    level: u8,
    #[cfg_attr(not(feature = "png"), allow(dead_code))]
    recipe: Option<RecipeChunk>,
    limits: Limits,
    info: Info,
}

/// What a file holds.
#[derive(Debug)]
enum Content<'a> {
    /// A mesh with its own connectivity.
    Mesh(Box<MeshFile<'a>>),
    /// Geometry images: one for each part of the surface.
    Images(Vec<ImageChunk<'a>>),
}

/// A mesh with its own connectivity.
#[derive(Debug)]
struct MeshFile<'a> {
    header: Header,
    body: Body<'a>,
    parts: Parts<'a>,
}

/// What the codec of a file needs.
#[derive(Debug)]
enum Body<'a> {
    Surface { chunk: SurfaceChunk<'a>, stages: Vec<Reader<'a>> },
    Mbcim { chunk: MbcimChunk<'a>, stages: Vec<&'a [u8]> },
    Planes { chunk: PlanesChunk<'a>, codec: Box<dyn PlaneCodec>, name: &'static str },
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
        if chunks.first() == Some(ImageChunk::TAG) {
            return Self::of_images(bytes, &chunks, limits);
        }
        let codecs = [Header::TAG, SurfaceChunk::TAG, MbcimChunk::TAG, PlanesChunk::TAG];
        chunks.check_known(&[&codecs[..], &Parts::TAGS].concat())?;
        let header = Header::read(chunks.one(Header::TAG)?.reader())?;
        let parts = Parts::read(&chunks, &header)?;
        let (vertices, _) = parts.surface_size(&header);
        let body = match header.codec {
            Header::SURFACE => {
                let chunk = SurfaceChunk::read(chunks.one(SurfaceChunk::TAG)?.reader())?;
                if vertices.checked_add(chunk.holes).is_none() {
                    let why = format!("{vertices} vertices and {} holes do not fit 32 bits", chunk.holes);
                    return Err(Error::malformed(Place::Whole, why));
                }
                let stages = chunks.iter().filter(|chunk| chunk.tag == STAGE).map(|chunk| chunk.reader());
                Body::Surface { stages: stages.take(chunk.stages.len()).collect(), chunk }
            }
            Header::MBCIM => {
                let chunk = MbcimChunk::read(chunks.one(MbcimChunk::TAG)?.reader(), &mut Budget::new(limits))?;
                let stages = chunks.iter().filter(|chunk| chunk.tag == STAGE).map(|chunk| chunk.payload);
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
        let info = Info::new(bytes, &chunks, &header, &body, &parts, recipe.as_ref())?;
        let content = Content::Mesh(Box::new(MeshFile { header, body, parts }));
        Ok(Self { content, level: 0, recipe, limits, info })
    }

    /// Decodes no more than the first `count` stages beside the base; all of them if there are fewer.
    pub fn stages(mut self, count: usize) -> Self {
        let Content::Mesh(file) = &mut self.content else { return self };
        match &mut file.body {
            Body::Surface { stages, .. } => stages.truncate(count),
            Body::Mbcim { stages, .. } => stages.truncate(count),
            Body::Planes { .. } => {}
        }
        self.info.cut(&file.header, count);
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
        let file = match &self.content {
            Content::Mesh(file) => file,
            Content::Images(_) => {
                let mesh = charts::mesh(&self.geometry_images_with(task)?, self.info.precision)?;
                let told = (self.info.vertices as usize, self.info.faces as usize);
                let found = (mesh.positions.len(), mesh.faces.len());
                if self.level == 0 && found != told {
                    let why = format!("{found:?} vertices and triangles, and the header tells of {told:?}");
                    return Err(Error::malformed(Place::Whole, why));
                }
                return Ok(mesh);
            }
        };
        budget.check_vertices(file.header.vertices.into())?;
        let surface = file.surface(self.info.effort, &mut budget, task)?;
        let (triangles, normals) = (surface.triangles, surface.normals);
        let mut mesh = file.parts.mesh(&file.header, surface.skin, surface.positions, triangles, &mut budget)?;
        mesh.precision = self.info.precision;
        if normals.len() == mesh.positions.len() && !normals.is_empty() {
            budget.reserve(24 * normals.len() as u64)?;
            let unit = normals.iter().flat_map(|&n| from_octahedral(n, self.info.normal_bits));
            mesh.attributes.push(Attribute {
                kind: AttributeKind::Normal,
                name: "normal".into(),
                domain: Domain::Vertex,
                width: 3,
                scalar: Scalar::F32,
                values: unit.map(|x| f64::from(x as f32)).collect(),
                indices: Vec::new(),
            });
        }
        Ok(mesh)
    }

    /// The JPEG 2000 codestream of a file, if it holds one: what any viewer of `.j2k` files opens.
    ///
    /// # Errors
    /// A file without one.
    pub fn codestream(&self) -> Result<&'a [u8]> {
        match &self.content {
            Content::Mesh(file) if file.header.codec == Header::J2K => match &file.body {
                Body::Planes { chunk, .. } => j2k::codestream(chunk.samples),
                _ => Err(Error::malformed(Place::Whole, "JPEG 2000 without planes")),
            },
            Content::Images(chunks) if self.info.codec == "j2k" => match &chunks[..] {
                [chunk] => j2k::codestream(chunk.bytes),
                _ => {
                    Err(Error::Parameter(format!("the file holds {} images, each with a codestream of its own", chunks.len())))
                }
            },
            _ => Err(Error::Parameter(format!("no JPEG 2000 codestream: the file is of the codec {}", self.info.codec))),
        }
    }

    /// The same wrapped as a JP2 file, for viewers that do not open a raw codestream.
    ///
    /// # Errors
    /// As [`Decoder::codestream`].
    pub fn jp2(&self) -> Result<Vec<u8>> {
        j2k::wrap(self.codestream()?)
    }

    /// The oriented manifold of triangles that the codec keeps; that is what an image is of.
    #[cfg(any(feature = "encode", feature = "png"))]
    pub(crate) fn decode_surface(&self, task: Task<'_>) -> Result<Mesh> {
        Ok(self.decode_image(task)?.0)
    }

    /// The same, and which of its vertices each pixel is if the file holds the image itself.
    #[cfg(any(feature = "encode", feature = "png"))]
    pub(crate) fn decode_image(&self, task: Task<'_>) -> Result<(Mesh, Option<Pixels>)> {
        let Content::Mesh(file) = &self.content else { return Ok((self.decode_with(task)?, None)) };
        let decoded = file.surface(self.info.effort, &mut Budget::new(self.limits), task)?;
        let lattice = file.header.lattice.lattice();
        let positions = decoded.positions.into_iter().map(|q| file.header.position(&lattice, q)).collect();
        Ok((Mesh::from_triangles(positions, decoded.skin.triangles), decoded.pixels))
    }
}

impl MeshFile<'_> {
    /// The surface that the codec keeps.
    fn surface(&self, effort: Effort, budget: &mut Budget, task: Task<'_>) -> Result<Decoded> {
        let header = &self.header;
        let (vertices, _) = self.parts.surface_size(header);
        budget.check_vertices(vertices.into())?;
        let is_plain = self.parts.fixes.is_none();
        let decoded = match &self.body {
            Body::Surface { chunk, stages } => {
                let census = census(vertices, chunk);
                let count = surface::ranges(census).len();
                let mut positions = vec![chunk.positions(count)?];
                for stage in stages {
                    positions.push(read_stage(stage.clone(), count + usize::from(chunk.has_region))?);
                }
                let plan = surface::Plan { effort, stages: &chunk.stages, has_region: chunk.has_region };
                let (connectivity, extent) = (chunk.connectivity, header.extent);
                let slide = chunk.slide.map(slide);
                let coded = surface::Coded { plan, slide, census, extent, connectivity, positions };
                let (surface, positions) = surface::read(&coded, budget, task)?;
                let skin = if is_plain { Skin::plain(surface.real_triangles()) } else { surface.skin() };
                return Ok(Decoded { skin, positions, triangles: census.closed_faces(), normals: Vec::new(), pixels: None });
            }
            Body::Mbcim { chunk, stages } => images::read_mbcim(chunk, stages, vertices, header.extent, budget, task)?,
            Body::Planes { chunk, codec, .. } => images::read_planes(chunk, &**codec, vertices, header.extent, budget, task)?,
        };
        let triangles = decoded.triangles.len() as u64;
        let skin = if is_plain {
            Skin::plain(decoded.triangles)
        } else {
            budget.reserve(triangles * Skin::BYTES_A_FACE)?;
            Skin::of_triangles(decoded.positions.len(), decoded.triangles)
                .map_err(|why| Error::malformed(Place::Whole, format!("the surface is none: {why}")))?
        };
        Ok(Decoded { skin, positions: decoded.positions, triangles, normals: decoded.normals, pixels: decoded.pixels })
    }
}

/// A surface on its lattice.
struct Decoded {
    skin: Skin,
    positions: Vec<[i32; 3]>,
    /// Triangles that the codec went through, fillings of holes included.
    triangles: u64,
    /// The octahedral normal of each vertex, if there are any.
    normals: Vec<[i32; 2]>,
    #[cfg_attr(not(feature = "png"), allow(dead_code))]
    pixels: Option<Pixels>,
}

fn slide(field: SlideField) -> Slide {
    Slide {
        fine: field.fine,
        longest: field.longest.unwrap_or(surface::LONGEST_STRETCH),
        filter: field.filter.map(surface::Filter),
    }
}

fn census(vertices: u32, surface: &SurfaceChunk<'_>) -> Census {
    Census { vertices, holes: surface.holes, components: surface.components, handles: surface.handles }
}

/// The codec of planes that a header names.
fn plane_codec(id: u8) -> Result<(Box<dyn PlaneCodec>, &'static str)> {
    match id {
        Header::RAW => Ok((Box::new(Raw), "raw")),
        #[cfg(feature = "exr")]
        Header::EXR => Ok((Box::new(Exr), "exr")),
        Header::J2K => Ok((Box::new(J2k::default()), "j2k")),
        other => Err(Error::Unsupported { what: "codec", id: other.to_string() }),
    }
}
