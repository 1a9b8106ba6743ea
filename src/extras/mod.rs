//! What a file holds beside an oriented manifold of triangles: how any mesh is made of one, its order, its names.
//!
//! One of the few files that see both wings. Every codec gives a surface (a [`Skin`]) with lattice positions; here it becomes
//! the mesh that was encoded. spec/any-mesh.md is the normative text.

mod arrange;
mod attributes;
#[cfg(feature = "encode")]
mod keep;
#[cfg(feature = "encode")]
mod source;
#[cfg(feature = "encode")]
mod write;

#[cfg(feature = "encode")]
pub(crate) use keep::choose as choose_attributes;
#[cfg(feature = "encode")]
pub(crate) use write::{Coded, write};

use arrange::Arrangement;
pub use attributes::AttributeInfo;

use crate::error::{Error, Place, Result};
use crate::format::{AttributeRecord, Chunks, EXACT_TAG, Extras, FixesChunk, Header, LabelsChunk, ORDER_TAG};
use crate::limits::Budget;
use crate::mesh::{Faces, Mesh, Scalar};
use crate::surface::attributes::{Ground, Values};
use crate::surface::records::{self, Totals};
use crate::surface::{Skin, exact, labels, renumber};

/// The chunks of all this; each may be absent.
#[derive(Debug, Clone)]
pub(crate) struct Parts<'a> {
    pub(crate) fixes: Option<FixesChunk<'a>>,
    exact: Option<&'a [u8]>,
    attributes: Vec<AttributeRecord<'a>>,
    order: Option<&'a [u8]>,
    labels: Option<LabelsChunk<'a>>,
}

impl<'a> Parts<'a> {
    /// Tags of the chunks.
    pub(crate) const TAGS: [[u8; 4]; 5] = [FixesChunk::TAG, EXACT_TAG, AttributeRecord::TAG, ORDER_TAG, LabelsChunk::TAG];

    /// The chunks of a file, which must be those that its header announces.
    pub(crate) fn read(chunks: &Chunks<'a>, header: &Header) -> Result<Self> {
        let fixes = match chunks.optional(FixesChunk::TAG)? {
            Some(chunk) => Some(FixesChunk::read(chunk.reader(), header.vertices, header.faces)?),
            None => None,
        };
        let attributes = match chunks.optional(AttributeRecord::TAG)? {
            Some(chunk) => AttributeRecord::read(chunk.reader())?,
            None => Vec::new(),
        };
        let exact = chunks.optional(EXACT_TAG)?.map(|chunk| chunk.payload);
        let order = chunks.optional(ORDER_TAG)?.map(|chunk| chunk.payload);
        let labels = match chunks.optional(LabelsChunk::TAG)? {
            Some(chunk) => Some(LabelsChunk::read(chunk.reader())?),
            None => None,
        };
        let extras = Extras {
            fixes: fixes.is_some(),
            order: order.is_some(),
            labels: labels.is_some(),
            attributes: !attributes.is_empty(),
            exact: exact.is_some(),
        };
        if extras != header.extras {
            let why = format!("the header announces other chunks ({:?}) than there are ({extras:?})", header.extras);
            return Err(Error::malformed(Place::Whole, why));
        }
        Ok(Self { fixes, exact, attributes, order, labels })
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
        let mut sizes = Vec::new();
        sizes.extend(self.fixes.map(|fixes| ("repairs", fixes.stream.len() as u64)));
        sizes.extend(self.exact.map(|stream| ("exact", stream.len() as u64)));
        for (kind, name) in attributes::KIND_NAMES.into_iter().enumerate() {
            let records = self.attributes.iter().filter(|record| usize::from(record.kind) == kind);
            let size = records.map(|record| record.stream.len() as u64).sum();
            sizes.extend(self.attributes.iter().any(|record| usize::from(record.kind) == kind).then_some((name, size)));
        }
        sizes.extend(self.labels.map(|labels| ("labels", labels.stream.len() as u64)));
        sizes.extend(self.order.map(|stream| ("order", stream.len() as u64)));
        sizes
    }

