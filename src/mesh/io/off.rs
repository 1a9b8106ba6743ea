//! OFF (Geomview's object file format) and its variants `[ST][C][N]OFF`.
//!
//! The header word, the counts of vertices, faces and edges (on the same line or the next), then
//! one line a vertex: `x y z [nx ny nz] [r g b [a]] [s t]`, and one line a face: how many corners,
//! their vertices, and a colour of three or four numbers or none. `#` starts a comment anywhere.
//! Plain `OFF` files with three or four numbers after the coordinates have colours too, as MeshLab
//! writes them. Colours that are all integers up to 255 are `u8`, others are floats.
//! `4OFF`, `nOFF` and binary files are not read.

use super::number::{Digits, Number};
use super::sink::Print;
use super::text::{Syntax, Text, show};
use super::{Sink, count, find, note_losses, note_rounding, push_face};
use crate::error::{Error, Place, Result};
use crate::mesh::{Attribute, AttributeKind, Domain, Mesh, Scalar};

/// What the header word announces for each vertex.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Variant {
    texcoords: bool,
    colours: bool,
    normals: bool,
}

impl Variant {
    fn parse(word: &[u8]) -> Result<Option<Self>> {
        let Some(mut prefix) = word.strip_suffix(b"OFF") else { return Ok(None) };
        let mut take = |letters: &[u8]| match prefix.strip_prefix(letters) {
            Some(rest) => {
                prefix = rest;
                true
            }
            None => false,
        };
        let variant = Self { texcoords: take(b"ST"), colours: take(b"C"), normals: take(b"N") };
        match prefix {
            b"" => Ok(Some(variant)),
            b"4" | b"n" | b"4n" => Err(Error::Unsupported { what: "OFF variant", id: word.escape_ascii().to_string() }),
            _ => Ok(None),
        }
    }
}

/// Reads a whole file.
pub(super) fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<Mesh> {
    let mut text = Text::new(bytes, Syntax::Off);
    let variant = read_variant(&mut text)?;
    let [vertices, faces] = read_counts(&mut text)?;

    let mut mesh = Mesh::default();
    let mut digits = Digits::default();
    let mut columns = Vertices::new(variant);
    for vertex in 0..vertices {
        if !text.find_word() {
            return Err(text.error(format!("{vertices} vertices are announced, and the file ends after {vertex}")));
        }
        let mut numbers = [Number::ZERO; 12];
        let found = text.numbers(&mut numbers)?;
        if found < 3 {
            return Err(text.error(format!("expected 3 coordinates, found {found}")));
        }
        let [x, y, z, rest @ ..] = &numbers;
        for (axis, number) in [x, y, z].into_iter().enumerate() {
            digits.see(3 * vertex + axis, number);
        }
        mesh.positions.push([x.value, y.value, z.value]);
        columns.push(rest, found - 3).map_err(|why| text.error(why))?;
    }
    mesh.precision = digits.settle(mesh.positions.as_flattened_mut());
    columns.finish(&mut mesh.attributes);
    read_faces(&mut text, faces, &mut mesh, notes)?;
    if text.find_word() {
        notes.push(format!("what follows the last face, from line {} on, is not kept", text.line()));
    }
    Ok(mesh)
}

/// The header word. Old files may begin with the counts at once.
fn read_variant(text: &mut Text<'_>) -> Result<Variant> {
    if !text.find_word() {
        return Err(Error::malformed(Place::Whole, "expected OFF, found nothing"));
    }
    let start = text.clone();
    let word = text.word().unwrap_or_default();
    if let Some(variant) = Variant::parse(word)? {
        let counts = text.clone();
        match text.word() {
            Some(b"BINARY") => return Err(Error::Unsupported { what: "OFF variant", id: "BINARY".to_owned() }),
            _ => *text = counts,
        }
        return Ok(variant);
    }
    if word.iter().all(u8::is_ascii_digit) {
        *text = start;
        return Ok(Variant::default());
    }
    Err(text.error(format!("expected OFF, found {}", show(word))))
}

