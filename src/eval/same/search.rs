//! The search for a map of vertices, by walking both surfaces in lockstep.
//!
//! Once one corner of a piece (faces joined over two-sided edges) is set against a corner of the other
//! mesh, everything else in the piece follows: next corner to next corner, across the edge to across
//! the edge, until all is mapped or something disagrees. Pieces that hang together at vertices or
//! edges of many sides form a group, whose pieces are tried one after the other and taken back where
//! they do not fit. Groups share nothing, so which group goes to which is a matching.

use std::collections::{HashMap, VecDeque};

use super::shape::Shape;
use crate::error::{Error, Result};
use crate::geom::PointTree;
use crate::mesh::NONE;
use crate::task::Task;

/// What a search came to.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Found {
    /// For each vertex of the first shape that of the second; [`NONE`] for unused ones.
    Map(Vec<u32>),
    /// Every way was tried.
    Nothing,
    /// There were too many ways to try.
    GaveUp,
}

/// Steps of the walk that a search may take: so many for each corner …
const STEPS_A_CORNER: u64 = 100;

/// … and so many more.
const STEPS_MORE: u64 = 30_000_000;

/// What it costs to find, sort and file a vertex that another one may go to, in steps of the walk.
const STEPS_A_CANDIDATE: u64 = 32;

/// A vertex of the first shape and that of the second.
type Pair = (u32, u32);

/// Why one group does not go to another.
enum Stop {
    Mismatch,
    Budget,
}

pub(super) struct Search<'s> {
    a: &'s Shape,
    b: &'s Shape,
    /// How far a coordinate may move.
    tolerance: Option<f64>,
    tree: &'s PointTree,
    left: u64,
    /// Corners of `a` to corners of `b`, and back; vertices likewise.
    corner: Vec<u32>,
    corner_back: Vec<u32>,
    vertex: Vec<u32>,
    vertex_back: Vec<u32>,
    /// What was set, in order, so that it can be taken back.
    corners_set: Vec<u32>,
    vertices_set: Vec<u32>,
    /// Vertices of `b`, sorted by colour and then by group.
    by_colour: Vec<(u64, u32, u32)>,
    /// Corners and vertices of `a` for which it is planned how they are reached, and pieces that have a place in a plan.
    planned: [Vec<bool>; 3],
    task: &'s Task<'s>,
}

/// Corners that the beginning of a piece may go to, the most likely last, and what was set before it was placed.
struct Choice {
    options: Vec<u32>,
    corners_set: usize,
    vertices_set: usize,
}

impl<'s> Search<'s> {
    /// A search over shapes that are coloured alike. `tree` holds the used vertices of `b`, in their order.
    pub(super) fn new(a: &'s Shape, b: &'s Shape, tree: &'s PointTree, tolerance: Option<f64>, task: &'s Task<'s>) -> Self {
        let key = |&v: &u32| (b.colour[v as usize], b.group[v as usize], v);
        let mut by_colour: Vec<(u64, u32, u32)> = b.used.iter().map(key).collect();
        by_colour.sort_unstable();
        Self {
            a,
            b,
            tolerance,
            tree,
            left: STEPS_MORE + STEPS_A_CORNER * a.corners.len() as u64,
            corner: vec![NONE; a.corners.len()],
            corner_back: vec![NONE; b.corners.len()],
            vertex: vec![NONE; a.positions.len()],
            vertex_back: vec![NONE; b.positions.len()],
            corners_set: Vec::new(),
            vertices_set: Vec::new(),
            by_colour,
            planned: [a.corners.len(), a.positions.len(), a.corners.face_count()].map(|n| vec![false; n]),
            task,
        }
    }

    /// The vertices of `b` with a colour, those of one group together; of one group alone, if it is given.
    fn of_colour(&self, colour: u64, group: Option<u32>) -> &[(u64, u32, u32)] {
        let (least, most) = group.map_or((0, u32::MAX), |h| (h, h));
        let from = self.by_colour.partition_point(|x| (x.0, x.1) < (colour, least));
        let to = self.by_colour.partition_point(|x| (x.0, x.1) <= (colour, most));
        &self.by_colour[from..to]
    }

