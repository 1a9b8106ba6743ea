//! A mesh whose vertices may slide along its surface: the step, found for what is asked of the surface.
//!
//! The psnr, the size and the greatest distance of a step are known only when the mesh is coded, decoded and measured. So a few
//! steps are tried; the connectivity is walked once.

use super::{Chunks, round_up};
use crate::error::{Error, MeshDefect, Result};
use crate::format::{Header, LatticeForm, MAX_EXTENT, SlideField, SurfaceChunk};
use crate::judge::Judge;
use crate::mesh::{Front, Mesh};
use crate::options::{Accuracy, EncodeOptions};
use crate::plane::{Lattice, bounding_box};
use crate::surface::{self, Filled, Hold, LONGEST_STRETCH, PARTS, Slid, Walked, Wishes};
use crate::task::Task;

/// A mesh that slides.
pub(super) struct Sliding<'a> {
    options: &'a EncodeOptions,
    mesh: &'a Mesh,
    draft: Header,
    /// The vertex of the mesh for each of its surface.
    vertices: &'a [u32],
    census: [u32; 3],
    connectivity: Vec<u8>,
    pub(super) walked: Walked,
    judge: Judge,
    bounds: [[f64; 3]; 2],
    task: Task<'a>,
}

/// What one step gave.
pub(super) struct Trial {
    step: f64,
    slid: Slid,
    pub(super) header: Header,
    /// Of each vertex of the mesh.
    pub(super) positions: Vec<[i32; 3]>,
    decoded: Mesh,
}

/// No corner of a face is farther than this from its plane, in steps, if it can be.
const REACH: f64 = 1.5;
/// Steps that are tried for a bound: as shares of it, and how many times √2 longer those across the normal may be. The fewest
/// bytes first; the last are nearly those of a lattice of cubes, on which any bound can be held.
const STEPS_FOR_BOUND: [(f64, u8); 11] = [
    (1.0, LONGEST_STRETCH),
    (0.75, LONGEST_STRETCH),
    (1.0, 3),
    (0.55, LONGEST_STRETCH),
    (0.75, 3),
    (1.0, 1),
    (0.75, 1),
    (0.4, LONGEST_STRETCH),
    (0.5, 0),
    (0.3, 0),
    (0.15, 0),
];
/// Rounds in which vertices are held closer, the last without a filter.
const ROUNDS: usize = 6;
/// Of the bound, what points that were looked at may use: others may be a little farther off.
const TRUSTED: f64 = 0.98;
/// How often vertices of turned faces are held closer.
const MENDINGS: usize = 3;
/// What that is multiplied by where it was too much.
const DISTRUST: f64 = 0.93;
/// No more than one vertex in so many is held closer at a time.
const MOST_HELD: usize = 12;

/// A trial between the logarithm of its step, with a sign, and its margin.
type Tried = (f64, Trial, f64);

/// Steps that are tried, at most.
const TRIALS: usize = 8;
/// What psnr falls by when the step doubles, and how far above the target is near enough, in dB.
const PSNR_SLOPE: f64 = 4.7;
const PSNR_TOLERANCE: f64 = 0.04;
/// What the logarithm of the size falls by, and how far below the target is near enough.
const SIZE_SLOPE: f64 = 0.3;
const SIZE_TOLERANCE: f64 = 0.004;
/// The root mean square distance of the surfaces is usually about this many steps.
const USUAL_RMS: f64 = 0.2;

impl<'a> Sliding<'a> {
    pub(super) fn new(
        options: &'a EncodeOptions,
        mesh: &'a Mesh,
        front: &'a Front,
        draft: Header,
        task: Task<'a>,
    ) -> Result<Self> {
        let bounds = bounding_box(mesh.positions.iter().copied()).ok_or(MeshDefect::Empty)?;
        let filled = Filled::new(&front.surface);
        let (connectivity, walked) = surface::trace(&filled, options.effort, task)?;
        Ok(Self {
            options,
            mesh,
            draft,
            vertices: &front.vertex,
            census: [filled.census.holes, filled.census.components, filled.census.handles],
            connectivity,
            walked,
            judge: Judge::new(mesh)?,
            bounds,
            task,
        })
    }

