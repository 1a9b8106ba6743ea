//! The codec `surface`: a mesh coded by walking over it.
//!
//! First the connectivity ([`walk`]), vertex by vertex, as valences; then, with all of the surface
//! known, the positions. The one room that knows both meshes and decisions. spec/surface.md is the
//! normative text.

mod gates;
pub(crate) mod labels;
mod learned;
mod order;
#[cfg(feature = "encode")]
mod original;
mod plain;
pub(crate) mod records;
pub(crate) mod renumber;
mod residual;
mod stretch;
mod topology;
mod valence;
mod walk;

#[cfg(feature = "encode")]
pub(crate) use topology::Filled;
pub(crate) use topology::{Census, Skin, Surface};

use crate::entropy::{BitCoder, BitReader, BitWriter};
use crate::error::Result;
use crate::limits::Budget;
use crate::par;
use crate::task::Task;

/// How much time a file may take for its size. Every decoder reads all three.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Effort {
    /// Integers only, few contexts.
    Fast,
    /// A good size for a moderate time.
    #[default]
    Default,
    /// The smallest size.
    Best,
}

/// Vertices that are coded as one stream; larger surfaces are split so that several cores can work.
const VERTICES_A_STREAM: u32 = 1 << 18;

/// A surface and its positions as bytes.
#[derive(Debug, Default)]
pub(crate) struct Streams {
    pub(crate) connectivity: Vec<u8>,
    /// One stream for each range of vertices that [`ranges`] gives.
    pub(crate) positions: Vec<Vec<u8>>,
}

/// How a mesh was walked: what its half-edges and vertices have become.
#[derive(Debug)]
#[cfg(feature = "encode")]
pub(crate) struct Walked {
    pub(crate) surface: Surface,
    /// The vertex of the mesh for every vertex met, those that fill holes left out.
    pub(crate) order: Vec<u32>,
    /// The half-edge of the mesh for the first of every face walked, those that fill holes included.
    pub(crate) faces: Vec<u32>,
}

/// Ranges of vertices (those of holes included) that are coded independently of each other.
pub(crate) fn ranges(census: Census) -> Vec<std::ops::Range<u32>> {
    let vertices = census.vertices + census.holes;
    let count = vertices.div_ceil(VERTICES_A_STREAM).max(1);
    let at = |i: u32| (u64::from(vertices) * u64::from(i) / u64::from(count)) as u32;
    (0..count).map(|i| at(i)..at(i + 1)).collect()
}

/// Memory and steps that reading takes at most.
pub(crate) fn cost(census: Census) -> (u64, u64) {
    let vertices = u64::from(census.vertices) + u64::from(census.holes);
    (walk::memory(census) + vertices * learned::BYTES_A_VERTEX, vertices * (6 + learned::STEPS_A_VERTEX))
}

/// Writes a surface, and the lattice positions of its vertices (`positions[v]` of vertex v of the mesh).
#[cfg(feature = "encode")]
pub(crate) fn write(
    filled: &Filled,
    positions: &[[i32; 3]],
    extent: [i32; 3],
    effort: Effort,
    task: Task<'_>,
) -> Result<(Streams, Walked)> {
    let mut budget = Budget::new(crate::Limits::default().memory(u64::MAX).work(u64::MAX).vertices(u64::MAX));
    let mut coder = BitWriter::default();
    let mut guide = original::Original::new(filled);
    let surface = walk::walk(&mut coder, &mut guide, filled.census, effort, &mut budget, task)?;
    let original::Original { order, faces, .. } = guide;
    let connectivity = coder.finish();

    let mut met = order.iter();
    let local: Vec<[i32; 3]> = surface
        .is_hole
        .iter()
        .map(|&hole| if hole { [0; 3] } else { met.next().map_or([0; 3], |&v| positions[v as usize]) })
        .collect();
    let coded = Positions::new(&surface, extent, effort);
    let ranges = ranges(filled.census);
    let streams = par::map(ranges.len(), |i| {
        let range = ranges[i].clone();
        let mut local = local[range.start as usize..range.end as usize].to_vec();
        let mut coder = BitWriter::default();
        coded.code(&mut coder, range, &mut local, task)?;
        Ok(coder.finish())
    });
    let streams = Streams { connectivity, positions: streams.into_iter().collect::<Result<_>>()? };
    Ok((streams, Walked { surface, order, faces }))
}

/// Reads what [`write`] wrote: the surface, and the lattice position of each of its vertices in order.
pub(crate) fn read(
    connectivity: &[u8],
    streams: &[&[u8]],
    census: Census,
    extent: [i32; 3],
    effort: Effort,
    budget: &mut Budget,
    task: Task<'_>,
) -> Result<(Surface, Vec<[i32; 3]>)> {
    struct Unknown;
    impl walk::Guide for Unknown {}
    let surface = walk::walk(&mut BitReader::new(connectivity), &mut Unknown, census, effort, budget, task)?;
    let vertices = surface.is_hole.len();
    budget.reserve(vertices as u64 * learned::BYTES_A_VERTEX)?;
    budget.spend(vertices as u64 * learned::STEPS_A_VERTEX)?;
    let positions = Positions::new(&surface, extent, effort);
    let ranges = ranges(census);
    let parts = par::map(ranges.len(), |i| {
        let mut local = vec![[0; 3]; ranges[i].len()];
        let mut coder = BitReader::new(streams[i]);
        positions.code(&mut coder, ranges[i].clone(), &mut local, task)?;
        Ok::<_, crate::Error>(local)
    });
    let mut all = Vec::with_capacity(vertices);
    for part in parts {
        all.extend(part?);
    }
    let mut is_hole = surface.is_hole.iter();
    all.retain(|_| is_hole.next() == Some(&false));
    Ok((surface, all))
}

/// The coder of positions that an effort uses, and what all its streams share.
struct Positions<'a> {
    surface: &'a Surface,
    outgoing: Vec<u32>,
    extent: [i32; 3],
    effort: Effort,
    degrees: Option<learned::Degrees>,
}

impl<'a> Positions<'a> {
    fn new(surface: &'a Surface, extent: [i32; 3], effort: Effort) -> Self {
        let degrees = (effort != Effort::Fast).then(|| learned::Degrees::new(surface));
        Self { surface, outgoing: surface.outgoing(), extent, effort, degrees }
    }

    fn code<C: BitCoder>(
        &self,
        coder: &mut C,
        range: std::ops::Range<u32>,
        positions: &mut [[i32; 3]],
        task: Task<'_>,
    ) -> Result<()> {
        let Self { surface, outgoing, extent, .. } = self;
        let stretch = stretch::Stretch { surface, outgoing, range, extent: *extent };
        match (&self.degrees, self.effort) {
            (None, _) => plain::code(coder, stretch, positions, task),
            (Some(degrees), Effort::Best) => learned::code_full(coder, stretch, degrees, positions, task),
            (Some(degrees), _) => learned::code_lean(coder, stretch, degrees, positions, task),
        }
    }
}
