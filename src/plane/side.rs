//! What an image of vertices needs beside its pixels.
//!
//! Pixels stand for *regions*, numbered by first occurrence from left to right and from top to bottom.
//! Most regions are one vertex each; where a surface was cut open, several regions are the same vertex.

/// Side information of a V-matrix.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct SideInformation {
    /// The matrices that are stacked in the image, from top to bottom; their rows add up to the image's.
    pub(crate) blocks: Vec<Block>,
    /// Where the boundary of the disks is glued.
    pub(crate) seams: Vec<Seam>,
    /// Regions that fill holes: neither they nor their triangles are part of the mesh. Ascending.
    pub(crate) dummies: Vec<u32>,
    /// Half-cells whose triangle is to be left out: twice the index of the upper left pixel, plus one for
    /// the lower right half. Ascending. Empty for matrices made here.
    pub(crate) extra: Vec<u64>,
    /// Triangles of regions that no half-cell holds.
    pub(crate) missing: Vec<[u32; 3]>,
}

/// One matrix of a stack. Between blocks there are no cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Block {
    pub(crate) rows: u32,
    /// Whether every triangle is turned over.
    pub(crate) mirrored: bool,
}

/// Boundary edges that are glued, counted along the boundary loops of the disks: edge `first + k` is the same
/// as edge `partner − k`, the other way round, for k below `length`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Seam {
    pub(crate) first: u32,
    pub(crate) partner: u32,
    pub(crate) length: u32,
}

/// How often the vertex changes along each row and each column of an image: the paper's x and y (CGIM §5.2).
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct RunCounts {
    /// For each row.
    pub(crate) rows: Vec<u32>,
    /// For each column of the first block, of the second, and so on.
    pub(crate) columns: Vec<u32>,
}
