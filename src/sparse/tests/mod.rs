//! Solvers against Gaussian elimination.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::error::Error;
use proptest::prelude::*;

/// The slow twin: elimination with pivots on a full matrix.
fn eliminate(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap();
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            for j in k..n {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        b[k] = (b[k] - (k + 1..n).map(|j| a[k][j] * b[j]).sum::<f64>()) / a[k][k];
    }
    b
}

/// A graph's weights as a matrix with a heavy diagonal, symmetric or not: full, and as pattern and values.
fn matrix(n: usize, edges: &[(usize, usize, f64)], symmetric: bool) -> (Vec<Vec<f64>>, Pattern, Vec<f64>) {
    let mut full = vec![vec![0.0; n]; n];
    let mut add = |i: usize, j: usize, w: f64| {
        full[i][j] -= w;
        full[i][i] += 1.1 * w;
    };
    for &(i, j, w) in edges {
        let (i, j) = (i % n, j % n);
        if i != j {
            add(i, j, w);
            add(j, i, if symmetric { w } else { 0.3 * w });
        }
    }
    (0..n).for_each(|i| full[i][i] += 0.1);
    let kept = |i: usize, j: usize| full[i][j] != 0.0 && (!symmetric || i >= j);
    let all = (0..n * n).map(|k| (k / n, k % n)).filter(|&(i, j)| kept(i, j));
    let pairs: Vec<(u32, u32)> = all.map(|(i, j)| (i as u32, j as u32)).collect();
    let (pattern, slots) = Pattern::new(n, &pairs);
    let mut values = vec![0.0; pattern.len()];
    pairs.iter().zip(slots).for_each(|(&(i, j), s)| values[s as usize] = full[i as usize][j as usize]);
    (full, pattern, values)
}

proptest! {
    #[test]
    fn all_solvers_find_what_elimination_finds(
        n in 1..30_usize,
        edges in prop::collection::vec((0..30_usize, 0..30_usize, 0.01..10.0_f64), 0..120),
        right in prop::collection::vec(-1.0..1.0_f64, 60),
    ) {
        let near = |x: &[f64], y: &[f64]| x.iter().zip(y).all(|(x, y)| (x - y).abs() < 1e-8 * (1.0 + y.abs()));
        for symmetric in [true, false] {
            let (full, pattern, values) = matrix(n, &edges, symmetric);
            let mut b = right[..2 * n].to_vec();
            let expected: Vec<f64> = b.chunks(n).flat_map(|b| eliminate(full.clone(), b.to_vec())).collect();
            let product = pattern.times(&values, &expected[..n], symmetric);
            prop_assert!(near(&product, &b[..n]));
            if symmetric {
                let gentle = Conjugate { tolerance: 1e-13, steps: 1000 };
                let times = |x: &[f64]| pattern.times(&values, x, true);
                let x = conjugate_gradients(&b[..n], &pattern.diagonal(&values), gentle, times);
                prop_assert!(near(&x, &expected[..n]));
                Cholesky::new(pattern).unwrap().solve(&values, &mut b).unwrap();
            } else {
                General::new(pattern).unwrap().solve(&values, &mut b).unwrap();
            }
            prop_assert!(near(&b, &expected));
        }
    }
}

#[test]
fn matrices_that_cannot_be_solved_are_reported() {
    let (pattern, _) = Pattern::new(2, &[(0, 0), (1, 0), (1, 1)]);
    let indefinite = Cholesky::new(pattern).unwrap().solve(&[1.0, 2.0, 1.0], &mut [1.0, 1.0]);
    assert!(matches!(indefinite, Err(Error::NoConvergence { .. })));
    let (pattern, _) = Pattern::new(2, &[(0, 0), (1, 0), (0, 1), (1, 1)]);
    let singular = General::new(pattern).unwrap().solve(&[1.0, 1.0, 1.0, 1.0], &mut [1.0, 2.0]);
    assert!(matches!(singular, Err(Error::NoConvergence { .. })), "{singular:?}");
}

#[test]
fn pairs_may_repeat_and_pairs_outside_have_no_slot() {
    let (pattern, slots) = Pattern::new(2, &[(1, 0), (0, 0), (1, 0), (NOWHERE, 1)]);
    assert_eq!((pattern.len(), slots), (2, vec![1, 0, 1, NOWHERE]));
}
