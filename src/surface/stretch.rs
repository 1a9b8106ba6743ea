//! A stretch of vertices that is coded by itself, and what its coder may look at.

use std::ops::Range;

#[cfg(feature = "encode")]
use super::learned::Aim;
use super::topology::Surface;

/// Vertices `range` of a surface, which are coded without a look at any others.
#[derive(Debug, Clone)]
pub(super) struct Stretch<'a> {
    pub(super) surface: &'a Surface,
    /// An outgoing half-edge of every vertex of the surface.
    pub(super) outgoing: &'a [u32],
    pub(super) range: Range<u32>,
    /// Coordinate `axis` of a position lies in `0..=extent[axis]`.
    pub(super) extent: [i32; 3],
    /// For each axis: whether a writer lists the values that occur.
    pub(super) palettes: [bool; 3],
    /// What the stage before said of the positions, in all stages but the first.
    pub(super) coarse: Option<Coarse<'a>>,
    /// How vertices slide along the surface, if they may.
    pub(super) sliding: Option<Sliding<'a>>,
}

/// How vertices slide along the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sliding<'a> {
    /// Whether the step along the normal becomes finer where edges are short.
    pub(super) fine: bool,
    /// √2 to the power of this is how many times longer than that the other steps may be.
    pub(super) longest: u8,
    /// What a writer aims at.
    #[cfg(feature = "encode")]
    pub(super) aim: Option<&'a Aim>,
    #[cfg(not(feature = "encode"))]
    pub(super) aim: std::marker::PhantomData<&'a ()>,
}

/// Positions on a coarser lattice: of each coordinate all but the lowest `shift` bits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coarse<'a> {
    pub(super) shift: u32,
    /// From the first vertex of the stretch on.
    pub(super) positions: &'a [[i32; 3]],
}

impl Coarse<'_> {
    /// The middle of a cell.
    pub(super) fn middle(&self, cell: [i32; 3]) -> [f64; 3] {
        let width = f64::from(1_u32 << self.shift);
        cell.map(|x| (f64::from(x) + 0.5) * width - 0.5)
    }
}
