//! OBJ out: vertices, values, then faces with the labels between them.

use std::ops::Range;

use crate::error::Result;
use crate::mesh::io::sink::Print;
use crate::mesh::io::{Sink, find, note_losses, note_rounding};
use crate::mesh::{Attribute, AttributeKind, Domain, LabelKind, Mesh, Scalar};

/// Writes a whole file.
pub(crate) fn write(mesh: &Mesh, out: &mut Sink<'_>, notes: &mut Vec<String>) -> Result<()> {
    let on_vertices = |a: &Attribute| a.domain == Domain::Vertex;
    let colours = find(mesh, AttributeKind::Colour, |a| on_vertices(a) && matches!(a.width, 3 | 4));
    let weights = find(mesh, AttributeKind::Other, |a| on_vertices(a) && a.width == 1 && a.name == "w" && colours.is_none());
    let on_corners = |a: &Attribute| a.domain != Domain::Face;
    let texcoords = find(mesh, AttributeKind::TexCoord, |a| on_corners(a) && matches!(a.width, 2 | 3));
    let normals = find(mesh, AttributeKind::Normal, |a| on_corners(a) && a.width == 3);
    let kept = [colours, weights, texcoords, normals];
    note_losses(mesh, "OBJ", notes, |i| kept.iter().flatten().any(|&(k, _)| k == i));
    note_rounding("the positions", mesh.positions.as_flattened(), mesh.precision, notes);

    let mut labels = mesh.labels.iter().enumerate().collect::<Vec<_>>();
    labels.sort_by_key(|&(i, label)| (label.first_face, i));
    let mut labels = labels.into_iter().map(|(_, label)| label).peekable();
    // References to materials come first, where every reader looks for them.
    while let Some(library) = labels.next_if(|l| l.kind == LabelKind::MaterialLibrary && l.first_face == 0) {
        label(out, library.kind, &library.name)?;
    }

    let extra = colours.or(weights).map(|(_, attribute)| attribute);
    let extra = extra.map(|attribute| (attribute, Print::new(&attribute.values, attribute.scalar)));
    let coordinates = mesh.positions.as_flattened();
    let print = Print::new(coordinates, mesh.precision);
    for vertex in 0..mesh.positions.len() {
        out.text("v");
        numbers(out, coordinates, 3 * vertex..3 * vertex + 3, print);
        if let Some((attribute, print)) = extra
            && let Some(index) = index(attribute, vertex)
        {
            let value = index as usize * attribute.width..(index as usize + 1) * attribute.width;
            if attribute.kind == AttributeKind::Colour && !attribute.scalar.is_float() {
                // OBJ's colours run from 0 to 1.
                for x in &attribute.values[value] {
                    out.text(" ");
                    out.number(x / attribute.scalar.range()[1], Scalar::F32);
                }
            } else {
                numbers(out, &attribute.values, value, print);
            }
        }
        out.text("\n");
        out.rest()?;
    }
    for (keyword, attribute) in [("vt", texcoords), ("vn", normals)] {
        let Some((_, attribute)) = attribute else { continue };
        let print = Print::new(&attribute.values, attribute.scalar);
        for i in 0..attribute.len() {
            out.text(keyword);
            numbers(out, &attribute.values, i * attribute.width..(i + 1) * attribute.width, print);
            out.text("\n");
            out.rest()?;
        }
    }

    let mut corner = 0;
    for (f, face) in mesh.faces.iter().enumerate() {
        while let Some(next) = labels.next_if(|l| l.first_face as usize <= f) {
            label(out, next.kind, &next.name)?;
        }
        out.text("f");
        for &vertex in face {
            out.text(" ");
            out.integer(u64::from(vertex) + 1);
            let [vt, vn] = [texcoords, normals].map(|attribute| {
                let (_, a) = attribute?;
                index(a, if a.domain == Domain::Vertex { vertex as usize } else { corner })
            });
            if vt.is_some() || vn.is_some() {
                out.text("/");
            }
            if let Some(vt) = vt {
                out.integer(u64::from(vt) + 1);
            }
            if let Some(vn) = vn {
                out.text("/");
                out.integer(u64::from(vn) + 1);
            }
            corner += 1;
        }
        out.text("\n");
        out.rest()?;
    }
    labels.try_for_each(|last| label(out, last.kind, &last.name))
}

fn numbers(out: &mut Sink<'_>, values: &[f64], range: Range<usize>, print: Print) {
    for i in range {
        out.text(" ");
        out.value(values, i, print);
    }
}

/// The place of a vertex' or corner's value in the list of values.
fn index(attribute: &Attribute, element: usize) -> Option<u32> {
    match attribute.indices.get(element) {
        Some(&index) => (index != Attribute::NONE).then_some(index),
        None => Some(element as u32),
    }
}

fn label(out: &mut Sink<'_>, kind: LabelKind, name: &str) -> Result<()> {
    out.text(match kind {
        LabelKind::Object => "o",
        LabelKind::Group => "g",
        LabelKind::Material => "usemtl",
        LabelKind::Smoothing => "s",
        LabelKind::MaterialLibrary => "mtllib",
    });
    if !name.is_empty() {
        out.text(" ");
        // A name cannot end its line.
        out.text(&name.replace(['\n', '\r'], " "));
    }
    out.text("\n");
    out.rest()
}
