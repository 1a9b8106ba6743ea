//! The cluster phase against a slow twin that follows §5.2 symbol for symbol, and on the images of random meshes.

use std::collections::BTreeSet;

use super::align::Contact;
use super::cluster::cluster;
use super::random_meshes::Growing;
use super::regions::{straight, walls};
use super::rng::Random;
use super::runs::run_counts;
use super::search::Search;
use super::stack::{Image, image};
use crate::mesh::HalfEdges;
use crate::plane::{Block, RunCounts};
use crate::task::Task;

type Pixel = (usize, usize);

/// I(i, k), J(l, j), Ξ and D as printed, with sets of pixels; the metrics are squared distances of colours.
struct Twin<'a> {
    rows: usize,
    columns: usize,
    colour: &'a dyn Fn(Pixel) -> i64,
}

impl Twin<'_> {
    fn d(&self, a: Pixel, b: Pixel) -> i64 {
        ((self.colour)(a) - (self.colour)(b)).pow(2)
    }

    /// Cuts a line of pixels at its `x` largest steps.
    fn categories(&self, line: &[Pixel], x: u32) -> Vec<BTreeSet<Pixel>> {
        let mut cuts: Vec<usize> = (0..line.len() - 1).collect();
        cuts.sort_by_key(|&k| (std::cmp::Reverse(self.d(line[k], line[k + 1])), k));
        cuts.truncate(x as usize);
        cuts.sort_unstable();
        let mut from = 0;
        let mut sets = Vec::new();
        for end in cuts.into_iter().map(|k| k + 1).chain([line.len()]) {
            sets.push(line[from..end].iter().copied().collect());
            from = end;
        }
        sets
    }

    /// The metric (6) as sum and count; `None` for +∞.
    fn metric(&self, upper: &BTreeSet<Pixel>, lower: &BTreeSet<Pixel>, j_of: &[Vec<BTreeSet<Pixel>>]) -> Option<(i64, i64)> {
        let xi = (0..self.columns).filter_map(|j| {
            let (a, b) = (upper.iter().find(|p| p.1 == j)?, lower.iter().find(|p| p.1 == j)?);
            j_of[j].iter().any(|set| set.contains(a) && set.contains(b)).then(|| self.d(*a, *b))
        });
        let distances: Vec<i64> = xi.collect();
        (!distances.is_empty()).then(|| (distances.iter().sum(), distances.len() as i64))
    }

    fn regions(&self, counts: &RunCounts) -> Vec<u32> {
        let row = |i: usize| (0..self.columns).map(|j| (i, j)).collect::<Vec<_>>();
        let column = |j: usize| (0..self.rows).map(|i| (i, j)).collect::<Vec<_>>();
        let i_of: Vec<_> = (0..self.rows).map(|i| self.categories(&row(i), counts.rows[i])).collect();
        let j_of: Vec<_> = (0..self.columns).map(|j| self.categories(&column(j), counts.columns[j])).collect();
        // What each category was combined with: itself, or one of the row above.
        let mut label: Vec<Vec<u32>> = Vec::new();
        let mut fresh = 0;
        for (i, row) in i_of.iter().enumerate() {
            let mut labels = Vec::new();
            for lower in row {
                let mut best: Option<(i64, i64, u32)> = None;
                if i > 0 {
                    for (k, upper) in i_of[i - 1].iter().enumerate() {
                        if let Some((sum, count)) = self.metric(upper, lower, &j_of)
                            && best.is_none_or(|(s, c, _)| sum * c < s * count)
                        {
                            best = Some((sum, count, label[i - 1][k]));
                        }
                    }
                }
                labels.push(best.map_or_else(
                    || {
                        fresh += 1;
                        fresh - 1
                    },
                    |b| b.2,
                ));
            }
            label.push(labels);
        }
        let of = |p: Pixel| i_of[p.0].iter().position(|set| set.contains(&p)).map_or(0, |k| label[p.0][k]);
        (0..self.rows).flat_map(|i| (0..self.columns).map(move |j| (i, j))).map(of).collect()
    }
}

#[test]
fn it_does_what_the_paper_says_symbol_for_symbol() {
    for seed in 0..600 {
        let mut random = Random::new(seed, 7);
        let (rows, columns) = (1 + random.below(9), 1 + random.below(9));
        // Few colours: many ties.
        let colours: Vec<i64> =
            (0..rows * columns).map(|_| random.below(if seed % 2 == 0 { 4 } else { 1000 }) as i64).collect();
        let counts = RunCounts {
            rows: (0..rows).map(|_| random.below(columns) as u32).collect(),
            columns: (0..columns).map(|_| random.below(rows) as u32).collect(),
        };
        let twin = Twin { rows, columns, colour: &|(i, j)| colours[i * columns + j] };
        let blocks = [Block { rows: rows as u32, mirrored: false }];
        let found = cluster(columns, &blocks, &counts, &[], |p, q| (colours[p] - colours[q]).pow(2) as u64).unwrap().0;
        assert_eq!(found, twin.regions(&counts), "seed {seed}");
    }
}

