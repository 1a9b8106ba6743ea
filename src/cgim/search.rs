//! The search for a small V-matrix: many disks and sweeps, of which the smallest matrix is kept.
//!
//! The first half of the trials is spread at random, the second half varies the best ones so far.
//! Trials run in batches, and a batch knows only what earlier batches found, so the outcome is the
//! same for any number of threads.

use super::align::{Contact, align, width};
use super::open::{Disk, Opening, Piece, Recipe};
use super::paper::{align_as_printed, remove_as_printed};
use super::rng::Random;
use super::shrink::shrink;
use super::stratify::stratify;
use super::vmatrix::VMatrix;
use crate::error::{Error, Result};
use crate::par;
use crate::plane::Levels;
use crate::task::Task;

/// How hard to look.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Search {
    /// How many sweeps to try; 1: the paper's choice, a quarter of the boundary.
    pub(crate) trials: usize,
    pub(crate) seed: u64,
    /// The paper's α for all trials, or any.
    pub(crate) alpha: Option<u8>,
    /// The share of the components that is passed in a round (see [`Recipe::keep`]) for all trials, or any.
    pub(crate) keep: Option<u8>,
    pub(crate) contact: Contact,
    /// Whether every row stays a level of the sweep, in which no vertex returns: neither shrunk nor laid on its side.
    pub(crate) simple: bool,
    /// Whether levels are aligned as the paper does it.
    pub(crate) as_printed: bool,
}

impl Default for Search {
    fn default() -> Self {
        let contact = Contact::Slash;
        Self { trials: 1, seed: 0, alpha: None, keep: None, contact, simple: false, as_printed: false }
    }
}

/// A disk and its matrix.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) recipe: Recipe,
    pub(crate) disk: Disk,
    /// Entries are vertices of the disk.
    pub(crate) matrix: VMatrix,
    /// Whether the matrix holds every triangle turned over.
    pub(crate) mirrored: bool,
}

/// Trials that know of each other's outcome only after the batch.
const BATCH: usize = 20;
/// How many of the best are varied.
const PARENTS: usize = 4;

/// The best of the trials. Stops early, with what it has, when the task is over.
pub(crate) fn search(piece: &Piece, search: &Search, task: &Task) -> Result<Found> {
    let mut best: Vec<(u64, Recipe, bool)> = Vec::new();
    let mut done = 0;
    while done < search.trials.max(1) {
        if done > 0 && task.is_over() {
            break;
        }
        let batch = BATCH.min(search.trials.max(1) - done);
        let outcomes = par::map(batch, |i| {
            let recipe = propose(search, piece.origin.len(), done + i, &best);
            let (levels, mirrored) = sweep(piece, &recipe, search)?.1;
            let columns = if search.as_printed { align_as_printed(&levels).columns() } else { width(&levels, search.contact) };
            let area = levels.len() as u64 * columns as u64;
            Ok((area, recipe, mirrored))
        });
        for outcome in outcomes {
            let outcome: Result<_> = outcome;
            best.push(outcome?);
        }
        best.sort_by_key(|&(area, ..)| area);
        best.truncate(PARENTS);
        done += batch;
    }
    let &(_, recipe, _) = best.first().ok_or(Error::Cancelled)?;
    sweep_of(piece, &recipe, search)
}

/// The matrix of one recipe.
pub(crate) fn sweep_of(piece: &Piece, recipe: &Recipe, search: &Search) -> Result<Found> {
    let (disk, (levels, mirrored)) = sweep(piece, recipe, search)?;
    let matrix = match search {
        Search { as_printed: true, .. } => remove_as_printed(&align_as_printed(&levels)),
        Search { simple: true, .. } => align(&levels, search.contact),
        _ => shrink(align(&levels, search.contact), search.contact),
    };
    Ok(Found { recipe: *recipe, disk, matrix, mirrored })
}

/// The levels of a recipe, read in the direction that gives the narrower matrix.
fn sweep(piece: &Piece, recipe: &Recipe, search: &Search) -> Result<(Disk, (Levels, bool))> {
    let disk = piece.open(recipe);
    let levels = stratify(&disk.half_edges, &disk.plan)?;
    let mirrored = levels.mirrored();
    let turn = !search.as_printed && width(&mirrored, search.contact) < width(&levels, search.contact);
    Ok((disk, if turn { (mirrored, true) } else { (levels, false) }))
}

/// The recipe of one trial.
fn propose(search: &Search, vertices: usize, trial: usize, best: &[(u64, Recipe, bool)]) -> Recipe {
    let mut random = Random::new(search.seed, trial as u64);
    if trial == 0 {
        let (alpha, keep) = (search.alpha.unwrap_or(5), search.keep.unwrap_or(255));
        return Recipe { opening: Opening::Plain, alpha, keep, columns: 0, seed: 0, start: 0, length: 1 << 14 };
    }
    if best.is_empty() || trial < search.trials / 2 {
        return scatter(search, vertices, &mut random);
    }
    vary(search, vertices, best[random.below(best.len())].1, &mut random)
}

fn scatter(search: &Search, vertices: usize, random: &mut Random) -> Recipe {
    let mut recipe = Recipe {
        opening: Opening::ALL[random.below(Opening::ALL.len())],
        alpha: search.alpha.unwrap_or(0),
        keep: 255,
        columns: 0,
        seed: random.next() as u8,
        start: random.next() as u16,
        length: ((0.02 + 0.7 * random.unit()) * 65536.0) as u16,
    };
    if search.alpha.is_none() && search.keep.is_none() && random.below(3) > 0 {
        // Good widths were 3 to 16 times the square root of the vertices.
        let wish = (vertices as f64).sqrt() * (2.0 + 18.0 * random.unit().powi(2));
        let fits = |c: &u8| Recipe { columns: *c, ..recipe }.columns() as f64 >= wish;
        recipe.columns = (1..=255).find(fits).unwrap_or(255);
    } else {
        recipe.alpha = search.alpha.unwrap_or(random.below(5) as u8);
        let keep = if random.below(5) == 0 { 255 } else { 38 + random.below(154) as u8 };
        recipe.keep = search.keep.unwrap_or(keep);
    }
    recipe
}

/// One or two of the choices changed.
fn vary(search: &Search, vertices: usize, mut recipe: Recipe, random: &mut Random) -> Recipe {
    let other = scatter(search, vertices, random);
    for _ in 0..1 + random.below(2) {
        match random.below(5) {
            0 => recipe.seed = other.seed,
            1 if recipe.columns > 0 => recipe.columns = recipe.columns.saturating_add_signed(random.below(17) as i8 - 8).max(1),
            1 => recipe.alpha = other.alpha,
            2 if recipe.keep < 255 && search.keep.is_none() => {
                recipe.keep = recipe.keep.saturating_add_signed(random.below(65) as i8 - 32)
            }
            2 => recipe.opening = other.opening,
            3 => recipe.start = recipe.start.wrapping_add_signed((random.below(8192) as i16) - 4096),
            _ => recipe.length = recipe.length.saturating_add_signed((random.below(8192) as i16) - 4096),
        }
    }
    recipe
}
