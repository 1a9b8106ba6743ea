//! Files of the method `gim`: their geometry image, at any of its levels.

use super::{ChunkInfo, Content, Decoder, Info, RoiInfo};
use crate::charts;
use crate::error::{Error, Place, Result};
use crate::format::{Chunks, ImageBody, ImageChunk};
use crate::limits::{Budget, Limits};
use crate::mesh::Scalar;
use crate::plane::{GeometryImage, RegionCells};
use crate::surface::Effort;
use crate::task::Task;

impl<'a> Decoder<'a> {
    pub(super) fn of_images(bytes: &'a [u8], chunks: &Chunks<'a>, limits: Limits) -> Result<Self> {
        chunks.check_known(&[ImageChunk::TAG])?;
        let of_images = chunks.iter().filter(|chunk| chunk.tag == ImageChunk::TAG);
        let images: Vec<_> = of_images.map(|chunk| ImageChunk::read(chunk.reader())).collect::<Result<_>>()?;
        let info = Info::of_images(bytes, chunks, &images)?;
        Ok(Self { content: Content::Images(images), level: 0, recipe: None, limits, info })
    }

    /// Decodes geometry images only down to a level: 0 is all of them, each further level halves their sides. Levels that
    /// an image has not are the coarsest that it has; files of other methods have none.
    pub fn level(mut self, level: u8) -> Self {
        self.level = level.min(self.info.levels);
        self
    }

    /// Decodes the geometry image of a file of the method `gim`, at the level asked for.
    ///
    /// # Errors
    /// As [`Decoder::decode`], and files that hold no geometry image, or several.
    pub fn geometry_image(&self) -> Result<GeometryImage> {
        self.geometry_image_with(Task::default())
    }

    /// The same under the eyes of a [`Task`].
    ///
    /// # Errors
    /// As [`Decoder::geometry_image`], and [`Error::Cancelled`].
    pub fn geometry_image_with(&self, task: Task<'_>) -> Result<GeometryImage> {
        let mut images = self.geometry_images_with(task)?;
        match (images.pop(), images.len()) {
            (Some(image), 0) => Ok(image),
            (_, others) => Err(Error::Parameter(format!("the file holds {} geometry images, not one", others + 1))),
        }
    }

    /// Decodes all geometry images of a file of the method `gim`, at the level asked for.
    ///
    /// # Errors
    /// As [`Decoder::decode`], files that hold no geometry image, and [`Error::Cancelled`].
    pub fn geometry_images_with(&self, task: Task<'_>) -> Result<Vec<GeometryImage>> {
        let Content::Images(chunks) = &self.content else {
            return Err(Error::Parameter("the file holds a mesh with its own connectivity and no geometry image".into()));
        };
        task.step(0.0)?;
        let mut budget = Budget::new(self.limits);
        let mut vertices = 0_u64;
        for chunk in chunks {
            vertices = vertices.saturating_add(charts::vertices_at(chunk, self.level)?);
        }
        budget.check_vertices(vertices)?;
        chunks.iter().map(|chunk| charts::read(chunk, self.level, &mut budget, task)).collect()
    }

    /// The region of interest of each geometry image of a file that has one: whether each sample, row by row, lies in one of its
    /// cells.
    ///
    /// # Errors
    /// As [`Decoder::geometry_images_with`], and files without a region.
    pub fn roi_samples(&self) -> Result<Vec<Vec<bool>>> {
        let regions = match &self.content {
            Content::Images(chunks) => {
                let mut budget = Budget::new(self.limits);
                chunks.iter().map(|chunk| charts::region(chunk, &mut budget)).collect::<Result<Vec<_>>>()?
            }
            _ => Vec::new(),
        };
        let regions: Option<Vec<_>> = regions.into_iter().collect();
        let regions = regions.filter(|some| !some.is_empty());
        let regions =
            regions.ok_or_else(|| Error::Parameter("the file has no geometry image with a region of interest".into()))?;
        let samples = |cells: &RegionCells| {
            let shape = cells.image();
            (0..shape.pixels()).map(|at| cells.has(at / shape.width(), at % shape.width())).collect()
        };
        Ok(regions.iter().map(samples).collect())
    }
}

