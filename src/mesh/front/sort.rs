//! Which faces can be part of a surface: those of three or more different vertices, each once.

use super::super::{Corners, Faces};

/// A face with the same corners as an earlier face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Repeat {
    pub(crate) face: u32,
    /// The first of its kind.
    pub(crate) of: u32,
    /// Whether it goes round the other way.
    pub(crate) is_reversed: bool,
}

#[derive(Debug, Default)]
pub(super) struct Sorted {
    pub(super) loose: Vec<u32>,
    pub(super) repeats: Vec<Repeat>,
    is_kept: Vec<bool>,
}

/// From counted faces of [`Corners`] to those of the mesh.
pub(super) struct Numbers(Option<Vec<u32>>);

impl Numbers {
    pub(super) fn number(&self, corners: &Corners, f: u32) -> u32 {
        let f = corners.number(f);
        self.0.as_ref().map_or(f, |numbers| numbers[f as usize])
    }
}

impl Sorted {
    /// The corners of the faces that can be part of a surface.
    pub(super) fn kept(&self, vertices: usize, faces: &Faces) -> (Corners, Numbers) {
        if self.loose.is_empty() && self.repeats.is_empty() {
            return (Corners::new(vertices, faces), Numbers(None));
        }
        let (mut kept, mut numbers) = (Faces::default(), Vec::new());
        for (f, face) in faces.iter().enumerate().filter(|&(f, _)| self.is_kept[f]) {
            kept.push(face);
            numbers.push(f as u32);
        }
        (Corners::new(vertices, &kept), Numbers(Some(numbers)))
    }
}

/// O(n log n).
pub(super) fn sort(faces: &Faces) -> Sorted {
    let mut sorted = Sorted { is_kept: vec![true; faces.len()], ..Sorted::default() };
    let mut keys = Vec::with_capacity(faces.len());
    let mut scratch = Vec::new();
    for (f, face) in faces.iter().enumerate() {
        if is_simple(face, &mut scratch) {
            keys.push((fingerprint(face), f as u32));
        } else {
            sorted.loose.push(f as u32);
            sorted.is_kept[f] = false;
        }
    }
    keys.sort_unstable();
    let mut firsts: Vec<u32> = Vec::new();
    for alike in keys.chunk_by(|a, b| a.0 == b.0).filter(|alike| alike.len() > 1) {
        firsts.clear();
        for &(_, f) in alike {
            let face = faces.get(f as usize);
            match firsts.iter().find(|&&of| cycle(face).eq(cycle(faces.get(of as usize)))) {
                Some(&of) => {
                    let is_reversed = is_backward(face) != is_backward(faces.get(of as usize));
                    sorted.repeats.push(Repeat { face: f, of, is_reversed });
                    sorted.is_kept[f as usize] = false;
                }
                None => firsts.push(f),
            }
        }
    }
    sorted
}

/// Whether a face has three or more corners, all different.
fn is_simple(face: &[u32], scratch: &mut Vec<u32>) -> bool {
    if let &[a, b, c] = face {
        return a != b && b != c && c != a;
    }
    scratch.clear();
    scratch.extend_from_slice(face);
    scratch.sort_unstable();
    face.len() >= 3 && scratch.windows(2).all(|w| w[0] != w[1])
}

fn least(face: &[u32]) -> usize {
    (0..face.len()).min_by_key(|&i| face[i]).unwrap_or(0)
}

/// Whether the neighbour before the least corner is less than the one after.
fn is_backward(face: &[u32]) -> bool {
    let (i, n) = (least(face), face.len());
    face[(i + n - 1) % n] < face[(i + 1) % n]
}

/// The corners from the least on, towards its lesser neighbour: the same for all turns and both ways round.
fn cycle(face: &[u32]) -> impl Iterator<Item = u32> + '_ {
    let (start, n) = (least(face), face.len());
    let step = if is_backward(face) { n - 1 } else { 1 };
    (0..n).map(move |i| face[(start + i * step) % n])
}

fn fingerprint(face: &[u32]) -> u64 {
    cycle(face).fold(face.len() as u64, |h, v| {
        let h = (h ^ u64::from(v)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        h ^ h >> 29
    })
}
