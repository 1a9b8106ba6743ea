//! The paper's own AlignAllLevels (CGIM §4.1, §4.3 steps 15–18, Algorithm 1), and its removal of rows and columns
//! (§5.1, Algorithm 2, lines 31–40), as printed.
//!
//! Used by `--align paper`, for tables, and as the slow twin of [`align`](super::align). The alignment is right, but
//! wider than it need be. The removal looks at edges alone and can lose, double or turn over a triangle
//! (`spec/readings.md`); what it breaks goes into the escape stream of the image.

use std::collections::HashMap;

use super::align::{Contact, align};
use super::vmatrix::VMatrix;
use crate::plane::Levels;

/// A level with repeats: each vertex and how often it stands there, from left to right.
type Stretched = Vec<(u32, usize)>;

fn stretched(row: &[u32]) -> Stretched {
    row.chunk_by(|x, y| x == y).map(|run| (run[0], run.len())).collect()
}

/// Algorithm 1, `align2`: where `first` repeats a vertex more often than `second`, which is the same level, the vertex is
/// repeated in `second`, and in `third`, which is aligned with `second`, the vertices beside it take turns.
fn align2(first: &Stretched, second: &mut Stretched, third: &mut Stretched) {
    let (mut start, mut beside, mut beside_start) = (0, 0, 0);
    for (&(v, wanted), (w, length)) in first.iter().zip(second.iter_mut()) {
        debug_assert_eq!(v, *w, "two forms of one level");
        let missing = wanted.saturating_sub(*length);
        if missing > 0 {
            while beside_start + third[beside].1 <= start {
                beside_start += third[beside].1;
                beside += 1;
            }
            let (mut count, mut from) = (0, beside_start);
            while beside + count < third.len() && from < start + *length {
                from += third[beside + count].1;
                count += 1;
            }
            for j in 0..count {
                third[beside + j].1 += missing / count + usize::from(j < missing % count);
            }
            *length += missing;
        }
        start += *length;
    }
}

/// AlignAllLevels, steps 15 to 18: down the levels and up again. O(levels · width).
pub(super) fn align_as_printed(levels: &Levels) -> VMatrix {
    let count = levels.len();
    if count < 2 {
        return align(levels, Contact::Slash);
    }
    // Align2Levels: plus[i] and minus[i] are the levels i and i + 1 aligned with each other alone.
    let (mut plus, mut minus): (Vec<Stretched>, Vec<Stretched>) = (1..count)
        .map(|i| {
            let mut pair = Levels::default();
            pair.push_level(levels.level(i - 1).iter().copied());
            pair.push_strip(levels.strip(i - 1).iter().copied());
            pair.push_level(levels.level(i).iter().copied());
            let pair = align(&pair, Contact::Slash);
            (stretched(pair.row(0)), stretched(pair.row(1)))
        })
        .unzip();
    for i in 1..count - 1 {
        let (above, below) = minus.split_at_mut(i);
        align2(&above[i - 1], &mut plus[i], &mut below[0]);
    }
    // Printed with the level that goes into the matrix only on the left; it is needed on the right, too.
    for i in (0..count - 2).rev() {
        let (above, below) = plus.split_at_mut(i + 1);
        align2(&below[0], &mut minus[i], &mut above[i]);
    }
    plus.extend(minus.pop());
    let columns = plus[0].iter().map(|run| run.1).sum();
    let entries = plus.iter().flatten().flat_map(|&(v, length)| std::iter::repeat_n(v, length));
    VMatrix::new(columns, entries.collect())
}

/// Lines 31 to 40 of Algorithm 2: takes out rows, then columns, without which the set of edges is still the same.
pub(super) fn remove_as_printed(matrix: &VMatrix) -> VMatrix {
    remove_rows(&remove_rows(matrix).transposed()).transposed()
}

fn remove_rows(matrix: &VMatrix) -> VMatrix {
    let mut rows: Vec<&[u32]> = (0..matrix.rows()).map(|i| matrix.row(i)).collect();
    // In how many places each edge is.
    let mut places: HashMap<[u32; 2], u32> = HashMap::new();
    for pair in rows.windows(2) {
        edges(pair[0], pair[1], |edge| *places.entry(edge).or_insert(0) += 1);
    }
    let mut i = 0;
    while i < rows.len() && rows.len() > 2 {
        let between = [i.checked_sub(1).map(|k| (k, i)), (i + 1 < rows.len()).then_some((i, i + 1))];
        let across = (i > 0 && i + 1 < rows.len()).then(|| (i - 1, i + 1));
        // Of an edge that is in no other place only the new pair of rows can keep it.
        let mut new: HashMap<[u32; 2], u32> = HashMap::new();
        across.iter().for_each(|&(a, b)| edges(rows[a], rows[b], |edge| *new.entry(edge).or_insert(0) += 1));
        let mut lost: HashMap<[u32; 2], u32> = HashMap::new();
        between.iter().flatten().for_each(|&(a, b)| edges(rows[a], rows[b], |edge| *lost.entry(edge).or_insert(0) += 1));
        let kept = lost.iter().all(|(edge, n)| places[edge] > *n || new.contains_key(edge));
        if kept && new.keys().all(|edge| places.contains_key(edge)) {
            for (edge, n) in lost {
                *places.entry(edge).or_insert(0) -= n;
            }
            for (edge, n) in new {
                *places.entry(edge).or_insert(0) += n;
            }
            rows.remove(i);
        } else {
            i += 1;
        }
    }
    VMatrix::new(matrix.columns(), rows.concat())
}

