//! Stratify (CGIM §4.1; steps 2–14 of §4.3 and lines 3–22 of Algorithm 2): orders a disk into levels.
//!
//! As in the paper, a level is a path across the disk, and the next level takes in the vertices just
//! below it, save those that would be joined to the level in more than one place ("irregular
//! pairs"). Printed as it is, the construction fails on most disks that have ears, chords or
//! separating triangles (`spec/readings.md`, stratify, says where). Done otherwise here:
//!
//! - the front of the sweep is kept as half-edges, and *triangles* are counted, not vertices: the
//!   sweep ends when every triangle has been passed;
//! - a vertex is taken in only if it touches the level in one contiguous stretch. That is looked for
//!   in the whole level, and it makes components that overlap, run backwards or repeat a vertex impossible;
//! - a triangle between three consecutive vertices of the level (an ear) is passed without a new vertex;
//! - the end of a level is dropped when the *edge* that leads down from it lies on the boundary.
//!
//! A round of the sweep:
//!
//! 1. list the triangles that hang on the level, from left to right;
//! 2. mark those whose new vertices may be taken in, less the fans that α thins out;
//! 3. pass maximal runs ("components") of marked triangles, and all ears; go along everywhere else.
//!
//! Some triangle is passed in every round: a vertex that may not be taken in closes off a pocket of
//! the disk together with the level, and an innermost pocket has an ear or a vertex that may.

use super::rng::Random;
use super::room::Room;
use crate::error::{Error, Result};
use crate::mesh::{HalfEdges, NONE, next, prev};
use crate::plane::{Levels, Step};

/// What decides the shape of the levels.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plan {
    /// The first level: consecutive boundary half-edges.
    pub(crate) start: Vec<u32>,
    /// The paper's α: a vertex of the level below which at least so many new edges would hang one
    /// beside the other stays in the level for another round. 0: never.
    pub(crate) alpha: usize,
    /// The share of the components that is passed in one round, the others wait. 1: all.
    pub(crate) keep: f64,
    /// How many columns the sweep should do with, as far as it can; 0: no matter.
    pub(crate) columns: usize,
    /// Which components wait.
    pub(crate) seed: u64,
    /// Whether the ends of the levels may walk along the boundary (step 13). If not, they stay
    /// where the first level has them.
    pub(crate) drop_ends: bool,
}

/// The levels of a disk, each triangle of which lies in exactly one strip.
///
/// O(triangles + sum of the level lengths).
///
/// # Errors
/// If the sweep cannot pass all triangles, which no disk is known to bring about.
pub(crate) fn stratify(disk: &HalfEdges, plan: &Plan) -> Result<Levels> {
    let mut sweep = Sweep::new(disk, plan);
    let mut levels = Levels::default();
    levels.push_level(sweep.path.iter().copied());
    let mut left = disk.triangles().len();
    while left > 0 {
        sweep.list_hanging();
        sweep.mark();
        let mut passed = sweep.advance();
        while passed == 0 && sweep.widen() {
            sweep.list_hanging();
            sweep.mark();
            passed = sweep.advance();
        }
        if passed == 0 {
            return Err(Error::NoConvergence { what: "stratify", after: levels.len(), residual: left as f64 });
        }
        left -= passed;
        levels.push_strip(sweep.word.iter().copied());
        levels.push_level(sweep.path.iter().copied());
    }
    Ok(levels)
}

/// What hangs on the level at its `k`-th vertex.
#[derive(Debug, Clone, Copy)]
struct Hanging {
    kind: Kind,
    k: usize,
    /// The new vertices: `left` of both kinds of triangle, `right` of those on a vertex.
    left: u32,
    right: u32,
    triangle: u32,
    /// Whether it may be passed in this round.
    marked: bool,
    /// Whether it does not share an edge with the triangle listed before it.
    apart: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// The triangle below the edge from the `k`-th vertex to the next.
    OnEdge,
    /// A triangle below the `k`-th vertex that has no edge of the level.
    OnVertex,
    /// Nothing below the edge from the `k`-th vertex to the next.
    Nothing,
}