    /// The mesh as the options ask for it; `size` tells how long the file of a trial is.
    pub(super) fn find(&self, size: impl Fn(&Trial) -> Result<usize>) -> Result<Trial> {
        let [low, high] = self.bounds;
        let longest = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
        let mut found = match self.options.accuracy {
            _ if !(longest > 0.0) => self.trial(1.0)?,
            Accuracy::Bits(bits) => self.upright(longest / ((1_u64 << bits) - 1) as f64)?,
            Accuracy::Step(step) => self.upright(step)?,
            Accuracy::Psnr(psnr) => self.reach(psnr)?,
            Accuracy::Size(bytes) => {
                let start = longest / 512.0;
                let margin = |trial: &Trial| Ok((bytes as f64 / size(trial)? as f64).ln());
                let (trial, margin) = self.search(start, -1.0, SIZE_SLOPE, SIZE_TOLERANCE, margin)?;
                if margin < 0.0 {
                    let least = size(&trial)?;
                    return Err(Error::Parameter(format!(
                        "{bytes} bytes are too few for this mesh; the smallest file tried has {least}"
                    )));
                }
                // With no face turned, if that still fits.
                let upright = self.upright(trial.step)?;
                if size(&upright)? as u64 <= bytes { upright } else { trial }
            }
            Accuracy::Error(bound) => return self.within(bound),
            Accuracy::RelativeError(share) => return self.within(share * self.judge.diagonal()),
            Accuracy::Exact | Accuracy::Lattice(_) => {
                return Err(Error::Parameter("the metric surface has no lattice of the caller's".into()));
            }
        };
        found.header.bound = self.certified(&found)?;
        Ok(found)
    }

    /// A distance beyond which no point of either surface is from the other.
    fn certified(&self, trial: &Trial) -> Result<f32> {
        let seen = self.judge.hausdorff(&trial.decoded, self.task)?;
        Ok(round_up(self.judge.bound(&trial.decoded, seen, self.task)?))
    }

    /// The first of some steps at which the surfaces can be held within a bound.
    ///
    /// What is farther off is found by looking, and its vertices are held closer; since later predictions then change, that
    /// takes a few rounds. Whether the bound holds in the end is certified.
    fn within(&self, bound: f64) -> Result<Trial> {
        let mut nearest = f64::INFINITY;
        for (i, (share, longest)) in STEPS_FOR_BOUND.into_iter().enumerate() {
            let step = share * bound;
            let mut holds = vec![Hold::Free; self.mesh.positions.len()];
            let reach = (0.8 / share).min(REACH);
            let (mut trusted, mut least) = (TRUSTED, usize::MAX);
            for round in 0..ROUNDS {
                self.task.step(i as f64 / STEPS_FOR_BOUND.len() as f64)?;
                let may_filter = round + 1 < ROUNDS;
                let mut trial = self.trial_of(step, longest, &holds, reach, may_filter)?;
                let mut far = self.judge.beyond(self.mesh, &trial.decoded, bound * trusted, self.task)?;
                if far.is_empty() {
                    trial.header.bound = self.certified(&trial)?;
                    nearest = nearest.min(trial.header.bound.into());
                    if f64::from(trial.header.bound) <= bound {
                        return Ok(trial);
                    }
                    // A point that was not looked at: those near it are not much nearer.
                    trusted *= DISTRUST;
                    far = self.judge.beyond(self.mesh, &trial.decoded, bound * trusted, self.task)?;
                }
                // Too many, or hardly fewer than before: the step is too coarse.
                if far.len() * MOST_HELD > holds.len().max(100) || round > 1 && 2 * far.len() > least {
                    break;
                }
                least = least.min(far.len());
                for v in far {
                    let hold = &mut holds[v as usize];
                    *hold = if *hold == Hold::Free { Hold::Planes } else { Hold::Point };
                }
            }
        }
        Err(Error::Parameter(format!("an error of {bound} cannot be held; the least that was reached is {nearest}")))
    }

