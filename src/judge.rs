//! How far a decoded surface is from its original: what encoders that search ask again and again.
//!
//! The measures are those of `eval`, by the same samples; the original's tree is built once.

use crate::distance::{Frame, SampleOptions, Sampled, Surface, certify, sample, sample_spread};
use crate::error::{Error, MeshDefect, Result};
use crate::geom::{Aabb, PLACES};
use crate::mesh::{Mesh, Region};
use crate::par;
use crate::task::Task;

/// A surface that others are compared with.
pub(crate) struct Judge {
    frame: Frame,
    original: Surface,
    diagonal: f64,
    /// The faces that matter most, if some do.
    region: Option<Surface>,
}

/// What was found.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Measured {
    /// As `eval::Comparison::psnr`.
    pub(crate) psnr: f64,
    /// The same of the region of interest: from its points to the other surface.
    pub(crate) region: Option<f64>,
    /// The greatest distance seen.
    pub(crate) hausdorff: f64,
}

impl Measured {
    /// What searches aim at: the region's, if there is one.
    pub(crate) fn aimed_at(&self) -> f64 {
        self.region.unwrap_or(self.psnr)
    }
}

/// Samples on each surface that `eval::compare` takes at least, and for each triangle.
const SAMPLES: usize = 200_000;
const SAMPLES_A_TRIANGLE: usize = 10;
/// What a search takes of the surface with more: psnr by these is right to some hundredths of a dB.
const FEW_SAMPLES: usize = 60_000;
const FACES_A_TASK: usize = 1024;
/// The seed of `eval::CompareOptions`.
const SEED: u64 = 1;
/// Where the formula would say infinity.
const PSNR_OF_EQUALS: f64 = 999.0;

/// How many samples of a surface `eval::compare` takes.
fn samples_of(surface: &Surface) -> usize {
    SAMPLES.max(SAMPLES_A_TRIANGLE * surface.triangles().len())
}

impl Judge {
    pub(crate) fn new(original: &Mesh) -> Result<Self> {
        let around = Aabb::of(original.positions.iter().filter(|p| p.iter().all(|x| x.is_finite())).map(|&p| p.into()));
        let frame = Frame::around(around, around);
        let surface = Surface::new(frame, &original.positions, &original.faces.triangles());
        if surface.is_empty() {
            return Err(MeshDefect::Empty.into());
        }
        Ok(Self { frame, original: surface, diagonal: around.size().length(), region: None })
    }

    /// From now on a psnr that is searched for is that of a region of the original.
    pub(crate) fn look_at(&mut self, original: &Mesh, region: &Region) {
        let inside = original.faces.triangles().into_iter().filter(|t| region.has_face(t));
        let surface = Surface::new(self.frame, &original.positions, &inside.collect::<Vec<_>>());
        self.region = (!surface.is_empty()).then_some(surface);
    }

    /// The diagonal of the original's box.
    pub(crate) fn diagonal(&self) -> f64 {
        self.diagonal
    }

    /// Measures a decoded mesh by as many samples as `eval::compare`.
    pub(crate) fn measure(&self, decoded: &Mesh, task: Task<'_>) -> Result<Measured> {
        let decoded = self.surface(decoded)?;
        let [there, back] = self.both_ways(&decoded, 1.0, |from, to, options| sample(from, to, options, &task))?;
        let of_region = |region: &Surface| -> Result<f64> {
            let options = SampleOptions { samples: samples_of(region), seed: SEED };
            Ok(self.psnr_of(&[sample(region, &decoded, options, &task)?]))
        };
        let region = self.region.as_ref().map(of_region).transpose()?;
        Ok(Measured {
            psnr: self.psnr_of(&[there, back]),
            region,
            hausdorff: self.frame.length_outside(there.max.max(back.max)),
        })
    }

    /// The psnr that is searched for, by few samples: off by some hundredths of a dB, and by about the same for surfaces that are
    /// nearly the same.
    pub(crate) fn psnr(&self, decoded: &Mesh, task: Task<'_>) -> Result<f64> {
        let decoded = self.surface(decoded)?;
        if let Some(region) = &self.region {
            let options = SampleOptions { samples: FEW_SAMPLES.min(samples_of(region)), seed: SEED };
            return Ok(self.psnr_of(&[sample_spread(region, &decoded, options, &task)?]));
        }
        let share = self.share_of_few(&decoded);
        let both = self.both_ways(&decoded, share, |from, to, options| sample_spread(from, to, options, &task))?;
        Ok(self.psnr_of(&both))
    }

