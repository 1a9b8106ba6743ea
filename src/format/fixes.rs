//! Chunk `FIXS`: what makes a mesh of any sort of the surface (spec/any-mesh.md). Absent where nothing need be made.

use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;

/// Counts, and the stream of records.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FixesChunk<'a> {
    /// Vertices of the surface, copies included.
    pub(crate) surface_vertices: u32,
    /// Vertices that no face of the surface uses.
    pub(crate) points: u32,
    /// Faces that are no part of the surface.
    pub(crate) loose: u32,
    /// Corners of all faces.
    pub(crate) corners: u32,
    pub(crate) stream: &'a [u8],
}

impl<'a> FixesChunk<'a> {
    pub(crate) const TAG: [u8; 4] = *b"FIXS";

    /// `vertices` and `faces` are those of the header: counts are told from what they would be in a sound mesh.
    #[cfg(feature = "encode")]
    pub(crate) fn write(&self, vertices: u32, faces: u32) -> Vec<u8> {
        let mut w = Writer::default();
        w.signed(i64::from(self.surface_vertices) - i64::from(vertices));
        w.varint(self.points.into());
        w.varint(self.loose.into());
        w.signed(i64::from(self.corners) - 3 * i64::from(faces));
        w.bytes(self.stream);
        w.into_bytes()
    }

    pub(crate) fn read(mut r: Reader<'a>, vertices: u32, faces: u32) -> Result<Self> {
        let surface_vertices = i64::from(vertices).saturating_add(r.signed("the vertices of the surface")?);
        let points = r.varint("the vertices beside the surface")?;
        let loose = r.varint("the loose faces")?;
        let corners = (3 * i64::from(faces)).saturating_add(r.signed("the corners")?);
        let counts = (u32::try_from(surface_vertices), u32::try_from(points), u32::try_from(loose), u32::try_from(corners));
        let (Ok(surface_vertices), Ok(points), Ok(loose), Ok(corners)) = counts else {
            return Err(r.error("counts that do not fit 32 bits"));
        };
        if points > vertices || loose > faces {
            return Err(r.error("more vertices beside the surface, or more loose faces, than there are in all"));
        }
        Ok(Self { surface_vertices, points, loose, corners, stream: r.rest() })
    }
}
