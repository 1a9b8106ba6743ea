//! The chunks of [`Parts`](super::Parts), as an encoder makes them.

use std::collections::HashMap;

use super::keep;
use super::source::Known;
use crate::error::{Error, Result};
use crate::format::{AttributeRecord, ChunkWriter, EXACT_TAG, FixesChunk, Header, LabelsChunk, ORDER_TAG};
use crate::mesh::{Front, HalfEdges, Mesh, NONE, Scalar};
use crate::surface::attributes::{Form, Ground};
use crate::surface::labels::{self, Labelling};
use crate::surface::records::{self, Origin};
use crate::surface::{Skin, Walked, exact, renumber};

/// A surface as a reader will have it, and what its vertices and faces were before.
#[derive(Debug)]
pub(crate) struct Coded {
    pub(crate) skin: Skin,
    /// The vertex of the surface that each vertex was.
    pub(crate) order: Vec<u32>,
    /// The half-edge of the surface that the first of each face was.
    pub(crate) first: Vec<u32>,
}

impl Coded {
    /// A surface that was walked over.
    pub(crate) fn by_walk(walked: &Walked) -> Self {
        let first = walked.surface.real_faces().iter().map(|&f| walked.faces[f as usize]).collect();
        Self { skin: walked.surface.skin(), order: walked.order.clone(), first }
    }

    /// A surface that was coded as an image: its triangles as they come back, and the vertices that theirs were.
    ///
    /// # Errors
    /// If these are not the triangles of `surface`, which would be a fault of this program.
    pub(crate) fn by_image(surface: &HalfEdges, triangles: Vec<[u32; 3]>, order: Vec<u32>) -> Result<Self> {
        let at: HashMap<_, u32> =
            (0..3 * surface.triangles().len() as u32).map(|h| ((surface.from(h), surface.to(h)), h)).collect();
        let old = |v: u32| order.get(v as usize).copied().unwrap_or(NONE);
        let first = triangles.iter().map(|&[a, b, _]| at.get(&(old(a), old(b))).copied());
        let Some(first) = first.collect() else {
            return Err(Error::Parameter("the image does not hold the surface".into()));
        };
        Ok(Self { skin: Skin::of_triangles(order.len(), triangles)?, order, first })
    }
}

/// Writes what the header announces.
pub(crate) fn write(
    writer: &mut ChunkWriter,
    header: &Header,
    mesh: &Mesh,
    positions: &[[i32; 3]],
    front: &Front,
    coded: &Coded,
    attributes: &[(usize, Form)],
) -> Result<()> {
    let skin = &coded.skin;
    let mut source = Known::new(front, coded, &mesh.faces, positions);
    let met: Vec<[i32; 3]> = coded.order.iter().map(|&v| positions[front.vertex[v as usize] as usize]).collect();
    let (faces_now, positions_now, origins) = if header.extras.fixes {
        let totals = source.totals(&mesh.faces, header.vertices);
        let (stream, rebuilt) = records::write(skin, &met, header.extent, totals, &mut source)?;
        let fixes = FixesChunk {
            surface_vertices: front.vertex.len() as u32,
            points: totals.points,
            loose: totals.loose,
            corners: totals.corners,
            stream: &stream,
        };
        writer.chunk(FixesChunk::TAG, &fixes.write(header.vertices, header.faces));
        (rebuilt.faces, rebuilt.positions, rebuilt.origins)
    } else {
        let origins = (0..header.faces).map(|f| Origin::Surface(3 * f, 0)).collect();
        (skin.triangles.iter().copied().collect(), met, origins)
    };
    let order = source.renumbering(&mesh.faces, &faces_now, &origins);
    if header.extras.exact {
        let lattice = header.lattice.lattice();
        let near: Vec<_> = positions_now.iter().map(|&q| header.position(&lattice, q)).collect();
        let known = |v: usize| mesh.positions[order.vertices[v] as usize];
        let scalar = if header.double { Scalar::F64 } else { Scalar::F32 };
        writer.chunk(EXACT_TAG, &exact::write(&near, known, scalar)?);
    }
    if header.extras.attributes {
        let ground = Ground::new(&faces_now, &positions_now);
        let one = |(i, form): &(usize, Form)| keep::write(&mesh.attributes[*i], form, &ground, &order, &mesh.faces);
        let written: Vec<_> = attributes.iter().map(one).collect::<Result<_>>()?;
        let records: Vec<_> = written.iter().map(|(record, stream)| AttributeRecord { stream, ..record.clone() }).collect();
        writer.chunk(AttributeRecord::TAG, &AttributeRecord::write(&records));
    }
    let mut old_faces = order.faces.clone();
    if header.extras.order {
        writer.chunk(ORDER_TAG, &renumber::write(&faces_now, &order)?);
        old_faces.sort_unstable();
    }
    if header.extras.labels {
        let faces = if header.extras.order { &mesh.faces } else { &faces_now };
        let (count, text, stream) = labels::write(&Labelling::new(&mesh.labels, &old_faces), faces, mesh.positions.len())?;
        writer.chunk(LabelsChunk::TAG, &LabelsChunk { count, text, stream: &stream }.write());
    }
    Ok(())
}
