//! STL: triangles without connectivity, in text or binary.
//!
//! Corners with equal coordinates become one vertex (exactly equal; −0 equals 0), numbered in order
//! of first appearance. Facet normals are dropped, which is said: they follow from the corners.
//! The 16 bits that binary files have for each facet are kept as the face attribute `attribute`
//! unless all are 0. A text file's `solid` names are objects. A binary file is known by its length,
//! since many begin with the word `solid` as well.
//!
//! Written in binary: an 80-byte header, the number of facets, and 50 bytes a facet.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use byteorder::{ByteOrder, LE};

use super::number::{Digits, Number};
use super::text::{Syntax, Text, name, show};
use super::{Sink, count, note_losses, note_rounding, push_face};
use crate::error::{Error, Place, Result};
use crate::mesh::{Attribute, AttributeKind, Domain, Label, LabelKind, Mesh, Scalar};

/// Bytes before the first facet, and of a facet.
const HEADER: usize = 84;
const FACET: usize = 50;
/// The name of the 16 bits of a facet.
const BITS: &str = "attribute";

/// Whether the length is the one that a binary file of so many facets has.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    announced(bytes).is_some_and(|facets| bytes.len() as u64 == HEADER as u64 + FACET as u64 * facets)
}

fn announced(bytes: &[u8]) -> Option<u64> {
    Some(LE::read_u32(bytes.get(80..HEADER)?).into())
}

/// Reads a whole file.
pub(super) fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<Mesh> {
    let says_solid = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    if says_solid && !is_binary(bytes) { read_text(bytes, notes) } else { read_binary(bytes, notes) }
}

fn read_binary(bytes: &[u8], notes: &mut Vec<String>) -> Result<Mesh> {
    let Some(facets) = announced(bytes) else {
        let why = format!("expected `solid`, or {HEADER} bytes of a binary header, found {}", count(bytes.len(), "byte"));
        return Err(Error::malformed(Place::Whole, why));
    };
    let (records, rest) = bytes[HEADER..].as_chunks::<FACET>();
    if (records.len() as u64) < facets {
        let why = format!("{facets} facets of {FACET} bytes are announced, and {} bytes follow", bytes.len() - HEADER);
        return Err(Error::malformed(Place::Byte(80), why));
    }
    let left_over = bytes.len() as u64 - HEADER as u64 - FACET as u64 * facets;
    if left_over > 0 {
        notes.push(format!("{left_over} bytes after the last facet are not kept"));
    }
    let _ = rest;
    let records = &records[..facets as usize];

    let mut weld = Weld::new(3 * records.len());
    let mut attribute = Vec::with_capacity(records.len());
    for record in records {
        let coordinate = |i: usize| f64::from(LE::read_f32(&record[4 * i..4 * i + 4]));
        weld.facet([1, 2, 3].map(|corner| [0, 1, 2].map(|axis| coordinate(3 * corner + axis))))?;
        attribute.push(f64::from(LE::read_u16(&record[48..])));
    }
    let mut mesh = weld.mesh;
    mesh.precision = Scalar::F32;
    if attribute.iter().any(|&bits| bits != 0.0) {
        mesh.attributes.push(Attribute {
            kind: AttributeKind::Other,
            name: BITS.to_owned(),
            domain: Domain::Face,
            width: 1,
            scalar: Scalar::U16,
            values: attribute,
            indices: Vec::new(),
        });
    }
    note_normals(&mesh, notes);
    Ok(mesh)
}

fn note_normals(mesh: &Mesh, notes: &mut Vec<String>) {
    if !mesh.faces.is_empty() {
        notes.push("facet normals are not kept: they follow from the corners".to_owned());
    }
}