    /// The coarsest step whose surface has this psnr.
    fn reach(&self, psnr: f64) -> Result<Trial> {
        let rms = self.judge.diagonal() * 10_f64.powf(-psnr / 20.0);
        let margin = |trial: &Trial| Ok(self.judge.psnr(&trial.decoded, self.task)? - psnr);
        let (found, _) = self.search(rms / USUAL_RMS, 1.0, PSNR_SLOPE, PSNR_TOLERANCE, margin)?;
        let mut step = found.step;
        // So far by few samples; the last word have those that everyone measures by.
        for _ in 0..TRIALS {
            let found = self.upright(step)?;
            let missing = psnr - self.judge.measure(&found.decoded, self.task)?.psnr;
            if missing <= 0.0 {
                return Ok(found);
            }
            step *= (-(missing + PSNR_TOLERANCE / 4.0) / PSNR_SLOPE).exp2();
        }
        Err(Error::NoConvergence { what: "the search for the psnr", after: 2 * TRIALS, residual: psnr })
    }

    /// The trial whose margin is the least that is not negative; one with a negative margin if there is none. Where the step
    /// doubles, the margin falls by about `sign · slope`.
    fn search(
        &self,
        start: f64,
        sign: f64,
        slope: f64,
        tolerance: f64,
        margin: impl Fn(&Trial) -> Result<f64>,
    ) -> Result<(Trial, f64)> {
        // With the logarithm of the step, or less that, growing, margins fall.
        let mut x = sign * start.log2();
        let (mut good, mut bad): (Option<Tried>, Option<Tried>) = (None, None);
        for i in 0..TRIALS {
            let trial = match self.trial((sign * x).exp2()) {
                Ok(trial) => trial,
                // Too fine a step for numbers to hold.
                Err(Error::Parameter(_)) if good.is_some() => break,
                Err(error) => return Err(error),
            };
            let m = margin(&trial)?;
            self.task.step(i as f64 / TRIALS as f64)?;
            if m >= 0.0 {
                good = Some((x, trial, m));
                if m <= tolerance {
                    break;
                }
            } else {
                bad = Some((x, trial, m));
            }
            x = match (&good, &bad) {
                (Some((x, _, m)), None) | (None, Some((x, _, m))) => {
                    x + (m - 0.4 * tolerance).clamp(-8.0 * slope, 8.0 * slope) / slope
                }
                (Some((x, _, m)), Some((y, _, n))) => {
                    let share = ((m - 0.4 * tolerance) / (m - n)).clamp(0.1, 0.9);
                    x + share * (y - x)
                }
                (None, None) => x,
            };
        }
        match good.or(bad) {
            Some((_, trial, m)) => Ok((trial, m)),
            None => Err(Error::Parameter("no step was tried".into())),
        }
    }

    /// What a step gives.
    fn trial(&self, step: f64) -> Result<Trial> {
        self.trial_of(step, LONGEST_STRETCH, &[], REACH, true)
    }

    /// The same with as few faces turned as holding their vertices closer leaves.
    fn upright(&self, step: f64) -> Result<Trial> {
        let mut best = self.trial(step)?;
        let mut holds = vec![Hold::Free; self.mesh.positions.len()];
        let mut turned = best.slid.turned.clone();
        for _ in 0..MENDINGS {
            if turned.is_empty() || turned.len() * MOST_HELD > self.mesh.faces.len() {
                break;
            }
            // Their vertices, and those of all faces that have one of them.
            let mut is_near = vec![false; holds.len()];
            turned.iter().flatten().for_each(|&v| is_near[self.vertices[v as usize] as usize] = true);
            for face in self.mesh.faces.iter().filter(|face| face.iter().any(|&v| is_near[v as usize])) {
                face.iter().for_each(|&v| holds[v as usize] = Hold::Point);
            }
            let next = self.trial_of(step, LONGEST_STRETCH, &holds, REACH, true)?;
            turned.clone_from(&next.slid.turned);
            if turned.len() < best.slid.turned.len() {
                best = next;
            }
        }
        Ok(best)
    }

