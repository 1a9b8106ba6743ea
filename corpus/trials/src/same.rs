//! The slow judge: is one mesh the other, up to the order of vertices, triangles and first corners?
//!
//! Part by part: one triangle of a part is laid onto every triangle of the other mesh with the same corner positions, in all
//! three turns, and the two meshes are walked in lockstep across their edges until they agree everywhere or differ.
//! Equal positions are required, so a part that fits anywhere can stay there.

use std::collections::HashMap;

use corpus_make::Shape;
use gimc::Mesh;

type Corner = (u32, usize);

struct Walkable<'a> {
    positions: &'a [[f64; 3]],
    triangles: &'a [[u32; 3]],
    /// Who walks an edge in this direction.
    sides: HashMap<(u32, u32), Corner>,
}

impl<'a> Walkable<'a> {
    fn new(positions: &'a [[f64; 3]], triangles: &'a [[u32; 3]]) -> Self {
        let mut sides = HashMap::new();
        for (f, t) in triangles.iter().enumerate() {
            for c in 0..3 {
                let before = sides.insert((t[c], t[(c + 1) % 3]), (f as u32, c));
                assert!(before.is_none(), "two triangles walk an edge in the same direction");
            }
        }
        Self { positions, triangles, sides }
    }

    fn vertex(&self, (f, c): Corner) -> u32 {
        self.triangles[f as usize][c % 3]
    }

    fn place(&self, corner: Corner) -> [u64; 3] {
        // −0 and 0 are the same place.
        self.positions[self.vertex(corner) as usize].map(|x| (x + 0.0).to_bits())
    }

    fn across(&self, (f, c): Corner) -> Option<Corner> {
        self.sides.get(&(self.vertex((f, c + 1)), self.vertex((f, c)))).copied()
    }
}

/// Compares `back` with `original`.
///
/// # Panics
/// If they differ.
pub fn assert_same(original: &Shape, back: &Mesh) {
    let triangles = back.faces.triangles();
    let a = Walkable::new(&original.positions, &original.triangles);
    let b = Walkable::new(&back.positions, &triangles);
    assert_eq!(a.positions.len(), b.positions.len(), "vertices");
    assert_eq!(a.triangles.len(), b.triangles.len(), "triangles");
    let mut by_place: HashMap<[u64; 3], Vec<Corner>> = HashMap::new();
    for f in 0..b.triangles.len() as u32 {
        for c in 0..3 {
            by_place.entry(b.place((f, c))).or_default().push((f, c));
        }
    }
    let mut to_b: Vec<Option<u32>> = vec![None; a.positions.len()];
    let mut taken = vec![false; b.positions.len()];
    let mut done = vec![false; a.triangles.len()];
    for f in 0..a.triangles.len() as u32 {
        if done[f as usize] {
            continue;
        }
        let candidates = by_place.get(&a.place((f, 0))).map_or(&[][..], Vec::as_slice);
        let found = candidates.iter().find_map(|&start| lockstep(&a, &b, (f, 0), start, &to_b, &taken));
        let Some((map, faces)) = found else { panic!("the part with triangle {f} is not in the mesh that came back") };
        for (v, w) in map {
            to_b[v as usize] = Some(w);
            taken[w as usize] = true;
        }
        faces.into_iter().for_each(|f| done[f as usize] = true);
    }
}

type Part = (HashMap<u32, u32>, Vec<u32>);

/// Walks both meshes from a corner each; the vertices and triangles of the part if they agree everywhere.
fn lockstep(
    a: &Walkable<'_>,
    b: &Walkable<'_>,
    from: Corner,
    to: Corner,
    to_b: &[Option<u32>],
    taken: &[bool],
) -> Option<Part> {
    let (mut map, mut used, mut faces) = (HashMap::new(), HashMap::new(), HashMap::new());
    let mut stack = vec![(from, to)];
    while let Some(((f, c), (g, d))) = stack.pop() {
        match faces.get(&f) {
            Some(&(h, turn)) if (h, turn) == (g, (d + 3 - c) % 3) => continue,
            Some(_) => return None,
            None => faces.insert(f, (g, (d + 3 - c) % 3)),
        };
        for i in 0..3 {
            let (p, q) = ((f, (c + i) % 3), (g, (d + i) % 3));
            let (v, w) = (a.vertex(p), b.vertex(q));
            if a.place(p) != b.place(q) || to_b[v as usize].is_some() || taken[w as usize] {
                return None;
            }
            if *map.entry(v).or_insert(w) != w || *used.entry(w).or_insert(v) != v {
                return None;
            }
            match (a.across(p), b.across(q)) {
                (None, None) => {}
                (Some(x), Some(y)) => stack.push((x, y)),
                _ => return None,
            }
        }
    }
    Some((map, faces.into_keys().collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(shape: &Shape) -> Mesh {
        Mesh::from_triangles(shape.positions.clone(), shape.triangles.iter().copied())
    }

    #[test]
    fn a_shuffled_mesh_is_the_same() {
        for seed in 0..60 {
            let shape = corpus_make::any(seed, 150);
            assert_same(&shape, &mesh(&shape.shuffled(seed)));
        }
    }

    #[test]
    fn a_flipped_edge_and_a_moved_vertex_are_noticed() {
        let shape = corpus_make::bumpy_sphere(200, 3);
        let differs = |other: &Shape| std::panic::catch_unwind(|| assert_same(&shape, &mesh(other))).is_err();
        let mut moved = shape.shuffled(1);
        moved.positions[17][2] += 1e-6;
        assert!(differs(&moved));
        let mut edited = corpus_make::edit::Editable::new(shape.clone());
        edited.flip_some(0.01, false, &mut corpus_make::random::Random::new(5));
        let flipped = edited.finish();
        assert_ne!(flipped, shape);
        assert!(differs(&flipped));
        let mut mirrored = shape.clone();
        mirrored.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(differs(&mirrored));
    }
}
