//! Rate–distortion sweeps: meshes × ways × settings, measured one by one, and where an earlier sweep stopped.
//!
//! A *way* is one curve: a method with its codec and all that stays the same along it. A *setting* is one point of it. A
//! [`Coder`] makes a file and reads it again; [`OwnCoder`] is this library, and a caller may bring others. Every point has all
//! measures of [`compare`], and the command that makes its file.

mod coder;
mod point;
mod table;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

pub use coder::{Coder, OwnCoder, RoundTrip};
pub use point::{Measured, SweepPoint};
pub use table::{MeshCurves, SweepTable, WayCurve, WayMean};

use super::measure::{CompareOptions, compare};
use crate::bits::crc32;
use crate::error::{Error, Result};
use crate::mesh::{Loaded, Mesh};
use crate::par;
use crate::task::Task;

/// The share of a point's work that is not measuring, for progress.
const CODING: f64 = 0.8;

/// A mesh of a sweep.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SweepMesh {
    /// How it is called in tables: the file's name without folder and extension, where no other mesh has that.
    pub name: String,
    /// The file it is from.
    pub file: String,
    /// Bytes of that file.
    pub bytes: u64,
    /// Their CRC-32: whether the file is still the same.
    pub crc32: u32,
    /// The mesh.
    pub mesh: Mesh,
}

impl SweepMesh {
    /// A mesh that was read from `content`.
    pub fn new(file: impl Into<String>, content: &[u8], mesh: Mesh) -> Self {
        let file = file.into();
        let name = Path::new(&file).file_stem().map_or_else(|| file.clone(), |stem| stem.to_string_lossy().into_owned());
        Self { name, file, bytes: content.len() as u64, crc32: crc32(content), mesh }
    }

    /// Reads a mesh file.
    ///
    /// # Errors
    /// As [`Mesh::load`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let content = std::fs::read(path).map_err(|e| Error::from(e).in_file(path))?;
        let Loaded { mesh, .. } = Mesh::load(path)?;
        Ok(Self::new(path.display().to_string(), &content, mesh))
    }

    fn is_of(&self, point: &SweepPoint) -> bool {
        (self.bytes, self.crc32) == (point.file_bytes, point.file_crc32)
    }
}

/// A point that is wanted.
struct Wanted {
    mesh: usize,
    way: String,
    setting: String,
    command: String,
    coder: Arc<dyn Coder>,
}

/// A sweep that is planned: [`Sweep::add`] points, then [`Sweep::run`].
///
/// ```
/// use gimc::eval::{OwnCoder, Sweep, SweepMesh, SweepTable, curves_svg};
/// let mut sweep = Sweep::new(vec![SweepMesh::open("corpus/meshes/sphere.ply")?], Vec::new());
/// for bits in [8, 10] {
///     let (coder, setting) = (OwnCoder::new(gimc::EncodeOptions::cgim().bits(bits), || 0.0), format!("--bits {bits}"));
///     sweep.add(0, "surface", setting, "the command that makes it", std::sync::Arc::new(coder));
/// }
/// let swept = sweep.run(&|_| Ok(()), gimc::Task::default());
/// let picture = curves_svg(&SweepTable::new(&swept.points, None)?);
/// # assert!(swept.measured == 2 && picture.contains("surface: --bits 10"));
/// # Ok::<(), gimc::Error>(())
/// ```
pub struct Sweep {
    meshes: Vec<SweepMesh>,
    known: Vec<SweepPoint>,
    dropped: usize,
    wanted: Vec<Wanted>,
    jobs: usize,
    fresh: bool,
    options: CompareOptions,
}

/// What became of a sweep.
#[derive(Debug)]
#[non_exhaustive]
pub struct Swept {
    /// Points of earlier sweeps that were not asked for again, then the points in the order in which they were added.
    pub points: Vec<SweepPoint>,
    /// Points measured now.
    pub measured: usize,
    /// Points asked for that were known.
    pub kept: usize,
    /// Points asked for that are missing, as the sweep was stopped.
    pub left: usize,
    /// What stopped it.
    pub stopped: Option<Error>,
}

