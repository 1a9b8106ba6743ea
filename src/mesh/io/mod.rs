//! Mesh files in and out: OBJ, PLY, OFF, STL, GLB.
//!
//! Readers keep what a file says: the order of vertices, faces and corners, polygons as polygons,
//! `f32` and `f64` values exactly, and every attribute and label that a [`Mesh`] can hold. What it
//! cannot hold is named in [`Loaded::notes`]; only comments are passed over without a word.
//! Writers do the same: they give a format all that it can hold, and return notes about the rest.
//!
//! Faces of one or two corners are kept like any other face, so that nothing is lost and indices
//! of faces stay true; [`Faces::triangles`](super::Faces::triangles) has none for them. A vertex
//! index that no vertex has is an error with its place.
//!
//! The readers are our own. The crates that were looked at (`tobj`, `serde-ply`, `stl_io`) turn
//! numbers into `f32`, triangulate or reorder, or do not say where an error is; here a file is one
//! slice of bytes and every error knows its line or byte. Memory stays within some multiple of
//! the file's length: counts in headers are compared with the bytes that follow them first.

mod format;
mod glb;
mod number;
mod obj;
mod off;
mod ply;
mod sink;
mod stl;
mod text;

use std::fs::File;
use std::io::Write;
use std::path::Path;

pub use format::Format;
use sink::Sink;

use super::{Attribute, AttributeKind, Domain, Faces, Mesh, Scalar};
use crate::error::{Error, Place, Result};

/// A file that has more to complain of is not read by a person.
const MOST_NOTES: usize = 100;

/// A mesh, and what its file said that the mesh does not hold.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Loaded {
    /// The mesh.
    pub mesh: Mesh,
    /// The format that was read.
    pub format: Format,
    /// What was left out, one sentence each.
    pub notes: Vec<String>,
}

impl Mesh {
    /// Reads a mesh file from memory; without a format, the content tells which it is.
    ///
    /// ```
    /// let file = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 1 2 3\n";
    /// let loaded = gimc::Mesh::read(file, None)?;
    /// assert_eq!(loaded.mesh.faces.get(0), [0, 1, 2]);
    /// assert_eq!(loaded.notes, ["statement \"l\" is not kept (1 line, the first is line 4)"]);
    /// # Ok::<(), gimc::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Malformed`] with a line (text) or byte (binary) and what was found and expected there;
    /// [`Error::Unsupported`] for variants of a format that are not read.
    pub fn read(bytes: &[u8], format: Option<Format>) -> Result<Loaded> {
        let Some(format) = format.or_else(|| Format::detect(bytes)) else {
            let why = if bytes.is_empty() { "the file is empty" } else { "the content is not OBJ, PLY, OFF, STL or GLB" };
            return Err(Error::malformed(Place::Whole, why));
        };
        let mut notes = Vec::new();
        let mesh = match format {
            Format::Obj => obj::read(bytes, &mut notes),
            Format::Ply => ply::read(bytes, &mut notes),
            Format::Off => off::read(bytes, &mut notes),
            Format::Stl => stl::read(bytes, &mut notes),
            Format::Glb => glb::read(bytes, &mut notes),
        }?;
        if notes.len() > MOST_NOTES {
            let more = notes.len() - MOST_NOTES;
            notes.truncate(MOST_NOTES);
            notes.push(format!("and {more} more of the kind"));
        }
        Ok(Loaded { mesh, format, notes })
    }

    /// Reads a mesh file. The extension tells the format, unless the content proves another.
    ///
    /// # Errors
    /// As [`Mesh::read`], with the file's name, or [`Error::Io`].
    pub fn load(path: impl AsRef<Path>) -> Result<Loaded> {
        let path = path.as_ref();
        let read = || {
            let bytes = std::fs::read(path)?;
            Self::read(&bytes, Format::magic(&bytes).or_else(|| Format::from_path(path)))
        };
        read().map_err(|error: Error| error.in_file(path))
    }

    /// Reads a mesh file, without the notes that [`Mesh::load`] gives.
    ///
    /// # Errors
    /// As [`Mesh::load`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        Ok(Self::load(path)?.mesh)
    }

    /// Writes the mesh in a format; the sentences returned say what the format could not hold.
    ///
    /// PLY and STL are written in binary (little-endian), GLB is binary, the others are text.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Mesh`] or [`Error::Parameter`] where indices, attributes or labels do not fit the mesh.
    pub fn write(&self, format: Format, mut out: impl Write) -> Result<Vec<String>> {
        self.check_references()?;
        let mut notes = Vec::new();
        let mut sink = Sink::new(&mut out);
        match format {
            Format::Obj => obj::write(self, &mut sink, &mut notes),
            Format::Ply => ply::write(self, &mut sink, &mut notes),
            Format::Off => off::write(self, &mut sink, &mut notes),
            Format::Stl => stl::write(self, &mut sink, &mut notes),
            Format::Glb => glb::write(self, &mut sink, &mut notes),
        }?;
        sink.finish()?;
        Ok(notes)
    }

    /// Writes the mesh to a file in the format of its extension; see [`Mesh::write`].
    ///
    /// # Errors
    /// As [`Mesh::write`], with the file's name; [`Error::Parameter`] if the extension is none that is written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<Vec<String>> {
        let path = path.as_ref();
        let Some(format) = Format::from_path(path) else {
            let why = "the file's extension is none of obj, ply, off, stl, glb".to_owned();
            return Err(Error::Parameter(why).in_file(path));
        };
        File::create(path).map_err(Error::from).and_then(|file| self.write(format, file)).map_err(|error| error.in_file(path))
    }
}

/// Adds a face, unless the corners become too many for their indices.
fn push_face(faces: &mut Faces, corners: &[u32]) -> Result<()> {
    const MOST: u64 = u32::MAX as u64;
    let wanted = faces.corners().len() as u64 + corners.len() as u64;
    if wanted >= MOST || faces.len() as u64 >= MOST {
        return Err(Error::Unsupported { what: "a mesh of", id: format!("{wanted} corners") });
    }
    faces.push(corners);
    Ok(())
}

/// `"1 line"`, `"7 lines"`.
fn count(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

/// Notes the attributes that are not written.
fn note_losses(mesh: &Mesh, format: &str, notes: &mut Vec<String>, kept: impl Fn(usize) -> bool) {
    for (_, left_out) in mesh.attributes.iter().enumerate().filter(|&(i, _)| !kept(i)) {
        let place = match left_out.domain {
            Domain::Vertex => "vertices",
            Domain::Corner => "corners",
            Domain::Face => "faces",
        };
        notes.push(format!("{format} files do not hold `{}` on {place}: left out", left_out.name));
    }
}

/// Notes that numbers change when they are written as `scalar`.
fn note_rounding(what: &str, values: &[f64], scalar: Scalar, notes: &mut Vec<String>) {
    let changed = values.iter().filter(|&&x| scalar.nearest(x) != x && !(scalar.is_float() && x.is_nan())).count();
    if changed > 0 {
        let are = if changed == 1 { "is" } else { "are" };
        notes.push(format!("{} of {what} {are} rounded to {scalar:?}", count(changed, "number")));
    }
}

/// The first attribute of a kind that fits, with its place in the mesh.
fn find(mesh: &Mesh, kind: AttributeKind, fits: impl Fn(&Attribute) -> bool) -> Option<(usize, &Attribute)> {
    mesh.attributes.iter().enumerate().find(|(_, attribute)| attribute.kind == kind && fits(attribute))
}
