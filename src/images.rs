//! The doors of images: a mesh to the streams of an image codec, and back.
//!
//! One of the few files that see both wings. On the way in: half-edges → levels → words → index map and base
//! colours. On the way out: words → triangles → base colours → mesh; the image itself is made only for those who
//! want to look at it.

#[cfg(feature = "encode")]
use crate::cgim::{Image, Search, image, walls, words};
use crate::cgim::{Rebuilt, Recipe, VMatrix, matrix_triangles, rebuild, regions, word_triangles};
use crate::codec::PlaneCodec;
use crate::codec::mbcim::{Meetings, base_colour, ladder::Ladder, stage};
use crate::entropy::{BitReader, BitWriter};
use crate::error::{Error, Place, Result};
use crate::format::{MbcimChunk, PlanesChunk, RecipeChunk};
use crate::limits::Budget;
use crate::mesh::HalfEdges;
use crate::plane::{Levels, MAX_DEPTH, Plane, Planes, Shape};
use crate::task::Task;

/// An image file before it is packed.
#[cfg(feature = "encode")]
pub(crate) struct Streams {
    /// Chunks, in order.
    pub(crate) chunks: Vec<([u8; 4], Vec<u8>)>,
    /// The triangles as they come back.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The vertex of the mesh that each vertex of them was.
    pub(crate) order: Vec<u32>,
}

/// What an encoder may choose.
#[cfg(feature = "encode")]
#[derive(Debug, Clone, Copy)]
pub(crate) struct ImageOptions<'a> {
    /// Full sweeps of which the cheapest is stored.
    pub(crate) sweeps: usize,
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

    let Rebuilt { triangles, vertex, vertices } = words.rebuilt;
    let order = order(vertices, vertex.into_iter().zip(words.origin));
    let colours: Vec<[i32; 3]> = order.iter().map(|&v| positions[v as usize]).collect();
    let meetings = Meetings::new(&triangles, colours.len());
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
    Ok(Streams { chunks, triangles, order })
}

/// What each of the new vertices was, from pairs of both (those of dummies included).
#[cfg(feature = "encode")]
fn order(vertices: u32, pairs: impl Iterator<Item = (u32, u32)>) -> Vec<u32> {
    let mut order = vec![0; vertices as usize];
    for (new, old) in pairs {
        if let Some(place) = order.get_mut(new as usize) {
            *place = old;
        }
    }
    order
}

