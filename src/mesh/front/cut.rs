//! Polygons to triangles, along diagonals that the mesh does not have as edges.
//!
//! A polygon is cut in a zigzag from an *ear*: (n−1, 0, 1), (n−1, 1, n−2), (1, 2, n−2), … so that no corner collects
//! many diagonals. Ears are put where vertices have many edges already.

use std::collections::HashSet;

use super::super::Corners;
use super::super::half_edge::NONE;

/// Ears that are tried before a polygon is given up.
const TRIES: usize = 32;

pub(super) struct Cut {
    /// In vertices of the mesh; turned over where the face is.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The counted face of each triangle.
    pub(super) face: Vec<u32>,
    /// Glued along diagonals only.
    pub(super) opposite: Vec<u32>,
    /// The half-edge on each corner's side.
    pub(super) side: Vec<u32>,
    /// Faces that cannot be cut without an edge that is there already.
    pub(super) uncut: Vec<u32>,
}

pub(super) fn cut(corners: &Corners, flips: &[bool]) -> Cut {
    let count = corners.len() - 2 * corners.face_count();
    let mut this = Cut {
        triangles: Vec::with_capacity(count),
        face: Vec::with_capacity(count),
        opposite: Vec::with_capacity(3 * count),
        side: vec![NONE; corners.len()],
        uncut: Vec::new(),
    };
    let mut taken = Taken::new(corners);
    let (mut polygon, mut zigzag) = (Vec::new(), Vec::new());
    let mut start = 0_u32;
    for (f, &flip) in flips.iter().enumerate() {
        let n = corners.of_face(f as u32).len();
        let first = start;
        start += n as u32;
        // The corners in the order in which the oriented face has them; `side_of[i]` is the side from corner i to the next.
        polygon.clear();
        polygon.extend((0..n as u32).map(|i| if flip { first + n as u32 - 1 - i } else { first + i }));
        let side_after = |i: usize| if flip { first + ((2 * n - 2 - i) % n) as u32 } else { polygon[i] };
        if n == 3 {
            let h = this.triangle(corners, f, [polygon[0], polygon[1], polygon[2]]);
            (0..3).for_each(|i| this.side[side_after(i) as usize] = h + i as u32);
            continue;
        }
        let Some(ear) = taken.choose(corners, &polygon, &mut zigzag) else {
            this.uncut.push(f as u32);
            continue;
        };
        let at = |i: usize| (ear + i) % n;
        let mut diagonal = NONE;
        for (turn, &[a, b, c]) in zigzag.iter().enumerate() {
            let h = this.triangle(corners, f, [polygon[at(a)], polygon[at(b)], polygon[at(c)]]);
            for (i, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
                if (from + 1) % n == to {
                    this.side[side_after(at(from)) as usize] = h + i as u32;
                }
            }
            // A triangle is glued to the one before it along its first half-edge.
            if diagonal != NONE {
                this.opposite[diagonal as usize] = h;
                this.opposite[h as usize] = diagonal;
            }
            diagonal = if turn % 2 == 0 { h + 2 } else { h + 1 };
        }
    }
    this
}

impl Cut {
    fn triangle(&mut self, corners: &Corners, f: usize, at: [u32; 3]) -> u32 {
        let h = self.opposite.len() as u32;
        self.triangles.push(at.map(|c| corners.vertex(c)));
        self.face.push(f as u32);
        self.opposite.extend([NONE; 3]);
        h
    }
}

/// Which vertices are joined, and how often each is.
struct Taken {
    diagonals: HashSet<(u32, u32)>,
    degree: Vec<u32>,
    /// All edges of the mesh, sorted; empty if there are only triangles.
    edges: Vec<(u32, u32)>,
}

impl Taken {
    fn new(corners: &Corners) -> Self {
        let mut this = Self { diagonals: HashSet::new(), degree: Vec::new(), edges: Vec::new() };
        if corners.len() == 3 * corners.face_count() {
            return this;
        }
        let most = corners.vertices().iter().max().map_or(0, |&v| v as usize + 1);
        this.degree = vec![0; most];
        for edge in corners.edges() {
            let (a, b) = (corners.vertex(edge[0]), corners.vertex(corners.next(edge[0])));
            this.edges.push((a.min(b), a.max(b)));
            this.degree[a as usize] += 1;
            this.degree[b as usize] += 1;
        }
        this
    }

    /// The best ear whose diagonals are all free, with the triangles of its zigzag.
    fn choose(&mut self, corners: &Corners, polygon: &[u32], zigzag: &mut Vec<[usize; 3]>) -> Option<usize> {
        let n = polygon.len();
        triangulate(n, zigzag);
        let v = |i: usize| corners.vertex(polygon[i % n]);
        let mut ears: Vec<(u32, usize)> = (0..if n == 4 { 2 } else { n })
            .map(|i| {
                let degree = |i: usize| self.degree[v(i) as usize];
                let load = if n == 4 { degree(i) + degree(i + 2) } else { degree(i) };
                (u32::MAX - load, i)
            })
            .collect();
        ears.sort_unstable();
        let ear = ears.into_iter().take(TRIES).map(|e| e.1).find(|&ear| {
            diagonals(zigzag).all(|(a, b)| {
                let key = (v(ear + a).min(v(ear + b)), v(ear + a).max(v(ear + b)));
                !self.diagonals.contains(&key) && self.edges.binary_search(&key).is_err()
            })
        })?;
        for (a, b) in diagonals(zigzag) {
            let (a, b) = (v(ear + a), v(ear + b));
            self.diagonals.insert((a.min(b), a.max(b)));
            self.degree[a as usize] += 1;
            self.degree[b as usize] += 1;
        }
        Some(ear)
    }
}

/// The zigzag of a polygon of `n` corners from the ear 0.
fn triangulate(n: usize, zigzag: &mut Vec<[usize; 3]>) {
    zigzag.clear();
    let (mut low, mut high) = (0, n - 1);
    let mut from_low = true;
    while high - low >= 2 {
        if from_low {
            zigzag.push([high, low, low + 1]);
            low += 1;
        } else {
            zigzag.push([high, low, high - 1]);
            high -= 1;
        }
        from_low = !from_low;
    }
}

/// The diagonals of a zigzag: what every triangle but the last leaves open.
fn diagonals(zigzag: &[[usize; 3]]) -> impl Iterator<Item = (usize, usize)> + '_ {
    zigzag.iter().take(zigzag.len() - 1).enumerate().map(
        |(i, &[high, low, third])| {
            if i % 2 == 0 { (third, high) } else { (low, third) }
        },
    )
}
