//! PLY in: tables to a mesh.

use byteorder::{BE, LE};

use super::cells::{Binary, Cells, Lines};
use super::header::{Element, Encoding, Header};
use super::meaning::{self, vertex_list};
use crate::error::{Error, Place, Result};
use crate::mesh::io::text::Text;
use crate::mesh::io::{count, push_face};
use crate::mesh::{Faces, Mesh};

/// Reads a whole file.
pub(crate) fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<Mesh> {
    let header = Header::read(bytes)?;
    if let Some(texture) = &header.texture {
        notes.push(format!("the comment that names the texture file `{texture}` is not kept"));
    }
    match header.encoding {
        Encoding::Text => {
            let text = Text::starting(bytes, header.body, header.body_line, header.end_of_line);
            read_tables(&header, &mut Lines::new(text), notes)
        }
        Encoding::Little => read_tables(&header, &mut Binary::<LE>::new(bytes, header.body), notes),
        Encoding::Big => read_tables(&header, &mut Binary::<BE>::new(bytes, header.body), notes),
    }
}

fn read_tables<C: Cells>(header: &Header, cells: &mut C, notes: &mut Vec<String>) -> Result<Mesh> {
    let mut mesh = Mesh::default();
    let mut vertices = None;
    let [mut faces, mut strips] = [None, None];
    for element in &header.elements {
        let least = element.least_bytes(header.encoding);
        // The last line of a text may lack its end.
        if element.records.saturating_mul(least) > cells.left() + 1 {
            let why =
                format!("{} records of `{}` are announced, and {} bytes follow", element.records, element.name, cells.left());
            return Err(Error::malformed(Place::Line(element.line), why));
        }
        match element.name.as_str() {
            "vertex" if vertices.is_none() => {
                let columns = element.properties.iter().map(|p| Column::new(p.counted_by.is_none()));
                let columns = read_table(element, columns.collect(), cells, None)?;
                meaning::vertices(element, columns, &mut mesh, notes)?;
                vertices = Some(element.records);
            }
            "face" if faces.is_none() => {
                let list = vertex_list(element);
                let columns = (0..element.properties.len())
                    .map(|i| if list == Some(i) { Column::Faces(Faces::default()) } else { Column::new(list.is_some()) });
                faces = Some((element, read_table(element, columns.collect(), cells, vertices)?));
            }
            "tristrips" if strips.is_none() => {
                let list = vertex_list(element);
                let columns = (0..element.properties.len()).map(|i| Column::new(list == Some(i)));
                strips = Some((element, read_table(element, columns.collect(), cells, vertices)?));
            }
            other => {
                let columns = element.properties.iter().map(|_| Column::Skipped).collect();
                read_table(element, columns, cells, vertices)?;
                notes.push(format!("element `{other}` is not kept ({})", count(element.records as usize, "record")));
            }
        }
    }
    if vertices.is_none() {
        return Err(Error::malformed(Place::Whole, "expected an element `vertex`, and the header has none"));
    }
    match (faces, strips) {
        (Some((element, columns)), strips) => {
            meaning::faces(element, columns, &mut mesh, notes)?;
            if strips.is_some() {
                notes.push("element `tristrips` is not kept beside `face`".to_owned());
            }
        }
        (None, Some((element, columns))) => meaning::strips(element, columns, &mut mesh, notes)?,
        (None, None) => {}
    }
    Ok(mesh)
}

/// What a property has in all records.
#[derive(Debug)]
pub(super) enum Column {
    /// Nothing that is wanted.
    Skipped,
    /// One number a record, or a list a record: set by the first that is read.
    Values(Values),
    /// The vertices of faces.
    Faces(Faces),
}

/// Numbers, one for each record; or lists, one after the other.
#[derive(Debug, Default)]
pub(super) struct Values {
    pub(super) numbers: Vec<f64>,
    /// For lists, where each one ends.
    pub(super) ends: Vec<usize>,
}

impl Column {
    fn new(is_wanted: bool) -> Self {
        if is_wanted { Self::Values(Values::default()) } else { Self::Skipped }
    }
}

/// Reads the records of a table; faces must name one of the `vertices`, if their number is known.
fn read_table<C: Cells>(
    element: &Element,
    mut columns: Vec<Column>,
    cells: &mut C,
    vertices: Option<u64>,
) -> Result<Vec<Column>> {
    // Records without properties take no bytes, and may be announced in any number.
    let records = if element.properties.is_empty() { 0 } else { element.records };
    let mut corners = Vec::new();
    for record in 0..records {
        if !cells.begin() {
            let why = format!("{records} records of `{}` are announced, and the file ends after {record}", element.name);
            return Err(cells.error(why));
        }
        for (property, column) in element.properties.iter().zip(&mut columns) {
            let of = property.of;
            let Some(count_type) = property.counted_by else {
                match column {
                    Column::Values(values) => values.numbers.push(cells.real(of)?),
                    _ => cells.skip(of, 1)?,
                }
                continue;
            };
            let length = cells.integer(count_type)?;
            let length = u64::try_from(length)
                .ok()
                .filter(|&length| length <= cells.left())
                .ok_or_else(|| cells.error(format!("a list of {length} values, and {} bytes follow", cells.left())))?;
            match column {
                Column::Skipped => cells.skip(of, length)?,
                Column::Values(values) => {
                    for _ in 0..length {
                        values.numbers.push(cells.real(of)?);
                    }
                    values.ends.push(values.numbers.len());
                }
                Column::Faces(faces) => {
                    corners.clear();
                    for _ in 0..length {
                        let vertex = cells.integer(of)?;
                        let index = u32::try_from(vertex).ok().filter(|&v| u64::from(v) < vertices.unwrap_or(u32::MAX.into()));
                        corners.push(index.ok_or_else(|| cells.error(bad_vertex(faces.len(), vertex, vertices)))?);
                    }
                    push_face(faces, &corners)?;
                }
            }
        }
        cells.end()?;
    }
    Ok(columns)
}

#[cold]
fn bad_vertex(face: usize, vertex: i64, vertices: Option<u64>) -> String {
    let there_are = vertices.map_or(String::new(), |n| format!(", and there are {n}"));
    format!("face {face} names vertex {vertex}{there_are} (counted from 0)")
}