struct Sweep<'a> {
    disk: &'a HalfEdges,
    plan: &'a Plan,
    random: Random,
    /// The current level.
    path: Vec<u32>,
    /// For each edge of the level the half-edge along it whose triangle has not been passed, or [`NONE`].
    below: Vec<u32>,
    /// Where a vertex is in `path`, or [`NONE`].
    position: Vec<u32>,
    /// Vertices that are or were in a level.
    visited: Vec<bool>,
    passed: Vec<bool>,
    /// How many triangles of each vertex have not been passed.
    left_at: Vec<u32>,
    hanging: Vec<Hanging>,
    /// Components that are passed in this round: `[start, end)` in `hanging`.
    components: Vec<(usize, usize)>,
    /// For each vertex the round in which it was asked for last, and the answer.
    asked: Vec<(u32, bool)>,
    round: u32,
    room: Option<Room>,
    weights: Vec<u32>,
    word: Vec<Step>,
    next_path: Vec<u32>,
    next_below: Vec<u32>,
}

impl<'a> Sweep<'a> {
    fn new(disk: &'a HalfEdges, plan: &'a Plan) -> Self {
        let mut path: Vec<u32> = plan.start.iter().map(|&h| disk.from(h)).collect();
        path.extend(plan.start.last().map(|&h| disk.to(h)));
        let mut visited = vec![false; disk.vertices()];
        path.iter().for_each(|&v| visited[v as usize] = true);
        let mut left_at = vec![0; disk.vertices()];
        disk.triangles().iter().flatten().for_each(|&v| left_at[v as usize] += 1);
        Self {
            disk,
            plan,
            random: Random::new(plan.seed, 0),
            below: plan.start.clone(),
            path,
            position: vec![NONE; disk.vertices()],
            visited,
            passed: vec![false; disk.triangles().len()],
            left_at,
            hanging: Vec::new(),
            components: Vec::new(),
            asked: vec![(0, false); disk.vertices()],
            round: 0,
            room: (plan.columns > 0).then(|| Room::new(plan.columns, plan.start.len())),
            weights: Vec::new(),
            word: Vec::new(),
            next_path: Vec::new(),
            next_below: Vec::new(),
        }
    }

    /// The half-edge below edge `k` of the level, if its triangle is still to be passed.
    fn edge_below(&self, k: usize) -> Option<u32> {
        self.below.get(k).copied().filter(|&h| h != NONE)
    }

    /// The half-edge opposite `h`, if its triangle is still to be passed.
    fn across(&self, h: u32) -> Option<u32> {
        self.disk.opposite(h).filter(|&g| !self.passed[g as usize / 3])
    }

    /// Lists the triangles that hang on the level, from left to right.
    fn list_hanging(&mut self) {
        for (k, &v) in self.path.iter().enumerate() {
            self.position[v as usize] = k as u32;
        }
        let mut hanging = std::mem::take(&mut self.hanging);
        hanging.clear();
        for k in 0..self.path.len() {
            let before = k.checked_sub(1).and_then(|k| self.edge_below(k)).map(next);
            if let Some(below) = self.edge_below(k) {
                let first = hanging.len();
                let apart = self.list_fan_leftwards(k, below, before, &mut hanging);
                hanging[first..].reverse();
                let triangle = below / 3;
                let left = self.disk.apex(below);
                hanging.push(Hanging { kind: Kind::OnEdge, k, left, right: NONE, triangle, marked: false, apart: false });
                hanging[first].apart = apart;
            } else {
                if let Some(before) = before {
                    self.list_fan_rightwards(k, before, &mut hanging);
                }
                if k + 1 < self.path.len() {
                    let nothing = Kind::Nothing;
                    hanging.push(Hanging {
                        kind: nothing,
                        k,
                        left: NONE,
                        right: NONE,
                        triangle: NONE,
                        marked: false,
                        apart: true,
                    });
                }
            }
        }
        self.hanging = hanging;
    }

