//! Wavefront OBJ: one statement a line, indices from 1, negative ones from the end.
//!
//! | statement | becomes |
//! |---|---|
//! | `v x y z` | a position |
//! | `v x y z w`, `v x y z r g b`, `v x y z r g b a` | with attribute `w` or colours on vertices |
//! | `vt u [v [w]]`, `vn x y z` | texture coordinates and normals, on the corners whose `f` names them |
//! | `f v/vt/vn …` | a face |
//! | `o`, `g`, `usemtl`, `s`, `mtllib` | labels |
//!
//! Normals or texture coordinates that every corner names by the number of its vertex are
//! attributes of vertices, and are written so: the two say the same. Lines, points, curves and
//! unknown statements are noted. An index of `vt` or `vn` that does not exist leaves the corner
//! without a value, with a note: the geometry is still good. An index of `v` that does not exist
//! is an error.

mod read;
mod table;
mod write;

pub(super) use read::read;
pub(super) use write::write;

#[cfg(test)]
mod tests;