/// The worked matrix of `spec/cluster.md`.
#[test]
fn the_worked_matrix_of_the_specification() {
    let colours = [10_i64, 12, 40, 41, 9, 30, 42, 41, 11, 31, 29, 60];
    let counts = RunCounts { rows: vec![1, 2, 2], columns: vec![0, 1, 1, 1] };
    let blocks = [Block { rows: 3, mirrored: false }];
    let distance = |p: usize, q: usize| (colours[p] - colours[q]).pow(2) as u64;
    let (found, regions) = cluster(4, &blocks, &counts, &[], distance).unwrap();
    assert_eq!(found, [0, 0, 1, 1, 0, 2, 1, 1, 0, 2, 2, 3]);
    assert_eq!(regions, 4);
    let twin = Twin { rows: 3, columns: 4, colour: &|(i, j)| colours[i * 4 + j] };
    assert_eq!(found, twin.regions(&counts));
}

#[test]
fn counts_and_walls_that_do_not_fit_are_refused() {
    let blocks = [Block { rows: 2, mirrored: false }];
    let fits = |rows: [u32; 2], columns: [u32; 2], walls: &[u64]| {
        let counts = RunCounts { rows: rows.to_vec(), columns: columns.to_vec() };
        cluster(2, &blocks, &counts, walls, |_, _| 0).is_some()
    };
    assert!(fits([1, 0], [0, 1], &[0]));
    assert!(!fits([2, 0], [0, 1], &[]));
    assert!(!fits([0, 0], [0, 0], &[0]));
    assert!(!fits([1, 1], [1, 1], &[2]), "walls along the slash have no meaning here");
    assert!(!fits([1, 1], [1, 1], &[3]), "nothing lies to the right of the last column");
    assert!(!fits([1, 1], [1, 1], &[3 * 2 + 1]), "nothing lies below the last row");
    assert!(!fits([1, 1], [1, 1], &[1 << 40]));
}

fn is_found_again(image: &Image, colours: &[i64]) -> bool {
    let entries = image.matrix.entries();
    let colour = |p: usize| colours[entries[p] as usize];
    let hidden = straight(walls(&image.matrix, &image.side.blocks, |p, q| colour(p) == colour(q)));
    let counts = run_counts(&image.matrix, &image.side.blocks);
    let distance = |p: usize, q: usize| (colour(p) - colour(q)).pow(2) as u64;
    let found = cluster(image.matrix.columns(), &image.side.blocks, &counts, &hidden, distance).unwrap();
    found.0 == entries
}

/// Without a loss of colour, and with walls where two vertices share one, every vertex is found again.
#[test]
fn without_loss_the_vertices_of_a_thousand_meshes_are_found_again() {
    let mut shrunk = 0;
    for seed in 0..1000 {
        let mut random = Random::new(seed, 9);
        let size = 5 + random.below(60);
        let mesh: HalfEdges = match seed % 3 {
            0 => Growing::triangle().grow_disk(size, &mut random).half_edges(),
            1 => Growing::sphere().grow(size, &mut random).half_edges(),
            _ => Growing::torus(4).grow(size, &mut random).with_holes(2, &mut random).half_edges(),
        };
        let mut options = Search { trials: 1 + random.below(3), seed, contact: Contact::Overlap, ..Search::default() };
        let wide = image(&mesh, &Search { simple: true, ..options }, &Task::default()).unwrap();
        let colours: Vec<i64> = (0..wide.regions()).map(|_| random.below(9) as i64).collect();
        assert!(is_found_again(&wide, &colours), "seed {seed}");
        options.simple = false;
        let small = image(&mesh, &options, &Task::default()).unwrap();
        shrunk += u32::from(is_found_again(&small, &colours));
    }
    // Shrinking bends vertices so that two of their runs in one row hang together only below.
    assert!((300..1000).contains(&shrunk), "{shrunk} of 1000 shrunk images");
}

#[test]
fn a_vertex_may_leave_a_column_and_come_back() {
    let returns = (0..200).any(|seed| {
        let mut random = Random::new(seed, 11);
        let mesh = Growing::triangle().grow_disk(60, &mut random).half_edges();
        let image = image(&mesh, &Search { seed, ..Search::default() }, &Task::default()).unwrap();
        let counts = run_counts(&image.matrix, &image.side.blocks);
        (0..image.matrix.columns()).any(|j| {
            let column = (0..image.matrix.rows()).map(|i| image.matrix.row(i)[j]);
            let different = column.collect::<BTreeSet<_>>().len() as u32;
            different < counts.columns[j] + 1
        })
    });
    assert!(returns, "then the number of different elements would be the number of runs");
}
