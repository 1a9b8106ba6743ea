//! What can go wrong, sorted by who can mend it.
//!
//! Texts are lower-case and say what was found, what was expected, and where.

use std::fmt;
use std::path::{Path, PathBuf};

/// The result of everything here that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why something was not done.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused to read or write.
    Io(std::io::Error),
    /// The input breaks the rules of its own format.
    Malformed {
        /// Where in the input.
        at: Place,
        /// What was found and what was expected.
        why: String,
    },
    /// The input is legal, but asks for something that this version does not do.
    Unsupported {
        /// The kind of thing, such as `codec` or `chunk`.
        what: &'static str,
        /// Which one.
        id: String,
    },
    /// A limit set by the caller would be passed.
    Limit {
        /// Which limit: `memory`, `vertices`, `pixels` or `work`.
        which: &'static str,
        /// What the input needs, as far as is known.
        wanted: u64,
        /// What the caller allows.
        allowed: u64,
    },
    /// The mesh is not one that the chosen method can take.
    Mesh(MeshDefect),
    /// The caller's options contradict each other, the mesh, or a range.
    Parameter(String),
    /// An iteration did not reach its goal.
    NoConvergence {
        /// Which iteration.
        what: &'static str,
        /// Steps done.
        after: usize,
        /// What was left.
        residual: f64,
    },
    /// The [`Task`](crate::Task) was cancelled or its deadline passed.
    Cancelled,
    /// Any of the others, with the file in which it happened.
    InFile {
        /// The file.
        path: PathBuf,
        /// What happened there.
        source: Box<Error>,
    },
}

/// A place in an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// A line of a text file, from 1.
    Line(u64),
    /// A byte of a binary file, from 0.
    Byte(u64),
    /// A byte of a `.gimc` file, counted from the start of a chunk's payload.
    Chunk([u8; 4], u64),
    /// The input as a whole.
    Whole,
}

/// Why a triangle list is not an oriented manifold, or not a mesh at all.
///
/// Indices count from 0, as in the [`Mesh`](crate::Mesh).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshDefect {
    /// No faces.
    Empty,
    /// A coordinate is NaN or infinite.
    NonFinite {
        /// The vertex.
        vertex: u32,
    },
    /// A face names a vertex that does not exist.
    IndexOutOfRange {
        /// The face.
        face: u32,
        /// The index found.
        index: u64,
        /// How many vertices there are.
        vertices: u64,
    },
    /// A face names one vertex twice.
    Degenerate {
        /// The triangle.
        face: u32,
    },
    /// More than two triangles share an edge.
    NonManifoldEdge {
        /// One end.
        a: u32,
        /// The other end.
        b: u32,
    },
    /// Two triangles walk their common edge in the same direction.
    Disoriented {
        /// Start of the edge.
        a: u32,
        /// End of the edge.
        b: u32,
    },
    /// The triangles around a vertex form more than one fan.
    NonManifoldVertex {
        /// The vertex.
        vertex: u32,
    },
}

impl Error {
    /// The same error, said of a file.
    pub fn in_file(self, path: &Path) -> Self {
        match self {
            Self::InFile { .. } => self,
            other => Self::InFile { path: path.to_owned(), source: Box::new(other) },
        }
    }

    /// What is [`Error::Unsupported`] where a surface has no geometry image.
    pub(crate) const IMAGE_OF: &'static str = "a geometry image of";

    pub(crate) fn malformed(at: Place, why: impl Into<String>) -> Self {
        Self::Malformed { at, why: why.into() }
    }

    /// What the user might do about it, if that can be said in one line.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::InFile { source, .. } => source.hint(),
            Self::Limit { which, wanted, .. } => {
                Some(format!("if the file is trusted, raise the limit: --limit-{which} {wanted}"))
            }
            Self::Mesh(MeshDefect::Empty | MeshDefect::NonFinite { .. } | MeshDefect::IndexOutOfRange { .. }) => None,
            Self::Mesh(_) => Some("`gimc inspect MESH` tells all that is wrong with it".into()),
            Self::NoConvergence { .. } | Self::Unsupported { what: Self::IMAGE_OF, .. } => {
                Some("`--method cgim` keeps the mesh's own triangles and needs no map of it".into())
            }
            _ => None,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io(e) => write!(f, "{e}"),
            Self::Malformed { at: Place::Whole, why } => write!(f, "{why}"),
            Self::Malformed { at, why } => write!(f, "{at}: {why}"),
            Self::Unsupported { what, id } => write!(f, "{what} {id} is not supported by this version"),
            Self::Limit { which, wanted, allowed } => {
                write!(f, "the {which} limit is {allowed}, and at least {wanted} would be needed")
            }
            Self::Mesh(defect) => write!(f, "{defect}"),
            Self::Parameter(why) => write!(f, "{why}"),
            Self::NoConvergence { what, after, residual } => {
                write!(f, "{what} did not converge: a residual of {residual:e} after {after} steps")
            }
            Self::Cancelled => write!(f, "cancelled"),
            Self::InFile { path, source } => write!(f, "{}: {source}", path.display()),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(n) => write!(f, "line {n}"),
            Self::Byte(n) => write!(f, "byte {n}"),
            Self::Chunk(tag, n) => write!(f, "chunk {} at byte {n}", tag.escape_ascii()),
            Self::Whole => write!(f, "the input"),
        }
    }
}

impl fmt::Display for MeshDefect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "the mesh has no faces"),
            Self::NonFinite { vertex } => write!(f, "vertex {vertex} has a coordinate that is not a finite number"),
            Self::IndexOutOfRange { face, index, vertices } => {
                write!(f, "face {face} names vertex {index}, and there are {vertices} vertices")
            }
            Self::Degenerate { face } => write!(f, "face {face} names one vertex twice"),
            Self::NonManifoldEdge { a, b } => write!(f, "more than two triangles share the edge of vertices {a} and {b}"),
            Self::Disoriented { a, b } => {
                write!(f, "two triangles walk the edge from vertex {a} to vertex {b} in the same direction")
            }
            Self::NonManifoldVertex { vertex } => write!(f, "the triangles around vertex {vertex} form more than one fan"),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io(e) => Some(e),
            Self::InFile { source, .. } => Some(source),
            _ => None,
        }
    }
}

impl From<std::io::Error> for Error {
    fn from(e: std::io::Error) -> Self {
        Self::Io(e)
    }
}

impl From<MeshDefect> for Error {
    fn from(defect: MeshDefect) -> Self {
        Self::Mesh(defect)
    }
}