/// The edges that two rows induce (§4), the lesser vertex first.
fn edges(top: &[u32], bottom: &[u32], mut edge: impl FnMut([u32; 2])) {
    let mut add = |a: u32, b: u32| {
        if a != b {
            edge([a.min(b), a.max(b)]);
        }
    };
    for j in 0..top.len() {
        add(top[j], bottom[j]);
        if j + 1 < top.len() {
            add(top[j], top[j + 1]);
            add(bottom[j], bottom[j + 1]);
            add(top[j + 1], bottom[j]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::compare;
    use super::super::random_meshes::{Growing, boundary_of};
    use super::super::rng::Random;
    use super::super::stratify::{Plan, stratify};
    use super::*;

    fn disk_levels(seed: u64) -> (Vec<[u32; 3]>, Levels) {
        let mut random = Random::new(seed, 12);
        let disk = Growing::triangle().grow_disk(10 + random.below(80), &mut random).half_edges();
        let boundary = boundary_of(&disk);
        let start = boundary[..1 + random.below(boundary.len() - 1)].to_vec();
        let plan = Plan { start, alpha: 5, keep: 1.0, columns: 0, seed, drop_ends: true };
        (disk.triangles().to_vec(), stratify(&disk, &plan).unwrap())
    }

    #[test]
    fn the_papers_alignment_holds_every_triangle_and_is_never_narrower_than_the_longest_path() {
        let (mut ours, mut papers) = (0, 0);
        for seed in 0..500 {
            let (triangles, levels) = disk_levels(seed);
            let (printed, least) = (align_as_printed(&levels), align(&levels, Contact::Slash));
            assert!(compare(&printed, |v| v, &triangles).is_empty(), "seed {seed}");
            assert_eq!(printed.rows(), least.rows());
            assert!(printed.columns() >= least.columns(), "seed {seed}");
            ours += least.columns();
            papers += printed.columns();
        }
        assert!(papers > ours, "{papers} columns by the paper, {ours} by the longest path");
    }

    #[test]
    fn the_guide_of_section_4_4_is_reproduced() {
        // L₁ = [ABCDE], L₂ = [AGCDJE], L₃ = [AGCDJLE], L₄ = [FHIK], aligned in pairs as printed there.
        let pairs = [["ABCDDE", "AGCDJE"], ["AGCDJJE", "AGCDJLE"], ["AGCDJLE", "FFHIIKK"]];
        let rows = pairs.map(|pair| pair.map(|row| stretched(&row.bytes().map(u32::from).collect::<Vec<_>>())));
        let [[mut plus_1, mut minus_2], [mut plus_2, mut minus_3], [mut plus_3, mut minus_4]] = rows;
        align2(&minus_2, &mut plus_2, &mut minus_3);
        align2(&minus_3, &mut plus_3, &mut minus_4);
        align2(&plus_3, &mut minus_3, &mut plus_2);
        align2(&plus_2, &mut minus_2, &mut plus_1);
        let text = |level: &Stretched| {
            level.iter().flat_map(|&(v, n)| std::iter::repeat_n(char::from(v as u8), n)).collect::<String>()
        };
        assert_eq!([&plus_1, &plus_2, &plus_3, &minus_4].map(text), ["ABCDDDE", "AGCDJJE", "AGCDJLE", "FFHIIKK"]);
    }

    #[test]
    fn removal_guarded_by_edges_keeps_the_edges_and_not_always_the_triangles() {
        let edge_set = |m: &VMatrix| {
            let mut all = std::collections::BTreeSet::new();
            (1..m.rows()).for_each(|i| edges(m.row(i - 1), m.row(i), |e| all.extend([e])));
            all
        };
        let mut broken = 0;
        for seed in 0..500 {
            let (triangles, levels) = disk_levels(seed);
            let matrix = align_as_printed(&levels);
            let small = remove_as_printed(&matrix);
            assert!(small.entries().len() <= matrix.entries().len());
            assert_eq!(edge_set(&small), edge_set(&matrix), "seed {seed}");
            broken += u32::from(!compare(&small, |v| v, &triangles).is_empty());
        }
        assert!(broken > 0, "then the escape stream would not be needed");
    }
}
