//! An image of vertices as planes of samples: positions, and normals beside them (CGIM and CNIM).
//!
//! Exact samples show by their colours which pixels are one vertex. Lossy ones do not: then an index map says it, or
//! the cluster phase finds it from run counts, and every vertex takes the mean of its pixels.

use super::borders::{read_map, read_words, stacked};
#[cfg(feature = "encode")]
use super::borders::{words_of, write_map, write_words};
#[cfg(feature = "encode")]
use super::unlimited;
use super::{Decoded, Pixels};
#[cfg(feature = "encode")]
use crate::cgim::{Contact, Image, Search, image, run_counts, straight, walls};
use crate::cgim::{Rebuilt, VMatrix, cluster, matrix_triangles, rebuild, regions};
use crate::codec::PlaneCodec;
use crate::error::{Error, Place, Result};
use crate::format::{Borders, PlanesChunk};
use crate::limits::Budget;
#[cfg(feature = "encode")]
use crate::mesh::HalfEdges;
use crate::plane::{MAX_DEPTH, Planes, Shape};
#[cfg(feature = "encode")]
use crate::plane::{Mask, Plane, SideInformation};
use crate::task::Task;

/// The most bits of a sample of a normal.
pub(crate) const MAX_NORMAL_DEPTH: u8 = 16;

/// How a file is to tell which pixels are one vertex.
#[cfg(feature = "encode")]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BorderChoice {
    /// Samples are exact.
    Colours,
    /// By an index map.
    Exact,
    /// By run counts.
    Implied,
}

/// The normals that go with the positions: one for each vertex, and bits of a sample.
#[cfg(feature = "encode")]
#[derive(Debug, Clone, Copy)]
pub(crate) struct NormalPlanes<'a> {
    pub(crate) normals: &'a [[i32; 2]],
    pub(crate) depth: u8,
}

/// An image before its planes are coded.
#[cfg(feature = "encode")]
#[derive(Debug)]
pub(crate) struct Draft {
    image: Image,
    pub(crate) planes: Planes,
    /// For each pixel one over the pixels of its vertex.
    pub(crate) weights: Vec<f32>,
    choice: BorderChoice,
    extent: [i32; 3],
    walls: Vec<u64>,
    /// Words or map.
    stream: Vec<u8>,
    as_words: bool,
}

/// A chunk, and what a reader will make of it.
#[cfg(feature = "encode")]
#[derive(Debug)]
pub(crate) struct Written {
    pub(crate) chunk: Vec<u8>,
    pub(crate) decoded: Decoded,
    /// Whether the decoded mesh has the connectivity of the original.
    pub(crate) exact: bool,
    /// If so: for each decoded vertex the one that it is in the original.
    pub(crate) origin: Vec<u32>,
}

#[cfg(feature = "encode")]
impl Draft {
    /// Makes an image of a mesh. `positions[v]` is the lattice position of vertex v.
    pub(crate) fn new(
        surface: &HalfEdges,
        positions: &[[i32; 3]],
        extent: [i32; 3],
        normals: Option<NormalPlanes<'_>>,
        choice: BorderChoice,
        search: &Search,
        task: Task<'_>,
    ) -> Result<Self> {
        let depth = extent.into_iter().fold(1, |depth, e| depth.max(32 - e.leading_zeros())) as u8;
        if depth > MAX_DEPTH {
            return Err(Error::Parameter(format!(
                "samples of {depth} bits; this codec has at most {MAX_DEPTH}: take a larger step"
            )));
        }
        let make = |search: &Search| {
            let image = image(surface, search, &task)?;
            let triangles = matrix_triangles(&image.matrix, image.regions(), &image.side, &mut unlimited())?;
            let colours = region_colours(&image, positions, &triangles);
            let walls = walls(&image.matrix, &image.side.blocks, |p, q| {
                let entries = image.matrix.entries();
                colours[entries[p] as usize] == colours[entries[q] as usize]
            });
            Ok::<_, Error>((image, colours, walls))
        };
        let (image, colours, walls) = if choice == BorderChoice::Implied {
            // Shrinking may bend a vertex so that the cluster phase does not find it.
            let overlap = Search { contact: Contact::Overlap, ..*search };
            let (image, colours, found) = make(&overlap)?;
            let found = straight(found);
            if clusters(&image, &found, |p| colours[image.matrix.entries()[p] as usize]) {
                (image, colours, found)
            } else {
                let (image, colours, found) = make(&Search { simple: true, ..overlap })?;
                (image, colours, straight(found))
            }
        } else {
            let (image, colours, found) = make(search)?;
            let walls = if choice == BorderChoice::Colours { found } else { Vec::new() };
            (image, colours, walls)
        };
        let shape = Shape::new(image.matrix.columns() as u32, image.matrix.rows() as u32)?;
        let entries = image.matrix.entries();
        let plane = |axis: usize| Plane::new(shape, depth, entries.iter().map(|&r| colours[r as usize][axis]).collect());
        let mut planes = vec![plane(0)?, plane(1)?, plane(2)?];
        if let Some(NormalPlanes { normals, depth }) = normals {
            let flat = crate::plane::octahedral([0.0; 3], depth);
            let of = |&r: &u32| normals.get(image.origin[r as usize] as usize).copied().unwrap_or(flat);
            for axis in 0..2 {
                planes.push(Plane::new(shape, depth, entries.iter().map(|r| of(r)[axis]).collect())?);
            }
        }
        let mut pixels = vec![0_u32; image.regions() as usize];
        entries.iter().for_each(|&r| pixels[r as usize] += 1);
        let weights = entries.iter().map(|&r| 1.0 / pixels[r as usize] as f32).collect();
        let words = if choice == BorderChoice::Exact { words_of(&image.matrix, &image.side.blocks) } else { None };
        let stream = match (choice, &words) {
            (BorderChoice::Exact, Some(words)) => write_words(words, image.regions(), &mut unlimited())?,
            (BorderChoice::Exact, None) => write_map(&image.matrix, image.regions(), &mut unlimited())?,
            _ => Vec::new(),
        };
        Ok(Self { planes: Planes::new(planes)?, weights, choice, extent, walls, stream, as_words: words.is_some(), image })
    }