impl Sweep {
    /// A sweep over `meshes` that knows the points of an earlier one (or of none).
    ///
    /// Known points of a file that has changed since are dropped, and a mesh that is given twice under one name counts once. Two
    /// different meshes never share a name: where they would, the later is called by its whole path.
    pub fn new(mut meshes: Vec<SweepMesh>, mut known: Vec<SweepPoint>) -> Self {
        let before = known.len();
        known.retain(|point| !meshes.iter().any(|mesh| mesh.file == point.file && !mesh.is_of(point)));
        let mut seen = BTreeSet::new();
        meshes.retain(|mesh| seen.insert((mesh.name.clone(), mesh.bytes, mesh.crc32)));
        let files: BTreeSet<String> = meshes.iter().map(|mesh| mesh.file.clone()).collect();
        let mut named: BTreeMap<String, (u64, u32)> =
            known.iter().map(|p| (p.mesh.clone(), (p.file_bytes, p.file_crc32))).collect();
        for mesh in &mut meshes {
            let content = (mesh.bytes, mesh.crc32);
            // The same mesh from another place keeps its name.
            let is_it = |point: &&SweepPoint| mesh.is_of(point) && (point.file == mesh.file || !files.contains(&point.file));
            if let Some(point) = known.iter().find(is_it) {
                mesh.name = point.mesh.clone();
            } else if named.get(&mesh.name).is_some_and(|&other| other != content) {
                mesh.name = mesh.file.clone();
            }
            named.insert(mesh.name.clone(), content);
        }
        let dropped = before - known.len();
        Self { meshes, known, dropped, wanted: Vec::new(), jobs: 1, fresh: false, options: CompareOptions::default() }
    }

    /// So many points at a time; 1 is the default. Points and their order do not depend on it, seconds do.
    pub fn jobs(mut self, jobs: usize) -> Self {
        self.jobs = jobs.max(1);
        self
    }

    /// Whether what is wanted is measured even where it is known. Default: no.
    pub fn fresh(mut self, fresh: bool) -> Self {
        self.fresh = fresh;
        self
    }

    /// The meshes, with their names in tables.
    pub fn meshes(&self) -> &[SweepMesh] {
        &self.meshes
    }

    /// How many known points were dropped, as their files have changed.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// Wants a point: a file of mesh number `mesh`, made in a way and setting by `command`, which is what `coder` does.
    ///
    /// A point that is wanted already is not added again.
    pub fn add(
        &mut self,
        mesh: usize,
        way: impl Into<String>,
        setting: impl Into<String>,
        command: impl Into<String>,
        coder: Arc<dyn Coder>,
    ) {
        let (way, setting, command) = (way.into(), setting.into(), command.into());
        let is_new = !self.wanted.iter().any(|w| (w.mesh, &w.way, &w.setting) == (mesh, &way, &setting));
        if mesh < self.meshes.len() && is_new {
            self.wanted.push(Wanted { mesh, way, setting, command, coder });
        }
    }

    /// How many points are wanted, and how many of them are not known.
    pub fn counts(&self) -> [usize; 2] {
        [self.wanted.len(), self.wanted.iter().filter(|w| self.find(w).is_none()).count()]
    }

    fn find(&self, wanted: &Wanted) -> Option<&SweepPoint> {
        if self.fresh {
            return None;
        }
        let mesh = &self.meshes[wanted.mesh];
        let is_it = |p: &&SweepPoint| mesh.is_of(p) && p.setting == wanted.setting && p.program == wanted.coder.program();
        self.known.iter().find(is_it)
    }

    /// What is known of a wanted point: its names are those of now.
    fn point(&self, wanted: &Wanted, result: Result<Measured, String>) -> SweepPoint {
        let mesh = &self.meshes[wanted.mesh];
        SweepPoint {
            mesh: mesh.name.clone(),
            file: mesh.file.clone(),
            file_bytes: mesh.bytes,
            file_crc32: mesh.crc32,
            vertices: mesh.mesh.positions.len() as u64,
            faces: mesh.mesh.faces.len() as u64,
            way: wanted.way.clone(),
            setting: wanted.setting.clone(),
            program: wanted.coder.program(),
            method: wanted.coder.method(),
            codec: wanted.coder.codec(),
            command: wanted.command.clone(),
            result,
        }
    }

