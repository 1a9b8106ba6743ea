//! A stretch of vertices that is coded by itself, and what its coder may look at.

use std::ops::Range;

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
}
