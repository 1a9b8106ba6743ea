//! From any manifold to disks (CGIM, supplement B; our form in `spec/cgim.md`).
//!
//! The V-matrix needs a disk. Each connected piece of the surface is therefore
//!
//! - closed: every boundary loop is filled with a fan about a dummy vertex, so that only the genus is left;
//! - cut along a graph of 2g loops, if its genus g is not 0;
//! - opened again where its longest boundary loop was, or, if it had none, along a slit or where a
//!   triangle is taken out.
//!
//! All choices come from a [`Recipe`] of eight bytes and from the triangles alone, so that the same
//! disk can be had again from a decoded mesh.

use super::rng::Random;
use super::stratify::Plan;
use crate::error::Result;
use crate::mesh::{CutGraph, HalfEdges, NONE, Paths, boundary_loops, close, part};

/// Which disk, and which sweep over it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Recipe {
    /// How a piece without boundary or genus is opened; others have no choice.
    pub(crate) opening: Opening,
    /// The paper's α; 0: off.
    pub(crate) alpha: u8,
    /// The share of the components that is passed in a round is `(keep + 1) / 256`.
    pub(crate) keep: u8,
    /// The columns that the sweep should do with, see [`Recipe::columns`]; 0: no matter.
    pub(crate) columns: u8,
    /// What else is random.
    pub(crate) seed: u8,
    /// Where the first level begins: `start / 65536` of the way around the boundary.
    pub(crate) start: u16,
    /// How long it is: `(length + 1) / 65537` of the boundary.
    pub(crate) length: u16,
}

impl Recipe {
    /// The largest α that a recipe holds.
    pub(crate) const MAX_ALPHA: u8 = 31;

    /// As one number of 64 bits.
    pub(crate) fn pack(&self) -> u64 {
        let opening = Opening::ALL.iter().position(|o| *o == self.opening).unwrap_or(0) as u64;
        let fields = [(u64::from(self.alpha), 5), (self.keep.into(), 8), (self.columns.into(), 8), (self.seed.into(), 8)];
        let packed = fields.into_iter().fold(opening, |packed, (field, bits)| packed << bits | field);
        packed << 32 | u64::from(self.start) << 16 | u64::from(self.length)
    }

    /// From such a number, if it is one.
    pub(crate) fn unpack(packed: u64) -> Option<Self> {
        let field = |shift: u32, bits: u32| (packed >> shift & ((1 << bits) - 1)) as u16;
        Some(Self {
            opening: *Opening::ALL.get((packed >> 61) as usize)?,
            alpha: field(56, 5) as u8,
            keep: field(48, 8) as u8,
            columns: field(40, 8) as u8,
            seed: field(32, 8) as u8,
            start: field(16, 16),
            length: field(0, 16),
        })
    }

    /// The columns that the sweep should do with: four bits of mantissa, the rest exponent.
    pub(crate) fn columns(&self) -> usize {
        if self.columns == 0 { 0 } else { ((16 + usize::from(self.columns % 16)) << (self.columns / 16)) / 2 }
    }
}

/// How a sphere becomes a disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Opening {
    /// Only as far as handles must be cut.
    Plain,
    /// Along a path between two far vertices; the first level is one side of it.
    Slit,
    /// The same cut, but the first level may be any part of the boundary.
    FreeSlit,
    /// One edge: no vertex is doubled.
    Edge,
    /// A triangle is taken out, to be added again as an explicit one.
    Triangle,
}

impl Opening {
    pub(crate) const ALL: [Self; 5] = [Self::Plain, Self::Slit, Self::FreeSlit, Self::Edge, Self::Triangle];
}

/// A connected piece of a surface with its boundary loops filled.
#[derive(Debug)]
pub(crate) struct Piece {
    closed: HalfEdges,
    /// For each vertex the one that it is in the surface; `surface.vertices() + i` is the dummy of boundary loop `i`.
    pub(crate) origin: Vec<u32>,
    /// The dummy of the longest boundary loop.
    outer: Option<u32>,
    genus: usize,
}

