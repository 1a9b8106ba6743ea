//! The doors of images: a mesh to the streams of an image codec, and back.
//!
//! One of the few files that see both wings. On the way in: half-edges → levels → words → index map and base
//! colours. On the way out: words → triangles → base colours → mesh; the image itself is made only for those who
//! want to look at it.

use crate::cgim::{Rebuilt, Recipe, rebuild, word_triangles};
#[cfg(feature = "encode")]
use crate::cgim::{Search, image, words};
use crate::codec::mbcim::{Meetings, base_colour, ladder::Ladder, stage};
use crate::entropy::{BitReader, BitWriter};
use crate::error::{Error, Place, Result};
use crate::format::{MbcimChunk, RecipeChunk};
use crate::limits::Budget;
use crate::mesh::HalfEdges;
use crate::plane::Levels;
use crate::task::Task;

/// An image file before it is packed: chunks, in order.
#[cfg(feature = "encode")]
pub(crate) struct Streams {
    pub(crate) chunks: Vec<([u8; 4], Vec<u8>)>,
}

/// What an encoder may choose.
#[cfg(feature = "encode")]
#[derive(Debug, Clone, Copy)]
pub(crate) struct ImageOptions<'a> {
    /// Full sweeps of which the cheapest is stored.
    pub(crate) sweeps: usize,
    /// The search for a small image.
    pub(crate) search: Search,
    /// Bits that each stage adds to the base colours.
    pub(crate) stages: &'a [u8],
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
    let mut unlimited = Budget::new(crate::Limits::default().memory(u64::MAX).work(u64::MAX).vertices(u64::MAX));
    let cost = |levels: &Levels| {
        let mut unlimited = Budget::new(crate::Limits::default().memory(u64::MAX).work(u64::MAX));
        // Ids in the order in which the words meet them.
        let mut ids = std::collections::HashMap::new();
        let levels = levels.clone().map(|v| {
            let next = ids.len() as u32;
            *ids.entry(v).or_insert(next)
        });
        write_map(std::slice::from_ref(&levels), ids.len() as u32, &mut unlimited).map_or(usize::MAX, |map| map.len())
    };
    let words = words(surface, options.sweeps, cost, &task)?;
    let regions = words.origin.len() as u32;
    let map = write_map(&words.blocks, regions, &mut unlimited)?;

    let Rebuilt { triangles, vertex, vertices } = &words.rebuilt;
    let mut colours = vec![[0; 3]; *vertices as usize];
    for (&new, &old) in vertex.iter().zip(&words.origin) {
        if let Some(colour) = colours.get_mut(new as usize) {
            *colour = positions[old as usize];
        }
    }
    let meetings = Meetings::new(triangles, colours.len());
    let mut rest: u32 = options.stages.iter().map(|&b| u32::from(b)).sum();
    let mut coarse: Vec<[i32; 3]> = colours.iter().map(|c| c.map(|x| x >> rest)).collect();
    let mut coder = BitWriter::default();
    base_colour::code(&mut coder, &meetings, extent.map(|e| e >> rest), &mut coarse, task)?;
    let base = coder.finish();
    let mut chunks = vec![(MbcimChunk::TAG, MbcimChunk::write(&words.side, regions, options.stages, &map, &base))];
    for &bits in options.stages {
        rest -= u32::from(bits);
        let finer: Vec<[i32; 3]> = colours.iter().map(|c| c.map(|x| x >> rest)).collect();
        let mut coder = BitWriter::default();
        stage::code(&mut coder, &meetings, bits.into(), extent.map(|e| e >> rest), &mut coarse, Some(&finer))?;
        chunks.push((MbcimChunk::STAGE, coder.finish()));
    }
    if options.search.trials > 1 {
        let mesh = HalfEdges::new(colours.len(), triangles.clone())?;
        chunks.push((RecipeChunk::TAG, search_recipe(&mesh, &options.search, &task)?.write()));
    }
    Ok(Streams { chunks })
}

/// Searches for a small image of a mesh as a decoder will have it.
#[cfg(feature = "encode")]
pub(crate) fn search_recipe(mesh: &HalfEdges, search: &Search, task: &Task<'_>) -> Result<RecipeChunk> {
    let image = image(mesh, search, task)?;
    let (rows, columns) = (image.matrix.rows() as u32, image.matrix.columns() as u32);
    Ok(RecipeChunk { rows, columns, recipes: image.recipes.iter().map(Recipe::pack).collect() })
}

#[cfg(feature = "encode")]
fn write_map(blocks: &[Levels], regions: u32, budget: &mut Budget) -> Result<Vec<u8>> {
    let mut coder = BitWriter::default();
    let mut ladder = Ladder::new(regions as usize);
    for levels in blocks {
        ladder.code(&mut coder, Some(levels), levels.len() as u32, regions, budget)?;
    }
    Ok(coder.finish())
}

/// Memory and steps that reading an mbcim file takes, as far as the header tells.
pub(crate) fn cost(vertices: u32, faces: u32) -> (u64, u64) {
    let (vertices, faces) = (u64::from(vertices), u64::from(faces));
    let memory = faces * (crate::cgim::BYTES_A_TRIANGLE + Meetings::BYTES) + vertices * (base_colour::BYTES + 1000);
    (memory, faces * crate::cgim::STEPS_A_TRIANGLE + vertices * (base_colour::STEPS + 64))
}

/// A decoded mesh on its lattice.
pub(crate) struct Decoded {
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) positions: Vec<[i32; 3]>,
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
    // Every region beside a vertex is a dummy or doubles one along a seam.
    budget.reserve(Ladder::bytes(chunk.regions as usize))?;
    let mut ladder = Ladder::new(chunk.regions as usize);
    let mut coder = BitReader::new(chunk.map);
    let blocks = chunk.side.blocks.iter().map(|block| ladder.code(&mut coder, None, block.rows, chunk.regions, budget));
    let blocks = blocks.collect::<Result<Vec<_>>>()?;
    if ladder.ids() != chunk.regions {
        return Err(malformed(format!("an index map of {} regions, {} expected", ladder.ids(), chunk.regions)));
    }
    let triangles = word_triangles(&blocks, chunk.regions, &chunk.side)?;
    drop(blocks);
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
    Ok(Decoded { triangles: rebuilt.triangles, positions: colours })
}
