//! Geometry images: the method `gim`.

use super::Encoded;
use crate::charts::{self, Interesting};
use crate::decode::Decoder;
use crate::error::{Error, MeshDefect, Result};
use crate::gim::{Atlas, Flattening};
use crate::judge::Judge;
use crate::mesh::{Mesh, Scalar};
use crate::options::{EncodeOptions, Method};
use crate::plane::GeometryImage;
use crate::task::Task;

impl EncodeOptions {
    /// Samples a mesh as a geometry image and encodes that.
    pub(super) fn encode_as_image(&self, mesh: &Mesh, task: Task<'_>) -> Result<Encoded> {
        if mesh.faces.is_empty() {
            return Err(MeshDefect::Empty.into());
        }
        let mut judge = Judge::new(mesh)?;
        let how = charts::How { codec: self.codec, precision: mesh.precision, regions: None };
        let flattening = Flattening { param: self.gim.param, border: self.gim.border };
        let atlas = Atlas::of_mesh(mesh, flattening, &task)?;
        task.step(0.3)?;
        let interesting = self.roi.as_ref().map(|roi| Interesting::of_mesh(mesh, &atlas, roi, task)).transpose()?;
        if let Some(interesting) = &interesting {
            judge.look_at(mesh, interesting.region());
        }
        let aim = self.aim(&judge, task);
        let found = charts::sample(&atlas, interesting.as_ref(), how, &self.gim, &aim, task)?;
        Self::encoded(aim.file(&found)?, notes(mesh))
    }

    /// Encodes a geometry image that was made elsewhere, with the method `gim`.
    ///
    /// Errors are measured against `original`, or against the surface of the image itself where there is none.
    ///
    /// # Errors
    /// Options that contradict each other, or a target that cannot be reached; [`Error::Cancelled`].
    pub fn encode_image(&self, image: &GeometryImage, original: Option<&Mesh>, task: Task<'_>) -> Result<Encoded> {
        self.check()?;
        if self.method != Method::Gim {
            return Err(Error::Parameter("a geometry image is encoded with the method gim".into()));
        }
        task.step(0.0)?;
        let precision = original.map_or(Scalar::F32, |mesh| mesh.precision);
        let own;
        let surface = match original {
            Some(mesh) => {
                mesh.check()?;
                mesh
            }
            None => {
                own = charts::mesh(&[image], Scalar::F64)?;
                &own
            }
        };
        let mut judge = Judge::new(surface)?;
        let how = charts::How { codec: self.codec, precision, regions: None };
        let images = std::slice::from_ref(image);
        let interesting = self.roi.as_ref().map(|roi| Interesting::of_image(surface, image, roi)).transpose()?;
        let cells = interesting.as_ref().map_or(Ok(Vec::new()), |some| some.cells(images))?;
        let how = interesting.as_ref().map_or(how, |some| some.among(&cells, how));
        if let Some(interesting) = &interesting {
            judge.look_at(surface, interesting.region());
        }
        let aim = self.aim(&judge, task);
        let found = charts::search(images, how, &aim, None)?;
        let found = charts::finish(images, how, &aim, found)?;
        Self::encoded(aim.file(&found)?, original.map_or(Vec::new(), notes))
    }

    fn aim<'a>(&'a self, judge: &'a Judge, task: Task<'a>) -> charts::Aim<'a> {
        charts::Aim { accuracy: self.accuracy, judge, history: self.gim.history.as_deref(), task }
    }

    fn encoded(bytes: Vec<u8>, notes: Vec<String>) -> Result<Encoded> {
        let info = Decoder::new(&bytes)?.info().clone();
        Ok(Encoded { info, bytes, notes })
    }
}

/// What a geometry image does not hold.
fn notes(mesh: &Mesh) -> Vec<String> {
    mesh.attributes.iter().map(|a| format!("attribute `{}` was left out: geometry images have none", a.name)).collect()
}
