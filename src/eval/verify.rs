//! Is a file what it should be, and does it keep what it promises?
//!
//! Reads strictly (structure, checksums, the one canonical way to write the header), decodes fully under limits, and checks
//! the invariants of the result. With the original at hand also that the connectivity is the same and the bound holds.

use super::measure::{CompareOptions, compare};
use super::same::{Verdict, same};
use crate::decode::{Decoder, Info};
use crate::error::{Error, Result};
use crate::format::{Chunks, Header, ImageChunk};
use crate::limits::Limits;
use crate::mesh::{HalfEdges, Mesh};
use crate::task::Task;

/// What [`verify`] found: one entry a check, in the order in which they were made.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Verification {
    /// The checks; those that had no sense after a failure are missing.
    pub checks: Vec<Check>,
}

/// One check.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Check {
    /// What was checked, in a word or two.
    pub name: &'static str,
    /// What was found, if all is well; or what is wrong.
    pub outcome: std::result::Result<String, String>,
}

impl Verification {
    /// Whether every check passed.
    pub fn passed(&self) -> bool {
        self.first_failure().is_none()
    }

    /// The first check that failed, and why.
    pub fn first_failure(&self) -> Option<(&'static str, &str)> {
        self.checks.iter().find_map(|check| Some((check.name, check.outcome.as_ref().err()?.as_str())))
    }

    fn add(&mut self, name: &'static str, outcome: std::result::Result<String, String>) -> bool {
        let passed = outcome.is_ok();
        self.checks.push(Check { name, outcome });
        passed
    }
}

/// Checks a file, and with `original` also what it promises about it.
///
/// # Errors
/// Only [`Error::Cancelled`]: whatever is wrong with the file is an entry of the result.
pub fn verify(bytes: &[u8], limits: Limits, original: Option<&Mesh>, task: Task<'_>) -> Result<Verification> {
    let mut found = Verification { checks: Vec::new() };
    let decoder = match Decoder::with_limits(bytes, limits) {
        Ok(decoder) => decoder,
        Err(error) => {
            found.add("structure", Err(error.to_string()));
            return Ok(found);
        }
    };
    let info = decoder.info();
    found.add("structure", Ok(format!("{} chunks, all checksums match", info.chunks.len())));
    found.add("canonical", canonical(bytes));
    let mesh = match decoder.decode_with(task) {
        Ok(mesh) => mesh,
        Err(Error::Cancelled) => return Err(Error::Cancelled),
        Err(error) => {
            found.add("decode", Err(error.to_string()));
            return Ok(found);
        }
    };
    found.add("decode", Ok(format!("{} vertices, {} faces", mesh.positions.len(), mesh.faces.len())));
    found.add("counts", counts(info, &mesh));
    if !found.add("indices", indices(&mesh)) {
        return Ok(found);
    }
    if info.manifold && info.connectivity_exact {
        found.add("manifold", manifold(&mesh));
    }
    found.add("box", inside_box(info, &mesh));
    task.step(0.5)?;
    if let Some(original) = original {
        let promised = if info.connectivity_exact { promises } else { surfaces_within };
        promised(info, original, &mesh, &mut found, task)?;
    }
    Ok(found)
}

/// The header is written as an encoder writes it, and no byte is unaccounted for.
fn canonical(bytes: &[u8]) -> std::result::Result<String, String> {
    let read = || -> Result<bool> {
        let chunks = Chunks::read(bytes)?;
        if chunks.first() == Some(ImageChunk::TAG) {
            let images = chunks.iter().filter(|chunk| chunk.tag == ImageChunk::TAG);
            let same = images.map(|chunk| Ok(ImageChunk::read(chunk.reader())?.write() == chunk.payload));
            return same.collect::<Result<Vec<bool>>>().map(|same| same.into_iter().all(|same| same));
        }
        let chunk = chunks.one(Header::TAG)?;
        Ok(Header::read(chunk.reader())?.write() == chunk.payload)
    };
    match read() {
        Ok(true) => Ok("the header is in its one canonical form".into()),
        Ok(false) => Err("the header could be written shorter or otherwise".into()),
        Err(error) => Err(error.to_string()),
    }
}

fn counts(info: &Info, mesh: &Mesh) -> std::result::Result<String, String> {
    let decoded = (mesh.positions.len(), mesh.faces.len());
    if decoded == (info.vertices as usize, info.faces as usize) {
        Ok("as the header says".into())
    } else {
        Err(format!("{decoded:?} vertices and faces, the header says {:?}", (info.vertices, info.faces)))
    }
}

fn indices(mesh: &Mesh) -> std::result::Result<String, String> {
    mesh.check().map(|()| "all in range, all coordinates finite".into()).map_err(|e| e.to_string())
}

