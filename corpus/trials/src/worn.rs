//! A mesh with every fault and every sort of attribute, and files in which what is beside the surface is noise.

use gimc::{
    Attribute, AttributeChoices, AttributeKind, Domain, Effort, EncodeOptions, Error, Label, LabelKind, Mesh, Precision, Scalar,
};

use crate::seal;

/// Chunks that do not hold the surface.
const BESIDE: [[u8; 4]; 5] = [*b"FIXS", *b"EXAC", *b"ATTR", *b"ORDR", *b"LABL"];

/// A small mesh with flipped, repeated, degenerate and loose faces, quads, copies of vertices, unused vertices; with values
/// on vertices, corners and faces, and names.
pub fn mesh() -> Mesh {
    let shape = corpus_make::sphere(60);
    let mut mesh = Mesh { positions: shape.positions, ..Mesh::default() };
    let extra = mesh.positions.len() as u32;
    mesh.positions.extend([[0.5, 0.25, 2.0], [0.1; 3], [0.7; 3], [-0.3; 3]]);
    for (i, &[a, b, c]) in shape.triangles.iter().enumerate() {
        match i % 16 {
            3 => mesh.faces.push(&[b, a, c]),
            5 => mesh.faces.push(&[a, b, extra]),
            7 => mesh.faces.push(&[a, a, c]),
            9 => [[a, b, c], [c, b, a], [b, c, a]].iter().for_each(|t| mesh.faces.push(t)),
            11 => mesh.faces.push(&[a, extra + 1, b, c]),
            _ => mesh.faces.push(&[a, b, c]),
        }
    }
    let kinds = [AttributeKind::Normal, AttributeKind::TexCoord, AttributeKind::Colour, AttributeKind::Other];
    for (i, kind) in kinds.into_iter().enumerate() {
        let domain = [Domain::Vertex, Domain::Corner, Domain::Face, Domain::Corner][i];
        let width = [3, 2, 4, 1][i];
        let number = |j: usize| f64::from(((j * 37 + i * 11) % 97) as f32 / 97.0 + 0.1);
        let count = mesh.count(domain);
        let index = |e: usize| if i % 2 == 1 && e % 13 == 5 { Attribute::NONE } else { (e * 7 / 3 % 20) as u32 };
        mesh.attributes.push(Attribute {
            kind,
            name: format!("a{i}"),
            domain,
            width,
            scalar: if kind == AttributeKind::Other { Scalar::F64 } else { Scalar::F32 },
            values: (0..20 * width).map(number).collect(),
            indices: (0..count).map(index).collect(),
        });
    }
    let label = |kind, name: &str, first_face| Label { kind, name: name.into(), first_face };
    mesh.labels = vec![
        label(LabelKind::Group, "first", 0),
        label(LabelKind::Material, "stone", 7),
        label(LabelKind::Group, "second", 30),
    ];
    mesh
}

/// Files of it: on a lattice and exact, in order and not.
pub fn files() -> Result<Vec<Vec<u8>>, Error> {
    let mesh = mesh();
    let mut exact = AttributeChoices::default();
    (exact.uv, exact.scalars) = (Some(Precision::Exact), Some(Precision::Exact));
    let options = EncodeOptions::cgim().bits(7).effort(Effort::Fast);
    [options.clone(), options.clone().attributes(exact).keep_order(true), options.exact().keep_order(true)]
        .iter()
        .map(|options| options.encode(&mesh))
        .collect()
}

/// Decodes a file of [`files`], of which a chunk beside the surface is noise from some byte on.
///
/// # Panics
/// If the decoder broke a promise.
pub fn decode(files: &[Vec<u8>], bytes: &[u8]) {
    let [file, chunk, from, noise @ ..] = bytes else { return };
    let broken = seal::changed(&files[usize::from(*file) % files.len()], |chunks| {
        let mut beside: Vec<_> = chunks.iter_mut().filter(|chunk| BESIDE.contains(&chunk.0)).collect();
        let count = beside.len();
        let payload = &mut beside[usize::from(*chunk) % count].1;
        payload.truncate(usize::from(*from));
        payload.extend(noise);
    });
    drop(crate::decode(&broken));
}