    /// From the triangle below edge `k` about its left end, as far as the triangle below the edge before.
    /// True if the fan ends before that.
    fn list_fan_leftwards(&self, k: usize, below: u32, before: Option<u32>, hanging: &mut Vec<Hanging>) -> bool {
        let mut h = below;
        while Some(h) != before {
            let Some(g) = self.across(prev(h)) else { return true };
            if Some(g) == before {
                break;
            }
            hanging.push(self.on_vertex(k, self.disk.apex(g), self.disk.apex(h), g));
            h = g;
        }
        false
    }

    /// From the triangle below edge `k - 1` about its right end; `h` runs from that end to the apex.
    fn list_fan_rightwards(&self, k: usize, mut h: u32, hanging: &mut Vec<Hanging>) {
        while let Some(g) = self.across(h) {
            h = next(g);
            hanging.push(self.on_vertex(k, self.disk.from(g), self.disk.to(h), g));
        }
    }

    fn on_vertex(&self, k: usize, left: u32, right: u32, h: u32) -> Hanging {
        Hanging { kind: Kind::OnVertex, k, left, right, triangle: h / 3, marked: false, apart: false }
    }

    /// Marks what may be passed, and gathers it into components.
    fn mark(&mut self) {
        self.round += 1;
        let mut hanging = std::mem::take(&mut self.hanging);
        for item in &mut hanging {
            item.marked = match item.kind {
                Kind::OnEdge => self.touches_once(item.left),
                Kind::OnVertex => self.touches_once(item.left) && self.touches_once(item.right),
                Kind::Nothing => false,
            };
        }
        if self.plan.alpha > 0 {
            thin_out(&mut hanging, self.plan.alpha);
        }
        if self.room.is_some() {
            self.make_fit(&mut hanging);
        }
        self.components.clear();
        let mut waiting = Vec::new();
        let mut start = 0;
        while start < hanging.len() {
            let mut end = start + 1;
            if hanging[start].marked {
                while end < hanging.len() && hanging[end].marked && !hanging[end].apart {
                    end += 1;
                }
                if hanging[start..end].iter().any(|item| item.kind == Kind::OnEdge) {
                    let wait = self.plan.keep < 1.0 && self.random.unit() >= self.plan.keep;
                    if wait { &mut waiting } else { &mut self.components }.push((start, end));
                }
            }
            start = end;
        }
        if self.components.is_empty() && !waiting.is_empty() {
            self.components.push(waiting[self.random.below(waiting.len())]);
        }
        self.hanging = hanging;
    }

    /// Unmarks what finds no room below its vertex.
    fn make_fit(&self, hanging: &mut [Hanging]) {
        let Some(room) = &self.room else { return };
        // The first column that is still free in the level to come, if everything goes as far left as it can.
        let mut next = 0;
        let mut k = 0;
        let mut i = 0;
        while i < hanging.len() {
            if !hanging[i].marked {
                i += 1;
                // Kept edges always find room.
                while k < hanging.get(i).map_or(0, |item| item.k) {
                    next = next.max(room.window(k).0) + 1;
                    k += 1;
                }
                continue;
            }
            let end = i + 1 + hanging[i + 1..].iter().take_while(|item| item.marked && !item.apart).count();
            match self.fit(room, &hanging[i..end], next) {
                Ok(free) => {
                    next = free;
                    let last = &hanging[end - 1];
                    k = last.k + usize::from(last.kind == Kind::OnEdge);
                    i = end;
                }
                Err(at) => {
                    // The fan that is in the way waits; the rest is tried again without it.
                    let at = i + at;
                    let narrow = hanging[at].k;
                    let fan = |item: &&mut Hanging| item.k == narrow && item.kind == Kind::OnVertex;
                    let before = hanging[i..at].iter_mut().rev().take_while(|item| fan(item));
                    before.for_each(|item| item.marked = false);
                    hanging[at].marked = false;
                    let after = hanging[at + 1..end].iter_mut().take_while(|item| fan(item));
                    after.for_each(|item| item.marked = false);
                }
            }
        }
    }

