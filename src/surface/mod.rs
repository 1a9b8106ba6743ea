//! The codec `surface`: a mesh coded by walking over it.
//!
//! First the connectivity ([`walk`]), vertex by vertex, as valences; then, with all of the surface
//! known, the positions. The one room that knows both meshes and decisions. spec/surface.md is the
//! normative text.

pub(crate) mod attributes;
pub(crate) mod exact;
mod filter;
mod gates;
pub(crate) mod labels;
mod learned;
mod neighbour;
mod order;
#[cfg(feature = "encode")]
mod original;
mod plain;
pub(crate) mod records;
mod region;
pub(crate) mod renumber;
#[cfg(feature = "encode")]
mod slide;
mod stretch;
mod topology;
mod valence;
mod walk;

pub(crate) use region::middle;
#[cfg(feature = "encode")]
pub(crate) use topology::Filled;
pub(crate) use topology::{Census, Skin, Surface};

pub(crate) use self::filter::Filter;
#[cfg(feature = "encode")]
pub(crate) use self::learned::Hold;
#[cfg(feature = "encode")]
pub(crate) use self::slide::{Slid, Wishes, slide};
use self::stretch::{Coarse, Sliding, Stretch};
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
    /// For each stage: one stream for each range of vertices that [`ranges`] gives.
    pub(crate) positions: Vec<Vec<Vec<u8>>>,
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
    ranges_of(census.vertices + census.holes)
}

fn ranges_of(vertices: u32) -> Vec<std::ops::Range<u32>> {
    let count = vertices.div_ceil(VERTICES_A_STREAM).max(1);
    let at = |i: u32| (u64::from(vertices) * u64::from(i) / u64::from(count)) as u32;
    (0..count).map(|i| at(i)..at(i + 1)).collect()
}

/// Parts of a step that positions of sliding vertices are whole numbers of.
pub(crate) const PARTS: f64 = learned::PARTS;
/// Without a limit of its own, a step across the normal is √2 to the power of this times longer, at most.
pub(crate) const LONGEST_STRETCH: u8 = learned::LONGEST_STRETCH;

/// How vertices slide along the surface, as a file says it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Slide {
    /// Whether the step along the normal becomes finer where edges are short.
    pub(crate) fine: bool,
    /// √2 to the power of this is how many times longer than that the other steps may be.
    pub(crate) longest: u8,
    /// What smooths the surface after all positions are known.
    pub(crate) filter: Option<Filter>,
}

/// Memory and steps that reading so many stages takes at most.
pub(crate) fn cost(census: Census, effort: Effort, stages: u64, has_region: bool, slide: Option<Slide>) -> (u64, u64) {
    let vertices = u64::from(census.vertices) + u64::from(census.holes);
    let region = if has_region { memory_of_region(census) } else { 0 };
    let filter = if slide.is_some_and(|s| s.filter.is_some()) { Filter::STEPS_A_VERTEX } else { 0 };
    let steps = vertices * (6 + filter + stages * learned::STEPS_A_VERTEX);
    (walk::memory(census) + memory(census, effort, slide) + region, steps)
}

fn memory_of_region(census: Census) -> u64 {
    let vertices = u64::from(census.vertices) + u64::from(census.holes);
    vertices * region::BYTES_A_VERTEX + census.closed_faces() * region::BYTES_A_FACE
}

/// Memory that reading positions takes at most, all ranges at once.
fn memory(census: Census, effort: Effort, slide: Option<Slide>) -> u64 {
    let vertices = u64::from(census.vertices) + u64::from(census.holes);
    let range = match effort {
        Effort::Fast => plain::memory,
        Effort::Default => learned::memory_lean,
        Effort::Best => learned::memory_full,
    };
    // Each position three times: of the stage before, of this by ranges, and in one piece.
    let shared = 3 * size_of::<[i32; 3]>() + size_of::<u32>() + learned::Degrees::BYTES;
    let filter = if slide.is_some_and(|s| s.filter.is_some()) { Filter::BYTES_A_VERTEX } else { 0 };
    vertices * (shared as u64 + filter) + ranges(census).iter().map(|r| range(r.len())).sum::<u64>()
}

/// How a surface is written.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plan<'a> {
    pub(crate) effort: Effort,
    /// Bits that each stage after the first adds to every coordinate.
    pub(crate) stages: &'a [u8],
    /// Whether the one stage after the first is for some vertices only; its first stream then says for which.
    pub(crate) has_region: bool,
}

