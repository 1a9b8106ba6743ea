//! What users ask for: a mesh as geometry images, with every part of the papers selectable alone.

use super::{Adjust, Atlas, Sampler, Sampling};
use crate::error::Result;
use crate::mesh::Mesh;
use crate::param::{Border, Flattening, Param};
use crate::plane::GeometryImage;
use crate::task::Task;

/// What is done to samples once they are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Adjustment {
    /// Nothing.
    #[default]
    None,
    /// Moved where the greatest distance to the mesh falls (paper 000, Algorithms 1 to 3).
    Hausdorff,
    /// Moved along their normals until the mean distance is least.
    Fit,
}

/// How a mesh is sampled as geometry images.
///
/// ```
/// let mesh = gimc::Mesh::open("corpus/meshes/sphere.ply")?;
/// let images = gimc::resample::Resample::new(33).images(&mesh, &gimc::Task::default())?;
/// assert_eq!(images[0].gluing(), gimc::Gluing::Orbifold); // a closed surface has no seam
/// let back = gimc::Mesh::from_triangles(images[0].points().to_vec(), images[0].triangles());
/// # assert_eq!(back.faces.len(), 2 * 32 * 32);
/// # Ok::<(), gimc::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Resample {
    /// Samples a side; odd for closed surfaces. Where a mesh has several components, that of the largest.
    pub side: usize,
    /// How the surface is flattened.
    pub param: Param,
    /// What becomes the border of the square.
    pub border: Border,
    /// Where samples are taken.
    pub sampling: Sampling,
    /// What is done to them.
    pub adjust: Adjustment,
}

impl Resample {
    /// Yoshizawa's parametrisation, boundaries on the square, regular samples that stay where they are.
    pub fn new(side: usize) -> Self {
        Self {
            side,
            param: Param::Yoshizawa,
            border: Border::Square,
            sampling: Sampling::default(),
            adjust: Adjustment::default(),
        }
    }

    /// The same with another parametrisation.
    pub fn param(mut self, param: Param) -> Self {
        self.param = param;
        self
    }

    /// The same with another border.
    pub fn border(mut self, border: Border) -> Self {
        self.border = border;
        self
    }

    fn how(&self) -> Flattening {
        Flattening { param: self.param, border: self.border }
    }

    /// The same with samples taken elsewhere.
    pub fn sampling(mut self, sampling: Sampling) -> Self {
        self.sampling = sampling;
        self
    }

    /// The same with samples moved otherwise.
    pub fn adjust(mut self, adjust: Adjustment) -> Self {
        self.adjust = adjust;
        self
    }

    /// The images of a mesh, one for each of its components, in the order of their first vertices.
    ///
    /// # Errors
    /// Meshes of too many components or handles, and [`Error::NoConvergence`](crate::Error::NoConvergence) where rounding leaves no
    /// map without folds.
    pub fn images(&self, mesh: &Mesh, task: &Task<'_>) -> Result<Vec<GeometryImage>> {
        mesh.check()?;
        let adjust = match self.adjust {
            Adjustment::None => Adjust::None,
            Adjustment::Hausdorff => Adjust::Hausdorff(None),
            Adjustment::Fit => Adjust::Fit,
        };
        let atlas = Atlas::of_mesh(mesh, self.how(), task)?;
        let sampler = Sampler { sampling: self.sampling, focus: None };
        atlas.adjust(atlas.sample(self.side, sampler, task)?, adjust, task)
    }

    /// How much each component is stretched by its parametrisation: 1 where it is only scaled.
    ///
    /// # Errors
    /// As [`Resample::images`].
    pub fn stretch(&self, mesh: &Mesh, task: &Task<'_>) -> Result<Vec<f64>> {
        mesh.check()?;
        let atlas = Atlas::of_mesh(mesh, self.how(), task)?;
        Ok(atlas.maps().iter().map(super::Map::stretch).collect())
    }
}