    /// Measures what is wanted and not known.
    ///
    /// `save` is called at the start and after every point, with all points so far in their final order. What a mesh or a
    /// setting is refused for becomes a point without measures; an [`Error::Io`] or [`Error::Cancelled`] ends the sweep.
    pub fn run(&self, save: &(dyn Fn(&[&SweepPoint]) -> Result<()> + Sync), task: Task<'_>) -> Swept {
        let wanted_again = |p: &SweepPoint| {
            let is_it = |w: &Wanted| {
                self.meshes[w.mesh].is_of(p) && (&w.way, &w.setting) == (&p.way, &p.setting) && w.coder.program() == p.program
            };
            self.wanted.iter().any(is_it)
        };
        let others: Vec<&SweepPoint> = self.known.iter().filter(|p| !wanted_again(p)).collect();
        let points: Vec<Option<SweepPoint>> =
            self.wanted.iter().map(|w| self.find(w).map(|known| self.point(w, known.result.clone()))).collect();
        let missing: Vec<usize> = (0..points.len()).filter(|&i| points[i].is_none()).collect();
        let kept = points.len() - missing.len();
        let state = Mutex::new(State { points, stopped: None });
        let save_all = |state: &mut State| {
            let all: Vec<&SweepPoint> = others.iter().copied().chain(state.points.iter().flatten()).collect();
            if let Err(error) = save(&all) {
                state.stopped.get_or_insert(error);
            }
        };
        save_all(&mut state.lock().unwrap_or_else(PoisonError::into_inner));
        let progress = Progress::new(missing.iter().map(|&i| self.wanted[i].coder.weight()).collect());
        par::side_by_side(self.jobs, missing.len(), |k| {
            let lock = || state.lock().unwrap_or_else(PoisonError::into_inner);
            if lock().stopped.is_some() {
                return;
            }
            let result = self.measure(&self.wanted[missing[k]], &|share| progress.report(k, share, &task), task);
            let mut state = lock();
            match result {
                Ok(result) => {
                    state.points[missing[k]] = Some(self.point(&self.wanted[missing[k]], result));
                    save_all(&mut state);
                }
                Err(error) => drop(state.stopped.get_or_insert(error)),
            }
        });
        let State { points, stopped } = state.into_inner().unwrap_or_else(PoisonError::into_inner);
        let left = points.iter().filter(|p| p.is_none()).count();
        let measured = points.len() - left - kept;
        let points = others.into_iter().cloned().chain(points.into_iter().flatten()).collect();
        Swept { points, measured, kept, left, stopped }
    }

    /// One point: a file there and back, measured; the inner result says why a mesh or setting was refused.
    fn measure(&self, wanted: &Wanted, report: &(dyn Fn(f64) + Sync), task: Task<'_>) -> Result<Result<Measured, String>> {
        let mesh = &self.meshes[wanted.mesh];
        let (coding, measuring) = (|share: f64| report(CODING * share), |share: f64| report(CODING + (1.0 - CODING) * share));
        let attempt = || {
            let there_and_back = wanted.coder.round_trip(mesh, task.with_progress(&coding))?;
            // A search that a deadline cut short gives another file than the command would.
            task.without_progress().step(0.0)?;
            let compared = compare(&mesh.mesh, &there_and_back.mesh, &self.options, &task.with_progress(&measuring))?;
            Ok(Measured::new(&there_and_back, &compared, mesh.mesh.positions.len()))
        };
        match attempt() {
            Ok(measured) => Ok(Ok(measured)),
            Err(error) if is_final(&error) => Err(error),
            Err(error) => Ok(Err(error.to_string().replace(['\n', '\r'], " "))),
        }
    }
}

/// Whether an error says nothing about the mesh or the setting.
fn is_final(error: &Error) -> bool {
    match error {
        Error::Io(_) | Error::Cancelled => true,
        Error::InFile { source, .. } => is_final(source),
        _ => false,
    }
}

/// What the jobs share.
struct State {
    points: Vec<Option<SweepPoint>>,
    stopped: Option<Error>,
}

/// Shares of points that are measured side by side, as one share.
struct Progress {
    weights: Vec<f64>,
    total: f64,
    /// The share of each point, and the weighted sum.
    done: Mutex<(Vec<f64>, f64)>,
}

impl Progress {
    fn new(weights: Vec<f64>) -> Self {
        let total = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        Self { done: Mutex::new((vec![0.0; weights.len()], 0.0)), weights, total }
    }

    fn report(&self, point: usize, share: f64, task: &Task<'_>) {
        let sum = {
            let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
            let more = self.weights[point] * (share - done.0[point]).max(0.0);
            done.0[point] = done.0[point].max(share);
            done.1 += more;
            done.1
        };
        // Whether it is over is asked elsewhere.
        let _ = task.step(sum / self.total);
    }
}

#[cfg(test)]
mod tests;