impl Plan<'_> {
    /// For each stage: the bits that it adds, 0 for the first; and those still missing after it.
    fn steps(self) -> impl Iterator<Item = (u32, u32)> {
        let mut rest: u32 = self.stages.iter().map(|&bits| u32::from(bits)).sum();
        std::iter::once(0).chain(self.stages.iter().map(|&bits| u32::from(bits))).map(move |bits| {
            rest -= bits;
            (bits, rest)
        })
    }
}

/// Walks over a surface: its connectivity as a stream.
#[cfg(feature = "encode")]
pub(crate) fn trace(filled: &Filled, effort: Effort, task: Task<'_>) -> Result<(Vec<u8>, Walked)> {
    let mut budget = Budget::new(crate::Limits::default().memory(u64::MAX).work(u64::MAX).vertices(u64::MAX));
    let mut coder = BitWriter::default();
    let mut guide = original::Original::new(filled);
    let surface = walk::walk(&mut coder, &mut guide, filled.census, effort, &mut budget, task)?;
    let original::Original { order, faces, .. } = guide;
    Ok((coder.finish(), Walked { surface, order, faces }))
}

/// Writes a surface, and the lattice positions of its vertices (`positions[v]` of vertex v of the mesh). `inside` says of each vertex
/// whether the later stage is for it, if not for all.
#[cfg(feature = "encode")]
pub(crate) fn write(
    filled: &Filled,
    positions: &[[i32; 3]],
    extent: [i32; 3],
    plan: Plan<'_>,
    inside: Option<&[bool]>,
    task: Task<'_>,
) -> Result<(Streams, Walked)> {
    let effort = plan.effort;
    let (connectivity, Walked { surface, order, faces }) = trace(filled, effort, task)?;
    let mut met = order.iter();
    let local: Vec<[i32; 3]> = surface
        .is_hole
        .iter()
        .map(|&hole| if hole { [0; 3] } else { met.next().map_or([0; 3], |&v| positions[v as usize]) })
        .collect();
    let all = Positions::new(&surface, effort);
    let region = inside.map(|inside| {
        let mut met = order.iter();
        let mut is_inside = |&hole: &bool| !hole && met.next().is_some_and(|&v| inside[v as usize]);
        let mut marks: Vec<bool> = surface.is_hole.iter().map(&mut is_inside).collect();
        let mut bits = BitWriter::default();
        region::code(&mut bits, &surface, &mut marks);
        (bits.finish(), surface.only(&marks))
    });
    let some = region.as_ref().map(|(_, surface)| Positions::new(surface, effort));
    let ranges = ranges(filled.census);
    let mut streams = Vec::new();
    let mut coarse = Vec::new();
    for (shift, rest) in plan.steps() {
        let coder = some.as_ref().filter(|_| shift > 0).unwrap_or(&all);
        let finer: Vec<[i32; 3]> = local.iter().map(|p| p.map(|x| x >> rest)).collect();
        let parts = par::map(ranges.len(), |i| {
            let range = ranges[i].start as usize..ranges[i].end as usize;
            let mut finer = finer[range.clone()].to_vec();
            let mut stretch = coder.stretch(ranges[i].clone(), extent.map(|e| e >> rest));
            stretch.coarse = (shift > 0).then(|| Coarse { shift, positions: &coarse[range.clone()] });
            let holes = &coder.surface.is_hole[range];
            let real = finer.iter().zip(holes).filter(|(_, hole)| !**hole).map(|(p, _)| *p);
            let choices = if effort == Effort::Fast { vec![[false; 3]] } else { learned::choices(stretch.extent, real) };
            let mut best: Option<Vec<u8>> = None;
            for palettes in choices {
                let mut bits = BitWriter::default();
                coder.code(&mut bits, Stretch { palettes, ..stretch.clone() }, &mut finer, task)?;
                let bytes = bits.finish();
                if best.as_ref().is_none_or(|best| bytes.len() < best.len()) {
                    best = Some(bytes);
                }
            }
            Ok(best.unwrap_or_default())
        });
        let mut parts = parts.into_iter().collect::<Result<Vec<_>>>()?;
        if let Some((marks, _)) = region.as_ref().filter(|_| shift > 0) {
            parts.insert(0, marks.clone());
        }
        streams.push(parts);
        coarse = finer;
    }
    Ok((Streams { connectivity, positions: streams }, Walked { surface, order, faces }))
}

/// What [`read`] needs.
#[derive(Debug)]
pub(crate) struct Coded<'a> {
    pub(crate) plan: Plan<'a>,
    /// How vertices slide, if they may; then there are no stages.
    pub(crate) slide: Option<Slide>,
    pub(crate) census: Census,
    pub(crate) extent: [i32; 3],
    pub(crate) connectivity: &'a [u8],
    /// The streams of the first stage, then those of each later one that is there.
    pub(crate) positions: Vec<Vec<&'a [u8]>>,
}