    /// What there is to say of the attributes.
    pub(crate) fn attributes(&self) -> Vec<AttributeInfo> {
        self.attributes.iter().map(AttributeInfo::new).collect()
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
        if self.exact.is_some() {
            let vertices = u64::from(vertices);
            add((vertices * exact::BYTES_A_VERTEX, vertices * exact::STEPS_A_VERTEX));
        }
        if !self.attributes.is_empty() {
            add((Ground::memory(corners, faces.into()), corners));
        }
        self.attributes.iter().for_each(|record| add(attributes::cost(record, header, corners)));
        if self.order.is_some() {
            add((renumber::memory(vertices, faces), renumber::work(vertices, faces)));
            add((arrange::memory(vertices, faces, corners), 0));
        }
        if let Some(LabelsChunk { count, text, .. }) = self.labels {
            add((labels::memory(count, text, vertices, faces, corners), labels::work(count, text, faces)));
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
        let (faces, positions) = if let Some(fixes) = &self.fixes {
            budget.reserve(triangles * Skin::BYTES_A_FACE)?;
            let totals = totals(header, fixes);
            let rebuilt = records::read(fixes.stream, &skin, &positions, header.extent, totals, budget)?;
            (rebuilt.faces, rebuilt.positions)
        } else {
            if skin.triangles.len() != header.faces as usize {
                let why = format!("{} faces were decoded, the header says {}", skin.triangles.len(), header.faces);
                return Err(Error::malformed(Place::Whole, why));
            }
            (skin.triangles.into_iter().collect(), positions)
        };
        let mut values = self.values(&faces, &positions, budget)?;
        let lattice = header.lattice.lattice();
        let mut positions: Vec<[f64; 3]> = positions.into_iter().map(|q| header.position(&lattice, q)).collect();
        if let Some(stream) = self.exact {
            positions = exact::read(stream, &positions, if header.double { Scalar::F64 } else { Scalar::F32 }, budget)?;
        }
        let mut mesh = Mesh { positions, faces, ..Mesh::default() };
        let corners = mesh.faces.corners().len() as u64;
        let mut arrange = |mesh: &mut Mesh, arrangement: Arrangement| {
            for (record, values) in self.attributes.iter().zip(&mut values) {
                arrangement.values(attributes::shape(record).domain, &mesh.faces, values);
            }
            mesh.positions = arrangement.positions(std::mem::take(&mut mesh.positions));
            mesh.faces = arrangement.faces(&mesh.faces);
        };
        if let Some(stream) = self.order {
            let order = renumber::read(stream, &mesh.faces, mesh.positions.len(), budget)?;
            budget.reserve(arrange::memory(header.vertices, header.faces, corners))?;
            let mut faces = vec![0_u32; order.faces.len()];
            for (f, &old) in order.faces.iter().enumerate() {
                faces[old as usize] = f as u32;
            }
            arrange(&mut mesh, Arrangement { vertices: order.vertices, faces, turns: order.turns });
        }
        if let Some(LabelsChunk { count, text, stream }) = self.labels {
            budget.reserve(labels::memory(count, text, header.vertices, header.faces, corners))?;
            let (faces, labels) = labels::read(stream, count, text, &mesh.faces, mesh.positions.len(), budget)?.apply();
            arrange(&mut mesh, Arrangement { faces, ..Arrangement::default() });
            mesh.labels = labels;
        }
        let records = self.attributes.iter().zip(&values);
        mesh.attributes = records.map(|(record, values)| attributes::attribute(record, values)).collect();
        Ok(mesh)
    }

    fn values(&self, faces: &Faces, positions: &[[i32; 3]], budget: &mut Budget) -> Result<Vec<Values>> {
        if self.attributes.is_empty() {
            return Ok(Vec::new());
        }
        budget.reserve(Ground::memory(faces.corners().len() as u64, faces.len() as u64))?;
        budget.spend(faces.corners().len() as u64)?;
        let ground = Ground::new(faces, positions);
        self.attributes.iter().map(|record| attributes::read(record, &ground, budget)).collect()
    }
}

fn totals(header: &Header, fixes: &FixesChunk<'_>) -> Totals {
    let FixesChunk { corners, loose, points, .. } = *fixes;
    Totals { vertices: header.vertices, faces: header.faces, corners, loose, points }
}