    /// The largest difference of a coordinate.
    fn moved(&self, v: u32, w: u32) -> f64 {
        (self.a.positions[v as usize] - self.b.positions[w as usize]).abs().max_element()
    }

    fn may_move(&self, v: u32, w: u32) -> bool {
        self.tolerance.is_none_or(|most| self.moved(v, w) <= most)
    }

    /// Takes back everything after the first so many corners and vertices.
    fn undo(&mut self, corners: usize, vertices: usize) {
        for c in self.corners_set.drain(corners..) {
            self.corner_back[self.corner[c as usize] as usize] = NONE;
            self.corner[c as usize] = NONE;
        }
        for v in self.vertices_set.drain(vertices..) {
            self.vertex_back[self.vertex[v as usize] as usize] = NONE;
            self.vertex[v as usize] = NONE;
        }
    }

    /// Maps the piece of corner `a0` so that `a0` goes to `b0`.
    fn walk(&mut self, a0: u32, b0: u32) -> Result<(), Stop> {
        let mut open = vec![(a0, b0)];
        while let Some((c, d)) = open.pop() {
            self.left = self.left.checked_sub(1).ok_or(Stop::Budget)?;
            if self.corner[c as usize] != NONE || self.corner_back[d as usize] != NONE {
                if self.corner[c as usize] != d {
                    return Err(Stop::Mismatch);
                }
                continue;
            }
            if self.a.kind[c as usize] != self.b.kind[d as usize] {
                return Err(Stop::Mismatch);
            }
            let (v, w) = (self.a.corners.vertex(c), self.b.corners.vertex(d));
            if self.vertex[v as usize] != w {
                let taken = self.vertex[v as usize] != NONE || self.vertex_back[w as usize] != NONE;
                if taken || self.a.colour[v as usize] != self.b.colour[w as usize] || !self.may_move(v, w) {
                    return Err(Stop::Mismatch);
                }
                self.vertex[v as usize] = w;
                self.vertex_back[w as usize] = v;
                self.vertices_set.push(v);
            }
            self.corner[c as usize] = d;
            self.corner_back[d as usize] = c;
            self.corners_set.push(c);
            let twin = self.a.twin[c as usize];
            if twin != NONE {
                // Equal kinds: the other corner has a twin too.
                open.push((twin, self.b.twin[d as usize]));
            }
            open.push((self.a.corners.next(c), self.b.corners.next(d)));
        }
        Ok(())
    }

    /// The corners of `b` at `candidates` that corner `c` may go to, the nearest last.
    fn options(&self, c: u32, candidates: impl Iterator<Item = u32>) -> Vec<u32> {
        let (a, b) = (&self.a.corners, &self.b.corners);
        let around = |x: &super::Shape, c: u32| {
            [x.corners.vertex(c), x.corners.vertex(x.corners.next(c)), x.corners.vertex(x.corners.prev(c))]
        };
        let mine = around(self.a, c);
        let mut options = Vec::new();
        // A triangle that hangs on nothing but its vertices may as well go to any of several equal ones.
        let loose = a.of_face(a.face(c)).len() == 3 && self.is_loose(c);
        let mut seen = Vec::new();
        for d in candidates.flat_map(|w| self.b.at(w)).copied() {
            let theirs = around(self.b, d);
            let fits = self.corner_back[d as usize] == NONE
                && self.a.kind[c as usize] == self.b.kind[d as usize]
                && self.a.kind[a.prev(c) as usize] == self.b.kind[b.prev(d) as usize]
                && mine.iter().zip(&theirs).all(|(&v, &w)| {
                    let (to, from) = (self.vertex[v as usize], self.vertex_back[w as usize]);
                    let free = if to == NONE { from == NONE } else { to == w };
                    free && self.a.colour[v as usize] == self.b.colour[w as usize] && self.may_move(v, w)
                });
            if !fits {
                continue;
            }
            if loose {
                if seen.contains(&theirs) {
                    continue;
                }
                seen.push(theirs);
            }
            let moved: f64 = mine.iter().zip(&theirs).map(|(&v, &w)| self.moved(v, w)).sum();
            options.push((moved, d));
        }
        options.sort_by(|x, y| y.0.total_cmp(&x.0).then(y.1.cmp(&x.1)));
        options.into_iter().map(|(_, d)| d).collect()
    }

