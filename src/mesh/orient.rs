//! Which faces to turn over so that neighbours agree about the outside.

use super::Corners;

/// Whether to turn each face over. Only edges of exactly two faces count; where they cannot all agree (a Möbius strip), some
/// will not. Of the two ways to orient each connected part, the one that turns fewer faces over.
pub(crate) fn orient(corners: &Corners) -> Vec<bool> {
    let mut flip = vec![false; corners.face_count()];
    let agrees = |edge: &[u32]| edge.len() != 2 || corners.vertex(edge[0]) != corners.vertex(edge[1]);
    if corners.edges().all(agrees) {
        return flip;
    }
    let mut seen = vec![false; corners.face_count()];
    let mut part = Vec::new();
    let mut starts = vec![0_u32; corners.face_count()];
    for c in (0..corners.len() as u32).rev() {
        starts[corners.face(c) as usize] = c;
    }
    for first in 0..corners.face_count() as u32 {
        if std::mem::replace(&mut seen[first as usize], true) {
            continue;
        }
        part.clear();
        part.push(first);
        let (mut i, mut flipped) = (0, 0);
        while i < part.len() {
            let f = part[i];
            i += 1;
            let start = starts[f as usize];
            for c in start..start + corners.of_face(f).len() as u32 {
                let &[x, y] = corners.sides(c) else { continue };
                let other = if x == c { y } else { x };
                let g = corners.face(other);
                if !std::mem::replace(&mut seen[g as usize], true) {
                    let same_way = corners.vertex(other) == corners.vertex(c);
                    flip[g as usize] = flip[f as usize] != same_way;
                    flipped += usize::from(flip[g as usize]);
                    part.push(g);
                }
            }
        }
        if 2 * flipped > part.len() {
            part.iter().for_each(|&f| flip[f as usize] = !flip[f as usize]);
        }
    }
    flip
}
