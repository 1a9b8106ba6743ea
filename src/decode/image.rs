//! Files of the method `gim`: their geometry image, at any of its levels.

use super::{ChunkInfo, Content, Decoder, Info};
use crate::charts;
use crate::error::{Error, Result};
use crate::format::{Chunks, ImageBody, ImageChunk};
use crate::limits::{Budget, Limits};
use crate::mesh::Scalar;
use crate::plane::GeometryImage;
use crate::surface::Effort;
use crate::task::Task;

impl<'a> Decoder<'a> {
    pub(super) fn of_image(bytes: &'a [u8], chunks: &Chunks<'a>, limits: Limits) -> Result<Self> {
        chunks.check_known(&[ImageChunk::TAG])?;
        let chunk = ImageChunk::read(chunks.one(ImageChunk::TAG)?.reader())?;
        let info = Info::of_image(bytes, chunks, &chunk)?;
        Ok(Self { content: Content::Image(chunk), level: 0, recipe: None, limits, info })
    }

    /// Decodes a geometry image only down to a level: 0 is all of it, each further level halves its sides. Levels that the
    /// file has not are the coarsest that it has; files of other methods have none.
    pub fn level(mut self, level: u8) -> Self {
        self.level = level.min(self.info.levels);
        self
    }

    /// Decodes the geometry image of a file of the method `gim`, at the level asked for.
    ///
    /// # Errors
    /// As [`Decoder::decode`], and files that hold no geometry image.
    pub fn geometry_image(&self) -> Result<GeometryImage> {
        self.geometry_image_with(Task::default())
    }

    /// The same under the eyes of a [`Task`].
    ///
    /// # Errors
    /// As [`Decoder::geometry_image`], and [`Error::Cancelled`].
    pub fn geometry_image_with(&self, task: Task<'_>) -> Result<GeometryImage> {
        let Content::Image(chunk) = &self.content else {
            return Err(Error::Parameter("the file holds a mesh with its own connectivity and no geometry image".into()));
        };
        task.step(0.0)?;
        let mut budget = Budget::new(self.limits);
        let [columns, rows] = charts::size_at(chunk, self.level)?;
        budget.check_vertices(crate::format::vertices(columns, rows, chunk.gluing))?;
        charts::read(chunk, self.level, &mut budget, task)
    }
}

impl Info {
    fn of_image(bytes: &[u8], chunks: &Chunks<'_>, chunk: &ImageChunk<'_>) -> Result<Self> {
        let (memory, work) = charts::cost(chunk, 0)?;
        let positions = chunk.bytes.len() as u64;
        let (levels, step, bounds, origin, bits) = match chunk.body {
            ImageBody::Wavelet { levels, step, bounds } => (levels, step.into(), bounds.bounds(), [0.0; 3], None),
            ImageBody::Planes { depth, lattice, .. } => {
                let bounds = [lattice.origin, lattice.point([(1 << depth) - 1; 3])];
                (0, lattice.step, bounds, lattice.origin, Some(depth.into()))
            }
        };
        let history = chunks.iter().find(|chunk| chunk.tag == ImageChunk::HISTORY);
        let info =
            |chunk: &crate::format::Chunk<'_>| ChunkInfo { tag: chunk.tag.escape_ascii().to_string(), bytes: chunk.size };
        Ok(Self {
            version: crate::format::VERSION,
            method: "gim",
            codec: charts::codec_name(&chunk.body),
            effort: Effort::Default,
            vertices: chunk.vertices() as u32,
            faces: chunk.faces() as u32,
            bounds,
            origin,
            step,
            bits,
            exact: false,
            bound: chunk.bound.map_or(f64::INFINITY, f64::from),
            psnr: chunk.psnr.map(|p| f64::from(p) / 100.0),
            levels,
            gluing: Some(chunk.gluing),
            history: history.map(|chunk| String::from_utf8_lossy(chunk.payload).into_owned()),
            precision: if chunk.double { Scalar::F64 } else { Scalar::F32 },
            manifold: true,
            attributes: Vec::new(),
            chunks: chunks.iter().map(info).collect(),
            parts: vec![("header", bytes.len() as u64 - positions), ("positions", positions)],
            image: Some([chunk.rows, chunk.columns]),
            stages: Vec::new(),
            stages_present: 0,
            boundaries: None,
            connectivity_exact: false,
            layers: None,
            normal_bits: 0,
            memory,
            work,
        })
    }
}
