//! From the surface back to the faces of the mesh: what the front end did, undone (spec/any-mesh.md).
//!
//! A mesh that is not an oriented manifold of triangles is coded as one that nearly is it, and records of the difference:
//! which vertices are copies of others, which edges cut polygons, which faces are turned over, repeated or loose, and where
//! the vertices are that no face of the surface uses. All of it is coded when the whole surface and the positions of
//! its vertices are known, so that most records cost next to nothing.
//!
//! Writer and reader are one function; what the writer knows comes from a [`Source`].

mod copies;
mod points;
mod polygons;

use super::topology::Skin;
use crate::entropy::{AdaptiveBit, BitCoder, BitReader, BitWriter, Numbers};
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::mesh::Faces;

/// What the records must add up to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Totals {
    /// Vertices of the mesh.
    pub(crate) vertices: u32,
    /// Faces of the mesh.
    pub(crate) faces: u32,
    /// Corners of all faces together.
    pub(crate) corners: u32,
    /// Faces that are no part of the surface.
    pub(crate) loose: u32,
    /// Vertices that no face of the surface uses.
    pub(crate) points: u32,
}

/// How often a face of the surface is there, and how.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct FaceRecord {
    /// Whether the mesh has it the other way round.
    pub(crate) is_flipped: bool,
    /// How often it is repeated, the same way round and the other.
    pub(crate) repeats: [u32; 2],
}

/// What a writer is asked. A reader's answers do not matter.
pub(crate) trait Source {
    /// Which of the records are not empty.
    fn kinds(&self) -> Kinds {
        Kinds::default()
    }

    /// The vertex of the mesh that `v` of the skin is, by the number it has got; the next number if it is met for the first
    /// time.
    fn vertex(&mut self, _v: u32, next: u32) -> u32 {
        next
    }

    /// Whether half-edge `h` of the skin is a diagonal.
    fn is_diagonal(&self, _h: u32) -> bool {
        false
    }

    /// The record of the face whose first side is half-edge `h`.
    fn face(&self, _h: u32) -> FaceRecord {
        FaceRecord::default()
    }

    /// The lattice points of the vertices that no face of the surface uses, in the order of [`points::key`].
    fn points(&self) -> &[[i32; 3]] {
        &[]
    }

    /// The loose faces in the numbers that their vertices have got, each from its least vertex on, in order.
    fn loose(&self) -> &[Vec<u32>] {
        &[]
    }
}

/// Which records there are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Kinds {
    pub(crate) copies: bool,
    pub(crate) polygons: bool,
    pub(crate) flips: bool,
    pub(crate) repeats: bool,
}

/// Where a face of the mesh comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(not(feature = "encode"), allow(dead_code))]
pub(crate) enum Origin {
    /// The half-edge of the skin that is its first side; then which repeat it is: 0 for none.
    Surface(u32, u32),
    /// Which loose face it is.
    Loose(u32),
}

/// The mesh, in lattice points.
#[derive(Debug, Default)]
pub(crate) struct Rebuilt {
    pub(crate) positions: Vec<[i32; 3]>,
    pub(crate) faces: Faces,
    #[cfg_attr(not(feature = "encode"), allow(dead_code))]
    pub(crate) origins: Vec<Origin>,
}

/// Bytes of memory that reading takes: for what vertices, faces and corners.
pub(crate) fn memory(surface_vertices: u32, surface_faces: u64, totals: Totals) -> u64 {
    u64::from(surface_vertices) * copies::BYTES_A_VERTEX
        + surface_faces * polygons::BYTES_A_FACE
        + u64::from(totals.vertices) * 12
        + u64::from(totals.faces) * 16
        + u64::from(totals.corners) * 4
}

/// Steps that reading takes at most.
pub(crate) fn work(surface_vertices: u32, surface_faces: u64, totals: Totals) -> u64 {
    u64::from(surface_vertices) * copies::STEPS_A_VERTEX
        + 6 * surface_faces
        + u64::from(totals.corners)
        + u64::from(totals.faces)
        + 2 * u64::from(totals.points)
}

/// Writes the records.
#[cfg(feature = "encode")]
pub(crate) fn write<S: Source>(
    skin: &Skin,
    positions: &[[i32; 3]],
    extent: [i32; 3],
    totals: Totals,
    source: &mut S,
) -> Result<(Vec<u8>, Rebuilt)> {
    let mut budget = Budget::new(crate::Limits::default().memory(u64::MAX).work(u64::MAX).vertices(u64::MAX));
    let mut coder = BitWriter::default();
    let rebuilt = code(&mut coder, skin, positions, extent, totals, source, &mut budget)?;
    Ok((coder.finish(), rebuilt))
}

/// Reads what [`write`] wrote.
pub(crate) fn read(
    bytes: &[u8],
    skin: &Skin,
    positions: &[[i32; 3]],
    extent: [i32; 3],
    totals: Totals,
    budget: &mut Budget,
) -> Result<Rebuilt> {
    struct Unknown;
    impl Source for Unknown {}
    code(&mut BitReader::new(bytes), skin, positions, extent, totals, &mut Unknown, budget)
}

