//! An index map as the words between its rows (spec/mbcim.md, "Ladder form").
//!
//! A map whose columns follow from its words — every V-matrix made here — is its first level and one word a
//! strip. The steps of a word are coded one by one, from left to right:
//!
//! - where top and bottom stand on the same id: both on? else a new id below? else the top on? else an old id below;
//! - elsewhere: the top on? else a new id below? else back to the id above? else the id after that? else an old id.
//!
//! The chances are mixed from what has happened to the ids nearby: how many triangles each has around it so far
//! (a fan of six wants to end), how long an edge has waited, and the last steps.

use crate::entropy::{BitCoder, Mixer, MixerOptions, Start, hash};
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::plane::{Levels, Step};

/// Contexts a decision.
const CONTEXTS: usize = 18;

/// The decisions; each has its own adaptive bits.
mod node {
    /// Both sides go on along a shared edge (asked where they stand on one id).
    pub(super) const BOTH: usize = 0;
    /// The bottom goes on to a new id, from a shared id.
    pub(super) const JOIN: usize = 1;
    /// The top goes on alone, from a shared id.
    pub(super) const LEAVE: usize = 2;
    /// The top goes on.
    pub(super) const TOP: usize = 3;
    /// The bottom goes on to a new id.
    pub(super) const NEW: usize = 4;
    /// The bottom goes on to the id above it.
    pub(super) const BACK: usize = 5;
    /// The bottom goes on to the id after that.
    pub(super) const AHEAD: usize = 6;
    /// The top has ended; the bottom goes on.
    pub(super) const MORE: usize = 7;
    /// The level starts with the id that starts the level above.
    pub(super) const SAME_START: usize = 8;
    /// It starts with a new id.
    pub(super) const NEW_START: usize = 9;
    /// The first level goes on.
    pub(super) const FIRST: usize = 10;
}

/// The sets of weights: one for the start of levels, four for shared edges by how many were kept before, then these.
mod set {
    pub(super) const TOP: usize = 5;
    pub(super) const NEW: usize = 6;
    pub(super) const JOIN: usize = 7;
    pub(super) const RARE: usize = 8;
    pub(super) const ALL: usize = 9;
}

/// The weights that sets 1 to 8 start with, in hundredths: what they came to on average on 16 meshes.
const START: [[i32; CONTEXTS]; set::ALL - 1] = [
    [-1, 1, 37, 2, 9, 7, 9, 10, 14, 6, 6, 6, 36, 13, 32, 15, 1, 7],
    [-2, -7, 17, 1, 8, 9, 4, 23, 21, -1, 2, 13, 20, 5, 42, 16, -3, 10],
    [3, 1, 14, -4, 0, 14, 0, 13, 22, 2, -4, 13, 12, 7, 40, 23, 2, 9],
    [-2, -5, 15, -14, -26, 20, 2, 3, 32, -14, -30, 8, 14, 8, 72, 30, 5, 17],
    [-2, 16, -5, 5, 35, 9, 18, 4, 6, 12, 4, 19, 19, 14, 29, 1, 21, 11],
    [-19, 16, -16, 38, 10, -1, 10, 7, 15, 20, -15, -2, 4, 10, 29, 21, 11, 18],
    [-10, 1, 19, -2, 18, 9, 14, 15, 22, 9, -13, 17, 4, -3, 38, 11, 0, 14],
    [13, 14, 11, 24, 19, 10, 12, 12, 12, 29, 11, 11, 11, 10, 11, 11, 18, 12],
];

/// What a line of a mixer's table takes.
const BYTES_A_LINE: usize = 64;

/// The most a count is told apart.
const MANY: u32 = 15;
/// The farthest that is looked along a level.
const FAR: usize = 20;

/// Codes the levels of one block after another.
pub(crate) struct Ladder {
    mixer: Mixer<CONTEXTS, 0>,
    /// For each id the triangles around it so far.
    closed: Vec<u8>,
    /// For each id the level in which it came.
    born: Vec<u32>,
    level: u32,
    /// The last steps, two bits each, the latest lowest.
    history: u32,
    steps: u64,
}