/// Searches for a small image of a mesh as a decoder will have it.
#[cfg(feature = "encode")]
pub(crate) fn search_recipe(mesh: &HalfEdges, search: &Search, task: Task<'_>) -> Result<RecipeChunk> {
    let image = image(mesh, search, &task)?;
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

/// Writes a mesh as planes of samples. `positions[v]` is the lattice position of vertex v.
#[cfg(feature = "encode")]
pub(crate) fn write_planes(
    surface: &HalfEdges,
    positions: &[[i32; 3]],
    extent: [i32; 3],
    codec: &dyn PlaneCodec,
    search: &Search,
    task: Task<'_>,
) -> Result<Streams> {
    let image = image(surface, search, &task)?;
    let depth = extent.into_iter().fold(1, |depth, e| depth.max(32 - e.leading_zeros())) as u8;
    if depth > MAX_DEPTH {
        return Err(Error::Parameter(format!(
            "samples of {depth} bits; this codec has at most {MAX_DEPTH}: take a larger step"
        )));
    }
    let triangles = matrix_triangles(&image.matrix, image.regions(), &image.side, &mut unlimited())?;
    let colours = region_colours(&image, positions, &triangles);
    let pixel = |p: usize| colours[image.matrix.entries()[p] as usize];
    let walls = walls(&image.matrix, &image.side.blocks, |p, q| pixel(p) == pixel(q));
    let shape = Shape::new(image.matrix.columns() as u32, image.matrix.rows() as u32)?;
    let plane = |axis: usize| Plane::new(shape, depth, (0..shape.pixels()).map(|p| pixel(p)[axis]).collect());
    let samples = codec.encode(&Planes::new(vec![plane(0)?, plane(1)?, plane(2)?])?, &task)?;
    let chunk = PlanesChunk {
        columns: shape.width() as u32,
        rows: shape.height() as u32,
        depth,
        side: image.side,
        side_size: 0,
        walls,
        samples: &samples,
    };
    // The regions as a reader finds and numbers them.
    let same_colour = |p, q| pixel(p) == pixel(q);
    let found = regions(shape.height(), shape.width(), &chunk.side.blocks, &chunk.walls, same_colour);
    let (entries, count) = found.ok_or_else(|| Error::Parameter("the image does not hold the surface".into()))?;
    let matrix = VMatrix::new(shape.width(), entries);
    let triangles = matrix_triangles(&matrix, count, &chunk.side, &mut unlimited())?;
    let rebuilt = rebuild(triangles, count, &chunk.side, &mut unlimited())?;
    let now = matrix.entries().iter().map(|&region| rebuilt.vertex[region as usize]);
    let then = image.matrix.entries().iter().map(|&region| image.origin[region as usize]);
    let order = order(rebuilt.vertices, now.zip(then));
    Ok(Streams { chunks: vec![(PlanesChunk::TAG, chunk.write())], triangles: rebuilt.triangles, order })
}

/// The position of every region; where a hole was filled, the mean of those around it.
#[cfg(feature = "encode")]
fn region_colours(image: &Image, positions: &[[i32; 3]], triangles: &[[u32; 3]]) -> Vec<[i32; 3]> {
    let known = |region: u32| positions.get(image.origin[region as usize] as usize);
    let mut around = std::collections::HashMap::new();
    for t in triangles.iter().filter(|t| t.iter().any(|&r| known(r).is_none())) {
        let dummy = t.iter().find(|&&r| known(r).is_none()).map_or(0, |&r| image.origin[r as usize]);
        let (sum, count) = around.entry(dummy).or_insert(([0_i64; 3], 0_i64));
        for p in t.iter().filter_map(|&r| known(r)) {
            (0..3).for_each(|i| sum[i] += i64::from(p[i]));
            *count += 1;
        }
    }
    let mean = |v: &u32| around.get(v).map_or([0; 3], |(sum, count)| sum.map(|s| (s / count.max(&1)) as i32));
    image.origin.iter().map(|v| positions.get(*v as usize).copied().unwrap_or_else(|| mean(v))).collect()
}

/// Memory and steps that reading planes takes, as far as the chunk tells.
pub(crate) fn planes_cost(chunk: &PlanesChunk<'_>, faces: u32) -> (u64, u64) {
    let (pixels, faces) = (u64::from(chunk.columns) * u64::from(chunk.rows), u64::from(faces));
    let (memory, work) = (pixels.saturating_mul(72), pixels.saturating_mul(30));
    let memory = memory.saturating_add(faces * crate::cgim::BYTES_A_TRIANGLE);
    (memory, work.saturating_add(faces * crate::cgim::STEPS_A_TRIANGLE))
}

/// Reads what [`write_planes`] wrote.
pub(crate) fn read_planes(
    chunk: &PlanesChunk<'_>,
    codec: &dyn PlaneCodec,
    vertices: u32,
    extent: [i32; 3],
    budget: &mut Budget,
    task: Task<'_>,
) -> Result<Decoded> {
    let malformed = |why: String| Error::malformed(Place::Whole, why);
    budget.check_pixels(u64::from(chunk.columns) * u64::from(chunk.rows))?;
    let shape = Shape::new(chunk.columns, chunk.rows).map_err(|e| malformed(e.to_string()))?;
    if chunk.side.blocks.iter().map(|block| u64::from(block.rows)).sum::<u64>() != u64::from(chunk.rows) {
        return Err(malformed(format!("blocks that do not add up to the {} rows of the image", chunk.rows)));
    }
    if !(1..=MAX_DEPTH).contains(&chunk.depth) {
        return Err(malformed(format!("samples of {} bits, 1 to {MAX_DEPTH} expected", chunk.depth)));
    }
    let planes = codec.decode(chunk.samples, shape, &[chunk.depth; 3], budget)?;
    task.step(0.3)?;
    let pixels = shape.pixels() as u64;
    budget.reserve(pixels * 24)?;
    budget.spend(pixels * 12)?;
    let colour = |p: usize| [0, 1, 2].map(|i| planes[i].samples()[p]);
    let found = regions(shape.height(), shape.width(), &chunk.side.blocks, &chunk.walls, |p, q| colour(p) == colour(q));
    let (entries, count) = found.ok_or_else(|| malformed("a wall between pixels of different colours".into()))?;
    let matrix = VMatrix::new(shape.width(), entries);
    let triangles = matrix_triangles(&matrix, count, &chunk.side, budget)?;
    let rebuilt = rebuild(triangles, count, &chunk.side, budget)?;
    if rebuilt.vertices != vertices {
        return Err(malformed(format!("{} vertices were decoded, the header says {vertices}", rebuilt.vertices)));
    }
    let mut positions = budget.vec(vertices as usize, [-1; 3])?;
    for (p, &region) in matrix.entries().iter().enumerate() {
        let Some(position) = positions.get_mut(rebuilt.vertex[region as usize] as usize) else { continue };
        if position[0] >= 0 && *position != colour(p) {
            return Err(malformed("two colours for one vertex".into()));
        }
        *position = colour(p);
        if (0..3).any(|i| position[i] > extent[i]) {
            return Err(malformed(format!("pixel {p} is outside the box")));
        }
    }
    Ok(Decoded { triangles: rebuilt.triangles, positions })
}

#[cfg(feature = "encode")]
fn unlimited() -> Budget {
    Budget::new(crate::Limits::default().memory(u64::MAX).work(u64::MAX).vertices(u64::MAX).pixels(u64::MAX))
}
