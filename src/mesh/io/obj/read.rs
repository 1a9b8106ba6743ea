//! OBJ in: statements to a mesh.

use std::collections::BTreeMap;

use super::table::{Forward, Table};
use crate::error::{Error, Place, Result};
use crate::mesh::io::number::{Digits, Number};
use crate::mesh::io::text::{self, Syntax, Text, show};
use crate::mesh::io::{count, push_face};
use crate::mesh::{AttributeKind, Domain, Label, LabelKind, Mesh};

/// Kinds of statements that are not kept are told apart up to this number.
const MOST_UNKEPT: usize = 20;

/// Reads a whole file.
pub(crate) fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<Mesh> {
    let mut reader = Reader { text: Text::new(bytes, Syntax::Obj), ..Reader::default() };
    loop {
        if let Some(keyword) = reader.text.word() {
            reader.statement(keyword)?;
        }
        if !reader.text.next_line() {
            return reader.finish(notes);
        }
    }
}

#[derive(Default)]
struct Reader<'a> {
    text: Text<'a>,
    mesh: Mesh,
    digits: Digits,
    weights: Table,
    colours: Table,
    texcoords: Table,
    normals: Table,
    vertices_ahead: Forward,
    texcoords_ahead: Forward,
    normals_ahead: Forward,
    /// `vt` and `vn` indices that mean nothing: how many, and the first.
    bad_references: Option<(usize, String)>,
    /// Statements that are not kept: how many, and the first line.
    unkept: BTreeMap<&'a [u8], (usize, u64)>,
    unkept_kinds_too_many: bool,
    renamed: bool,
    corners: Vec<u32>,
}

impl<'a> Reader<'a> {
    fn statement(&mut self, keyword: &'a [u8]) -> Result<()> {
        match keyword {
            b"v" => self.vertex(),
            b"f" | b"fo" => self.face(),
            b"vt" => {
                let mut value = [Number::ZERO; 3];
                match self.text.numbers(&mut value)? {
                    0 => return Err(self.text.error("expected 2 texture coordinates, found 0")),
                    n @ 1..=3 => self.texcoords.push(&value[..n.max(2)], 0.0),
                    n => return Err(self.text.error(format!("expected 2 or 3 texture coordinates, found {n}"))),
                }
                Ok(())
            }
            b"vn" => {
                let mut value = [Number::ZERO; 3];
                match self.text.numbers(&mut value)? {
                    3 => self.normals.push(&value, 0.0),
                    n => return Err(self.text.error(format!("expected 3 components of a normal, found {n}"))),
                }
                Ok(())
            }
            b"o" => self.label(LabelKind::Object),
            b"g" => self.label(LabelKind::Group),
            b"usemtl" => self.label(LabelKind::Material),
            b"s" => self.label(LabelKind::Smoothing),
            b"mtllib" => self.label(LabelKind::MaterialLibrary),
            other => {
                let line = self.text.line();
                if let Some((times, _)) = self.unkept.get_mut(other) {
                    *times += 1;
                } else if self.unkept.len() < MOST_UNKEPT {
                    self.unkept.insert(other, (1, line));
                } else {
                    self.unkept_kinds_too_many = true;
                }
                Ok(())
            }
        }
    }

    fn vertex(&mut self) -> Result<()> {
        let mut numbers = [Number::ZERO; 7];
        let found = self.text.numbers(&mut numbers)?;
        let vertex = self.mesh.positions.len();
        let [x, y, z, rest @ ..] = &numbers;
        let table = match found {
            3 => None,
            4 => Some((&mut self.weights, &rest[..1])),
            6 => Some((&mut self.colours, &rest[..3])),
            7 => Some((&mut self.colours, &rest[..4])),
            0..3 => return Err(self.text.error(format!("expected 3 coordinates, found {found}"))),
            _ => return Err(self.text.error(format!("expected 3, 4, 6 or 7 numbers, found {found}"))),
        };
        for (axis, number) in [x, y, z].into_iter().enumerate() {
            self.digits.see(3 * vertex + axis, number);
        }
        if let Some((table, value)) = table {
            table.refer(vertex, table.len() as u32);
            table.push(value, 1.0);
        }
        self.mesh.positions.push([x.value, y.value, z.value]);
        if vertex >= u32::MAX as usize - 1 {
            return Err(Error::Unsupported { what: "a mesh of", id: format!("more than {vertex} vertices") });
        }
        Ok(())
    }

