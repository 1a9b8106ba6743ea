//! What a file says of itself before it is decoded.

use super::{Body, census, slide};
use crate::codec::j2k;
use crate::error::{Error, Result};
use crate::extras::{AttributeInfo, Parts};
use crate::format::{Borders, Chunks, Header, LatticeForm, RecipeChunk};
use crate::images;
use crate::mesh::Scalar;
use crate::plane::Gluing;
use crate::surface::{self, Effort};

/// What a file says of itself before it is decoded.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Info {
    /// The version of the format.
    pub version: u8,
    /// `cgim`: the connectivity is kept exactly; `gim`: the surface was sampled as a geometry image.
    pub method: &'static str,
    /// How the mesh became bytes.
    pub codec: &'static str,
    /// What the error is measured on: `vertex`, or `surface`. On a surface, vertices may have slid along it.
    pub metric: &'static str,
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
    /// The distance of lattice points; where vertices slide, that along normals.
    pub step: f64,
    /// log₂ of the lattice points on the longest side of the box, if the lattice was chosen so.
    pub bits: Option<u32>,
    /// Whether every coordinate is kept bit by bit.
    pub exact: bool,
    /// No point of the original surface is farther than this from the decoded one, nor the other way round; infinite where
    /// a geometry image states none. It is said of the whole file, not of a coarser level.
    pub bound: f64,
    /// The psnr of a geometry image against its original, in dB, if the file states it.
    pub psnr: Option<f64>,
    /// How often a geometry image can be halved without decoding its finer levels.
    pub levels: u8,
    /// How the border of a geometry image is glued.
    pub gluing: Option<Gluing>,
    /// How the image came about, if the file tells.
    pub history: Option<String>,
    /// The number type of the positions.
    pub precision: Scalar,
    /// Whether the mesh is an oriented manifold of triangles that uses all its vertices.
    pub manifold: bool,
    /// Attributes, in the order of the mesh.
    pub attributes: Vec<AttributeInfo>,
    /// The chunks in the order of the file.
    pub chunks: Vec<ChunkInfo>,
    /// The bytes by what they are for; they add up to the size of the file.
    pub parts: Vec<(&'static str, u64)>,
    /// Seams along which the borders of geometry images are glued.
    pub seams: usize,
    /// Whether parts of geometry images are no surface.
    pub has_holes: bool,
    /// How many geometry images there are; 0 in files of other methods.
    pub images: usize,
    /// Rows and columns of the largest geometry image, or of the image of vertices if the file says how to make one.
    pub image: Option<[u32; 2]>,
    /// Bits that each stage after the first adds to every coordinate; one entry a stage.
    pub stages: Vec<u8>,
    /// How many of the stages the file still has.
    pub stages_present: usize,
    /// How the pixels of lossy planes are told apart: `exact` by an index map, `implied` by the cluster phase.
    pub boundaries: Option<&'static str>,
    /// Whether the connectivity is that of the original. Only the cluster phase may fail to find it.
    pub connectivity_exact: bool,
    /// Quality layers of a JPEG 2000 codestream.
    pub layers: Option<u8>,
    /// Bits of each of the two planes of normals; 0 if there are none.
    pub normal_bits: u8,
    /// The region of interest, if the file has one.
    pub roi: Option<RoiInfo>,
    /// Bytes of memory that decoding takes at most.
    pub memory: u64,
    /// Steps of work that decoding takes, as far as the header tells.
    pub work: u64,
}

/// What a file says of its region of interest.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct RoiInfo {
    /// Bytes that say where it is, and of what it has more than the rest.
    pub bytes: u64,
    /// The psnr of the region, in dB: from its points to the decoded surface.
    pub psnr: Option<f64>,
    /// Geometry images: away from it quantiser steps are 2 to this times as large.
    pub coarser: u8,
    /// Exact connectivity: bits of the lattice inside.
    pub bits: Option<u32>,
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

impl Info {
    /// Leaves no more than `count` stages beside the base.
    pub(super) fn cut(&mut self, header: &Header, count: usize) {
        self.stages_present = self.stages_present.min(count);
        self.bound = bound(header, &self.stages, self.stages_present);
    }

