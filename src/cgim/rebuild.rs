//! From a matrix, or from the words of one, back to a mesh: cells, seams, dummies.
//!
//! The triangles are found in terms of regions; regions that a seam glues are one vertex, and
//! what touches a dummy is left out.

use super::vmatrix::VMatrix;
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::mesh::{HalfEdges, NONE, boundary_loops};
use crate::plane::{Levels, Seam, SideInformation};

/// A mesh whose vertices are numbered by first occurrence in the image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Rebuilt {
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The vertex of each region; [`NONE`] for dummies.
    pub(crate) vertex: Vec<u32>,
    pub(crate) vertices: u32,
}

/// Bytes and steps that rebuilding takes, a triangle.
pub(crate) const BYTES_A_TRIANGLE: u64 = 150;
pub(crate) const STEPS_A_TRIANGLE: u64 = 100;

fn malformed(why: String) -> Error {
    Error::malformed(Place::Whole, why)
}

/// The mesh of these triangles of regions. O(n log n).
pub(crate) fn rebuild(triangles: Vec<[u32; 3]>, regions: u32, side: &SideInformation, budget: &mut Budget) -> Result<Rebuilt> {
    budget.reserve(triangles.len() as u64 * BYTES_A_TRIANGLE)?;
    budget.spend(triangles.len() as u64 * STEPS_A_TRIANGLE)?;
    let mut classes = Classes::new(budget.vec(regions as usize, 0)?);
    if !side.seams.is_empty() {
        let edges = boundary(regions, &triangles)?;
        for seam in &side.seams {
            glue(seam, &edges, &mut classes)?;
        }
    }
    let mut is_dummy = budget.vec(regions as usize, false)?;
    for &region in &side.dummies {
        match is_dummy.get_mut(region as usize) {
            Some(_) => is_dummy[classes.find(region) as usize] = true,
            None => return Err(malformed(format!("region {region} is a dummy, and there are {regions} regions"))),
        }
    }
    let mut vertex = budget.vec(regions as usize, NONE)?;
    let mut vertices = 0;
    for region in 0..regions {
        let class = classes.find(region) as usize;
        if is_dummy[class] {
            continue;
        }
        // Classes are named by their first region, so that region is numbered before the others.
        if class == region as usize {
            vertex[class] = vertices;
            vertices += 1;
        }
        vertex[region as usize] = vertex[class];
    }
    let triangles = triangles.into_iter().map(|t| t.map(|r| vertex[r as usize])).filter(|t| !t.contains(&NONE)).collect();
    Ok(Rebuilt { triangles, vertex, vertices })
}

/// All triangles of an image in terms of its regions: those of the cells, then the explicit ones.
pub(crate) fn matrix_triangles(
    matrix: &VMatrix,
    regions: u32,
    side: &SideInformation,
    budget: &mut Budget,
) -> Result<Vec<[u32; 3]>> {
    let rows: u64 = side.blocks.iter().map(|block| u64::from(block.rows)).sum();
    if rows != matrix.rows() as u64 {
        return Err(malformed(format!("blocks of {rows} rows together in an image of {} rows", matrix.rows())));
    }
    budget.spend(matrix.entries().len() as u64)?;
    let mut triangles = Vec::new();
    let mut extra = side.extra.iter().copied().peekable();
    let mut first = 0;
    for block in &side.blocks {
        let rows = first..first + block.rows as usize;
        first = rows.end;
        for (half, triangle) in matrix.cells_of(rows) {
            if extra.next_if_eq(&half).is_none() {
                triangles.push(oriented(triangle, block.mirrored));
            }
        }
    }
    if let Some(half) = extra.next() {
        return Err(malformed(format!("half-cell {half} is to be left out, and holds no triangle")));
    }
    with_missing(triangles, regions, side)
}

/// The same of the words of an image, one block after the other.
pub(crate) fn word_triangles(blocks: &[Levels], regions: u32, side: &SideInformation) -> Result<Vec<[u32; 3]>> {
    let turned = side.blocks.iter().map(|block| block.mirrored);
    let cells = blocks.iter().zip(turned).flat_map(|(levels, turn)| levels.triangles().map(move |t| oriented(t, turn)));
    with_missing(cells.collect(), regions, side)
}

fn oriented([a, b, c]: [u32; 3], turn: bool) -> [u32; 3] {
    if turn { [a, c, b] } else { [a, b, c] }
}

fn with_missing(mut triangles: Vec<[u32; 3]>, regions: u32, side: &SideInformation) -> Result<Vec<[u32; 3]>> {
    for &triangle in &side.missing {
        if triangle.iter().any(|&r| r >= regions) {
            return Err(malformed(format!("an explicit triangle names the regions {triangle:?}, and there are {regions}")));
        }
        triangles.push(triangle);
    }
    Ok(triangles)
}

/// The ends of the boundary edges, loop after loop.
pub(crate) fn boundary(regions: u32, triangles: &[[u32; 3]]) -> Result<Vec<[u32; 2]>> {
    let disks = HalfEdges::new(regions as usize, triangles.to_vec())?;
    let edges = boundary_loops(&disks).into_iter().flatten();
    Ok(edges.map(|h| [disks.from(h), disks.to(h)]).collect())
}

fn glue(seam: &Seam, edges: &[[u32; 2]], classes: &mut Classes) -> Result<()> {
    let fits = u64::from(seam.first) + u64::from(seam.length) <= edges.len() as u64
        && (seam.partner as usize) < edges.len()
        && seam.length <= seam.partner + 1;
    if !fits {
        return Err(malformed(format!(
            "a seam glues {} edges from {} on to those from {} down, and there are {}",
            seam.length,
            seam.first,
            seam.partner,
            edges.len()
        )));
    }
    for k in 0..seam.length {
        let ([a, b], [c, d]) = (edges[(seam.first + k) as usize], edges[(seam.partner - k) as usize]);
        classes.join(a, d);
        classes.join(b, c);
    }
    Ok(())
}

/// Sets of regions that are one vertex, each named by its first region.
struct Classes(Vec<u32>);

impl Classes {
    fn new(mut parents: Vec<u32>) -> Self {
        parents.iter_mut().zip(0..).for_each(|(parent, region)| *parent = region);
        Self(parents)
    }

    fn find(&mut self, region: u32) -> u32 {
        let mut r = region as usize;
        while self.0[r] as usize != r {
            self.0[r] = self.0[self.0[r] as usize];
            r = self.0[r] as usize;
        }
        r as u32
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