    /// The first free column after a component, or the item for which there is no room.
    fn fit(&self, room: &Room, component: &[Hanging], mut next: u32) -> Result<u32, usize> {
        if !component.iter().any(|item| item.kind == Kind::OnEdge) {
            return Err(0);
        }
        let mut take = |k: usize| {
            let (first, end) = room.window(k);
            let x = next.max(first);
            next = x + 1;
            x < end
        };
        if !take(component[0].k) {
            return Err(0);
        }
        let mut k = component[0].k;
        for (i, item) in component.iter().enumerate() {
            match item.kind {
                Kind::OnEdge => k = item.k + 1,
                _ if !take(item.k) => return Err(i),
                _ => {}
            }
        }
        if !take(k) {
            return Err(component.len() - 1);
        }
        Ok(next)
    }

    /// More columns, if their number was what held the sweep up.
    fn widen(&mut self) -> bool {
        self.room.as_mut().map(Room::widen).is_some()
    }

    /// The share of columns that each vertex of the new level would like: one, and one for each triangle still below it.
    fn hand_out_columns(&mut self) {
        let Some(mut room) = self.room.take() else { return };
        let mut weights = std::mem::take(&mut self.weights);
        weights.clear();
        weights.extend(self.next_path.iter().map(|&v| 1 + self.left_at[v as usize]));
        room.advance(&self.word, &weights);
        self.weights = weights;
        self.room = Some(room);
    }

    /// Whether a vertex is new and its neighbours in the level are consecutive there: one more than
    /// the edges of the level that it sees.
    fn touches_once(&mut self, v: u32) -> bool {
        if self.visited[v as usize] {
            return false;
        }
        let (round, answer) = self.asked[v as usize];
        if round == self.round {
            return answer;
        }
        let (mut neighbours, mut edges) = (0, 0);
        let mut last = None;
        for h in self.disk.fan(v) {
            let position = self.position[self.disk.to(h) as usize];
            neighbours += u32::from(position != NONE);
            let far = next(h);
            edges += u32::from(position != NONE && self.edge_below(position as usize) == Some(far));
            last = Some(prev(h));
        }
        // On the boundary, the last neighbour has no outgoing half-edge in the fan.
        if let Some(h) = last.filter(|&h| self.disk.opposite(h).is_none()) {
            neighbours += u32::from(self.position[self.disk.from(h) as usize] != NONE);
        }
        let answer = neighbours == edges + 1;
        self.asked[v as usize] = (self.round, answer);
        answer
    }