fn manifold(mesh: &Mesh) -> std::result::Result<String, String> {
    let glued = HalfEdges::new(mesh.positions.len(), mesh.faces.triangles()).map_err(|e| e.to_string())?;
    match (0..mesh.positions.len() as u32).find(|&v| glued.outgoing(v).is_none()) {
        None => Ok("an oriented manifold, every vertex in use".into()),
        Some(v) => Err(format!("vertex {v} is in no face")),
    }
}

fn inside_box(info: &Info, mesh: &Mesh) -> std::result::Result<String, String> {
    let [low, high] = info.bounds;
    // Decoded coordinates are rounded to the precision of the file, the box is not.
    let rounding = if info.precision == crate::mesh::Scalar::F64 { 0.0 } else { f64::from(f32::EPSILON) };
    let slack = |x: f64| rounding * x.abs();
    let outside =
        mesh.positions.iter().position(|p| (0..3).any(|i| p[i] < low[i] - slack(low[i]) || p[i] > high[i] + slack(high[i])));
    match outside {
        None => Ok("every vertex lies in the box".into()),
        Some(v) => Err(format!("vertex {v} lies outside the box of the header")),
    }
}

/// The surfaces are no farther from each other than the bound: all that is promised where the connectivity is not.
fn surfaces_within(info: &Info, original: &Mesh, mesh: &Mesh, found: &mut Verification, task: Task<'_>) -> Result<()> {
    found.add("connectivity", Ok("not that of the original, as the file says".into()));
    let distance = compare(original, mesh, &CompareOptions::default().exact(true), &task)?.hausdorff;
    let within = distance <= info.bound * (1.0 + 1e-3);
    let text = format!("the surfaces are {distance:e} apart; the file promises {:e}", info.bound);
    found.add("bound", if within { Ok(text) } else { Err(text) });
    Ok(())
}

/// Same connectivity, and no vertex moved farther than the bound.
fn promises(info: &Info, original: &Mesh, mesh: &Mesh, found: &mut Verification, task: Task<'_>) -> Result<()> {
    if info.method == "gim" {
        return surface_promises(info, original, mesh, found, task);
    }
    // Vertices that slide go farther than the surfaces are apart.
    let slides = info.metric == "surface";
    let correspondence = same(original, mesh, if slides { None } else { Some(info.bound) }, &task)?;
    let outcome = match correspondence.verdict {
        Verdict::Same => Ok("the same as that of the original".into()),
        Verdict::Different => Err("differs from that of the original".into()),
        Verdict::Undecided => Err("could not be decided".into()),
    };
    found.add("connectivity", outcome);
    if slides {
        return surface_promises(info, original, mesh, found, task);
    }
    let Some(map) = correspondence.map else { return Ok(()) };
    let moved = original.positions.iter().zip(&map).filter_map(|(p, &w)| Some((p, mesh.positions.get(w as usize)?)));
    let square = |(p, q): (&[f64; 3], &[f64; 3])| (0..3).map(|i| (p[i] - q[i]) * (p[i] - q[i])).sum::<f64>();
    let farthest = moved.map(square).fold(0.0, f64::max).sqrt();
    found.add(
        "bound",
        if farthest <= info.bound {
            Ok(format!("no vertex moved farther than {farthest:e}; the file promises {:e}", info.bound))
        } else {
            Err(format!("a vertex moved by {farthest:e}; the file promises {:e}", info.bound))
        },
    );
    Ok(())
}

/// The psnr and the bound that are stated of the surface, measured.
fn surface_promises(info: &Info, original: &Mesh, mesh: &Mesh, found: &mut Verification, task: Task<'_>) -> Result<()> {
    let measured = match compare(original, mesh, &CompareOptions::default().exact(info.bound.is_finite()), &task) {
        Ok(measured) => measured,
        Err(Error::Cancelled) => return Err(Error::Cancelled),
        Err(error) => {
            found.add("original", Err(error.to_string()));
            return Ok(());
        }
    };
    if let Some(psnr) = info.psnr {
        let said = format!("{:.2} dB measured; the file promises {psnr:.2} dB", measured.psnr);
        // Other machines may round the samples' places differently.
        found.add("psnr", if measured.psnr >= psnr - 0.01 { Ok(said) } else { Err(said) });
    }
    if info.bound.is_finite() {
        let seen = measured.certified.map_or(measured.hausdorff, |bounds| bounds.lower);
        let said = format!("a distance of {seen:e} was found; the file promises {:e}", info.bound);
        found.add("bound", if seen <= info.bound { Ok(said) } else { Err(said) });
    }
    Ok(())
}
