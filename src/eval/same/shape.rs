//! One of the two meshes that are compared: its corners, what must agree corner by corner, and its colours.

use glam::DVec3;

use crate::mesh::{Corners, Mesh, NONE, Union};
use crate::par;

/// A mesh prepared for the search.
#[derive(Debug)]
pub(super) struct Shape {
    pub(super) corners: Corners,
    /// Positions with numbers in place of NaN and infinities, so that equal ones are at distance zero.
    pub(super) positions: Vec<DVec3>,
    /// Vertices that a face uses, in order.
    pub(super) used: Vec<u32>,
    /// The corner across each two-sided edge.
    pub(super) twin: Vec<u32>,
    /// What must agree corner by corner: size of the face, sides of the edge, whether the two run alike.
    pub(super) kind: Vec<u32>,
    /// Faces joined over two-sided edges, by corner.
    pub(super) piece: Vec<u32>,
    /// Faces joined over vertices, by vertex.
    pub(super) group: Vec<u32>,
    pub(super) groups: usize,
    /// The corners at each vertex: `at[starts[v]..starts[v + 1]]`.
    starts: Vec<u32>,
    at: Vec<u32>,
    /// Vertices that a map can take to each other have the same colour.
    pub(super) colour: Vec<u64>,
}

/// A bijection of 64-bit numbers whose results look random (MurmurHash3's finaliser with Stafford's constants).
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 31)).wrapping_mul(0x7fb5_d329_728e_a185);
    x = (x ^ (x >> 27)).wrapping_mul(0x81da_def4_bc2d_d44d);
    x ^ (x >> 33)
}

impl Shape {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let vertices = mesh.positions.len();
        let corners = Corners::new(vertices, &mesh.faces);
        let plain = |x: f64| match x {
            x if x.is_nan() => 3e300,
            x => x.clamp(-1e300, 1e300),
        };
        let mut starts = vec![0_u32; vertices + 1];
        for &v in corners.vertices() {
            starts[v as usize + 1] += 1;
        }
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut at = vec![0; corners.len()];
        let (mut pieces, mut groups) = (Union::new(corners.face_count()), Union::new(vertices));
        let count = corners.len() as u32;
        for c in 0..count {
            let slot = &mut next[corners.vertex(c) as usize];
            at[*slot as usize] = c;
            *slot += 1;
            groups.join(corners.vertex(c), corners.vertex(corners.next(c)));
        }
        let twin: Vec<u32> = (0..count).map(|c| corners.twin(c)).collect();
        for c in 0..count {
            if twin[c as usize] != NONE {
                pieces.join(corners.face(c), corners.face(twin[c as usize]));
            }
        }
        let kind = (0..count).map(|c| {
            let (sides, d) = (corners.sides(c).len(), twin[c as usize]);
            let alike = d != NONE && corners.run_alike(c, d);
            let size = corners.of_face(corners.face(c)).len();
            mix((size as u64) << 33 | (sides as u64) << 1 | u64::from(alike)) as u32
        });
        let kind = kind.collect();
        let (piece, _) = pieces.numbered();
        let (group, groups) = groups.numbered();
        Self {
            positions: mesh.positions.iter().map(|p| DVec3::from(p.map(plain))).collect(),
            used: (0..vertices as u32).filter(|&v| starts[v as usize] < starts[v as usize + 1]).collect(),
            twin,
            kind,
            piece: (0..count).map(|c| piece[corners.face(c) as usize]).collect(),
            group,
            groups,
            starts,
            at,
            colour: vec![0; vertices],
            corners,
        }
    }

    /// The corners at vertex `v`.
    pub(super) fn at(&self, v: u32) -> &[u32] {
        &self.at[self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize]
    }

    /// For each corner, in the order of [`Shape::at`], the vertices after and before it, and what its two sides are.
    fn neighbours(&self) -> Vec<(u32, u32, u64)> {
        let sides = |c: u32, p: u32| u64::from(self.kind[c as usize]) << 32 | u64::from(self.kind[p as usize]);
        let of = |&c: &u32| {
            let (next, prev) = (self.corners.next(c), self.corners.prev(c));
            (self.corners.vertex(next), self.corners.vertex(prev), mix(sides(c, prev)))
        };
        self.at.iter().map(of).collect()
    }

    /// One round of refinement: a vertex's next colour tells its colour and those of its neighbours, corner by corner.
    /// Returns the colours of the used vertices, sorted.
    fn refine(&mut self, neighbours: &[(u32, u32, u64)]) -> Vec<u64> {
        let colour = &self.colour;
        let of = |&(next, prev, sides): &(u32, u32, u64)| {
            let (n, p) = (colour[next as usize].wrapping_mul(3), colour[prev as usize].wrapping_mul(5));
            mix(n.wrapping_add(p.rotate_left(17)).wrapping_add(sides))
        };
        let refined = self.used.iter().map(|&v| {
            let corners = self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize;
            let around = neighbours[corners].iter().fold(0_u64, |sum, c| sum.wrapping_add(of(c)));
            mix(colour[v as usize].wrapping_mul(7).wrapping_add(around))
        });
        let mut refined: Vec<u64> = refined.collect();
        for (&v, &x) in self.used.iter().zip(&refined) {
            self.colour[v as usize] = x;
        }
        refined.sort_unstable();
        refined
    }

    /// A number for each group that is the same for groups that a map can take to each other.
    pub(super) fn group_hashes(&self) -> Vec<u64> {
        let mut hashes = vec![0_u64; self.groups];
        for &v in &self.used {
            let h = &mut hashes[self.group[v as usize] as usize];
            *h = h.wrapping_add(mix(self.colour[v as usize] ^ 0x5851_f42d_4c95_7f2d));
        }
        hashes
    }
}

/// Rounds after which colours are good enough to begin a walk: it finds all that is left. Irregular meshes
/// need no more to tell all vertices apart; grids would go on for half their width.
const ROUNDS: usize = 8;

/// Colours both shapes until no round tells more vertices apart. Whether the colours agree, as they must if the
/// connectivity is the same.
pub(super) fn colour(a: &mut Shape, b: &mut Shape) -> bool {
    let (around_a, around_b) = par::join(|| a.neighbours(), || b.neighbours());
    let mut told_apart = 0;
    for _ in 0..ROUNDS {
        let (x, y) = par::join(|| a.refine(&around_a), || b.refine(&around_b));
        if x != y {
            return false;
        }
        let different = x.chunk_by(|p, q| p == q).count();
        if different == told_apart || different == x.len() {
            break;
        }
        told_apart = different;
    }
    true
}