/// A disk to be swept.
#[derive(Debug)]
pub(crate) struct Disk {
    pub(crate) half_edges: HalfEdges,
    /// For each vertex the one that it is in the piece.
    pub(crate) origin: Vec<u32>,
    pub(crate) plan: Plan,
}

/// The connected pieces of a surface, in the order of their first triangles. O(n log n).
pub(crate) fn pieces(surface: &HalfEdges) -> Result<Vec<Piece>> {
    let loops = boundary_loops(surface);
    let closed = close(surface, &loops)?;
    let (label, count) = label_pieces(&closed);
    let mut members = vec![Vec::new(); count];
    for (f, &piece) in label.iter().enumerate() {
        members[piece as usize].push(f as u32);
    }
    Ok(members.iter().map(|members| Piece::new(surface, &loops, &closed, members)).collect())
}

/// Which piece each triangle belongs to, and how many there are.
fn label_pieces(mesh: &HalfEdges) -> (Vec<u32>, usize) {
    let mut label = vec![NONE; mesh.triangles().len()];
    let mut count = 0;
    let mut stack = Vec::new();
    for seed in 0..label.len() {
        if label[seed] != NONE {
            continue;
        }
        label[seed] = count;
        stack.push(seed as u32);
        while let Some(f) = stack.pop() {
            for g in (3 * f..3 * f + 3).filter_map(|h| mesh.opposite(h)) {
                if label[g as usize / 3] == NONE {
                    label[g as usize / 3] = count;
                    stack.push(g / 3);
                }
            }
        }
        count += 1;
    }
    (label, count as usize)
}