    fn face(&mut self) -> Result<()> {
        self.corners.clear();
        let line = self.text.line();
        let first = self.mesh.faces.corners().len();
        while let Some(word) = self.text.word() {
            let [v, vt, vn] = parse_corner(word).ok_or_else(|| {
                self.text.error(format!("expected a corner like 1, 1/1, 1//1 or 1/1/1, found {}", show(word)))
            })?;
            let v = v.unwrap_or_default();
            let index = self.vertices_ahead.resolve(v, self.mesh.positions.len(), line);
            let corner = first + self.corners.len();
            self.corners.push(index.map_err(|why| self.text.error(format!("vertex {why}")))?);
            for (reference, table, ahead, what) in [
                (vt, &mut self.texcoords, &mut self.texcoords_ahead, "vt"),
                (vn, &mut self.normals, &mut self.normals_ahead, "vn"),
            ] {
                let Some(reference) = reference else { continue };
                match ahead.resolve(reference, table.len(), line) {
                    Ok(index) => table.refer(corner, index),
                    Err(why) => {
                        let first = || (0, format!("line {line}: {what} {why}"));
                        self.bad_references.get_or_insert_with(first).0 += 1;
                    }
                }
            }
        }
        push_face(&mut self.mesh.faces, &self.corners)
    }

    fn label(&mut self, kind: LabelKind) -> Result<()> {
        let rest = self.text.rest();
        self.renamed |= std::str::from_utf8(rest).is_err();
        self.mesh.labels.push(Label { kind, name: text::name(rest), first_face: self.mesh.faces.len() as u32 });
        Ok(())
    }

    fn finish(mut self, notes: &mut Vec<String>) -> Result<Mesh> {
        let vertices = self.mesh.positions.len();
        self.vertices_ahead.check(vertices)?;
        if vertices == 0 {
            return Err(Error::malformed(Place::Whole, "expected OBJ statements, found no vertex (`v`)"));
        }
        self.mesh.precision = self.digits.settle(self.mesh.positions.as_flattened_mut());

        for (what, table, ahead) in
            [("vt", &mut self.texcoords, &self.texcoords_ahead), ("vn", &mut self.normals, &self.normals_ahead)]
        {
            if let Some((index, line)) = ahead.dangling(table.len()) {
                let why = format!("line {line}: {what} index {}, and there are {}", u64::from(index) + 1, table.len());
                let dangling = table.drop_dangling();
                self.bad_references.get_or_insert((0, why)).0 += dangling;
            }
        }
        if let Some((n, first)) = self.bad_references {
            notes.push(format!("{} to values that are not there, left out ({first})", count(n, "reference")));
        }
        for (keyword, (n, line)) in self.unkept {
            notes.push(format!("statement {} is not kept ({}, the first is line {line})", show(keyword), count(n, "line")));
        }
        if self.unkept_kinds_too_many {
            notes.push("further unknown statements are not kept".to_owned());
        }
        if self.renamed {
            notes.push("names that are not UTF-8 were changed".to_owned());
        }

        let corners = self.mesh.faces.corners();
        for (table, kind, name, domain) in [
            (self.weights, AttributeKind::Other, "w", Domain::Vertex),
            (self.colours, AttributeKind::Colour, "r g b", Domain::Vertex),
            (self.texcoords, AttributeKind::TexCoord, "vt", Domain::Corner),
            (self.normals, AttributeKind::Normal, "vn", Domain::Corner),
        ] {
            let values = table.len();
            let elements = if domain == Domain::Vertex { vertices } else { corners.len() };
            let Some(mut attribute) = table.finish(kind, name, domain, elements) else {
                if values > 0 {
                    notes.push(format!("no corner uses `{name}`: {} left out", count(values, "value")));
                }
                continue;
            };
            let index = |corner: usize| if attribute.indices.is_empty() { corner as u32 } else { attribute.indices[corner] };
            if domain == Domain::Corner && values == vertices && corners.iter().enumerate().all(|(c, &v)| index(c) == v) {
                attribute.domain = Domain::Vertex;
                attribute.indices = Vec::new();
            }
            self.mesh.attributes.push(attribute);
        }
        Ok(self.mesh)
    }
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`; parts after a slash may be empty.
fn parse_corner(word: &[u8]) -> Option<[Option<i64>; 3]> {
    let mut corner = [None; 3];
    let mut i = 0;
    for (part, slot) in corner.iter_mut().enumerate() {
        let start = i;
        let negative = word.get(i) == Some(&b'-');
        i += usize::from(matches!(word.get(i), Some(b'-' | b'+')));
        let digits = i;
        let mut n = 0_i64;
        while let Some(digit) = word.get(i).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
            n = n.saturating_mul(10).saturating_add(digit.into());
            i += 1;
        }
        if i > digits {
            *slot = Some(if negative { -n } else { n });
        } else if i > start || part == 0 {
            return None;
        }
        match word.get(i) {
            Some(b'/') if part < 2 => i += 1,
            Some(_) => return None,
            None => break,
        }
    }
    Some(corner)
}