/// The numbers of vertices and faces. Each of them takes at least a line of the file.
fn read_counts(text: &mut Text<'_>) -> Result<[usize; 2]> {
    let mut counts = [0; 2];
    for (slot, what) in counts.iter_mut().zip(["vertices", "faces"]) {
        if !text.find_word() {
            return Err(text.error(format!("expected the number of {what}, found the end of the file")));
        }
        let word = text.word().unwrap_or_default();
        *slot = std::str::from_utf8(word)
            .ok()
            .and_then(|word| word.parse().ok())
            .ok_or_else(|| text.error(format!("expected the number of {what}, found {}", show(word))))?;
    }
    // The number of edges may follow on the same line; nobody needs it.
    text.count_words();
    let [vertices, faces] = counts;
    // "0 0 0" and a line end, "0" and a line end; the last line may lack its end.
    let least = 6_u64.saturating_mul(vertices as u64).saturating_add(2_u64.saturating_mul(faces as u64));
    if least > text.left() as u64 + 1 {
        return Err(
            text.error(format!("{vertices} vertices and {faces} faces are announced, and {} bytes follow", text.left()))
        );
    }
    Ok(counts)
}

/// Colours as they are read: the type is known at the end.
#[derive(Debug, Default)]
struct Colours {
    width: usize,
    values: Vec<f64>,
    digits: Digits,
    has_fractions: bool,
}

impl Colours {
    fn push(&mut self, colour: &[Number]) {
        for number in colour {
            self.digits.see(self.values.len(), number);
            self.has_fractions |= number.has_point || number.typed(Scalar::U8).is_none();
            self.values.push(number.value);
        }
    }

    fn finish(mut self, domain: Domain, indices: Vec<u32>) -> Attribute {
        let floats = self.digits.settle(&mut self.values);
        Attribute {
            kind: AttributeKind::Colour,
            name: if self.width == 4 { "r g b a" } else { "r g b" }.to_owned(),
            domain,
            width: self.width,
            scalar: if self.has_fractions { floats } else { Scalar::U8 },
            values: self.values,
            indices,
        }
    }
}

/// What stands after the coordinates of vertices.
#[derive(Debug)]
struct Vertices {
    variant: Variant,
    /// Set by the first vertex.
    width: Option<usize>,
    normals: (Vec<f64>, Digits),
    colours: Colours,
    texcoords: (Vec<f64>, Digits),
}

impl Vertices {
    fn new(variant: Variant) -> Self {
        Self { variant, width: None, normals: Default::default(), colours: Colours::default(), texcoords: Default::default() }
    }

    /// Takes the `found` numbers that follow the coordinates.
    fn push(&mut self, numbers: &[Number], found: usize) -> Result<(), String> {
        let width = match self.width {
            Some(width) => width,
            None => self.decide(found)?,
        };
        if found != width {
            return Err(format!("expected {} numbers as on the first vertex, found {}", 3 + width, 3 + found));
        }
        let (normal, rest) = numbers.split_at(if self.variant.normals { 3 } else { 0 });
        let (colour, rest) = rest.split_at(self.colours.width);
        for ((values, digits), numbers) in
            [(&mut self.normals, normal), (&mut self.texcoords, if self.variant.texcoords { &rest[..2] } else { &[] })]
        {
            for number in numbers {
                digits.see(values.len(), number);
                values.push(number.value);
            }
        }
        self.colours.push(colour);
        Ok(())
    }

    /// The first vertex tells how many numbers a colour has.
    fn decide(&mut self, found: usize) -> Result<usize, String> {
        let Variant { texcoords, colours, normals } = self.variant;
        let without = if normals { 3 } else { 0 } + if texcoords { 2 } else { 0 };
        self.colours.width = match found.checked_sub(without) {
            Some(0) if !colours => 0,
            Some(width @ (3 | 4)) if colours || without == 0 => width,
            _ => {
                let colour = if colours { " and 3 or 4 of the colour" } else { "" };
                return Err(format!("expected {} numbers{colour}, found {}", 3 + without, 3 + found));
            }
        };
        self.width = Some(found);
        Ok(found)
    }