    /// The pixels of some vertices of the surface.
    pub(crate) fn pixels(&self, is_wanted: impl Fn(u32) -> bool) -> Mask {
        let (entries, columns) = (self.image.matrix.entries(), self.image.matrix.columns());
        Mask::from_fn(self.planes.shape(), |row, column| {
            let vertex = self.image.origin[entries[row * columns + column] as usize];
            is_wanted(vertex)
        })
    }

    /// Packs coded planes, and reads them as a decoder will.
    pub(crate) fn pack(&self, samples: &[u8], codec: &dyn PlaneCodec) -> Result<Written> {
        let shape = self.planes.shape();
        let normal_depth = self.planes.depths().get(3).copied().unwrap_or(0);
        let mut chunk = PlanesChunk {
            columns: shape.width() as u32,
            rows: shape.height() as u32,
            depth: self.planes[0].depth(),
            normal_depth,
            borders: Borders::Colours,
            side: self.image.side.clone(),
            side_size: 0,
            walls: self.walls.clone(),
            samples,
        };
        let regions = self.image.regions();
        let mut exact = true;
        match self.choice {
            BorderChoice::Colours => {}
            BorderChoice::Exact if self.as_words => chunk.borders = Borders::Words { regions, stream: &self.stream },
            BorderChoice::Exact => chunk.borders = Borders::Map { regions, stream: &self.stream },
            BorderChoice::Implied => {
                let counts = run_counts(&self.image.matrix, &self.image.side.blocks);
                let planes = codec.decode(samples, shape, &self.planes.depths(), &mut unlimited())?;
                let distance = |p: usize, q: usize| distance(&planes, p, q);
                let found = cluster(shape.width(), &self.image.side.blocks, &counts, &self.walls, distance);
                let (found, _) = found.ok_or(Error::NoConvergence { what: "the cluster phase", after: 1, residual: 1.0 })?;
                exact = found == self.image.matrix.entries();
                if !exact {
                    chunk.side = self.side_of_clusters(&VMatrix::new(shape.width(), found));
                }
                chunk.borders = Borders::Counts { counts, exact };
            }
        }
        let (decoded, rebuilt) = read(&chunk, codec, self.extent, &mut unlimited(), Task::default())?;
        let mut origin = vec![0; rebuilt.vertices as usize];
        if exact {
            for (&new, &old) in rebuilt.vertex.iter().zip(&self.image.origin) {
                if let Some(slot) = origin.get_mut(new as usize) {
                    *slot = old;
                }
            }
        }
        Ok(Written { chunk: chunk.write(), decoded, exact, origin })
    }