/// One side of a strip while it is coded.
#[derive(Default)]
struct Row {
    ids: Vec<u32>,
    /// For each edge to the next id, through how many strips it has been kept.
    age: Vec<u8>,
}

/// What a writer knows: the steps that are still to come.
struct Ahead<'a> {
    steps: &'a [Step],
    ids: &'a [u32],
}

impl Ladder {
    /// For maps of about `ids` ids.
    pub(crate) fn new(ids: usize) -> Self {
        let options = MixerOptions { lines_log2: lines_log2(ids), rate_shift: 5, count_limit: 1000 };
        Self { mixer: Mixer::new(options, &starts()), closed: Vec::new(), born: Vec::new(), level: 0, history: 0, steps: 0 }
    }

    /// The memory that the models of [`Ladder::new`] take.
    pub(crate) fn bytes(ids: usize) -> u64 {
        ((CONTEXTS * BYTES_A_LINE) as u64) << lines_log2(ids)
    }

    /// The ids met so far.
    pub(crate) fn ids(&self) -> u32 {
        self.born.len() as u32
    }

    /// Codes one block of `rows` levels. A writer gives the block as `original`; its ids that are not yet met are
    /// numbered on in the order in which they come.
    pub(crate) fn code<C: BitCoder>(
        &mut self,
        coder: &mut C,
        original: Option<&Levels>,
        rows: u32,
        limit: u32,
        budget: &mut Budget,
    ) -> Result<Levels> {
        let mut levels = Levels::default();
        let mut top = Row::default();
        loop {
            let wanted = original.map(|o| o.level(0).len());
            let more = wanted.is_some_and(|n| n > top.ids.len());
            if !top.ids.is_empty() && !self.decide(coder, more, node::FIRST, [0; CONTEXTS], 0) {
                break;
            }
            top.ids.push(self.new_id(limit)?);
            top.age.push(0);
            self.spend(coder, budget, 1)?;
        }
        levels.push_level(top.ids.iter().copied());
        for i in 1..rows as usize {
            self.level += 1;
            let ahead = original.map(|o| Ahead { steps: o.strip(i - 1), ids: o.level(i) });
            let mut word = Vec::new();
            let bottom = self.strip(coder, &top, ahead, &mut word, limit)?;
            self.spend(coder, budget, (word.len() + bottom.ids.len()) as u64)?;
            levels.push_strip(word);
            levels.push_level(bottom.ids.iter().copied());
            top = bottom;
        }
        Ok(levels)
    }

    fn spend<C: BitCoder>(&mut self, coder: &C, budget: &mut Budget, steps: u64) -> Result<()> {
        self.steps += steps;
        if coder.is_exhausted() {
            return Err(malformed(format!("the words end too soon, in level {}", self.level)));
        }
        budget.spend(4 * steps)?;
        budget.reserve(8 * steps)
    }

    fn new_id(&mut self, limit: u32) -> Result<u32> {
        let id = self.born.len() as u32;
        if id >= limit {
            return Err(malformed(format!("the words name more than the {limit} ids of the map")));
        }
        self.born.push(self.level);
        self.closed.push(0);
        Ok(id)
    }