    fn finish(self, attributes: &mut Vec<Attribute>) {
        for (kind, name, width, (mut values, digits)) in
            [(AttributeKind::Normal, "nx ny nz", 3, self.normals), (AttributeKind::TexCoord, "s t", 2, self.texcoords)]
        {
            if !values.is_empty() {
                let scalar = digits.settle(&mut values);
                let name = name.to_owned();
                attributes.push(Attribute { kind, name, domain: Domain::Vertex, width, scalar, values, indices: Vec::new() });
            }
        }
        if self.colours.width > 0 {
            attributes.push(self.colours.finish(Domain::Vertex, Vec::new()));
        }
    }
}

fn read_faces(text: &mut Text<'_>, faces: usize, mesh: &mut Mesh, notes: &mut Vec<String>) -> Result<()> {
    let vertices = mesh.positions.len();
    let mut corners = Vec::new();
    let mut colours = Colours::default();
    let mut indices = Vec::new();
    let mut odd_colours = 0;
    for face in 0..faces {
        if !text.find_word() {
            return Err(text.error(format!("{faces} faces are announced, and the file ends after {face}")));
        }
        let announced = read_index(text)?.unwrap_or_default();
        corners.clear();
        while (corners.len() as u64) < announced {
            let Some(vertex) = read_index(text)? else {
                return Err(text.error(format!("expected {announced} corners, found {}", corners.len())));
            };
            if vertex >= vertices as u64 {
                return Err(text.error(format!("the face names vertex {vertex}, and there are {vertices} (counted from 0)")));
            }
            corners.push(vertex as u32);
        }
        push_face(&mut mesh.faces, &corners)?;
        let mut colour = [Number::ZERO; 4];
        let found = text.numbers(&mut colour)?;
        if found == 0 {
            continue;
        }
        if colours.values.is_empty() && matches!(found, 3 | 4) {
            colours.width = found;
        }
        if found == colours.width {
            indices.resize(face, Attribute::NONE);
            indices.push((colours.values.len() / found) as u32);
            colours.push(&colour[..found]);
        } else {
            odd_colours += 1;
        }
    }
    if odd_colours > 0 {
        notes.push(format!("the colours of {} are not of one kind with the others and left out", count(odd_colours, "face")));
    }
    if colours.width > 0 {
        indices.resize(faces, Attribute::NONE);
        if colours.values.len() == colours.width * faces {
            indices.clear();
        }
        mesh.attributes.push(colours.finish(Domain::Face, indices));
    }
    Ok(())
}

fn read_index(text: &mut Text<'_>) -> Result<Option<u64>> {
    let Some(word) = text.word() else { return Ok(None) };
    let digits = word.iter().try_fold(0_u64, |n, b| {
        let digit = b.wrapping_sub(b'0');
        if digit < 10 { n.checked_mul(10)?.checked_add(digit.into()) } else { None }
    });
    match digits {
        Some(index) => Ok(Some(index)),
        None => Err(text.error(format!("expected an index, found {}", show(word)))),
    }
}