/// `solid NAME`, then `facet normal … outer loop vertex … vertex … vertex … endloop endfacet`, then `endsolid`.
///
/// Only `solid` and `vertex` carry anything that is kept; the other words must be known, but their
/// order is not checked beyond three vertices a loop.
fn read_text(bytes: &[u8], notes: &mut Vec<String>) -> Result<Mesh> {
    let mut text = Text::new(bytes, Syntax::Plain);
    let mut weld = Weld::new(0);
    let mut digits = Digits::default();
    let mut corners = Vec::<[f64; 3]>::new();
    let mut found = Vec::<f64>::new();
    while text.find_word() {
        let word = text.word().unwrap_or_default();
        match word.to_ascii_lowercase().as_slice() {
            b"vertex" => {
                let mut numbers = [Number::ZERO; 3];
                for (n, slot) in numbers.iter_mut().enumerate() {
                    *slot = text.number()?.ok_or_else(|| text.error(format!("expected 3 coordinates, found {n}")))?;
                    digits.see(found.len(), slot);
                    found.push(slot.value);
                }
                corners.push(numbers.map(|n| n.value));
            }
            b"endloop" | b"endfacet" if corners.is_empty() => {}
            b"endloop" | b"endfacet" => {
                let facet = corners.as_slice().try_into();
                weld.facet(facet.map_err(|_| text.error(format!("expected 3 vertices in a loop, found {}", corners.len())))?)?;
                corners.clear();
            }
            b"solid" => {
                let rest = text.rest();
                let first_face = weld.mesh.faces.len() as u32;
                if !rest.is_empty() || first_face > 0 {
                    weld.mesh.labels.push(Label { kind: LabelKind::Object, name: name(rest), first_face });
                }
            }
            b"endsolid" => {
                text.rest();
            }
            b"facet" | b"outer" | b"loop" => {}
            b"normal" => {
                for _ in 0..3 {
                    text.number()?;
                }
            }
            _ => return Err(text.error(format!("expected an STL keyword, found {}", show(word)))),
        }
    }
    if !corners.is_empty() {
        return Err(text.error("the file ends inside a facet"));
    }
    let mut mesh = weld.mesh;
    // The type is known at the end; then equal numbers are still equal.
    mesh.precision = digits.settle(&mut found);
    if mesh.precision == Scalar::F32 {
        for (vertex, &first) in mesh.positions.iter_mut().zip(&weld.first) {
            vertex.copy_from_slice(&found[3 * first..3 * first + 3]);
        }
    }
    note_normals(&mesh, notes);
    Ok(mesh)
}

/// Makes equal corners one vertex.
struct Weld {
    vertices: HashMap<[u64; 3], u32>,
    mesh: Mesh,
    /// For each vertex the first corner that is it.
    first: Vec<usize>,
}

impl Weld {
    fn new(corners: usize) -> Self {
        // A closed mesh has about one vertex for six corners.
        Self { vertices: HashMap::with_capacity(corners / 6), mesh: Mesh::default(), first: Vec::new() }
    }

    fn facet(&mut self, corners: [[f64; 3]; 3]) -> Result<()> {
        let mut face = [0; 3];
        for (corner, (position, slot)) in corners.into_iter().zip(&mut face).enumerate() {
            // Adding 0 turns −0 into 0.
            *slot = match self.vertices.entry(position.map(|x| (x + 0.0).to_bits())) {
                Entry::Occupied(vertex) => *vertex.get(),
                Entry::Vacant(vacant) => {
                    let vertex = self.mesh.positions.len() as u32;
                    self.mesh.positions.push(position);
                    self.first.push(self.mesh.faces.corners().len() + corner);
                    *vacant.insert(vertex)
                }
            };
        }
        push_face(&mut self.mesh.faces, &face)
    }
}

/// Writes a whole file.
pub(super) fn write(mesh: &Mesh, out: &mut Sink<'_>, notes: &mut Vec<String>) -> Result<()> {
    let bits = mesh.attributes.iter().position(|a| {
        a.name == BITS && a.domain == Domain::Face && a.width == 1 && a.scalar == Scalar::U16 && mesh.faces.are_triangles()
    });
    note_losses(mesh, "STL", notes, |i| bits == Some(i));
    note_rounding("the positions", mesh.positions.as_flattened(), Scalar::F32, notes);
    if !mesh.labels.is_empty() {
        notes.push(format!("STL files do not hold names: {} left out", count(mesh.labels.len(), "label")));
    }
    let polygons = mesh.faces.iter().filter(|face| face.len() > 3).count();
    if polygons > 0 {
        notes.push(format!("STL files hold triangles only: {} cut into fans", count(polygons, "polygon")));
    }
    let short = mesh.faces.iter().filter(|face| face.len() < 3).count();
    if short > 0 {
        notes.push(format!("STL files hold triangles only: {} of fewer than 3 corners left out", count(short, "face")));
    }
    let mut used = vec![false; mesh.positions.len()];
    mesh.faces.iter().filter(|face| face.len() >= 3).flatten().for_each(|&v| used[v as usize] = true);
    let isolated = used.iter().filter(|&&used| !used).count();
    if isolated > 0 {
        notes.push(format!("STL files do not hold vertices that no face uses: {isolated} left out"));
    }

    let triangles = mesh.faces.triangles();
    let facets = u32::try_from(triangles.len())
        .map_err(|_| Error::Unsupported { what: "an STL file of", id: format!("{} facets", triangles.len()) })?;
    // The header must not begin with `solid`.
    let mut header = [b' '; 80];
    header[..10].copy_from_slice(b"binary STL");
    out.bytes(&header);
    out.bytes(&facets.to_le_bytes());
    for (f, triangle) in triangles.iter().enumerate() {
        let corners = triangle.map(|v| mesh.positions[v as usize]);
        for x in normal(corners).into_iter().chain(corners.into_iter().flatten()) {
            out.binary(x, Scalar::F32);
        }
        out.binary(bits.and_then(|i| mesh.attributes[i].get(f)).map_or(0.0, |value| value[0]), Scalar::U16);
        out.rest()?;
    }
    Ok(())
}