/// Reads what [`write`] wrote, as far as there are stages: the surface, and the lattice position of each of its
/// vertices in order.
pub(crate) fn read(coded: &Coded<'_>, budget: &mut Budget, task: Task<'_>) -> Result<(Surface, Vec<[i32; 3]>)> {
    let &Coded { plan, census, extent, slide, .. } = coded;
    struct Unknown;
    impl walk::Guide for Unknown {}
    let surface = walk::walk(&mut BitReader::new(coded.connectivity), &mut Unknown, census, plan.effort, budget, task)?;
    let vertices = surface.is_hole.len();
    budget.reserve(memory(census, plan.effort, slide))?;
    let all = Positions::new(&surface, plan.effort);
    let only;
    let mut some = None;
    let ranges = ranges(census);
    let mut known: Vec<[i32; 3]> = Vec::new();
    let mut missing = 0;
    if let (true, Some(streams)) = (plan.has_region, coded.positions.get(1)) {
        budget.reserve(memory_of_region(census))?;
        let mut inside = vec![false; vertices];
        region::code(&mut BitReader::new(streams.first().copied().unwrap_or_default()), &surface, &mut inside);
        only = surface.only(&inside);
        some = Some(Positions::new(&only, plan.effort));
    }
    for (streams, (shift, rest)) in coded.positions.iter().zip(plan.steps()) {
        budget.spend(vertices as u64 * learned::STEPS_A_VERTEX)?;
        let later = some.as_ref().filter(|_| shift > 0);
        let coder = later.unwrap_or(&all);
        let streams = if later.is_some() { &streams[1..] } else { &streams[..] };
        let parts = par::map(ranges.len(), |i| {
            let mut finer = vec![[0; 3]; ranges[i].len()];
            let range = ranges[i].start as usize..ranges[i].end as usize;
            let mut stretch = coder.stretch(ranges[i].clone(), extent.map(|e| e >> rest));
            stretch.coarse = (shift > 0).then(|| Coarse { shift, positions: &known[range.clone()] });
            stretch.sliding = slide.map(|slide| Sliding { fine: slide.fine, longest: slide.longest, aim: Default::default() });
            let mut bits = BitReader::new(streams[i]);
            coder.code(&mut bits, stretch, &mut finer, task)?;
            if later.is_some() {
                let cells = finer.iter_mut().zip(&known[range.clone()]).zip(&coder.surface.is_hole[range]);
                for ((position, cell), _) in cells.filter(|(_, outside)| **outside) {
                    *position = [0, 1, 2].map(|i| middle(cell[i], shift, extent[i]));
                }
            }
            Ok::<_, crate::Error>(finer)
        });
        known = parts.into_iter().collect::<Result<Vec<_>>>()?.concat();
        missing = rest;
    }
    if let Some(Slide { filter: Some(filter), .. }) = slide {
        budget.spend(vertices as u64 * Filter::STEPS_A_VERTEX)?;
        known = filter.apply(&surface, &all.outgoing, &known, extent);
    }
    let mut is_hole = surface.is_hole.iter();
    known.retain(|_| is_hole.next() == Some(&false));
    if missing > 0 {
        // What is not known stands in the middle of its cell.
        for position in &mut known {
            *position = [0, 1, 2].map(|i| middle(position[i], missing, extent[i]));
        }
    }
    Ok((surface, known))
}

/// The coder of positions that an effort uses, and what all its streams share.
struct Positions<'a> {
    surface: &'a Surface,
    outgoing: Vec<u32>,
    effort: Effort,
    degrees: Option<learned::Degrees>,
}

impl<'a> Positions<'a> {
    fn new(surface: &'a Surface, effort: Effort) -> Self {
        let degrees = (effort != Effort::Fast).then(|| learned::Degrees::new(surface));
        Self { surface, outgoing: surface.outgoing(), effort, degrees }
    }

    fn stretch(&self, range: std::ops::Range<u32>, extent: [i32; 3]) -> Stretch<'_> {
        let Self { surface, outgoing, .. } = self;
        Stretch { surface, outgoing, range, extent, palettes: [false; 3], coarse: None, sliding: None }
    }

    fn code<C: BitCoder>(&self, coder: &mut C, stretch: Stretch<'_>, positions: &mut [[i32; 3]], task: Task<'_>) -> Result<()> {
        match (&self.degrees, self.effort) {
            (None, _) => plain::code(coder, stretch, positions, task),
            (Some(degrees), Effort::Best) => learned::code_full(coder, stretch, degrees, positions, task),
            (Some(degrees), _) => learned::code_lean(coder, stretch, degrees, positions, task),
        }
    }
}