/// Writes a whole file.
pub(super) fn write<'a>(mesh: &'a Mesh, out: &mut Sink<'_>, notes: &mut Vec<String>) -> Result<()> {
    let whole = |a: &Attribute| a.domain == Domain::Vertex && (0..mesh.positions.len()).all(|v| a.get(v).is_some());
    let normals = find(mesh, AttributeKind::Normal, |a| whole(a) && a.width == 3);
    let texcoords = find(mesh, AttributeKind::TexCoord, |a| whole(a) && a.width == 2);
    let colours = find(mesh, AttributeKind::Colour, |a| whole(a) && matches!(a.width, 3 | 4));
    let face_colours = find(mesh, AttributeKind::Colour, |a| a.domain == Domain::Face && matches!(a.width, 3 | 4));
    let kept = [normals, colours, texcoords, face_colours];
    note_losses(mesh, "OFF", notes, |i| kept.iter().flatten().any(|&(k, _)| k == i));
    note_rounding("the positions", mesh.positions.as_flattened(), mesh.precision, notes);
    if !mesh.labels.is_empty() {
        notes.push(format!("OFF files do not hold names: {} left out", count(mesh.labels.len(), "label")));
    }

    for (is_there, letters) in [(texcoords.is_some(), "ST"), (colours.is_some(), "C"), (normals.is_some(), "N")] {
        if is_there {
            out.text(letters);
        }
    }
    out.text(&format!("OFF\n{} {} 0\n", mesh.positions.len(), mesh.faces.len()));
    let coordinates = mesh.positions.as_flattened();
    let print = Print::new(coordinates, mesh.precision);
    let with_print = |(_, a): (usize, &'a Attribute)| (a, Print::new(&a.values, a.scalar));
    let on_vertices = [normals, colours, texcoords].map(|attribute| attribute.map(with_print));
    for vertex in 0..mesh.positions.len() {
        for axis in 0..3 {
            out.text(if axis == 0 { "" } else { " " });
            out.value(coordinates, 3 * vertex + axis, print);
        }
        for (attribute, print) in on_vertices.iter().flatten() {
            numbers(out, attribute, vertex, *print);
        }
        out.text("\n");
        out.rest()?;
    }
    let on_faces = face_colours.map(with_print);
    for (f, face) in mesh.faces.iter().enumerate() {
        out.integer(face.len() as u64);
        for &vertex in face {
            out.text(" ");
            out.integer(vertex.into());
        }
        if let Some((attribute, print)) = on_faces {
            numbers(out, attribute, f, print);
        }
        out.text("\n");
        out.rest()?;
    }
    Ok(())
}

