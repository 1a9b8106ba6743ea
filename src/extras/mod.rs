//! What a file holds beside an oriented manifold of triangles: how any mesh is made of one, its order, its names.
//!
//! One of the few files that see both wings. Every codec gives a surface (a [`Skin`]) with lattice positions; here it becomes
//! the mesh that was encoded. spec/any-mesh.md is the normative text.

mod arrange;
#[cfg(feature = "encode")]
mod source;
#[cfg(feature = "encode")]
mod write;

#[cfg(feature = "encode")]
pub(crate) use write::{Coded, write};

use crate::error::{Error, Place, Result};
use crate::format::{Chunks, Extras, FixesChunk, Header, LabelsChunk, ORDER_TAG};
use crate::limits::Budget;
use crate::mesh::Mesh;
use crate::surface::records::{self, Totals};
use crate::surface::{Skin, labels, renumber};

/// The chunks of all this; each may be absent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parts<'a> {
    pub(crate) fixes: Option<FixesChunk<'a>>,
    order: Option<&'a [u8]>,
    labels: Option<LabelsChunk<'a>>,
}

impl<'a> Parts<'a> {
    /// Tags of the chunks.
    pub(crate) const TAGS: [[u8; 4]; 3] = [FixesChunk::TAG, ORDER_TAG, LabelsChunk::TAG];

    /// The chunks of a file, which must be those that its header announces.
    pub(crate) fn read(chunks: &Chunks<'a>, header: &Header) -> Result<Self> {
        let fixes = match chunks.optional(FixesChunk::TAG)? {
            Some(chunk) => Some(FixesChunk::read(chunk.reader(), header.vertices, header.faces)?),
            None => None,
        };
        let order = chunks.optional(ORDER_TAG)?.map(|chunk| chunk.payload);
        let labels = match chunks.optional(LabelsChunk::TAG)? {
            Some(chunk) => Some(LabelsChunk::read(chunk.reader())?),
            None => None,
        };
        let extras = Extras { fixes: fixes.is_some(), order: order.is_some(), labels: labels.is_some() };
        if extras != header.extras {
            let why = format!("the header announces other chunks ({:?}) than there are ({extras:?})", header.extras);
            return Err(Error::malformed(Place::Whole, why));
        }
        Ok(Self { fixes, order, labels })
    }

    /// Vertices of the surface, and the most triangles that it may have.
    pub(crate) fn surface_size(&self, header: &Header) -> (u32, u32) {
        match self.fixes {
            None => (header.vertices, header.faces),
            Some(FixesChunk { surface_vertices, corners, loose, .. }) => {
                let sides = 2 * (u64::from(header.faces) - u64::from(loose));
                (surface_vertices, u64::from(corners).saturating_sub(sides) as u32)
            }
        }
    }

    /// The bytes of each part, by name.
    pub(crate) fn sizes(&self) -> Vec<(&'static str, u64)> {
        let fixes = self.fixes.map(|fixes| ("repairs", fixes.stream.len() as u64));
        let labels = self.labels.map(|labels| ("labels", labels.stream.len() as u64));
        let order = self.order.map(|stream| ("order", stream.len() as u64));
        fixes.into_iter().chain(labels).chain(order).collect()
    }

    /// Memory and steps that [`Parts::mesh`] takes at most, for a surface of so many triangles (fillings of holes included).
    pub(crate) fn cost(&self, header: &Header, triangles: u64) -> (u64, u64) {
        let Header { vertices, faces, .. } = *header;
        let (mut memory, mut work) = (0_u64, 0_u64);
        let mut corners = 3 * u64::from(faces);
        let mut add = |(bytes, steps): (u64, u64)| {
            memory = memory.saturating_add(bytes);
            work = work.saturating_add(steps);
        };
        if let Some(fixes) = &self.fixes {
            corners = fixes.corners.into();
            let totals = totals(header, fixes);
            let surface = fixes.surface_vertices;
            add((triangles * Skin::BYTES_A_FACE, 0));
            add((records::memory(surface, triangles, totals), records::work(surface, triangles, totals)));
        }
        if self.order.is_some() {
            add((renumber::memory(vertices, faces), renumber::work(vertices, faces)));
            add((arrange::memory(vertices, faces, corners), 0));
        }
        if let Some(LabelsChunk { count, text, .. }) = self.labels {
            add((labels::memory(count, text, faces, corners), labels::work(count, text, faces)));
        }
        (memory, work)
    }

    /// The mesh that a surface is coded for. `triangles` as in [`Parts::cost`].
    pub(crate) fn mesh(
        &self,
        header: &Header,
        skin: Skin,
        positions: Vec<[i32; 3]>,
        triangles: u64,
        budget: &mut Budget,
    ) -> Result<Mesh> {
        let lattice = header.lattice.lattice();
        let placed = |positions: Vec<[i32; 3]>| positions.into_iter().map(|q| header.position(&lattice, q)).collect();
        let mut mesh = if let Some(fixes) = &self.fixes {
            budget.reserve(triangles * Skin::BYTES_A_FACE)?;
            let totals = totals(header, fixes);
            let rebuilt = records::read(fixes.stream, &skin, &positions, header.extent, totals, budget)?;
            Mesh { positions: placed(rebuilt.positions), faces: rebuilt.faces, ..Mesh::default() }
        } else {
            if skin.triangles.len() != header.faces as usize {
                let why = format!("{} faces were decoded, the header says {}", skin.triangles.len(), header.faces);
                return Err(Error::malformed(Place::Whole, why));
            }
            Mesh::from_triangles(placed(positions), skin.triangles)
        };
        if let Some(stream) = self.order {
            let order = renumber::read(stream, &mesh.faces, mesh.positions.len(), budget)?;
            let corners = mesh.faces.corners().len() as u64;
            budget.reserve(arrange::memory(header.vertices, header.faces, corners))?;
            mesh = arrange::in_order(mesh, &order);
        }
        if let Some(LabelsChunk { count, text, stream }) = self.labels {
            budget.reserve(labels::memory(count, text, header.faces, mesh.faces.corners().len() as u64))?;
            let labelling = labels::read(stream, count, text, mesh.faces.len(), budget)?;
            (mesh.faces, mesh.labels) = labelling.apply(&mesh.faces);
        }
        Ok(mesh)
    }
}

fn totals(header: &Header, fixes: &FixesChunk<'_>) -> Totals {
    let FixesChunk { corners, loose, points, .. } = *fixes;
    Totals { vertices: header.vertices, faces: header.faces, corners, loose, points }
}
