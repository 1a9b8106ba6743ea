//! Index map and base colours: the codec mbcim (spec/mbcim.md).
//!
//! The map is mostly there as the words between its rows, from which the matrix of least width follows. A matrix that
//! was made otherwise is stored pixel by pixel.

use super::Decoded;
#[cfg(feature = "encode")]
use super::Streams;
use super::borders::{read_map, read_words};
#[cfg(feature = "encode")]
use super::borders::{write_map, write_words};
use super::planes::vertices_of;
#[cfg(feature = "encode")]
use super::unlimited;
#[cfg(feature = "encode")]
use crate::cgim::{Rebuilt, Search, image, words};
use crate::cgim::{matrix_triangles, rebuild, word_triangles};
use crate::codec::mbcim::{Meetings, base_colour, ladder::Ladder, stage};
use crate::entropy::BitReader;
#[cfg(feature = "encode")]
use crate::entropy::BitWriter;
use crate::error::{Error, Place, Result};
use crate::format::MbcimChunk;
#[cfg(feature = "encode")]
use crate::format::STAGE;
use crate::limits::Budget;
#[cfg(feature = "encode")]
use crate::mesh::HalfEdges;
use crate::plane::Shape;
#[cfg(feature = "encode")]
use crate::plane::{Levels, SideInformation};
use crate::task::Task;

/// What an encoder may choose.
#[cfg(feature = "encode")]
#[derive(Debug, Clone, Copy)]
pub(crate) struct ImageOptions<'a> {
    /// Full sweeps of which the cheapest is stored.
    pub(crate) sweeps: usize,
    /// Bits that each stage adds to the base colours.
    pub(crate) stages: &'a [u8],
    /// The image that is to be stored pixel by pixel, instead of words.
    pub(crate) image: Option<&'a Search>,
}

/// An index map before it is packed.
#[cfg(feature = "encode")]
struct Map {
    stream: Vec<u8>,
    side: SideInformation,
    origin: Vec<u32>,
    raster: Option<[u32; 2]>,
    rebuilt: Rebuilt,
}

/// Writes a mesh with the codec mbcim. `positions[v]` is the lattice position of vertex v.
#[cfg(feature = "encode")]
pub(crate) fn write_mbcim(
    surface: &HalfEdges,
    positions: &[[i32; 3]],
    extent: [i32; 3],
    options: &ImageOptions<'_>,
    task: Task<'_>,
) -> Result<Streams> {
    let map = match options.image {
        Some(search) => raster_map(surface, search, task)?,
        None => word_map(surface, options.sweeps, task)?,
    };
    let Rebuilt { triangles, vertex, vertices } = map.rebuilt;
    let mut order = vec![0; vertices as usize];
    for (&new, &old) in vertex.iter().zip(&map.origin) {
        if let Some(place) = order.get_mut(new as usize) {
            *place = old;
        }
    }
    let colours: Vec<[i32; 3]> = order.iter().map(|&v| positions[v as usize]).collect();
    let meetings = Meetings::new(&triangles, colours.len());
    let mut rest: u32 = options.stages.iter().map(|&b| u32::from(b)).sum();
    let mut coarse: Vec<[i32; 3]> = colours.iter().map(|c| c.map(|x| x >> rest)).collect();
    let mut coder = BitWriter::default();
    base_colour::code(&mut coder, &meetings, extent.map(|e| e >> rest), &mut coarse, task)?;
    let base = coder.finish();
    let chunk = MbcimChunk {
        side: map.side,
        side_size: 0,
        regions: map.origin.len() as u32,
        raster: map.raster,
        stages: options.stages.to_vec(),
        map: &map.stream,
        colours: &base,
    };
    let mut chunks = vec![(MbcimChunk::TAG, chunk.write())];
    for &bits in options.stages {
        rest -= u32::from(bits);
        let finer: Vec<[i32; 3]> = colours.iter().map(|c| c.map(|x| x >> rest)).collect();
        let mut coder = BitWriter::default();
        stage::code(&mut coder, &meetings, bits.into(), extent.map(|e| e >> rest), &mut coarse, Some(&finer))?;
        chunks.push((STAGE, coder.finish()));
    }
    Ok(Streams { chunks, triangles, order })
}

#[cfg(feature = "encode")]
fn word_map(surface: &HalfEdges, sweeps: usize, task: Task<'_>) -> Result<Map> {
    let cost = |levels: &Levels| {
        // Ids in the order in which the words meet them.
        let mut ids = std::collections::HashMap::new();
        let levels = levels.clone().map(|v| {
            let next = ids.len() as u32;
            *ids.entry(v).or_insert(next)
        });
        write_words(std::slice::from_ref(&levels), ids.len() as u32, &mut unlimited()).map_or(usize::MAX, |map| map.len())
    };
    let words = words(surface, sweeps, cost, &task)?;
    let stream = write_words(&words.blocks, words.origin.len() as u32, &mut unlimited())?;
    Ok(Map { stream, side: words.side, origin: words.origin, raster: None, rebuilt: words.rebuilt })
}

