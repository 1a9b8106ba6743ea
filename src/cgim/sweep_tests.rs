//! Disks through stratify, align and shrink, and back.

use super::align::{Contact, align, width};
use super::check::compare;
use super::random_meshes::{Growing, boundary_of};
use super::rng::Random;
use super::shrink::shrink;
use super::stratify::{Plan, stratify};
use super::vmatrix::VMatrix;

fn random_plan(boundary: &[u32], random: &mut Random) -> Plan {
    let length = 1 + random.below(boundary.len() - 1);
    let first = random.below(boundary.len());
    let start = (0..length).map(|i| boundary[(first + i) % boundary.len()]).collect();
    let alpha = [0, 1, 2, 3, 5][random.below(5)];
    let keep = if random.below(2) == 0 { 1.0 } else { random.unit() };
    let columns = [0, 5, 20][random.below(3)];
    Plan { start, alpha, keep, columns, seed: random.next(), drop_ends: random.below(2) == 0 }
}

/// How many vertices are not one connected set of pixels.
fn split_vertices(matrix: &VMatrix, slash: bool) -> usize {
    let (rows, columns) = (matrix.rows(), matrix.columns());
    let at = |i: usize, j: usize| matrix.row(i)[j];
    let mut seen = vec![false; rows * columns];
    let mut started = std::collections::HashSet::new();
    let mut split = std::collections::HashSet::new();
    for pixel in 0..rows * columns {
        if std::mem::replace(&mut seen[pixel], true) {
            continue;
        }
        let v = matrix.entries()[pixel];
        if !started.insert(v) {
            split.insert(v);
        }
        let mut stack = vec![(pixel / columns, pixel % columns)];
        while let Some((i, j)) = stack.pop() {
            let mut go = |i: usize, j: usize| {
                if i < rows && j < columns && at(i, j) == v && !std::mem::replace(&mut seen[i * columns + j], true) {
                    stack.push((i, j));
                }
            };
            go(i.wrapping_sub(1), j);
            go(i + 1, j);
            go(i, j.wrapping_sub(1));
            go(i, j + 1);
            if slash {
                go(i.wrapping_sub(1), j + 1);
                go(i + 1, j.wrapping_sub(1));
            }
        }
    }
    split.len()
}

#[test]
fn a_thousand_random_disks_survive_the_matrix_whatever_the_plan() {
    for seed in 0..1000 {
        let mut random = Random::new(seed, 1);
        let size = 1 + random.below(80);
        let disk = Growing::triangle().grow_disk(size, &mut random).half_edges();
        let boundary = boundary_of(&disk);
        let plan = random_plan(&boundary, &mut random);
        let levels = stratify(&disk, &plan).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        for contact in [Contact::Slash, Contact::Overlap] {
            let matrix = align(&levels, contact);
            assert_eq!(matrix.columns(), width(&levels, contact));
            assert!(compare(&matrix, |v| v, disk.triangles()).is_empty(), "seed {seed}, {contact:?}");
            assert_eq!(split_vertices(&matrix, contact == Contact::Slash), 0, "seed {seed}, {contact:?}");
            let small = shrink(matrix.clone(), contact);
            assert!(small.entries().len() <= matrix.entries().len());
            assert!(compare(&small, |v| v, disk.triangles()).is_empty(), "seed {seed}, {contact:?}, shrunk");
            assert_eq!(split_vertices(&small, contact == Contact::Slash), 0, "seed {seed}, {contact:?}, shrunk");
        }
        let turned: Vec<_> = disk.triangles().iter().map(|&[a, b, c]| [a, c, b]).collect();
        let mirrored = align(&levels.mirrored(), Contact::Slash);
        assert!(compare(&mirrored, |v| v, &turned).is_empty(), "seed {seed}, mirrored");
    }
}

#[test]
fn without_overlap_some_vertices_touch_only_along_the_slash() {
    let split: usize = (0..50)
        .map(|seed| {
            let mut random = Random::new(seed, 2);
            let disk = Growing::triangle().grow_disk(60, &mut random).half_edges();
            let plan = random_plan(&boundary_of(&disk), &mut random);
            split_vertices(&align(&stratify(&disk, &plan).unwrap(), Contact::Slash), false)
        })
        .sum();
    assert!(split > 0, "the overlap variant would not be needed");
}