fn code<C: BitCoder, S: Source>(
    coder: &mut C,
    skin: &Skin,
    positions: &[[i32; 3]],
    extent: [i32; 3],
    totals: Totals,
    source: &mut S,
    budget: &mut Budget,
) -> Result<Rebuilt> {
    budget.reserve(memory(positions.len() as u32, skin.triangles.len() as u64, totals))?;
    let kinds = code_kinds(coder, source.kinds());
    let mut rebuilt = Rebuilt::default();
    let number = copies::code(coder, skin, positions, kinds.copies, source, &mut rebuilt.positions, budget)?;
    points::code(coder, extent, totals.points, source.points(), &mut rebuilt.positions, budget)?;
    if rebuilt.positions.len() != totals.vertices as usize {
        return Err(error(format!("{} vertices, {} expected", rebuilt.positions.len(), totals.vertices)));
    }
    let starts = polygons::code(coder, skin, positions, kinds.polygons, source, budget)?;
    let mut tally = Tally { faces: totals.faces, corners: totals.corners };
    let mut face = Vec::new();
    let mut models = FaceModels::default();
    for &start in &starts.starts {
        face.clear();
        let mut h = start;
        loop {
            face.push(number[skin.from(h) as usize]);
            h = starts.after(skin, h);
            if h == start {
                break;
            }
            if face.len() > totals.corners as usize {
                return Err(error("diagonals that cut no polygon"));
            }
        }
        let record = models.code(coder, kinds, source.face(start));
        if record.is_flipped {
            face[1..].reverse();
        }
        let mut repeat = 0;
        for (count, reverse) in [(1, false), (record.repeats[0], false), (record.repeats[1], true)] {
            for i in 0..count {
                if reverse && i == 0 {
                    face[1..].reverse();
                }
                tally.take(face.len(), budget)?;
                rebuilt.faces.push(&face);
                rebuilt.origins.push(Origin::Surface(start, repeat));
                repeat += 1;
            }
        }
        if coder.is_exhausted() {
            return Err(error("the stream ends too soon"));
        }
    }
    code_loose(coder, totals, source.loose(), &mut tally, &mut rebuilt, budget)?;
    if (tally.faces, tally.corners) != (0, 0) {
        return Err(error(format!("{} faces and {} corners are missing", tally.faces, tally.corners)));
    }
    Ok(rebuilt)
}

#[cold]
fn error(why: impl std::fmt::Display) -> Error {
    Error::malformed(Place::Chunk(*b"FIXS", 0), format!("records: {why}"))
}

fn code_kinds<C: BitCoder>(coder: &mut C, kinds: Kinds) -> Kinds {
    let mut flag = |is| coder.code(is, 1 << 15);
    Kinds { copies: flag(kinds.copies), polygons: flag(kinds.polygons), flips: flag(kinds.flips), repeats: flag(kinds.repeats) }
}

/// Faces and corners that are still to come.
struct Tally {
    faces: u32,
    corners: u32,
}

impl Tally {
    fn take(&mut self, corners: usize, budget: &mut Budget) -> Result<()> {
        budget.spend(1 + corners as u64)?;
        let corners = u32::try_from(corners).unwrap_or(u32::MAX);
        match (self.faces.checked_sub(1), self.corners.checked_sub(corners)) {
            (Some(faces), Some(corners)) => {
                *self = Self { faces, corners };
                Ok(())
            }
            _ => Err(error("more faces or corners than there should be")),
        }
    }
}

/// Flips and repeats; each by that of the face before.
struct FaceModels {
    flip: [AdaptiveBit; 2],
    repeat: Numbers,
    last: FaceRecord,
}

impl Default for FaceModels {
    fn default() -> Self {
        Self { flip: [AdaptiveBit::default(); 2], repeat: Numbers::new(4), last: FaceRecord::default() }
    }
}

impl FaceModels {
    fn code<C: BitCoder>(&mut self, coder: &mut C, kinds: Kinds, mut record: FaceRecord) -> FaceRecord {
        record.is_flipped = kinds.flips && self.flip[usize::from(self.last.is_flipped)].code(coder, record.is_flipped);
        for (i, repeats) in record.repeats.iter_mut().enumerate() {
            let context = 2 * i + usize::from(self.last.repeats[i] > 0);
            *repeats = if kinds.repeats { self.repeat.code(coder, *repeats, context) } else { 0 };
        }
        self.last = record;
        record
    }
}

/// Loose faces: how many corners; the least vertex, from that of the face before on; the others, from the least on.
fn code_loose<C: BitCoder>(
    coder: &mut C,
    totals: Totals,
    loose: &[Vec<u32>],
    tally: &mut Tally,
    rebuilt: &mut Rebuilt,
    budget: &mut Budget,
) -> Result<()> {
    let mut models = Numbers::new(4);
    let mut last = 0_u32;
    let mut face = Vec::new();
    for i in 0..totals.loose {
        let known = loose.get(i as usize).map_or(&[][..], Vec::as_slice);
        let n = models.code(coder, known.len() as u32, 0);
        tally.take(n as usize, budget)?;
        face.clear();
        for c in 0..n as usize {
            let at = known.get(c).copied().unwrap_or(0);
            let from = if c == 0 { last } else { face[0] };
            let v = from.saturating_add(models.code(coder, at.wrapping_sub(from), 1 + c.min(2)));
            if v >= totals.vertices {
                return Err(error(format!("a loose face names vertex {v}, and there are {}", totals.vertices)));
            }
            face.push(v);
        }
        last = face.first().copied().unwrap_or(last);
        rebuilt.faces.push(&face);
        rebuilt.origins.push(Origin::Loose(i));
        if coder.is_exhausted() {
            return Err(error("the stream ends too soon"));
        }
    }
    Ok(())
}

#[cfg(feature = "encode")]
pub(crate) use points::key as point_key;