    /// The side information in terms of the regions that the cluster phase found, as far as it has a meaning there:
    /// seams have none.
    fn side_of_clusters(&self, found: &VMatrix) -> SideInformation {
        let mut first = vec![0; self.image.regions() as usize];
        self.image.matrix.entries().iter().enumerate().rev().for_each(|(p, &r)| first[r as usize] = p);
        let now = |r: u32| found.entries()[first[r as usize]];
        let mut side = SideInformation { blocks: self.image.side.blocks.clone(), ..SideInformation::default() };
        side.dummies = self.image.side.dummies.iter().map(|&r| now(r)).collect();
        side.dummies.sort_unstable();
        side.dummies.dedup();
        let missing = self.image.side.missing.iter().map(|t| t.map(now));
        side.missing = missing.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        side
    }
}

/// Whether the cluster phase finds every vertex of an image from exact colours.
#[cfg(feature = "encode")]
fn clusters(image: &Image, walls: &[u64], colour: impl Fn(usize) -> [i32; 3]) -> bool {
    let counts = run_counts(&image.matrix, &image.side.blocks);
    let found = cluster(image.matrix.columns(), &image.side.blocks, &counts, walls, |p, q| squared(colour(p), colour(q)));
    found.is_some_and(|(found, _)| found == image.matrix.entries())
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
    let (memory, work) = match chunk.borders {
        Borders::Colours => (96, 40),
        _ => (200, 500),
    };
    let memory = pixels.saturating_mul(memory).saturating_add(faces * crate::cgim::BYTES_A_TRIANGLE);
    (memory.saturating_add(64 << 20), pixels.saturating_mul(work).saturating_add(faces * crate::cgim::STEPS_A_TRIANGLE))
}

/// Reads an image of planes; `vertices` are what the header says.
pub(crate) fn read_planes(
    chunk: &PlanesChunk<'_>,
    codec: &dyn PlaneCodec,
    vertices: u32,
    extent: [i32; 3],
    budget: &mut Budget,
    task: Task<'_>,
) -> Result<Decoded> {
    let (decoded, _) = read(chunk, codec, extent, budget, task)?;
    if decoded.positions.len() != vertices as usize {
        let why = format!("{} vertices were decoded, the header says {vertices}", decoded.positions.len());
        return Err(malformed(why));
    }
    Ok(decoded)
}

fn read(
    chunk: &PlanesChunk<'_>,
    codec: &dyn PlaneCodec,
    extent: [i32; 3],
    budget: &mut Budget,
    task: Task<'_>,
) -> Result<(Decoded, Rebuilt)> {
    budget.check_pixels(u64::from(chunk.columns) * u64::from(chunk.rows))?;
    let shape = Shape::new(chunk.columns, chunk.rows).map_err(|e| malformed(e.to_string()))?;
    if !(1..=MAX_DEPTH).contains(&chunk.depth) || chunk.normal_depth == 1 || chunk.normal_depth > MAX_NORMAL_DEPTH {
        let why = format!("samples of {} bits and normals of {}", chunk.depth, chunk.normal_depth);
        return Err(malformed(format!("{why}; 1 to {MAX_DEPTH}, and 0 or 2 to {MAX_NORMAL_DEPTH} are possible")));
    }
    let mut depths = vec![chunk.depth; 3];
    if chunk.normal_depth > 0 {
        depths.extend([chunk.normal_depth; 2]);
    }
    let planes = codec.decode(chunk.samples, shape, &depths, budget)?;
    task.step(0.3)?;
    let (matrix, count) = matrix_of(chunk, &planes, budget)?;
    task.step(0.6)?;
    let triangles = matrix_triangles(&matrix, count, &chunk.side, budget)?;
    let rebuilt = rebuild(triangles, count, &chunk.side, budget)?;
    let (positions, normals) = match chunk.borders {
        Borders::Colours => one_colour(&planes, &matrix, &rebuilt, extent, budget)?,
        _ => mean_colours(&planes, &matrix, &rebuilt, extent, budget)?,
    };
    budget.reserve(4 * shape.pixels() as u64)?;
    let pixels = Some(vertices_of(&matrix, &rebuilt));
    Ok((Decoded { triangles: rebuilt.triangles.clone(), positions, normals, pixels }, rebuilt))
}