    /// The greatest distance of few samples and of all vertices.
    pub(crate) fn hausdorff(&self, decoded: &Mesh, task: Task<'_>) -> Result<f64> {
        let decoded = self.surface(decoded)?;
        let share = self.share_of_few(&decoded);
        let [there, back] = self.both_ways(&decoded, share, |from, to, options| sample(from, to, options, &task))?;
        Ok(self.frame.length_outside(there.max.max(back.max)))
    }

    /// The share of all samples that is few; both surfaces then weigh as they do with all.
    fn share_of_few(&self, decoded: &Surface) -> f64 {
        let most = samples_of(&self.original).max(samples_of(decoded));
        FEW_SAMPLES.min(most) as f64 / most as f64
    }

    fn both_ways(
        &self,
        decoded: &Surface,
        share: f64,
        measure: impl Fn(&Surface, &Surface, SampleOptions) -> Result<Sampled>,
    ) -> Result<[Sampled; 2]> {
        let options = |from| SampleOptions { samples: ((samples_of(from) as f64 * share) as usize).max(1), seed: SEED };
        Ok([measure(&self.original, decoded, options(&self.original))?, measure(decoded, &self.original, options(decoded))?])
    }

    fn psnr_of(&self, sampled: &[Sampled]) -> f64 {
        let (sum, count) = sampled.iter().fold((0.0, 0), |(sum, count), s| (sum + s.sum2, count + s.samples));
        let rms = (sum / count.max(1) as f64).sqrt();
        let rms = self.frame.length_outside(rms);
        if rms <= self.diagonal * 1e-15 { PSNR_OF_EQUALS } else { 20.0 * (self.diagonal / rms).log10() }
    }

    /// A distance beyond which no point of either surface is from the other; `seen` is one that was measured.
    pub(crate) fn bound(&self, decoded: &Mesh, seen: f64, task: Task<'_>) -> Result<f64> {
        let decoded = self.surface(decoded)?;
        let seen = seen / self.frame.length_outside(1.0);
        let there = certify(&self.original, &decoded, seen, &task)?;
        let back = certify(&decoded, &self.original, there.lower, &task)?;
        Ok(self.frame.length_outside(there.upper.max(back.upper)))
    }

    /// The vertices of faces of either mesh that have a point, of some that are looked at, farther than `bound` from the other.
    /// Both have the same faces.
    pub(crate) fn beyond(&self, original: &Mesh, decoded: &Mesh, bound: f64, task: Task<'_>) -> Result<Vec<u32>> {
        let surface = self.surface(decoded)?;
        let faces = original.faces.triangles();
        let limit = bound / self.frame.length_outside(1.0);
        let mut found = Vec::new();
        for (from, to) in [(original, &surface), (decoded, &self.original)] {
            let chunks = par::map(faces.len().div_ceil(FACES_A_TASK), |chunk| {
                let mut far: Vec<u32> = Vec::new();
                let mut hint = 0;
                for t in &faces[chunk * FACES_A_TASK..faces.len().min((chunk + 1) * FACES_A_TASK)] {
                    let corners = t.map(|v| self.frame.inside(from.positions[v as usize].into()));
                    let is_far = PLACES.iter().any(|w| {
                        let hit = to.closest(corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2], hint);
                        hint = hit.slot;
                        hit.distance2 > limit * limit
                    });
                    if is_far {
                        far.extend(t);
                    }
                }
                far
            });
            found.extend(chunks.into_iter().flatten());
            task.step(0.5)?;
        }
        found.sort_unstable();
        found.dedup();
        Ok(found)
    }

    fn surface(&self, mesh: &Mesh) -> Result<Surface> {
        let surface = Surface::new(self.frame, &mesh.positions, &mesh.faces.triangles());
        if surface.is_empty() { Err(Error::Mesh(MeshDefect::Empty)) } else { Ok(surface) }
    }
}