    fn trial_of(&self, step: f64, longest: u8, holds: &[Hold], reach: f64, may_filter: bool) -> Result<Trial> {
        let [low, high] = self.bounds;
        let fine = step / PARTS;
        let single = low.map(|x| f64::from(if f64::from(x as f32) > x { (x as f32).next_down() } else { x as f32 }));
        let is_short = !self.draft.double && (fine as f32).is_normal() && single.iter().all(|x| x.is_finite());
        let lattice = if is_short {
            Lattice { origin: single, step: f64::from(fine as f32) }
        } else {
            Lattice { origin: low, step: fine }
        };
        let extent = [0, 1, 2].map(|i| ((high[i] - lattice.origin[i]) / lattice.step).ceil().max(0.0));
        if !extent.iter().all(|&e| e <= MAX_EXTENT as f64) || !(lattice.step > 0.0) {
            return Err(Error::Parameter(format!(
                "a step of {step} is too small for this mesh: at most {} such steps are possible",
                MAX_EXTENT as f64 / PARTS
            )));
        }
        let extent = extent.map(|e| e as i32);
        let size = PARTS * lattice.step;
        let points: Vec<[f64; 3]> = self
            .vertices
            .iter()
            .map(|&v| [0, 1, 2].map(|i| (self.mesh.positions[v as usize][i] - lattice.origin[i]) / size))
            .collect();
        let holds: Vec<Hold> =
            if holds.is_empty() { Vec::new() } else { self.vertices.iter().map(|&v| holds[v as usize]).collect() };
        let wishes = Wishes { effort: self.options.effort, fine: true, longest, holds: &holds, reach, may_filter };
        let slid = surface::slide(&self.walked, &points, extent, wishes, self.task)?;
        let form = if is_short { LatticeForm::Short(lattice) } else { LatticeForm::Free(lattice) };
        let header = Header { lattice: form, extent, low: [0; 3], ..self.draft.clone() };
        let mut positions = vec![[0; 3]; self.mesh.positions.len()];
        for (&v, &p) in self.vertices.iter().zip(&slid.positions) {
            positions[v as usize] = p;
        }
        let decoded = positions.iter().map(|&q| header.position(&lattice, q)).collect();
        let decoded = Mesh { positions: decoded, faces: self.mesh.faces.clone(), ..Mesh::default() };
        Ok(Trial { step, slid, header, positions, decoded })
    }

    /// The chunk of a trial.
    pub(super) fn chunks(&self, trial: &Trial) -> Chunks {
        let slide = trial.slid.slide;
        let field = SlideField {
            fine: slide.fine,
            longest: Some(slide.longest).filter(|&l| l < LONGEST_STRETCH),
            filter: slide.filter.map(|filter| filter.0),
        };
        let effort = self.options.effort as u8;
        let chunk = SurfaceChunk::write(effort, &[], false, Some(field), self.census, &self.connectivity, &trial.slid.streams);
        vec![(SurfaceChunk::TAG, chunk)]
    }

    /// What there is to say of a trial.
    pub(super) fn notes(&self, trial: &Trial, notes: &mut Vec<String>) {
        match trial.slid.turned.len() {
            0 => {}
            n => notes.push(format!("{n} faces, of the size of a step, look the other way")),
        }
        if self.mesh.attributes.iter().any(|a| !a.indices.is_empty() || !a.values.is_empty()) {
            notes.push("attributes stay with their vertices, which may have slid along the surface".into());
        }
    }
}
