//! How far a decoded mesh is from its original: what an encoder must know of a file with lossy planes.

use glam::DVec3;

use crate::distance::{Frame, SampleOptions, Surface, certify, sample};
use crate::error::{Error, Result};
use crate::geom::Aabb;
use crate::mesh::Mesh;
use crate::task::Task;

/// The greatest distance of a decoded vertex from the one that it is in the original.
pub(super) fn farthest(original: &Mesh, decoded: &Mesh, origin: &[u32]) -> f64 {
    let squares = decoded.positions.iter().zip(origin).map(|(q, &v)| {
        let p = original.positions[v as usize];
        (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>()
    });
    squares.fold(0.0, f64::max).sqrt()
}

/// An upper bound of the Hausdorff distance of the two surfaces.
pub(super) fn hausdorff(original: &Mesh, decoded: &Mesh, task: &Task<'_>) -> Result<f64> {
    let (frame, a, b) = surfaces(original, decoded)?;
    let there = certify(&a, &b, 0.0, task)?;
    let back = certify(&b, &a, there.lower, task)?;
    Ok(frame.length_outside(there.upper.max(back.upper)))
}

/// `psnr` of `measures.md`, in dB.
pub(super) fn psnr(original: &Mesh, decoded: &Mesh, task: &Task<'_>) -> Result<f64> {
    let (frame, a, b) = surfaces(original, decoded)?;
    let measured = |from: &Surface, to: &Surface| {
        let samples = 200_000.max(10 * from.triangles().len());
        sample(from, to, SampleOptions { samples, seed: 1 }, task)
    };
    let (there, back) = (measured(&a, &b)?, measured(&b, &a)?);
    let rms = frame.length_outside(((there.sum2 + back.sum2) / (there.samples + back.samples) as f64).sqrt());
    let diagonal = finite_box(original).size().length();
    Ok(if rms > diagonal * 1e-15 { 20.0 * (diagonal / rms).log10() } else { f64::INFINITY })
}

fn finite_box(mesh: &Mesh) -> Aabb {
    Aabb::of(mesh.positions.iter().map(|&p| DVec3::from(p)).filter(|p| p.is_finite()))
}

fn surfaces(original: &Mesh, decoded: &Mesh) -> Result<(Frame, Surface, Surface)> {
    let frame = Frame::around(finite_box(original), finite_box(decoded));
    let surface = |mesh: &Mesh| Surface::new(frame, &mesh.positions, &mesh.faces.triangles());
    let (a, b) = (surface(original), surface(decoded));
    if b.is_empty() {
        return Err(Error::Parameter("at this rate no face is left; take a higher one".into()));
    }
    Ok((frame, a, b))
}
