//! PLY, the Stanford polygon format: a text header that describes its own tables, then the tables.
//!
//! | in the file | becomes |
//! |---|---|
//! | `vertex`: `x` `y` `z` of any type | positions |
//! | `nx ny nz` | normals |
//! | `red green blue [alpha]`, `r g b [a]`, `diffuse_…` | colours |
//! | `s t`, `u v`, `texture_u texture_v` | texture coordinates |
//! | any other number of a vertex or a face | an attribute of its name |
//! | `face`: `vertex_indices` or `vertex_index` | faces |
//! | another list of a face, with as many numbers for each corner (`texcoord`, `color`) | an attribute on corners |
//! | `tristrips` | triangles, if there are no faces |
//!
//! Properties may come in any order and of any type, 64-bit integers (not in the standard, but
//! seen) included. Other elements and lists are skipped, with a note. In text, each record has a
//! line of its own.
//!
//! Written in binary, little-endian, positions in their own type.

mod cells;
mod header;
mod meaning;
mod read;
mod write;

pub(super) use read::read;
pub(super) use write::write;

#[cfg(test)]
mod tests;