    /// Whether no side of the face of `c` has a twin.
    fn is_loose(&self, c: u32) -> bool {
        let mut d = c;
        loop {
            if self.a.twin[d as usize] != NONE {
                return false;
            }
            d = self.a.corners.next(d);
            if d == c {
                return true;
            }
        }
    }

    /// Where to begin each piece of a group, in an order in which every piece but the first hangs on an earlier one.
    fn plan(&mut self, seed: u32) -> Vec<u32> {
        let a = self.a;
        let [met, seen, placed] = &mut self.planned;
        let mut starts = Vec::new();
        // Corners whose piece is to be placed, first come, first served.
        let mut queue = VecDeque::from([seed]);
        while let Some(start) = queue.pop_front() {
            if std::mem::replace(&mut placed[a.piece[start as usize] as usize], true) {
                continue;
            }
            starts.push(start);
            met[start as usize] = true;
            let mut open = vec![start];
            while let Some(c) = open.pop() {
                let v = a.corners.vertex(c);
                if !std::mem::replace(&mut seen[v as usize], true) {
                    queue.extend(a.at(v).iter().filter(|&&d| !placed[a.piece[d as usize] as usize]));
                }
                for d in [a.corners.next(c), a.twin[c as usize]] {
                    if d != NONE && !std::mem::replace(&mut met[d as usize], true) {
                        open.push(d);
                    }
                }
            }
        }
        starts
    }

    /// Maps the group whose pieces begin at `starts`, the first of them going to one of `seeds`. Leaves nothing set.
    fn map_group(&mut self, starts: &[u32], seeds: &[u32]) -> Result<Vec<Pair>, Stop> {
        let mut choices: Vec<Choice> = Vec::with_capacity(starts.len());
        loop {
            if self.task.is_over() {
                return Err(Stop::Budget);
            }
            if let Some(&start) = starts.get(choices.len()) {
                let v = self.a.corners.vertex(start);
                let options = match self.vertex[v as usize] {
                    NONE => self.options(start, seeds.iter().copied()),
                    w => self.options(start, std::iter::once(w)),
                };
                self.left = self.left.saturating_sub(options.len() as u64 + 1);
                choices.push(Choice { options, corners_set: self.corners_set.len(), vertices_set: self.vertices_set.len() });
            }
            // Move on with the last choice that has an option left.
            loop {
                let depth = choices.len();
                let Some(choice) = choices.last_mut() else { return Err(Stop::Mismatch) };
                let (corners, vertices, option) = (choice.corners_set, choice.vertices_set, choice.options.pop());
                self.undo(corners, vertices);
                let Some(d) = option else {
                    choices.pop();
                    continue;
                };
                match self.walk(starts[depth - 1], d) {
                    Ok(()) => break,
                    Err(Stop::Mismatch) => {}
                    Err(Stop::Budget) => {
                        self.undo(0, 0);
                        return Err(Stop::Budget);
                    }
                }
            }
            if choices.len() == starts.len() {
                let map = self.vertices_set.iter().map(|&v| (v, self.vertex[v as usize])).collect();
                self.undo(0, 0);
                return Ok(map);
            }
        }
    }

    /// Looks for a map of all groups.
    pub(super) fn run(mut self) -> Result<Found> {
        let mut matching = Matching::new(&self);
        for group in std::mem::take(&mut matching.largest_first) {
            match matching.place(group, &mut self) {
                Ok(()) => {}
                Err(Stop::Mismatch) => return Ok(Found::Nothing),
                Err(Stop::Budget) if self.task.is_over() => return Err(Error::Cancelled),
                Err(Stop::Budget) => return Ok(Found::GaveUp),
            }
        }
        let mut map = vec![NONE; self.a.positions.len()];
        for (g, h) in matching.place_of.iter().enumerate() {
            if let Some(pairs) = h.and_then(|h| matching.tried.get(&(g as u32, h))?.as_ref()) {
                for &(v, w) in pairs {
                    map[v as usize] = w;
                }
            }
        }
        Ok(Found::Map(map))
    }
}