    pub(super) fn new(
        bytes: &[u8],
        chunks: &Chunks<'_>,
        header: &Header,
        body: &Body<'_>,
        beside: &Parts<'_>,
        recipe: Option<&RecipeChunk>,
    ) -> Result<Self> {
        let lattice = header.lattice.lattice();
        let bits = match header.lattice {
            LatticeForm::Box { bits, .. } if !header.extras.exact => Some(bits),
            _ => None,
        };
        let (vertices, faces) = beside.surface_size(header);
        let mut triangles = u64::from(faces);
        let mut roi = None;
        let (codec, effort, connectivity, positions, mut cost) = match body {
            Body::Surface { chunk, stages } => {
                let effort = match chunk.effort {
                    0 => Effort::Fast,
                    1 => Effort::Default,
                    2 => Effort::Best,
                    other => return Err(Error::Unsupported { what: "effort", id: other.to_string() }),
                };
                let connectivity = chunk.connectivity.len() as u64;
                let census = census(vertices, chunk);
                triangles = census.closed_faces();
                let mut later: usize = stages.iter().map(|stage| stage.clone().rest().len()).sum();
                let cost = surface::cost(census, effort, stages.len() as u64 + 1, chunk.has_region, chunk.slide.map(slide));
                if chunk.has_region {
                    let bits = bits.filter(|_| !stages.is_empty());
                    roi = Some(RoiInfo { bytes: later as u64, psnr: None, coarser: 0, bits });
                    later = 0;
                }
                ("surface", effort, connectivity, chunk.positions_size() + later as u64, cost)
            }
            Body::Mbcim { chunk, stages } => {
                let positions = chunk.colours.len() + stages.iter().map(|stage| stage.len()).sum::<usize>();
                let connectivity = chunk.map.len() + chunk.side_size;
                ("mbcim", Effort::Default, connectivity as u64, positions as u64, images::cost(chunk, vertices, faces))
            }
            Body::Planes { chunk, name, .. } => {
                let cost = images::planes_cost(chunk, faces);
                (*name, Effort::Default, chunk.side_size as u64, chunk.samples.len() as u64, cost)
            }
        };
        let (stages, stages_present) = match body {
            Body::Surface { chunk, stages } => (chunk.stages.clone(), stages.len()),
            Body::Mbcim { chunk, stages } => (chunk.stages.clone(), stages.len().min(chunk.stages.len())),
            Body::Planes { .. } => (Vec::new(), 0),
        };
        let slides = matches!(body, Body::Surface { chunk, .. } if chunk.slide.is_some());
        let (mut boundaries, mut connectivity_exact, mut layers, mut normal_bits) = (None, true, None, 0);
        if let Body::Planes { chunk, .. } = body {
            (boundaries, connectivity_exact) = match chunk.borders {
                Borders::Colours => (None, true),
                Borders::Words { .. } | Borders::Map { .. } => (Some("exact"), true),
                Borders::Counts { exact, .. } => (Some("implied"), exact),
            };
            normal_bits = chunk.normal_depth;
            if header.codec == Header::J2K {
                layers = Some(j2k::profile(j2k::codestream(chunk.samples)?)?.layers);
            }
        }
        let image = match body {
            Body::Planes { chunk, .. } => Some([chunk.rows, chunk.columns]),
            Body::Mbcim { chunk, .. } if chunk.raster.is_some() => chunk.raster,
            _ => recipe.map(|chunk| [chunk.rows, chunk.columns]),
        };
        let mut parts = vec![("header", 0), ("connectivity", connectivity), ("positions", positions)];
        parts.extend(roi.as_ref().map(|roi: &RoiInfo| ("roi", roi.bytes)));
        parts.extend(beside.sizes());
        parts[0].1 = bytes.len() as u64 - parts.iter().map(|part| part.1).sum::<u64>();
        let (memory, work) = beside.cost(header, triangles);
        cost = (cost.0.saturating_add(memory), cost.1.saturating_add(work));
        Ok(Self {
            version: crate::format::VERSION,
            method: "cgim",
            codec,
            metric: if slides { "surface" } else { "vertex" },
            effort,
            vertices: header.vertices,
            faces: header.faces,
            bounds: [header.corner(false), header.corner(true)],
            origin: lattice.origin,
            step: lattice.step * if slides { surface::PARTS } else { 1.0 },
            bits,
            exact: header.extras.exact,
            bound: bound(header, &stages, stages_present),
            psnr: None,
            levels: 0,
            gluing: None,
            history: None,
            precision: if header.double { Scalar::F64 } else { Scalar::F32 },
            manifold: beside.fixes.is_none(),
            attributes: beside.attributes(),
            chunks: chunks
                .iter()
                .map(|chunk| ChunkInfo { tag: chunk.tag.escape_ascii().to_string(), bytes: chunk.size })
                .collect(),
            parts,
            seams: 0,
            has_holes: false,
            images: 0,
            image,
            stages,
            stages_present,
            boundaries,
            connectivity_exact,
            layers,
            normal_bits,
            roi,
            memory: cost.0,
            work: cost.1,
        })
    }
}

/// How far a vertex can be from where it was, if no more than the first `present` stages are decoded.
fn bound(header: &Header, stages: &[u8], present: usize) -> f64 {
    let missing: u32 = stages[present..].iter().map(|&bits| u32::from(bits)).sum();
    if missing == 0 {
        return header.bound.into();
    }
    // It then stands in the middle of its cell, on each axis at most half a cell away, and is rounded once more.
    let half_cell = f64::from(1_u32 << (missing - 1)) * header.lattice.lattice().step;
    let largest = [false, true].iter().flat_map(|&high| header.corner(high)).fold(0.0, |most: f64, x| most.max(x.abs()));
    let rounding = if header.double { f64::EPSILON } else { f64::from(f32::EPSILON) } * largest;
    f64::from(header.bound) + 3_f64.sqrt() * (half_cell + rounding)
}
