//! A region of interest on its way from a mesh to the files of geometry images.

use super::write::{How, Regions};
use crate::codec::wavelet::Zones;
use crate::error::{Error, Result};
use crate::gim::{Atlas, Focus, Interest, Sampler, Sampling, region_under};
use crate::mesh::{Mesh, Region};
use crate::options::{Roi, RoiPlace};
use crate::plane::{GeometryImage, Mask, RegionCells, Shape};
use crate::task::Task;

/// What matters most of a surface, and how much more.
pub(crate) struct Interesting<'a> {
    interest: Interest,
    roi: &'a Roi,
}

/// Samples a side by which a mask finds its vertices.
const SIDE: usize = 129;

impl<'a> Interesting<'a> {
    /// A region of a mesh that has been flattened.
    pub(crate) fn of_mesh(mesh: &Mesh, atlas: &Atlas, roi: &'a Roi, task: Task<'_>) -> Result<Self> {
        Self::new(mesh, roi, || {
            let grains = atlas.grains();
            let side = (SIDE - 1).next_multiple_of(grains) + 1;
            atlas.sample(side, Sampler { sampling: Sampling::Regular, focus: None }, &task)
        })
    }

    /// A region of a mesh that is sampled as one image, or was.
    pub(crate) fn of_image(mesh: &Mesh, image: &GeometryImage, roi: &'a Roi) -> Result<Self> {
        Self::new(mesh, roi, || Ok(vec![image.clone()]))
    }

    fn new(mesh: &Mesh, roi: &'a Roi, images: impl FnOnce() -> Result<Vec<GeometryImage>>) -> Result<Self> {
        let region = match &roi.place {
            RoiPlace::Mask { columns, inside } => match &images()?[..] {
                [image] => region_under(mesh, image, &mask(*columns, inside)?)?,
                images => {
                    return Err(Error::Parameter(format!(
                        "a mask for a surface of {} images; take a list of vertices or a box",
                        images.len()
                    )));
                }
            },
            place => place.on(mesh)?,
        };
        Ok(Self { interest: Interest::new(mesh, region), roi })
    }

    pub(crate) fn region(&self) -> &Region {
        self.interest.region()
    }

    /// How it draws samples together.
    pub(crate) fn focus(&self) -> Focus<'_> {
        Focus { interest: &self.interest, closer: self.roi.closer }
    }

    /// Which cells of some images it takes.
    pub(crate) fn cells(&self, images: &[GeometryImage]) -> Result<Vec<RegionCells>> {
        images.iter().map(|image| RegionCells::around(&self.interest.samples(image))).collect()
    }

    /// The same way to code, with regions whose cells are known.
    pub(crate) fn among<'b>(&self, cells: &'b [RegionCells], how: How<'b>) -> How<'b> {
        How { regions: Some(Regions { cells, coarser: self.roi.coarser }), ..how }
    }

    /// Where steps of an image are coarser.
    pub(crate) fn zones(&self, image: &GeometryImage) -> Result<Zones> {
        let cells = RegionCells::around(&self.interest.samples(image))?;
        Ok(Zones::new(&cells, image.gluing(), self.roi.coarser))
    }
}

fn mask(columns: usize, inside: &[bool]) -> Result<Mask> {
    let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let shape = Shape::new(side(columns), side(inside.len() / columns.max(1)))?;
    Mask::from_bits(shape, inside.iter().copied())
}