/// Which group of `b` each group of `a` goes to.
struct Matching {
    largest_first: Vec<u32>,
    /// A corner at each group's vertex of the rarest colour.
    seeds: Vec<u32>,
    hashes: [Vec<u64>; 2],
    /// Groups of `b` by hash.
    by_hash: HashMap<u64, Vec<u32>>,
    plans: HashMap<u32, Vec<u32>>,
    /// For pairs that were tried, the map.
    tried: HashMap<(u32, u32), Option<Vec<Pair>>>,
    /// For each group of `b` the one that goes there.
    taken_by: Vec<Option<u32>>,
    /// For each group of `a` where it goes.
    place_of: Vec<Option<u32>>,
}

impl Matching {
    fn new(search: &Search<'_>) -> Self {
        let (a, b) = (search.a, search.b);
        let hashes = [a.group_hashes(), b.group_hashes()];
        let mut sizes = vec![0_u32; a.groups];
        let mut rarest = vec![(usize::MAX, NONE); a.groups];
        for &v in &a.used {
            let g = a.group[v as usize] as usize;
            sizes[g] += a.at(v).len() as u32;
            rarest[g] = rarest[g].min((search.of_colour(a.colour[v as usize], None).len(), v));
        }
        let mut by_hash: HashMap<u64, Vec<u32>> = HashMap::new();
        let mut has_faces = vec![false; b.groups];
        for &w in &b.used {
            let h = b.group[w as usize];
            if !std::mem::replace(&mut has_faces[h as usize], true) {
                by_hash.entry(hashes[1][h as usize]).or_default().push(h);
            }
        }
        let mut largest_first: Vec<u32> = (0..a.groups as u32).filter(|&g| sizes[g as usize] > 0).collect();
        largest_first.sort_by_key(|&g| (std::cmp::Reverse(sizes[g as usize]), g));
        let seeds = rarest.iter().map(|&(_, v)| if v == NONE { NONE } else { a.at(v)[0] }).collect();
        Self {
            largest_first,
            seeds,
            hashes,
            by_hash,
            plans: HashMap::new(),
            tried: HashMap::new(),
            taken_by: vec![None; b.groups],
            place_of: vec![None; a.groups],
        }
    }

    /// Groups of `b` that group `g` may go to, the nearest first, each with the vertices its seed may go to.
    fn candidates(&self, g: u32, search: &mut Search<'_>) -> Result<Vec<(u32, Vec<u32>)>, Stop> {
        /// So many vertices of a colour are looked through one by one.
        const FEW: usize = 64;
        let (a, b) = (search.a, search.b);
        let v = a.corners.vertex(self.seeds[g as usize]);
        let (colour, hash) = (a.colour[v as usize], self.hashes[0][g as usize]);
        let alike = search.of_colour(colour, None);
        let mut near: Vec<u32> = Vec::new();
        if search.tolerance.is_none() && alike.len() <= FEW {
            near.extend(alike.iter().map(|x| x.2));
        } else {
            let p = a.positions[v as usize];
            let radius = search.tolerance.unwrap_or_else(|| search.tree.nearest(p).map_or(0.0, |(_, d)| 2.0 * d));
            // Without a tolerance these are only the first to be tried, and a few will do.
            let (most, cost) = if search.tolerance.is_some() { (usize::MAX, STEPS_A_CANDIDATE) } else { (FEW, 1) };
            let left = &mut search.left;
            search.tree.within(p, radius, |i| {
                near.push(b.used[i as usize]);
                *left = left.saturating_sub(cost);
                *left > 0 && near.len() < most
            });
            if search.left == 0 {
                return Err(Stop::Budget);
            }
        }
        near.retain(|&w| {
            let h = b.group[w as usize] as usize;
            b.colour[w as usize] == colour && self.hashes[1][h] == hash && search.may_move(v, w)
        });
        near.sort_by(|&x, &y| search.moved(v, x).total_cmp(&search.moved(v, y)).then(x.cmp(&y)));
        let mut groups: Vec<(u32, Vec<u32>)> = Vec::new();
        let mut index: HashMap<u32, usize> = HashMap::new();
        for w in near {
            let h = b.group[w as usize];
            let i = *index.entry(h).or_insert(groups.len());
            if i == groups.len() {
                groups.push((h, Vec::new()));
            }
            groups[i].1.push(w);
        }
        Ok(groups)
    }