/// The unit normal; zero where there is none.
fn normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let [u, v] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() { n.map(|x| x / length + 0.0) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::io::Format;

    const TEXT: &str = "solid left half\nfacet normal 0 0 1\n  outer loop\n    vertex 0 0 0\n    vertex 1 0 0\n    vertex 0.1 1e0 -0\n  endloop\nendfacet\n\
                        endsolid left half\nsolid\nFACET NORMAL nan nan nan OUTER LOOP\nVERTEX 1 0 0 VERTEX -0 0 0 VERTEX 0.1 -1 0\nENDLOOP ENDFACET\nendsolid\n";

    fn read(bytes: &[u8]) -> Result<crate::Loaded> {
        Mesh::read(bytes, Some(Format::Stl))
    }

    #[test]
    fn equal_corners_are_one_vertex_in_order_of_appearance() {
        let loaded = read(TEXT.as_bytes()).unwrap();
        let mesh = loaded.mesh;
        assert_eq!(
            mesh.positions,
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [f64::from(0.1_f32), 1.0, 0.0], [f64::from(0.1_f32), -1.0, 0.0]]
        );
        assert_eq!(mesh.faces.iter().collect::<Vec<_>>(), [[0, 1, 2], [1, 0, 3]]);
        let labels = mesh.labels.iter().map(|l| (l.name.as_str(), l.first_face)).collect::<Vec<_>>();
        assert_eq!(labels, [("left half", 0), ("", 1)]);
        assert_eq!(loaded.notes, ["facet normals are not kept: they follow from the corners"]);
    }

    #[test]
    fn a_binary_file_comes_back_with_its_attribute_bits() {
        let mut mesh = read(TEXT.as_bytes()).unwrap().mesh;
        mesh.labels.clear();
        mesh.attributes.push(Attribute {
            kind: AttributeKind::Other,
            name: BITS.to_owned(),
            domain: Domain::Face,
            width: 1,
            scalar: Scalar::U16,
            values: vec![0.0, 0x801f.into()],
            indices: Vec::new(),
        });
        let mut bytes = Vec::new();
        assert_eq!(mesh.write(Format::Stl, &mut bytes).unwrap(), [] as [&str; 0]);
        assert_eq!(bytes.len(), 84 + 2 * 50);
        assert_eq!(&bytes[84..96], [0_f32, 0.0, 1.0].map(f32::to_le_bytes).as_flattened());
        assert_eq!(read(&bytes).unwrap().mesh, mesh);
        // Many binary files begin with the word that text files begin with.
        bytes[..5].copy_from_slice(b"solid");
        assert_eq!(read(&bytes).unwrap().mesh, mesh);
    }

    #[test]
    fn what_stl_cannot_hold_is_said() {
        let mut mesh =
            Mesh::from_triangles(vec![[0.1, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [5.0, 5.0, 5.0]], []);
        mesh.faces.push(&[0, 1, 2, 3]);
        mesh.faces.push(&[0, 1]);
        let notes = mesh.write(Format::Stl, std::io::sink()).unwrap();
        assert_eq!(
            notes,
            [
                "1 number of the positions is rounded to F32",
                "STL files hold triangles only: 1 polygon cut into fans",
                "STL files hold triangles only: 1 face of fewer than 3 corners left out",
                "STL files do not hold vertices that no face uses: 1 left out",
            ]
        );
    }

    #[test]
    fn errors_name_the_line_or_the_byte() {
        let fails = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
        assert_eq!(fails(b"solid\nvertex 0 0\n"), "line 2: expected 3 coordinates, found 2");
        assert_eq!(fails(b"solid\nvertex 0 0 0 vertex 0 0 0\nendloop"), "line 3: expected 3 vertices in a loop, found 2");
        assert_eq!(fails(b"solid\nvertex 0 0 0"), "line 2: the file ends inside a facet");
        assert_eq!(fails(b"solid\nface"), "line 2: expected an STL keyword, found \"face\"");
        assert_eq!(fails(b"half"), "expected `solid`, or 84 bytes of a binary header, found 4 bytes");
        let mut short = [0; 84 + 49];
        short[80] = 1;
        assert_eq!(fails(&short), "byte 80: 1 facets of 50 bytes are announced, and 49 bytes follow");
        assert_eq!(read(&[0; 90]).unwrap().notes, ["6 bytes after the last facet are not kept"]);
    }
}
