//! What tables mean: columns by name to positions, faces and attributes.

use std::collections::HashMap;

use super::header::{Element, Type};
use super::read::{Column, Values};
use crate::error::{Error, MeshDefect, Place, Result};
use crate::mesh::io::{count, push_face};
use crate::mesh::{Attribute, AttributeKind, Domain, Faces, Mesh, Scalar};

/// Names that belong together. Those after the bar may be missing.
const GROUPS: [(AttributeKind, &[&str], &[&str]); 8] = [
    (AttributeKind::Normal, &["nx", "ny", "nz"], &[]),
    (AttributeKind::Colour, &["red", "green", "blue"], &["alpha"]),
    (AttributeKind::Colour, &["r", "g", "b"], &["a"]),
    (AttributeKind::Colour, &["diffuse_red", "diffuse_green", "diffuse_blue"], &["diffuse_alpha"]),
    (AttributeKind::TexCoord, &["s", "t"], &["p"]),
    (AttributeKind::TexCoord, &["u", "v"], &["w"]),
    (AttributeKind::TexCoord, &["texture_u", "texture_v"], &["texture_w"]),
    (AttributeKind::TexCoord, &["texture_s", "texture_t"], &[]),
];

/// The components that a writer gives an attribute, and how many.
pub(super) fn usual_names(kind: AttributeKind, width: usize) -> Option<Vec<String>> {
    let (_, names, more) =
        GROUPS.iter().find(|(k, names, more)| *k == kind && (names.len()..=names.len() + more.len()).contains(&width))?;
    Some(names.iter().chain(*more).take(width).map(|&name| name.to_owned()).collect())
}

/// What a list of a face holds for each corner, by its name.
const CORNER_LISTS: [(AttributeKind, &str, [usize; 2]); 3] = [
    (AttributeKind::TexCoord, "texcoord", [2, 3]),
    (AttributeKind::Colour, "color", [3, 4]),
    (AttributeKind::Normal, "normal", [3, 3]),
];

/// The name of a list of such values on corners.
pub(super) fn usual_list(kind: AttributeKind) -> Option<&'static str> {
    CORNER_LISTS.iter().find(|(k, ..)| *k == kind).map(|&(_, name, _)| name)
}

/// The list of a face's vertices: the one of that name, or else the first.
pub(super) fn vertex_list(element: &Element) -> Option<usize> {
    let is_list = |i: &usize| element.properties[*i].counted_by.is_some();
    let all = 0..element.properties.len();
    all.clone()
        .filter(is_list)
        .find(|&i| matches!(element.properties[i].name.as_str(), "vertex_indices" | "vertex_index"))
        .or_else(|| all.clone().find(is_list))
}

/// A column of numbers with its name.
struct Named {
    name: String,
    of: Type,
    numbers: Vec<f64>,
}

/// Positions and attributes of vertices.
pub(super) fn vertices(element: &Element, columns: Vec<Column>, mesh: &mut Mesh, notes: &mut Vec<String>) -> Result<()> {
    let mut named = named(element, columns, notes);
    let axes = ["x", "y", "z"].map(|axis| match named.iter().position(|column| column.name == axis) {
        Some(column) => Ok(named.remove(column)),
        None => Err(Error::malformed(Place::Line(element.line), format!("element `vertex` has no property `{axis}`"))),
    });
    let [x, y, z] = axes;
    let [x, y, z] = [x?, y?, z?];
    mesh.precision = common([&x, &y, &z]);
    mesh.positions = x.numbers.iter().zip(&y.numbers).zip(&z.numbers).map(|((&x, &y), &z)| [x, y, z]).collect();
    if mesh.positions.len() >= u32::MAX as usize {
        return Err(Error::Unsupported { what: "a mesh of", id: format!("{} vertices", mesh.positions.len()) });
    }
    mesh.attributes.extend(attributes(named, Domain::Vertex));
    Ok(())
}

/// The columns that are numbers; lists are noted.
fn named(element: &Element, columns: Vec<Column>, notes: &mut Vec<String>) -> Vec<Named> {
    let mut named = Vec::new();
    for (property, column) in element.properties.iter().zip(columns) {
        match column {
            Column::Values(Values { numbers, .. }) if property.counted_by.is_none() => {
                if matches!(property.of, Type::Long { .. }) && numbers.iter().any(|x| x.abs() >= 9e15) {
                    notes.push(format!("64-bit integers `{}` are rounded to f64", property.name));
                }
                named.push(Named { name: property.name.clone(), of: property.of, numbers });
            }
            Column::Skipped if element.name == "vertex" => {
                notes.push(format!("list `{}` of the vertices is not kept", property.name));
            }
            _ => {}
        }
    }
    named
}

/// The type that holds several columns.
fn common<const N: usize>(columns: [&Named; N]) -> Scalar {
    let scalar = columns[0].of.scalar();
    if columns.iter().all(|column| column.of.scalar() == scalar) { scalar } else { Scalar::F64 }
}