    /// Whether `g` can go to `h`, its seed to one of `seeds`.
    fn fits(&mut self, g: u32, h: u32, seeds: &[u32], search: &mut Search<'_>) -> Result<bool, Stop> {
        if let Some(known) = self.tried.get(&(g, h)) {
            return Ok(known.is_some());
        }
        let seed = self.seeds[g as usize];
        let starts = self.plans.entry(g).or_insert_with(|| search.plan(seed));
        let map = match search.map_group(starts, seeds) {
            Ok(map) => Some(map),
            Err(Stop::Mismatch) => None,
            Err(Stop::Budget) => return Err(Stop::Budget),
        };
        let fits = map.is_some();
        self.tried.insert((g, h), map);
        Ok(fits)
    }

    /// The vertices of group `h` that have the colour of the seed of `g`.
    fn seeds_in(&self, g: u32, h: u32, search: &Search<'_>) -> Vec<u32> {
        let v = search.a.corners.vertex(self.seeds[g as usize]);
        let colour = search.a.colour[v as usize];
        search.of_colour(colour, Some(h)).iter().map(|x| x.2).collect()
    }

    /// Finds a place for group `g`; groups placed before may have to give way (Kuhn 1955).
    fn place(&mut self, g: u32, search: &mut Search<'_>) -> Result<(), Stop> {
        // Breadth first from `g`: groups of `a` that look for a place, and how each was reached.
        let mut asked_by: HashMap<u32, u32> = HashMap::new();
        let mut queue = VecDeque::from([g]);
        while let Some(asking) = queue.pop_front() {
            let near = self.candidates(asking, search)?;
            // Free places first, so that nobody has to move; where positions do not count, nobody ever has to.
            let may_ask = search.tolerance.is_some();
            for want_free in [true, false] {
                for (h, seeds) in near.iter().filter(|_| want_free || may_ask) {
                    if self.taken_by[*h as usize].is_none() == want_free
                        && !asked_by.contains_key(h)
                        && self.try_place(asking, *h, seeds, &mut asked_by, &mut queue, search)?
                    {
                        return Ok(());
                    }
                }
            }
            if !may_ask && self.place_anywhere(asking, &mut asked_by, &mut queue, search)? {
                return Ok(());
            }
        }
        Err(Stop::Mismatch)
    }

    /// Puts `asking` into `h` if it fits and `h` is free, moving up everyone on the way; otherwise asks who is there.
    fn try_place(
        &mut self,
        asking: u32,
        h: u32,
        seeds: &[u32],
        asked_by: &mut HashMap<u32, u32>,
        queue: &mut VecDeque<u32>,
        search: &mut Search<'_>,
    ) -> Result<bool, Stop> {
        if !self.fits(asking, h, seeds, search)? {
            return Ok(false);
        }
        asked_by.insert(h, asking);
        if let Some(owner) = self.taken_by[h as usize] {
            queue.push_back(owner);
            return Ok(false);
        }
        let mut place = h;
        loop {
            let mover = asked_by[&place];
            self.taken_by[place as usize] = Some(mover);
            match self.place_of[mover as usize].replace(place) {
                Some(left) => place = left,
                None => return Ok(true),
            }
        }
    }

    /// Puts `asking` into any free group of the same colours.
    fn place_anywhere(
        &mut self,
        asking: u32,
        asked_by: &mut HashMap<u32, u32>,
        queue: &mut VecDeque<u32>,
        search: &mut Search<'_>,
    ) -> Result<bool, Stop> {
        let hash = self.hashes[0][asking as usize];
        let mut others = self.by_hash.remove(&hash).unwrap_or_default();
        while others.last().is_some_and(|&h| self.taken_by[h as usize].is_some()) {
            others.pop();
        }
        let mut placed = Ok(false);
        for &h in others.iter().rev() {
            if self.taken_by[h as usize].is_none() {
                let seeds = self.seeds_in(asking, h, search);
                placed = self.try_place(asking, h, &seeds, asked_by, queue, search);
                if !matches!(placed, Ok(false)) {
                    break;
                }
            }
        }
        self.by_hash.insert(hash, others);
        placed
    }
}
