//! How far a region of interest of a mesh is from another surface.

use super::measure::psnr;
use crate::distance::{Frame, SampleOptions, Surface, sample};
use crate::error::{Error, Result};
use crate::geom::Aabb;
use crate::mesh::Mesh;
use crate::options::RoiPlace;
use crate::task::Task;

/// Measures from the points of a region to another surface, in the units of the meshes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct RegionComparison {
    /// Root mean square distance.
    pub rms: f64,
    /// The greatest distance of a sampled point or a vertex.
    pub hausdorff: f64,
    /// `20·log10(diag / rms)` in dB, `diag` being the box diagonal of the whole original.
    pub psnr: f64,
    /// The region's share of the original's area.
    pub share: f64,
    /// Points sampled.
    pub samples: usize,
}

/// Measures how far a region of the original `a` is from the surface of `b`: from the region's points, 10 a triangle and at least
/// 200,000, to the nearest of `b`. Distances the other way do not count: `b` has no region of its own.
///
/// # Errors
/// As [`compare`](super::compare); regions without a face, and masks, which are of images.
pub fn compare_region(a: &Mesh, b: &Mesh, place: &RoiPlace, task: &Task<'_>) -> Result<RegionComparison> {
    a.check()?;
    b.check()?;
    let region = place.on(a)?;
    let aabb = |mesh: &Mesh| Aabb::of(mesh.positions.iter().map(|&p| p.into()));
    let frame = Frame::around(aabb(a), aabb(b));
    let triangles = a.faces.triangles();
    let inside: Vec<[u32; 3]> = triangles.iter().filter(|t| region.has_face(*t)).copied().collect();
    let [whole, from] = [&triangles, &inside].map(|triangles| Surface::new(frame, &a.positions, triangles));
    let to = Surface::new(frame, &b.positions, &b.faces.triangles());
    if from.is_empty() || to.is_empty() {
        let what = if from.is_empty() { "the region has no face" } else { "the second mesh has no face" };
        return Err(Error::Parameter(format!("{what}: no surface to measure")));
    }
    let area =
        |surface: &Surface| -> f64 { surface.triangles().iter().map(|[p, q, r]| (*q - *p).cross(*r - *p).length()).sum() };
    let samples = 200_000.max(10 * from.triangles().len());
    let found = sample(&from, &to, SampleOptions { samples, seed: 1 }, task)?;
    let rms = frame.length_outside((found.sum2 / found.samples as f64).sqrt());
    Ok(RegionComparison {
        rms,
        hausdorff: frame.length_outside(found.max),
        psnr: psnr(aabb(a).size().length(), rms),
        share: area(&from) / area(&whole),
        samples: found.samples,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_region_counts() {
        // Two triangles; the second of the other mesh is raised.
        let at = |x: f64, z: f64| [[x, 0.0, z], [x + 1.0, 0.0, z], [x, 1.0, z]];
        let mesh = |z: f64| Mesh::from_triangles([at(0.0, 0.0), at(10.0, z)].concat(), [[0, 1, 2], [3, 4, 5]]);
        let (a, b) = (mesh(0.0), mesh(0.25));
        let measure = |list: Vec<u32>| compare_region(&a, &b, &RoiPlace::Vertices(list), &Task::default()).unwrap();
        let (still, moved) = (measure(vec![0]), measure(vec![3, 4]));
        assert!(still.rms < 1e-12 && (moved.rms - 0.25).abs() < 1e-12 && (moved.hausdorff - 0.25).abs() < 1e-12);
        assert!((moved.share - 0.5).abs() < 1e-12);
        let diag = (121.0_f64 + 1.0).sqrt();
        assert!((moved.psnr - 20.0 * (diag / 0.25).log10()).abs() < 1e-9);
    }
}
