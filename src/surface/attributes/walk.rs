//! The walk over all faces: which values are shared across edges, and what the others are.
//!
//! Faces come in their order. In each, the first side with an earlier face behind it is the gate; corners come from there on
//! around the face. A corner has at most two neighbours that it may share a value with: the corners at its vertex
//! in the faces behind the side that leads to it, and the side that leaves it.

use std::collections::HashMap;

use super::guess::{GUESSES, Guesser, Scene};
use super::octahedral::{Frame, Octahedron};
use super::residual::{CONTEXTS, Residuals, class};
use super::{Form, Ground, NONE, Shape, Values, check, error};
use crate::entropy::{AdaptiveBit, BitCoder, Numbers};
use crate::error::Result;
use crate::mesh::Domain;

/// Faces behind an edge that are looked at, and values of a vertex that are remembered.
const SIDES: usize = 8;
const RANKS: usize = 32;

/// An element that was not met.
const UNMET: u32 = NONE - 1;

/// Writes `known`, or reads.
pub(super) fn walk<C: BitCoder>(coder: &mut C, ground: &Ground<'_>, shape: &Shape, known: &Values) -> Result<Values> {
    let elements = ground.elements(shape.domain);
    let mut walk = Walk {
        coder,
        ground,
        shape,
        known,
        values: Values { integers: Vec::new(), of: vec![UNMET; elements] },
        guesser: Guesser::new(ground, shape),
        models: Models::new(elements),
        newest: if shape.domain == Domain::Corner { vec![NONE; ground.positions.len()] } else { Vec::new() },
        older: Vec::new(),
        strength: Vec::new(),
        followers: HashMap::new(),
        last: NONE,
    };
    for f in 0..ground.corners.face_count() as u32 {
        if shape.domain == Domain::Face {
            walk.face(f)?
        } else {
            walk.corners(f)?
        }
        check(walk.coder)?;
    }
    for e in 0..elements {
        if walk.values.of[e] == UNMET {
            let vertex = if shape.domain == Domain::Corner { ground.faces.corners()[e] } else { e as u32 };
            let mut scene = Scene::new(if shape.domain == Domain::Face { 0 } else { vertex }, NONE);
            scene.near[0] = (walk.last, vertex);
            if ground.positions.is_empty() {
                return Err(error("values of faces without vertices"));
            }
            walk.element(e, &scene, [NONE; 2], 0)?;
            check(walk.coder)?;
        }
    }
    Ok(walk.values)
}

struct Walk<'a, C> {
    coder: &'a mut C,
    ground: &'a Ground<'a>,
    shape: &'a Shape,
    known: &'a Values,
    values: Values,
    guesser: Guesser<'a>,
    models: Models,
    /// The last new value at each vertex, and for each value the one before it at its vertex.
    newest: Vec<u32>,
    older: Vec<u32>,
    /// How large the residual of each value was.
    strength: Vec<u8>,
    /// The value that followed two others.
    followers: HashMap<u64, u32>,
    last: u32,
}

struct Models {
    is_there: [AdaptiveBit; 2],
    /// Sharing with the first neighbour, with the second, with another at the vertex.
    shares: [[AdaptiveBit; 27]; 3],
    rank: Numbers,
    follows: [AdaptiveBit; 32],
    residuals: Residuals,
    is_behind: [AdaptiveBit; 4],
    /// How far off each guess was lately, by how much is known of the face.
    off: [[u64; GUESSES]; 4],
    there: usize,
    followed: usize,
    classes: [i32; 4],
    scratch: Vec<i64>,
}

impl Models {
    fn new(elements: usize) -> Self {
        Self {
            is_there: Default::default(),
            shares: [[AdaptiveBit::default(); 27]; 3],
            rank: Numbers::new(1),
            follows: [AdaptiveBit::default(); 32],
            residuals: Residuals::new(elements),
            is_behind: Default::default(),
            off: [[0; GUESSES]; 4],
            there: 1,
            followed: 0,
            classes: [0; 4],
            scratch: Vec::new(),
        }
    }
}