/// Which pixels are one vertex, or one of the copies of one.
fn matrix_of(chunk: &PlanesChunk<'_>, planes: &Planes, budget: &mut Budget) -> Result<(VMatrix, u32)> {
    let shape = planes.shape();
    let pixels = shape.pixels() as u64;
    budget.reserve(pixels * 24)?;
    budget.spend(pixels * 24)?;
    let blocks = &chunk.side.blocks;
    let found = match &chunk.borders {
        Borders::Colours => {
            let same = |p: usize, q: usize| (0..3).all(|i| planes[i].samples()[p] == planes[i].samples()[q]);
            let found = regions(shape.height(), shape.width(), blocks, &chunk.walls, same);
            found.ok_or_else(|| malformed("a wall between pixels of different colours".into()))?
        }
        Borders::Counts { counts, .. } => {
            let found = cluster(shape.width(), blocks, counts, &chunk.walls, |p, q| distance(planes, p, q));
            found.ok_or_else(|| malformed("run counts or walls that do not fit the image".into()))?
        }
        Borders::Words { regions, stream } => {
            let words = read_words(stream, blocks, *regions, budget)?;
            let matrix = stacked(&words, shape.width()).filter(|m| m.rows() == shape.height());
            let matrix = matrix.ok_or_else(|| malformed("words that need more columns than the image has".into()))?;
            return Ok((matrix, *regions));
        }
        Borders::Map { regions, stream } => {
            return Ok((read_map(stream, [shape.height(), shape.width()], *regions, budget)?, *regions));
        }
    };
    Ok((VMatrix::new(shape.width(), found.0), found.1))
}

/// How different the positions of two pixels are: the square of their distance.
fn distance(planes: &Planes, p: usize, q: usize) -> u64 {
    let at = |pixel: usize| [0, 1, 2].map(|i| planes[i].samples()[pixel]);
    squared(at(p), at(q))
}

fn squared(p: [i32; 3], q: [i32; 3]) -> u64 {
    (0..3).map(|i| u64::from(p[i].abs_diff(q[i])).pow(2)).sum()
}

type Colours = (Vec<[i32; 3]>, Vec<[i32; 2]>);

/// The colour of each vertex, where all its pixels have one.
fn one_colour(planes: &Planes, matrix: &VMatrix, rebuilt: &Rebuilt, extent: [i32; 3], budget: &mut Budget) -> Result<Colours> {
    let colour = |p: usize| [0, 1, 2].map(|i| planes[i].samples()[p]);
    let has_normals = planes.len() > 3;
    let mut positions = budget.vec(rebuilt.vertices as usize, [-1; 3])?;
    let mut normals = budget.vec(if has_normals { rebuilt.vertices as usize } else { 0 }, [-1; 2])?;
    for (p, &region) in matrix.entries().iter().enumerate() {
        let Some(position) = positions.get_mut(rebuilt.vertex[region as usize] as usize) else { continue };
        let normal = normals.get_mut(rebuilt.vertex[region as usize] as usize);
        let known = position[0] >= 0;
        let mut differs = known && *position != colour(p);
        *position = colour(p);
        if let Some(normal) = normal {
            let found = [3, 4].map(|i| planes[i].samples()[p]);
            differs |= known && *normal != found;
            *normal = found;
        }
        if differs {
            return Err(malformed("two colours for one vertex".into()));
        }
        if (0..3).any(|i| position[i] > extent[i]) {
            return Err(malformed(format!("pixel {p} is outside the box")));
        }
    }
    Ok((positions, normals))
}

/// The mean colour of each vertex, rounded to the nearest, halves up.
fn mean_colours(
    planes: &Planes,
    matrix: &VMatrix,
    rebuilt: &Rebuilt,
    extent: [i32; 3],
    budget: &mut Budget,
) -> Result<Colours> {
    let mut sums = budget.vec(rebuilt.vertices as usize, [0_i64; 6])?;
    for (p, &region) in matrix.entries().iter().enumerate() {
        let Some(sum) = sums.get_mut(rebuilt.vertex[region as usize] as usize) else { continue };
        planes.iter().enumerate().for_each(|(i, plane)| sum[i] += i64::from(plane.samples()[p]));
        sum[5] += 1;
    }
    let mean = |sum: &[i64; 6], i: usize| (2 * sum[i] + sum[5]).div_euclid(2 * sum[5].max(1)) as i32;
    budget.reserve(u64::from(rebuilt.vertices) * 20)?;
    let positions = sums.iter().map(|sum| [0, 1, 2].map(|i| mean(sum, i).min(extent[i]))).collect();
    let normals = if planes.len() > 3 { sums.iter().map(|sum| [3, 4].map(|i| mean(sum, i))).collect() } else { Vec::new() };
    Ok((positions, normals))
}

/// Which vertex each pixel is.
pub(super) fn vertices_of(matrix: &VMatrix, rebuilt: &Rebuilt) -> Pixels {
    let vertices = matrix.entries().iter().map(|&region| rebuilt.vertex[region as usize]).collect();
    Pixels { columns: matrix.columns(), vertices }
}

fn malformed(why: String) -> Error {
    Error::malformed(Place::Whole, why)
}