    fn strip<C: BitCoder>(
        &mut self,
        coder: &mut C,
        top: &Row,
        ahead: Option<Ahead<'_>>,
        word: &mut Vec<Step>,
        limit: u32,
    ) -> Result<Row> {
        let mut bottom = Row::default();
        let wanted = |p: usize| ahead.as_ref().and_then(|a| a.ids.get(p).copied());
        let first = wanted(0);
        let start = if self.decide(coder, first == Some(top.ids[0]), node::SAME_START, [0; CONTEXTS], 0) {
            top.ids[0]
        } else if self.decide(coder, first == Some(self.ids()), node::NEW_START, [0; CONTEXTS], 0) {
            self.new_id(limit)?
        } else {
            self.old_id(coder, first)?
        };
        bottom.ids.push(start);
        let mut t = 0;
        // Steps below the current top, and above the current bottom.
        let (mut fan_top, mut fan_bottom) = (0, 0);
        let mut kept = 0;
        loop {
            let next = ahead.as_ref().and_then(|a| a.steps.get(word.len()).copied());
            let (v, w) = (top.ids[t], bottom.ids[bottom.ids.len() - 1]);
            let after = top.ids.get(t + 1).copied();
            let same = v == w;
            let step_on = after.is_some();
            let contexts = self.contexts(top, &bottom, t, fan_top, fan_bottom, kept);
            let waits = 1 + kept.min(3) as usize;
            let target = if next == Some(Step::Bottom) { wanted(bottom.ids.len()) } else { None };
            let is_new = target == Some(self.ids());
            let step = match (same, after) {
                (true, Some(_)) if self.decide(coder, next == Some(Step::Both), node::BOTH, contexts, waits) => Step::Both,
                (true, Some(_)) if self.decide(coder, is_new, node::JOIN, contexts, set::JOIN) => {
                    bottom.ids.push(self.new_id(limit)?);
                    Step::Bottom
                }
                (true, Some(_)) if self.decide(coder, next == Some(Step::Top), node::LEAVE, contexts, set::RARE) => Step::Top,
                (false, Some(_)) if self.decide(coder, next == Some(Step::Top), node::TOP, contexts, set::TOP) => Step::Top,
                (_, None) if !self.decide(coder, next.is_some(), node::MORE, contexts, set::RARE) => break,
                _ => {
                    let id = if !(same && step_on) && self.decide(coder, is_new, node::NEW, contexts, set::NEW) {
                        self.new_id(limit)?
                    } else if !same && self.decide(coder, target == Some(v), node::BACK, contexts, set::RARE) {
                        v
                    } else {
                        match after {
                            Some(u) if u != w && self.decide(coder, target == Some(u), node::AHEAD, contexts, set::RARE) => u,
                            _ => self.old_id(coder, target)?,
                        }
                    };
                    bottom.ids.push(id);
                    Step::Bottom
                }
            };
            word.push(step);
            let kind = match step {
                Step::Both => {
                    kept += 1;
                    bottom.ids.extend(after);
                    bottom.age.push(top.age[t].saturating_add(1));
                    0
                }
                Step::Top => 1,
                Step::Bottom => {
                    bottom.age.push(0);
                    let to = bottom.ids[bottom.ids.len() - 1];
                    if to == v { 3 } else { 2 }
                }
            };
            if step != Step::Both {
                kept = 0;
            }
            self.history = self.history << 2 | kind;
            match step {
                Step::Both => {
                    t += 1;
                    (fan_top, fan_bottom) = (0, 0);
                }
                Step::Top => {
                    if let Some(u) = after {
                        self.close([v, u, w]);
                    }
                    t += 1;
                    fan_top = 0;
                    fan_bottom += 1;
                }
                Step::Bottom => {
                    self.close([v, w, bottom.ids[bottom.ids.len() - 1]]);
                    fan_bottom = 0;
                    fan_top += 1;
                }
            }
        }
        bottom.age.push(0);
        Ok(bottom)
    }

    /// Counts a triangle, if it is one.
    fn close(&mut self, [a, b, c]: [u32; 3]) {
        if a != b && b != c && c != a {
            for v in [a, b, c] {
                self.closed[v as usize] = self.closed[v as usize].saturating_add(1);
            }
        }
    }

    /// An id met before, plainly.
    fn old_id<C: BitCoder>(&self, coder: &mut C, id: Option<u32>) -> Result<u32> {
        let ids = self.ids();
        let bits = 32 - ids.saturating_sub(1).leading_zeros();
        let id = coder.raw(id.unwrap_or(0), bits);
        if id < ids { Ok(id) } else { Err(malformed(format!("id {id} among the first {ids}"))) }
    }