/// The numbers of an attribute; colours as integers up to 255 or as floats that show a point.
fn numbers(out: &mut Sink<'_>, attribute: &Attribute, element: usize, print: Print) {
    let index = match attribute.indices.get(element) {
        Some(&Attribute::NONE) => return,
        Some(&index) => index as usize,
        None => element,
    };
    for i in index * attribute.width..(index + 1) * attribute.width {
        let x = attribute.values[i];
        out.text(" ");
        if attribute.kind == AttributeKind::Colour && !matches!(attribute.scalar, Scalar::U8 | Scalar::F32 | Scalar::F64) {
            out.number(x / attribute.scalar.range()[1], Scalar::F32);
            continue;
        }
        out.value(&attribute.values, i, print);
        if attribute.kind == AttributeKind::Colour && attribute.scalar.is_float() && x.fract() == 0.0 && x.abs() < 1e9 {
            out.text(".0");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::io::Format;

    fn read(text: &str) -> Result<crate::Loaded> {
        Mesh::read(text.as_bytes(), Some(Format::Off))
    }

    fn fails(text: &str) -> String {
        read(text).unwrap_err().to_string()
    }

    #[test]
    fn counts_may_stand_on_the_first_line_or_the_next_and_comments_anywhere() {
        let same = [
            "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
            "# made by hand\n\nOFF # it is\r\n3 1\r\n\r\n0 0 0#first\r\n1 0 0\r\n#none\r\n0 1 0\r\n3 0 1 2",
            "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2",
            "OFF\n3\n1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2",
        ];
        for text in same {
            assert_eq!(read(text).unwrap().mesh, read(same[0]).unwrap().mesh, "{text}");
        }
        assert_eq!(read(same[0]).unwrap().mesh.faces.get(0), [0, 1, 2]);
    }

    #[test]
    fn every_variant_has_its_numbers_in_their_order() {
        let text = "STCNOFF\n2 0 0\n0 0 0 0 0 1 255 0 10 0.5 0.25\n1 0 0 0 1 0 1 2 3 1 0\n";
        let mesh = read(text).unwrap().mesh;
        let found = mesh.attributes.iter().map(|a| (a.kind, a.scalar, a.values.as_slice())).collect::<Vec<_>>();
        assert_eq!(
            found,
            [
                (AttributeKind::Normal, Scalar::F32, &[0.0, 0.0, 1.0, 0.0, 1.0, 0.0][..]),
                (AttributeKind::TexCoord, Scalar::F32, &[0.5, 0.25, 1.0, 0.0]),
                (AttributeKind::Colour, Scalar::U8, &[255.0, 0.0, 10.0, 1.0, 2.0, 3.0]),
            ]
        );
        let mut out = Vec::new();
        assert_eq!(mesh.write(Format::Off, &mut out).unwrap(), [] as [&str; 0]);
        assert_eq!(String::from_utf8(out).unwrap(), text);
    }

    #[test]
    fn colours_are_integers_or_floats_on_vertices_and_on_some_faces() {
        let text = "OFF\n3 3 0\n0 0 0 1.0 0.5 0.0 1.0\n1 0 0 1.0 0.5 0.0 1.0\n0 1 0 1.0 0.5 0.0 1.0\n3 0 1 2 255 0 0\n3 0 1 2\n2 0 1 0 0 255\n";
        let mesh = read(text).unwrap().mesh;
        assert_eq!((mesh.attributes[0].width, mesh.attributes[0].scalar), (4, Scalar::F32));
        let on_faces = &mesh.attributes[1];
        assert_eq!(
            (on_faces.domain, on_faces.scalar, on_faces.indices.as_slice()),
            (Domain::Face, Scalar::U8, &[0, Attribute::NONE, 1][..])
        );
        let mut out = Vec::new();
        mesh.write(Format::Off, &mut out).unwrap();
        assert_eq!(String::from_utf8(out).unwrap(), text.replacen("OFF", "COFF", 1));
        let odd = read("OFF\n1 3 0\n0 0 0\n1 0 7\n1 0 1 2 3\n1 0 1 2 3 4\nmore").unwrap();
        assert_eq!(
            odd.notes,
            [
                "the colours of 2 faces are not of one kind with the others and left out",
                "what follows the last face, from line 7 on, is not kept",
            ]
        );
    }

    #[test]
    fn errors_name_the_line() {
        assert_eq!(fails(""), "expected OFF, found nothing");
        assert_eq!(fails("OBJ\n"), "line 1: expected OFF, found \"OBJ\"");
        assert_eq!(fails("4OFF\n1 0 0\n"), "OFF variant 4OFF is not supported by this version");
        assert_eq!(fails("OFF BINARY\n"), "OFF variant BINARY is not supported by this version");
        assert_eq!(fails("OFF\n1"), "line 2: expected the number of faces, found the end of the file");
        assert_eq!(fails("OFF\n-1 0 0"), "line 2: expected the number of vertices, found \"-1\"");
        assert_eq!(
            fails("OFF\n99999999 1 0\n0 0 0"),
            "line 2: 99999999 vertices and 1 faces are announced, and 6 bytes follow"
        );
        assert_eq!(fails("OFF\n2 0 0\n0 0 0 # pad\n"), "line 4: 2 vertices are announced, and the file ends after 1");
        assert_eq!(fails("OFF\n1 1 0\n0 0\n3 0 0 0"), "line 3: expected 3 coordinates, found 2");
        assert_eq!(fails("OFF\n2 0 0\n0 0 0\n0 0 0 1 1 1"), "line 4: expected 3 numbers as on the first vertex, found 6");
        assert_eq!(fails("COFF\n1 0 0\n0 0 0 1 1"), "line 3: expected 3 numbers and 3 or 4 of the colour, found 5");
        assert_eq!(fails("OFF\n1 1 0\n0 0 0\n3 0 0"), "line 4: expected 3 corners, found 2");
        assert_eq!(fails("OFF\n1 1 0\n0 0 0\n3 0 0 1"), "line 4: the face names vertex 1, and there are 1 (counted from 0)");
        assert_eq!(fails("OFF\n1 1 0\n0 0 0\nthree"), "line 4: expected an index, found \"three\"");
    }
}
