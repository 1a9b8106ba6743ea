//! PLY out: binary, little-endian.

use super::header::Type;
use super::meaning::{usual_list, usual_names};
use crate::error::Result;
use crate::mesh::io::{Sink, count, note_rounding};
use crate::mesh::{Attribute, AttributeKind, Domain, Mesh, Scalar};

/// Writes a whole file.
pub(crate) fn write(mesh: &Mesh, out: &mut Sink<'_>, notes: &mut Vec<String>) -> Result<()> {
    note_rounding("the positions", mesh.positions.as_flattened(), mesh.precision, notes);
    if !mesh.labels.is_empty() {
        notes
            .push(format!("PLY files do not hold names of stretches of faces: {} left out", count(mesh.labels.len(), "label")));
    }
    let on = |domain: Domain| mesh.attributes.iter().filter(move |a| a.domain == domain).collect::<Vec<_>>();
    let [on_vertices, on_faces, on_corners] = [Domain::Vertex, Domain::Face, Domain::Corner].map(on);
    for attribute in on_vertices.iter().chain(&on_faces) {
        let missing = (0..mesh.count(attribute.domain)).filter(|&i| attribute.get(i).is_none()).count();
        if missing > 0 {
            notes.push(format!("`{}` has no value in {} places: written as 0", attribute.name, missing));
        }
    }

    let most_corners = mesh.faces.iter().map(<[u32]>::len).max().unwrap_or(0);
    let index = if mesh.positions.len() <= i32::MAX as usize { Scalar::I32 } else { Scalar::U32 };
    out.text(&format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", mesh.positions.len()));
    for axis in ["x", "y", "z"] {
        out.text(&format!("property {} {axis}\n", Type::name(mesh.precision)));
    }
    numbers_header(&on_vertices, out);
    out.text(&format!("element face {}\n", mesh.faces.len()));
    let length = length_type(most_corners);
    out.text(&format!("property list {} {} vertex_indices\n", Type::name(length), Type::name(index)));
    numbers_header(&on_faces, out);
    for attribute in &on_corners {
        let [length, of] = [length_type(attribute.width * most_corners), attribute.scalar].map(Type::name);
        out.text(&format!("property list {length} {of} {}\n", list_name(attribute)));
    }
    out.text("end_header\n");

    for (vertex, position) in mesh.positions.iter().enumerate() {
        for &x in position {
            out.binary(x, mesh.precision);
        }
        numbers(&on_vertices, vertex, out);
        out.rest()?;
    }
    let mut first = 0;
    for (f, face) in mesh.faces.iter().enumerate() {
        out.binary(face.len() as f64, length);
        for &vertex in face {
            out.bytes(&vertex.to_le_bytes());
        }
        numbers(&on_faces, f, out);
        let corners = first..first + face.len();
        for attribute in &on_corners {
            corner_list(attribute, corners.clone(), length_type(attribute.width * most_corners), out);
        }
        first = corners.end;
        out.rest()?;
    }
    for attribute in on_corners {
        let mut first = 0;
        let mixed = mesh.faces.iter().filter(|face| {
            let here = (first..first + face.len()).filter(|&c| attribute.get(c).is_none()).count();
            first += face.len();
            here > 0 && here < face.len()
        });
        let mixed = mixed.count();
        if mixed > 0 {
            notes.push(format!("`{}` has no value on some corners of {}: written as 0", attribute.name, count(mixed, "face")));
        }
    }
    Ok(())
}

/// The smallest type that counts up to `most`.
fn length_type(most: usize) -> Scalar {
    match most {
        0..=0xff => Scalar::U8,
        0x100..=0xffff => Scalar::U16,
        _ => Scalar::U32,
    }
}

/// The properties of attributes that have one value a record.
fn numbers_header(attributes: &[&Attribute], out: &mut Sink<'_>) {
    for attribute in attributes {
        for name in component_names(attribute) {
            out.text(&format!("property {} {name}\n", Type::name(attribute.scalar)));
        }
    }
}

/// The names it was read with, if they fit, or else the usual ones.
fn component_names(attribute: &Attribute) -> Vec<String> {
    let own = attribute.name.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    if own.len() == attribute.width && (attribute.width > 1 || attribute.kind == AttributeKind::Other) {
        return own;
    }
    usual_names(attribute.kind, attribute.width).unwrap_or_else(|| {
        let name = own.join("_");
        if attribute.width == 1 { vec![name] } else { (0..attribute.width).map(|i| format!("{name}_{i}")).collect() }
    })
}

fn list_name(attribute: &Attribute) -> String {
    let own = attribute.name.split_whitespace().collect::<Vec<_>>().join("_");
    usual_list(attribute.kind).map_or(own, str::to_owned)
}

fn numbers(attributes: &[&Attribute], element: usize, out: &mut Sink<'_>) {
    for attribute in attributes {
        match attribute.get(element) {
            Some(value) => value.iter().for_each(|&x| out.binary(x, attribute.scalar)),
            None => (0..attribute.width).for_each(|_| out.binary(0.0, attribute.scalar)),
        }
    }
}

/// An empty list if no corner of the face has a value.
fn corner_list(attribute: &Attribute, corners: std::ops::Range<usize>, length: Scalar, out: &mut Sink<'_>) {
    if corners.clone().all(|c| attribute.get(c).is_none()) {
        out.binary(0.0, length);
        return;
    }
    out.binary((corners.len() * attribute.width) as f64, length);
    for corner in corners {
        numbers(&[attribute], corner, out);
    }
}