#[cfg(feature = "encode")]
fn raster_map(surface: &HalfEdges, search: &Search, task: Task<'_>) -> Result<Map> {
    let image = image(surface, search, &task)?;
    let regions = image.regions();
    let stream = write_map(&image.matrix, regions, &mut unlimited())?;
    let triangles = matrix_triangles(&image.matrix, regions, &image.side, &mut unlimited())?;
    let rebuilt = rebuild(triangles, regions, &image.side, &mut unlimited())?;
    let raster = Some([image.matrix.rows() as u32, image.matrix.columns() as u32]);
    Ok(Map { stream, side: image.side, origin: image.origin, raster, rebuilt })
}

/// Memory and steps that reading an mbcim file takes, as far as the header tells.
pub(crate) fn cost(chunk: &MbcimChunk<'_>, vertices: u32, faces: u32) -> (u64, u64) {
    let (vertices, faces) = (u64::from(vertices), u64::from(faces));
    let pixels = chunk.raster.map_or(0, |[rows, columns]| u64::from(rows) * u64::from(columns));
    let memory = faces * (crate::cgim::BYTES_A_TRIANGLE + Meetings::BYTES) + vertices * (base_colour::BYTES + 1000);
    let memory = memory.saturating_add(pixels.saturating_mul(40)).saturating_add(Ladder::bytes(chunk.regions as usize));
    let work = faces * crate::cgim::STEPS_A_TRIANGLE + vertices * (base_colour::STEPS + 64);
    (memory, work.saturating_add(pixels.saturating_mul(30)))
}

/// Reads what [`write_mbcim`] wrote, as far as there are stages.
pub(crate) fn read_mbcim(
    chunk: &MbcimChunk<'_>,
    stages: &[&[u8]],
    vertices: u32,
    extent: [i32; 3],
    budget: &mut Budget,
    task: Task<'_>,
) -> Result<Decoded> {
    let malformed = |why: String| Error::malformed(Place::Whole, why);
    let (triangles, matrix) = match chunk.raster {
        None => {
            let blocks = read_words(chunk.map, &chunk.side.blocks, chunk.regions, budget)?;
            (word_triangles(&blocks, chunk.regions, &chunk.side)?, None)
        }
        Some([rows, columns]) => {
            budget.check_pixels(u64::from(columns) * u64::from(rows))?;
            let shape = Shape::new(columns, rows).map_err(|e| malformed(e.to_string()))?;
            let matrix = read_map(chunk.map, [shape.height(), shape.width()], chunk.regions, budget)?;
            budget.reserve(24 * shape.pixels() as u64)?;
            (matrix_triangles(&matrix, chunk.regions, &chunk.side, budget)?, Some(matrix))
        }
    };
    let rebuilt = rebuild(triangles, chunk.regions, &chunk.side, budget)?;
    if rebuilt.vertices != vertices {
        return Err(malformed(format!("{} vertices were decoded, the header says {vertices}", rebuilt.vertices)));
    }
    budget.reserve(rebuilt.triangles.len() as u64 * Meetings::BYTES + u64::from(vertices) * base_colour::BYTES)?;
    budget.spend(u64::from(vertices) * base_colour::STEPS)?;
    let meetings = Meetings::new(&rebuilt.triangles, vertices as usize);
    let mut colours = budget.vec(vertices as usize, [0; 3])?;
    let mut rest: u32 = chunk.stages.iter().map(|&b| u32::from(b)).sum();
    base_colour::code(&mut BitReader::new(chunk.colours), &meetings, extent.map(|e| e >> rest), &mut colours, task)?;
    for (&bits, stream) in chunk.stages.iter().zip(stages) {
        task.step(0.5)?;
        rest -= u32::from(bits);
        let mut coder = BitReader::new(stream);
        stage::code(&mut coder, &meetings, bits.into(), extent.map(|e| e >> rest), &mut colours, None)?;
    }
    if rest > 0 {
        // What is not known stands in the middle of its cell.
        for colour in &mut colours {
            *colour = [0, 1, 2].map(|i| ((colour[i] << rest) + (1 << rest >> 1)).min(extent[i]));
        }
    }
    let pixels = matrix.map(|matrix| vertices_of(&matrix, &rebuilt));
    Ok(Decoded { triangles: rebuilt.triangles, positions: colours, normals: Vec::new(), pixels })
}