    /// Passes the components and the ears. Makes the word and the next level; returns how many triangles were passed.
    fn advance(&mut self) -> usize {
        let hanging = std::mem::take(&mut self.hanging);
        let gathered = std::mem::take(&mut self.components);
        self.word.clear();
        self.next_path.clear();
        self.next_below.clear();
        let last = self.path.len() - 1;
        let mut passed = 0;
        let mut k = 0;
        let drop_left = gathered.first().is_some_and(|&(start, _)| {
            start == 0 && hanging[0].k == 0 && self.may_drop(&hanging[0], hanging[0].left, self.path[0])
        });
        if !drop_left {
            self.next_path.push(self.path[0]);
        }
        let mut components = gathered.iter().peekable();
        let mut i = 0;
        while let Some(item) = hanging.get(i) {
            if let Some(&(start, end)) = components.next_if(|&&(start, _)| start == i) {
                if start == 0 && drop_left {
                    self.next_path.push(item.left);
                } else {
                    self.step_down(item.triangle, self.path[item.k], item.left);
                }
                for item in &hanging[start..end] {
                    self.pass(item.triangle);
                    self.visited[item.left as usize] = true;
                    if item.kind == Kind::OnEdge {
                        self.word.push(Step::Top);
                        k = item.k + 1;
                    } else {
                        self.visited[item.right as usize] = true;
                        self.step_down(item.triangle, item.left, item.right);
                    }
                }
                passed += end - start;
                let right = self.next_path[self.next_path.len() - 1];
                let drop_right = end == hanging.len() && k == last && self.may_drop(&hanging[end - 1], self.path[k], right);
                if !drop_right {
                    self.step_down(hanging[end - 1].triangle, right, self.path[k]);
                }
                i = end;
                continue;
            }
            i += 1;
            if item.kind == Kind::OnVertex {
                continue;
            }
            k = item.k + 1;
            let ear = item.kind == Kind::OnEdge && self.edge_below(k) == Some(next(self.below[item.k]));
            if ear {
                self.pass(item.triangle);
                passed += 1;
                self.word.push(Step::Top);
                self.step_down(item.triangle, self.path[item.k], self.path[k + 1]);
                self.word.push(Step::Top);
                k += 1;
                while hanging.get(i).is_some_and(|item| item.k < k) {
                    i += 1;
                }
            } else {
                self.word.push(Step::Both);
                self.next_below.push(self.below[item.k]);
                self.next_path.push(self.path[k]);
            }
        }
        debug_assert_eq!(k, last, "a round ends at the end of the level");
        for &v in &self.path {
            self.position[v as usize] = NONE;
        }
        for h in &mut self.next_below {
            if *h != NONE && self.passed[*h as usize / 3] {
                *h = NONE;
            }
        }
        if passed > 0 {
            self.hand_out_columns();
        }
        std::mem::swap(&mut self.path, &mut self.next_path);
        std::mem::swap(&mut self.below, &mut self.next_below);
        self.hanging = hanging;
        self.components = gathered;
        passed
    }

    fn pass(&mut self, triangle: u32) {
        self.passed[triangle as usize] = true;
        for v in self.disk.triangles()[triangle as usize] {
            self.left_at[v as usize] -= 1;
        }
    }

    /// The half-edge of `triangle` between two of its vertices, in whichever direction.
    fn edge(&self, triangle: u32, a: u32, b: u32) -> u32 {
        let [h, g, f] = [3 * triangle, 3 * triangle + 1, 3 * triangle + 2];
        let joins = |h: u32| [(a, b), (b, a)].contains(&(self.disk.from(h), self.disk.to(h)));
        if joins(h) {
            h
        } else if joins(g) {
            g
        } else {
            debug_assert!(joins(f), "triangle {triangle} has no edge {a}-{b}");
            f
        }
    }

    /// The lower level goes on along the edge from `a` to `b` of a triangle just passed.
    fn step_down(&mut self, triangle: u32, a: u32, b: u32) {
        self.word.push(Step::Bottom);
        self.next_below.push(self.disk.opposite(self.edge(triangle, a, b)).unwrap_or(NONE));
        self.next_path.push(b);
    }

    /// Whether the edge at the end of a level lies on the boundary, so that the next level may end at its other vertex.
    fn may_drop(&self, item: &Hanging, a: u32, b: u32) -> bool {
        self.plan.drop_ends && self.disk.opposite(self.edge(item.triangle, a, b)).is_none()
    }
}

/// Algorithm 2's thinning: unmarks each run of at least `alpha` marked triangles about one vertex of the level.
fn thin_out(hanging: &mut [Hanging], alpha: usize) {
    for run in hanging.chunk_by_mut(|x, y| x.kind == y.kind && x.k == y.k && x.marked == y.marked) {
        if run[0].kind == Kind::OnVertex && run.len() >= alpha {
            run.iter_mut().for_each(|item| item.marked = false);
        }
    }
}