    fn decide<C: BitCoder>(
        &mut self,
        coder: &mut C,
        decision: bool,
        node: usize,
        contexts: [u32; CONTEXTS],
        set: usize,
    ) -> bool {
        self.mixer.choose(contexts, set);
        self.mixer.code(coder, decision, node, [])
    }

    /// What the decision at this place may depend on.
    fn contexts(&self, top: &Row, bottom: &Row, t: usize, fan_top: u32, fan_bottom: u32, kept: u32) -> [u32; CONTEXTS] {
        let last = bottom.ids.len() - 1;
        // Triangles around the vertices of the level above, and of the new one, counted from where we stand.
        let closed = |id: Option<&u32>| id.map_or(MANY, |&id| u32::from(self.closed[id as usize]).min(MANY - 1));
        let above = |k: isize| closed(t.checked_add_signed(k).and_then(|k| top.ids.get(k)));
        let (vm, v, v1, v2) = (above(-1), above(0), above(1), above(2));
        let (w, w0) = (closed(bottom.ids.get(last)), closed(last.checked_sub(1).and_then(|p| bottom.ids.get(p))));
        // How long the edges above have been kept.
        let age = |k: isize| t.checked_add_signed(k).and_then(|k| top.age.get(k)).map_or(MANY, |&a| u32::from(a).min(MANY - 1));
        let class = |k: isize| match age(k) {
            a @ 0..=2 => a,
            3..=5 => 3,
            6..MANY => 4,
            _ => 5,
        };
        let (waits, right, left) = (age(0), far(top.age[t + 1..].iter(), 0), far(top.age[..t].iter().rev(), 0));
        let (nt, nb, kept) = (fan_bottom.min(7), fan_top.min(7), kept.min(MANY));
        let life = (self.level - self.born[top.ids[t] as usize]).min(MANY);
        let h = |k: u32| self.history & ((1 << (2 * k)) - 1);
        let same = u32::from(top.ids[t] == bottom.ids[last]);
        let pack = |parts: &[u32]| parts.iter().fold(same, |sum, &part| hash(sum, part));
        [
            pack(&[v, w]),
            pack(&[v, w, h(1), nb, nt]),
            pack(&[v, v1, waits]),
            pack(&[w, nt, h(2)]),
            pack(&[h(6)]),
            pack(&[v, v1, w, h(1)]),
            pack(&[v, w, w0, h(2)]),
            pack(&[waits, age(1), age(-1), h(1)]),
            pack(&[v, v1, v2, waits, nb]),
            pack(&[kept, waits, h(2)]),
            pack(&[life, v, w, h(1)]),
            pack(&[h(3), v, w, v1]),
            pack(&[waits, right, left]),
            pack(&[kept, right, waits]),
            pack(&[class(-2), class(-1), class(0), class(1), class(2), class(3), h(1)]),
            pack(&[right, far(top.age[t + 1..].iter(), 1), v, w, h(1)]),
            pack(&[vm, v, w, nb]),
            pack(&[v, v1, w, nb, nt, h(2)]),
        ]
    }
}

/// How far the next edge of this age is, at most [`FAR`].
fn far<'a>(ages: impl Iterator<Item = &'a u8>, age: u8) -> u32 {
    ages.take(FAR).position(|&a| a == age).unwrap_or(FAR) as u32
}

fn starts() -> [Start<CONTEXTS, 0>; set::ALL] {
    let mut starts = [Start::even(10); set::ALL];
    starts.iter_mut().skip(1).zip(START).for_each(|(start, weights)| start.contexts = weights);
    starts
}

fn lines_log2(ids: usize) -> u32 {
    ids.max(1).ilog2().clamp(6, 14) + 1
}

fn malformed(why: String) -> Error {
    Error::malformed(Place::Whole, why)
}