impl Info {
    fn of_images(bytes: &[u8], chunks: &Chunks<'_>, images: &[ImageChunk<'_>]) -> Result<Self> {
        let (mut memory, mut work, mut vertices, mut faces, mut positions) = (0_u64, 0_u64, 0_u64, 0_u64, 0);
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let mut levels = 0;
        for image in images {
            let cost = charts::cost(image, 0)?;
            (memory, work) = (memory.saturating_add(cost.0), work.saturating_add(cost.1));
            (vertices, faces) = (vertices + image.vertices(), faces + image.faces());
            positions += image.bytes.len() as u64;
            let [low, high] = image.bounds();
            (0..3).for_each(|i| (bounds[0][i], bounds[1][i]) = (bounds[0][i].min(low[i]), bounds[1][i].max(high[i])));
            levels = levels.max(image.levels());
        }
        let whole = |n: u64, what: &str| {
            u32::try_from(n)
                .map_err(|_| Error::malformed(Place::Whole, format!("images of {n} {what}, more than 32 bits count")))
        };
        let Some(chunk) = images.first() else { return Err(Error::malformed(Place::Whole, "no geometry image")) };
        if images.iter().any(|image| image.double != chunk.double) {
            return Err(Error::malformed(Place::Whole, "images of different number types"));
        }
        let roi = chunk.region.map(|region| RoiInfo {
            bytes: images.iter().filter_map(|image| image.region).map(|region| region.bytes.len() as u64).sum(),
            psnr: (region.psnr > 0).then(|| f64::from(region.psnr) / 100.0),
            coarser: region.coarser,
            bits: None,
        });
        let says_more = |image: &ImageChunk<'_>| {
            image.psnr.is_some() || image.bound.is_some() || image.region.is_some_and(|region| region.psnr > 0)
        };
        if images[1..].iter().any(says_more) {
            return Err(Error::malformed(Place::Whole, "a psnr or a bound of an image that is not the first"));
        }
        let (step, origin, bits) = match chunk.body {
            ImageBody::Wavelet { step, .. } => (step.into(), [0.0; 3], None),
            ImageBody::Planes { depth, lattice, .. } => (lattice.step, lattice.origin, Some(depth.into())),
        };
        let largest = images.iter().max_by_key(|image| u64::from(image.rows) * u64::from(image.columns)).unwrap_or(chunk);
        let of_roi = roi.as_ref().map(|roi| ("roi", roi.bytes));
        let header = bytes.len() as u64 - positions - of_roi.map_or(0, |(_, bytes)| bytes);
        let parts = [("header", header), ("positions", positions)].into_iter().chain(of_roi).collect();
        let history = chunks.iter().find(|chunk| chunk.tag == ImageChunk::HISTORY);
        let info =
            |chunk: &crate::format::Chunk<'_>| ChunkInfo { tag: chunk.tag.escape_ascii().to_string(), bytes: chunk.size };
        Ok(Self {
            version: crate::format::VERSION,
            method: "gim",
            metric: "surface",
            codec: charts::codec_name(&chunk.body),
            effort: Effort::Default,
            vertices: whole(vertices, "vertices")?,
            faces: whole(faces, "triangles")?,
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
            parts,
            image: Some([largest.rows, largest.columns]),
            seams: images.iter().filter_map(|image| image.seams.as_ref()).map(|seams| seams.sides().len() / 2).sum(),
            has_holes: images.iter().any(|image| image.holes.is_some()),
            images: images.len(),
            stages: Vec::new(),
            stages_present: 0,
            boundaries: None,
            connectivity_exact: false,
            layers: None,
            normal_bits: 0,
            roi,
            memory,
            work,
        })
    }
}