/// Columns as attributes, in order of the first of each group.
fn attributes(mut columns: Vec<Named>, domain: Domain) -> Vec<Attribute> {
    let mut places = HashMap::with_capacity(columns.len());
    for (place, column) in columns.iter().enumerate() {
        places.entry(column.name.clone()).or_insert(place);
    }
    // No name is in two groups.
    let mut groups = vec![None; columns.len()];
    for (kind, names, more) in GROUPS {
        let Some(mut members) = names.iter().map(|&name| places.get(name).copied()).collect::<Option<Vec<_>>>() else {
            continue;
        };
        members.extend(more.iter().map_while(|&name| places.get(name).copied()));
        let first = members.iter().copied().min().unwrap_or_default();
        for &member in &members {
            groups[member] = Some((kind, Vec::new()));
        }
        groups[first] = Some((kind, members));
    }

    let mut attributes = Vec::new();
    for (place, group) in groups.into_iter().enumerate() {
        let (kind, members) = group.unwrap_or((AttributeKind::Other, vec![place]));
        let scalars = members.iter().map(|&m| columns[m].of.scalar());
        let Some(scalar) = scalars.reduce(|a, b| if a == b { a } else { Scalar::F64 }) else { continue };
        let name = members.iter().map(|&m| columns[m].name.as_str()).collect::<Vec<_>>().join(" ");
        let values = match members.as_slice() {
            &[only] => std::mem::take(&mut columns[only].numbers),
            _ => {
                let rows = columns[place].numbers.len();
                let columns = &columns;
                (0..rows).flat_map(|row| members.iter().map(move |&m| columns[m].numbers[row])).collect()
            }
        };
        attributes.push(Attribute { kind, name, domain, width: members.len(), scalar, values, indices: Vec::new() });
    }
    attributes
}

/// Faces, their attributes, and those of their corners.
pub(super) fn faces(element: &Element, columns: Vec<Column>, mesh: &mut Mesh, notes: &mut Vec<String>) -> Result<()> {
    let mut corner_lists = Vec::new();
    let mut rest = Vec::new();
    let mut has_faces = false;
    for (property, column) in element.properties.iter().zip(columns) {
        rest.push(match column {
            Column::Faces(faces) => {
                mesh.faces = faces;
                has_faces = true;
                Column::Skipped
            }
            Column::Values(values) if property.counted_by.is_some() => {
                corner_lists.push((property, values));
                Column::Skipped
            }
            other => other,
        });
    }
    if !has_faces {
        if element.records > 0 {
            notes.push(format!("the {} records of `face` have no list of vertices and are not kept", element.records));
        }
        return Ok(());
    }
    check_range(mesh)?;
    mesh.attributes.extend(attributes(named(element, rest, notes), Domain::Face));
    for (property, values) in corner_lists {
        match corner_attribute(&property.name, property.of.scalar(), values, &mesh.faces) {
            Some(attribute) => mesh.attributes.push(attribute),
            None => {
                notes.push(format!("list `{}` of the faces has not one value for each corner and is not kept", property.name))
            }
        }
    }
    Ok(())
}

/// Only for faces that came before the vertices; the others were checked as they were read.
fn check_range(mesh: &Mesh) -> Result<()> {
    let vertices = mesh.positions.len() as u64;
    for (face, corners) in mesh.faces.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&v| u64::from(v) >= vertices) {
            return Err(MeshDefect::IndexOutOfRange { face: face as u32, index: index.into(), vertices }.into());
        }
    }
    Ok(())
}

/// Lists with the same number of values for each corner; empty ones for corners that have none.
fn corner_attribute(name: &str, scalar: Scalar, list: Values, faces: &Faces) -> Option<Attribute> {
    let mut width = 0;
    let mut indices = Vec::with_capacity(faces.corners().len());
    let mut start = 0;
    let mut values = 0;
    for (face, &end) in faces.iter().zip(&list.ends) {
        let length = end - start;
        start = end;
        if length == 0 {
            indices.extend(face.iter().map(|_| Attribute::NONE));
            continue;
        }
        if face.is_empty() || length % face.len() != 0 || (width != 0 && length != width * face.len()) {
            return None;
        }
        width = length / face.len();
        indices.extend((values..).take(face.len()));
        values += face.len() as u32;
    }
    if width == 0 {
        return None;
    }
    if values as usize == faces.corners().len() {
        indices = Vec::new();
    }
    let kind = CORNER_LISTS.iter().find(|(_, known, widths)| *known == name && widths.contains(&width));
    let kind = kind.map_or(AttributeKind::Other, |&(kind, ..)| kind);
    Some(Attribute { kind, name: name.to_owned(), domain: Domain::Corner, width, scalar, values: list.numbers, indices })
}

/// Triangle strips, cut at negative numbers. Triangles that name a vertex twice only turn the strip.
pub(super) fn strips(element: &Element, columns: Vec<Column>, mesh: &mut Mesh, notes: &mut Vec<String>) -> Result<()> {
    let list = vertex_list(element).and_then(|i| columns.into_iter().nth(i));
    let Some(Column::Values(values)) = list else { return Ok(()) };
    let mut start = 0;
    for &end in &values.ends {
        for strip in values.numbers[start..end].split(|&v| v < 0.0) {
            for (i, corners) in strip.windows(3).enumerate() {
                let [a, b, c] = [corners[0], corners[1], corners[2]].map(|v| v as u32);
                if a != b && b != c && c != a {
                    push_face(&mut mesh.faces, &if i % 2 == 0 { [a, b, c] } else { [b, a, c] })?;
                }
            }
        }
        start = end;
    }
    notes.push(format!("{} unrolled to triangles", count(values.ends.len(), "triangle strip")));
    check_range(mesh)
}