impl<C: BitCoder> Walk<'_, C> {
    /// The value that an element was given, if it was met and has one.
    fn value_at(&self, element: usize) -> u32 {
        let value = self.values.of[element];
        if value == UNMET { NONE } else { value }
    }

    /// The value at corner `c` of the counted faces.
    fn at(&self, c: u32) -> u32 {
        self.value_at(match self.shape.domain {
            Domain::Corner => self.ground.corner(c),
            _ => self.ground.corners.vertex(c) as usize,
        })
    }

    /// A corner of an earlier face behind the side of `c`: that at `c`'s vertex, and that at the next vertex.
    fn behind(&self, c: u32) -> Option<[u32; 2]> {
        let corners = &self.ground.corners;
        let sides = corners.sides(c).iter().take(SIDES);
        let d = *sides.into_iter().find(|&&d| corners.face(d) < corners.face(c))?;
        Some(if corners.run_alike(c, d) { [d, corners.next(d)] } else { [corners.next(d), d] })
    }

    fn face(&mut self, f: u32) -> Result<()> {
        let corners = &self.ground.corners;
        let n = corners.of_face(f).len() as u32;
        let mut scene = Scene::new(corners.vertex(corners.first(f)), f);
        let mut found = 0;
        for c in corners.first(f)..corners.first(f) + n.min(64) {
            let Some([d, _]) = self.behind(c) else { continue };
            let value = self.value_at(corners.number(corners.face(d)) as usize);
            if value != NONE && found < 2 {
                scene.near[found] = (value, corners.vertex(c));
                found += 1;
            }
        }
        if found == 0 {
            scene.near[0] = (self.last, scene.vertex);
        }
        self.element(corners.number(f) as usize, &scene, [NONE; 2], found)
    }

    fn corners(&mut self, f: u32) -> Result<()> {
        let corners = &self.ground.corners;
        let (first, n) = (corners.first(f), corners.of_face(f).len() as u32);
        let gate = (0..n).find(|&i| self.behind(first + i).is_some()).unwrap_or(0);
        let corner = |i: u32| first + (gate + i) % n;
        // What was before the corner: whether it shared its value across the side that leads here.
        let (mut behind_last, mut seam) = (None::<[u32; 2]>, 0);
        for i in 0..n {
            let c = corner(i);
            let ahead = self.behind(c);
            let element = match self.shape.domain {
                Domain::Corner => self.ground.corner(c),
                _ => corners.vertex(c) as usize,
            };
            if self.values.of[element] == UNMET {
                let candidates = [behind_last.map(|b| b[1]), ahead.map(|b| b[0])].map(|d| d.map_or(NONE, |d| self.at(d)));
                let candidates = if candidates[0] == NONE { [candidates[1], NONE] } else { candidates };
                let scene = self.scene(f, &corner, i);
                self.element(element, &scene, candidates, seam)?;
            }
            // Towards the next corner.
            let value = self.at(c);
            seam = ahead.map_or(0, |[d, _]| if self.at(d) == value { 1 } else { 2 });
            behind_last = ahead;
        }
        Ok(())
    }

    /// What is known at the i-th corner of a face, those before it being known.
    fn scene(&self, f: u32, corner: &impl Fn(u32) -> u32, i: u32) -> Scene {
        let corners = &self.ground.corners;
        let mut scene = Scene::new(corners.vertex(corner(i)), f);
        let near = |c: u32| (self.at(c), corners.vertex(c));
        match i {
            0 => scene.near[0] = (self.last, scene.vertex),
            1 => scene.near[0] = near(corner(0)),
            2 => {
                scene.near = [near(corner(1)), near(corner(0)), (NONE, 0)];
                if let Some([d, e]) = self.behind(corner(0))
                    && (self.at(d), self.at(e)) == (scene.near[1].0, scene.near[0].0)
                {
                    // The third corner of the face behind the gate, beyond its corner at the gate's end.
                    let third = if corners.next(d) == e { corners.prev(d) } else { corners.next(d) };
                    scene.near[2] = near(third);
                    scene.is_across = true;
                }
            }
            _ => {
                // Of three corners the one that is farthest from the line through the first and the last.
                scene.near = [near(corner(i - 1)), near(corner(0)), (NONE, 0)];
                let third = [1, i / 2, i - 2].into_iter().map(corner);
                let third = third.fold((-1.0, corner(1)), |best, c| {
                    let height = self.height(scene.near[0].1, scene.near[1].1, corners.vertex(c));
                    if height > best.0 { (height, c) } else { best }
                });
                scene.near[2] = near(third.1);
            }
        }
        if scene.near[0].0 == NONE {
            scene.near = [(self.last, scene.vertex), (NONE, 0), (NONE, 0)];
        }
        scene
    }

    /// How far `v` is from the line through two others, squared, in squares of their distance.
    fn height(&self, a: u32, b: u32, v: u32) -> f64 {
        let at = |v: u32| self.ground.positions[v as usize].map(f64::from);
        let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let (edge, side) = (minus(at(b), at(a)), minus(at(v), at(a)));
        let cross = |i: usize, j: usize| edge[i] * side[j] - edge[j] * side[i];
        let normal = [cross(1, 2), cross(2, 0), cross(0, 1)];
        normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]
    }

    /// Codes what an element has: nothing, a value of a neighbour, or a new one.
    fn element(&mut self, element: usize, scene: &Scene, candidates: [u32; 2], seam: usize) -> Result<()> {
        let wanted = self.known.of.get(element).copied().unwrap_or(NONE);
        if self.shape.has_gaps {
            let is_there = self.models.is_there[self.models.there].code(self.coder, wanted != NONE);
            self.models.there = usize::from(is_there);
            if !is_there {
                self.values.of[element] = NONE;
                return Ok(());
            }
        }
        let n = self.shape.components;
        let wanted = self.known.integers.get(wanted as usize * n..(wanted as usize + 1) * n).unwrap_or(&[]);
        if self.shape.domain == Domain::Corner
            && let Some(value) = self.shared(scene.vertex, wanted, candidates, seam)?
        {
            self.values.of[element] = value;
            self.last = value;
            return Ok(());
        }
        let value = self.fresh(scene, wanted, seam)?;
        if self.shape.domain == Domain::Corner {
            self.older.push(std::mem::replace(&mut self.newest[scene.vertex as usize], value));
        }
        self.values.of[element] = value;
        self.last = value;
        Ok(())
    }

    fn is(&self, value: u32, wanted: &[i64]) -> bool {
        let n = self.shape.components;
        C::WRITES && self.values.integers[value as usize * n..(value as usize + 1) * n] == *wanted
    }

    /// The value that is shared with another corner at the vertex, if it is.
    fn shared(&mut self, vertex: u32, wanted: &[i64], [first, second]: [u32; 2], seam: usize) -> Result<Option<u32>> {
        let newest = self.newest[vertex as usize];
        let count = match newest {
            NONE => 0,
            value => 1 + usize::from(self.older[value as usize] != NONE),
        };
        let agree = if first == NONE || second == NONE { 0 } else { 1 + usize::from(first != second) };
        let context = (seam * 3 + agree) * 3 + count;
        if first != NONE {
            let is = self.is(first, wanted);
            if self.models.shares[0][context].code(self.coder, is) {
                return Ok(Some(first));
            }
            if second != NONE && second != first {
                let is = self.is(second, wanted);
                if self.models.shares[1][context].code(self.coder, is) {
                    return Ok(Some(second));
                }
            }
        }
        let (mut others, mut value) = (Vec::new(), newest);
        while value != NONE && others.len() < RANKS {
            if value != first && value != second {
                others.push(value);
            }
            value = self.older[value as usize];
        }
        if others.is_empty() {
            return Ok(None);
        }
        let rank = others.iter().position(|&value| self.is(value, wanted));
        if !self.models.shares[2][context].code(self.coder, rank.is_some()) {
            return Ok(None);
        }
        let rank = if others.len() > 1 { self.models.rank.code(self.coder, rank.unwrap_or(0) as u32, 0) } else { 0 };
        others.get(rank as usize).map(|&value| Some(value)).ok_or_else(|| error("a value that its vertex does not have"))
    }

    /// Codes a new value.
    fn fresh(&mut self, scene: &Scene, wanted: &[i64], seam: usize) -> Result<u32> {
        let n = self.shape.components;
        let value = self.strength.len() as u32;
        let key = self.key(scene);
        let known = scene.near.iter().take_while(|near| near.0 != NONE).count();
        if let Some(&follower) = self.followers.get(&key) {
            let model = self.models.followed * 4 + known;
            let is = self.is(follower, wanted);
            let follows = self.models.follows[model].code(self.coder, is);
            self.models.followed = (2 * self.models.followed + usize::from(follows)) & 7;
            if follows {
                let at = follower as usize * n;
                self.values.integers.extend_from_within(at..at + n);
                self.strength.push(0);
                self.guesser.learn(scene, &self.values, value);
                return Ok(value);
            }
        }
        let mut guesses = std::mem::take(&mut self.models.scratch);
        self.guesser.guess(scene, &self.values, &mut guesses);
        let off = &self.models.off[known];
        let best = (0..GUESSES).fold(0, |best, i| if off[i] < off[best] { i } else { best });
        let strength = self.residual(scene, wanted, &guesses, best, seam)?;
        self.strength.push(strength);
        let at = value as usize * n;
        for (i, off) in self.models.off[known].iter_mut().enumerate() {
            let distance = |(q, p): (&i64, &i64)| q.wrapping_sub(*p).unsigned_abs().min(1 << 48) >> 2;
            let now = self.values.integers[at..].iter().zip(&guesses[i * n..]).map(distance);
            *off = *off - (*off >> 4) + now.fold(0_u64, u64::saturating_add).min(1 << 52);
        }
        self.models.scratch = guesses;
        self.followers.insert(key, value);
        self.guesser.learn(scene, &self.values, value);
        Ok(value)
    }

    /// What a value follows: the two before it.
    fn key(&self, scene: &Scene) -> u64 {
        let n = self.shape.components;
        let mut key = 0xCBF2_9CE4_8422_2325_u64;
        for &(value, _) in scene.near[..2].iter().filter(|near| near.0 != NONE) {
            for &q in &self.values.integers[value as usize * n..(value as usize + 1) * n] {
                key = (key ^ q as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                key ^= key >> 29;
            }
            key = key.wrapping_add(1);
        }
        key
    }

    /// Codes how a value differs from the best guess; returns how much, in few words.
    fn residual(&mut self, scene: &Scene, wanted: &[i64], guesses: &[i64], best: usize, seam: usize) -> Result<u8> {
        let n = self.shape.components;
        let near = [scene.near[0].0, scene.near[1].0].into_iter().filter(|&v| v != NONE);
        let strength = near.map(|v| u32::from(self.strength[v as usize])).max().unwrap_or(20);
        let known = scene.near.iter().take_while(|near| near.0 != NONE).count() as u32;
        let octahedron = if let Form::Octahedral { bits } = self.shape.form { Some(Octahedron::new(bits)) } else { None };
        let frame = octahedron.map(|_| Frame::of([0, 1, 2].map(|i| guesses[best * n + i])));
        let seen = |point: &[i64], i: usize| match &frame {
            Some(frame) => frame.seen([point[0], point[1], point[2]])[i],
            None => point[i],
        };
        let guess = |which: usize, i: usize| seen(&guesses[which % GUESSES * n..], i);
        let (mut before, mut most) = (0_i32, 0);
        let mut point = [0; 3];
        for i in 0..if frame.is_some() { 2 } else { n } {
            let p = guess(best, i);
            let apart = |which: usize| guess(best + which, i).wrapping_sub(p).clamp(-7, 7) as i32;
            let last = self.models.classes[i.min(3)];
            let word =
                |parts: [i32; 4]| parts.iter().fold(i.min(3) as u32, |h, &x| h.wrapping_mul(67).wrapping_add((x + 65) as u32));
            let (strength, best) = (strength as i32, best as i32);
            let contexts: [u32; CONTEXTS] = [
                word([strength, 0, 0, 0]),
                word([strength / 2, before, 1, known as i32]),
                word([apart(1), apart(2), 2, best]),
                word([apart(3), before, 3, best]),
                word([last, strength, 4, seam as i32]),
                word([best, known as i32, before.signum(), 5]),
            ];
            let residual = if C::WRITES { seen(wanted, i).wrapping_sub(p) } else { 0 };
            let residual = self.models.residuals.code(self.coder, residual, i, contexts);
            let q = p.wrapping_add(residual);
            before = class(residual);
            self.models.classes[i.min(3)] = before;
            most = most.max(before.unsigned_abs());
            match frame {
                Some(_) => point[i] = q,
                None => self.values.integers.push(q),
            }
        }
        if let (Some(octahedron), Some(frame)) = (octahedron, frame) {
            let (x, y) = (point[0].unsigned_abs(), point[1].unsigned_abs());
            let Some(z) = x.checked_add(y).and_then(|sum| (octahedron.n() as u64).checked_sub(sum)) else {
                return Err(error("a normal beyond the octahedron"));
            };
            let is_behind = z > 0 && {
                let is = C::WRITES && seen(wanted, 2) < 0;
                self.models.is_behind[(most as usize).min(3)].code(self.coder, is)
            };
            point[2] = if is_behind { -(z as i64) } else { z as i64 };
            self.values.integers.extend(frame.unseen(point));
        }
        Ok(most.min(63) as u8)
    }
}