impl Piece {
    fn new(surface: &HalfEdges, loops: &[Vec<u32>], closed: &HalfEdges, members: &[u32]) -> Self {
        let mut local = std::collections::HashMap::new();
        let mut vertices: Vec<u32> = members.iter().flat_map(|&f| closed.triangles()[f as usize]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        for (new, &old) in vertices.iter().enumerate() {
            local.insert(old, new as u32);
        }
        let place: std::collections::HashMap<u32, u32> =
            members.iter().enumerate().map(|(new, &old)| (old, new as u32)).collect();
        let triangles: Vec<_> = members.iter().map(|&f| closed.triangles()[f as usize].map(|v| local[&v])).collect();
        let opposite = members.iter().flat_map(|&f| 3 * f..3 * f + 3);
        let opposite = opposite.map(|h| closed.opposite(h).map_or(NONE, |g| 3 * place[&(g / 3)] + g % 3)).collect();
        let faces = triangles.len();
        let piece = HalfEdges::from_parts(triangles, opposite, vertices.len());
        let loop_of = |v: u32| (v as usize).checked_sub(surface.vertices());
        let dummies = (0..vertices.len()).filter_map(|v| Some((loops[loop_of(vertices[v])?].len(), v)));
        // The first of the longest.
        let outer = dummies.max_by_key(|&(length, v)| (length, std::cmp::Reverse(v))).map(|(_, v)| v as u32);
        // V − E + F = 2 − 2g, and E = 3F/2.
        let genus = (2 + faces / 2).saturating_sub(vertices.len()) / 2;
        Self { closed: piece, origin: vertices, outer, genus }
    }

    /// Whether the piece can only be opened where a boundary loop or a handle is.
    pub(crate) fn has_boundary_or_genus(&self) -> bool {
        self.outer.is_some() || self.genus > 0
    }

    /// The triangles between vertices of the piece, dummies included, less those about the outer dummy.
    pub(crate) fn triangles(&self) -> Vec<[u32; 3]> {
        self.closed.triangles().iter().copied().filter(|t| self.outer.is_none_or(|d| !t.contains(&d))).collect()
    }

    /// Opens the piece to a disk.
    pub(crate) fn open(&self, recipe: &Recipe) -> Disk {
        let mut random = Random::new(recipe.seed.into(), 1);
        let opening = match recipe.opening {
            Opening::Edge | Opening::Triangle if self.has_boundary_or_genus() => Opening::Plain,
            Opening::Plain if !self.has_boundary_or_genus() => Opening::Slit,
            opening => opening,
        };
        let (half_edges, origin, start) = match opening {
            Opening::Plain | Opening::Slit | Opening::FreeSlit => self.cut(opening, recipe, &mut random),
            Opening::Edge => {
                let h = random.below(3 * self.closed.triangles().len()) as u32;
                let mut cut = CutGraph::empty(&self.closed);
                cut.mark(&self.closed, h);
                let (disk, origin) = cut.open(&self.closed);
                (disk, origin, vec![h])
            }
            Opening::Triangle => {
                let h = random.below(3 * self.closed.triangles().len()) as u32;
                let out = self.closed.opposite(h).unwrap_or(h) / 3;
                let (disk, origin) = part(&self.closed, |f| f != out);
                // Triangles after the one taken out have moved up.
                let h = if h / 3 > out { h - 3 } else { h };
                (disk, origin, vec![h])
            }
        };
        let drop_ends = self.has_boundary_or_genus() || opening == Opening::FreeSlit;
        let keep = f64::from(u16::from(recipe.keep) + 1) / 256.0;
        let columns = recipe.columns();
        let plan = Plan { start, alpha: recipe.alpha.into(), keep, columns, seed: recipe.seed.into(), drop_ends };
        Disk { half_edges, origin, plan }
    }

    /// Cuts the handles open, and along a path from there to a far vertex if there is to be a slit.
    fn cut(&self, opening: Opening, recipe: &Recipe, random: &mut Random) -> (HalfEdges, Vec<u32>, Vec<u32>) {
        let mesh = &self.closed;
        let farthest = |paths: &Paths| paths.order[paths.order.len() - 1];
        let root = self.outer.unwrap_or_else(|| {
            let any = random.below(mesh.vertices()) as u32;
            if self.genus > 0 { any } else { farthest(&Paths::from(mesh, any)) }
        });
        let mut cut = if self.genus > 0 { CutGraph::of_closed(mesh, root, true) } else { CutGraph::empty(mesh) };
        let mut side = Vec::new();
        if opening != Opening::Plain {
            let paths = Paths::from(mesh, root);
            // One of the farther 70 %, mostly among the farthest.
            let far = paths.order.len() - 1;
            let share = match opening {
                Opening::Slit => f64::from(recipe.length) / 65536.0,
                _ => random.unit(),
            };
            let b = paths.order[far - (far as f64 * 0.7 * share * share) as usize];
            side.extend(paths.back_from(mesh, b).take_while(|&h| !cut.has(h)));
            side.reverse();
            side.iter().for_each(|&h| cut.mark(mesh, h));
        }
        let (open, open_origin) = cut.open(mesh);
        let kept = |f: u32| {
            self.outer.is_none_or(|outer| open.triangles()[f as usize].iter().all(|&v| open_origin[v as usize] != outer))
        };
        let mut moved = vec![NONE; open.triangles().len()];
        let mut count = 0;
        for (f, new) in moved.iter_mut().enumerate() {
            if kept(f as u32) {
                *new = count;
                count += 1;
            }
        }
        let (disk, origin) = part(&open, kept);
        let origin: Vec<u32> = origin.into_iter().map(|v| open_origin[v as usize]).collect();
        let mut start: Vec<u32> =
            side.iter().filter(|&&h| moved[h as usize / 3] != NONE).map(|&h| 3 * moved[h as usize / 3] + h % 3).collect();
        if opening != Opening::Slit || start.is_empty() {
            start = Self::arc(&disk, recipe);
        }
        (disk, origin, start)
    }

    /// A stretch of the boundary of a disk.
    fn arc(disk: &HalfEdges, recipe: &Recipe) -> Vec<u32> {
        let around = boundary_loops(disk).into_iter().next().unwrap_or_default();
        let n = around.len();
        let first = (usize::from(recipe.start) * n) >> 16;
        let length = ((usize::from(recipe.length) + 1) * n / 65537).clamp(1, n - 1);
        (0..length).map(|i| around[(first + i) % n]).collect()
    }
}
