//! Where the samples of the new image come from: a warped grid read backwards.
//!
//! Every cell of the warped grid is two triangles; the target samples in a triangle come from the same share of its
//! corners. The border is read along itself, so that a border sample comes from the border exactly.

use super::field::Field;
use super::warp::{Warp, area};

/// Columns and rows of the source, with fractions, for every sample of a target of `width` × `height`; O(samples).
///
/// Where cells fold, the first triangle counts that covers a sample.
pub(crate) fn inverse(warp: &Warp, width: usize, height: usize) -> Field<[f64; 2]> {
    let mut found: Vec<Option<[f64; 2]>> = vec![None; width * height];
    border(warp, width, height, &mut found);
    for y in 0..warp.x.height - 1 {
        for x in 0..warp.x.width - 1 {
            let corner = |(dx, dy): (usize, usize)| [warp.x.at(x + dx, y + dy), warp.y.at(x + dx, y + dy)];
            for corners in [[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]] {
                let [a, b, c] = corners.map(corner);
                let from = corners.map(|(dx, dy)| [(x + dx) as f64, (y + dy) as f64]);
                fill([a, b, c], from, width, height, &mut found);
            }
        }
    }
    close(&mut found, width, height);
    let values = found.into_iter().map(|place| place.unwrap_or([0.0; 2])).collect();
    Field::new(width, height, values)
}

/// How far outside a triangle a sample may lie, in shares of it, to be taken for one on its edge.
const SLACK: f64 = 1e-9;

fn fill([a, b, c]: [[f64; 2]; 3], from: [[f64; 2]; 3], width: usize, height: usize, found: &mut [Option<[f64; 2]>]) {
    let whole = area(a, b, c);
    if whole == 0.0 {
        return;
    }
    // The samples within its box; those on the border are known already.
    let range = |axis: usize, side: usize| {
        let (low, high) = (a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis]));
        let first = (low - 1e-6).ceil().max(1.0) as usize;
        let last = (high + 1e-6).floor().min(side as f64 - 2.0);
        first..if last < 0.0 { 0 } else { last as usize + 1 }
    };
    for v in range(1, height) {
        for u in range(0, width) {
            let slot = &mut found[v * width + u];
            if slot.is_some() {
                continue;
            }
            let p = [u as f64, v as f64];
            let shares = [area(p, b, c) / whole, area(a, p, c) / whole, area(a, b, p) / whole];
            if shares.iter().all(|&s| s >= -SLACK) {
                *slot = Some([0, 1].map(|axis| (0..3).map(|i| shares[i] * from[i][axis]).sum::<f64>()));
            }
        }
    }
}

/// The samples of the border, each from the side of the source that it lies on.
fn border(warp: &Warp, width: usize, height: usize, found: &mut [Option<[f64; 2]>]) {
    let (last_x, last_y) = (warp.x.width - 1, warp.x.height - 1);
    for (to, from) in [(0, 0), (height - 1, last_y)] {
        let line: Vec<f64> = (0..=last_x).map(|x| warp.x.at(x, from)).collect();
        for (u, place) in backwards(&line, width).into_iter().enumerate() {
            found[to * width + u] = Some([place, from as f64]);
        }
    }
    for (to, from) in [(0, 0), (width - 1, last_x)] {
        let line: Vec<f64> = (0..=last_y).map(|y| warp.y.at(from, y)).collect();
        for (v, place) in backwards(&line, height).into_iter().enumerate() {
            found[v * width + to] = Some([from as f64, place]);
        }
    }
}

/// Where along `line` the whole numbers below `count` are, the first place each.
fn backwards(line: &[f64], count: usize) -> Vec<f64> {
    let last = (line.len() - 1) as f64;
    let mut places: Vec<Option<f64>> = vec![None; count];
    places[0] = Some(0.0);
    places[count - 1] = Some(last);
    for (i, pair) in line.windows(2).enumerate() {
        let (low, high) = (pair[0].min(pair[1]), pair[0].max(pair[1]));
        let first = low.ceil().max(0.0) as usize;
        let mut u = first;
        while u < count && u as f64 <= high {
            let share = if pair[0] == pair[1] { 0.0 } else { (u as f64 - pair[0]) / (pair[1] - pair[0]) };
            places[u].get_or_insert(i as f64 + share);
            u += 1;
        }
    }
    // The line runs from 0 to count − 1, so all are known.
    places.into_iter().map(|place| place.unwrap_or(last)).collect()
}

/// Gives samples that no triangle covered, because of rounding or of folds, the place of a neighbour.
fn close(found: &mut [Option<[f64; 2]>], width: usize, height: usize) {
    let mut open: Vec<usize> = (0..found.len()).filter(|&p| found[p].is_none()).collect();
    while !open.is_empty() {
        let mut filled = Vec::new();
        open.retain(|&p| {
            let (x, y) = (p % width, p / width);
            let around = [
                (x > 0, p.wrapping_sub(1)),
                (x + 1 < width, p + 1),
                (y > 0, p.wrapping_sub(width)),
                (y + 1 < height, p + width),
            ];
            let known = around.into_iter().filter(|&(inside, _)| inside).find_map(|(_, q)| found[q]);
            filled.extend(known.map(|place| (p, place)));
            known.is_none()
        });
        if filled.is_empty() {
            return;
        }
        filled.into_iter().for_each(|(p, place)| found[p] = Some(place));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wavy(width: usize, height: usize, to: (usize, usize)) -> Warp {
        let (sx, sy) = ((to.0 - 1) as f64 / (width - 1) as f64, (to.1 - 1) as f64 / (height - 1) as f64);
        let wave = |t: f64, last: f64, by: f64| by * (3.0 * t).sin() * (t / last) * (1.0 - t / last);
        let x = |x: usize, y: usize| sx * (x as f64 + wave(x as f64, (width - 1) as f64, 0.5 + 0.01 * y as f64));
        let y = |x: usize, y: usize| sy * (y as f64 + wave(y as f64, (height - 1) as f64, 0.7 - 0.01 * x as f64));
        Warp { x: Field::from_fn(width, height, x), y: Field::from_fn(width, height, y) }
    }

    #[test]
    fn a_warped_grid_read_backwards_and_forwards_is_where_it_began() {
        let warp = wavy(31, 23, (17, 19));
        assert!(warp.folded().is_empty());
        let inverse = inverse(&warp, 17, 19);
        for v in 0..19 {
            for u in 0..17 {
                let [x, y] = inverse.at(u, v);
                // The triangle of the cell, forwards again.
                let (i, j) = ((x as usize).min(29), (y as usize).min(21));
                let (s, t) = (x - i as f64, y - j as f64);
                let forth = |field: &Field<f64>| {
                    let [a, b, c, d] = [field.at(i, j), field.at(i + 1, j), field.at(i + 1, j + 1), field.at(i, j + 1)];
                    if s >= t { a + s * (b - a) + t * (c - b) } else { a + t * (d - a) + s * (c - d) }
                };
                assert!((forth(&warp.x) - u as f64).abs() < 1e-7, "column {u} of row {v}: {}", forth(&warp.x));
                assert!((forth(&warp.y) - v as f64).abs() < 1e-7, "row {v} of column {u}: {}", forth(&warp.y));
            }
        }
    }

    #[test]
    fn the_border_comes_from_the_border() {
        let inverse = inverse(&wavy(12, 15, (9, 8)), 9, 8);
        for u in 0..9 {
            assert_eq!((inverse.at(u, 0)[1], inverse.at(u, 7)[1]), (0.0, 14.0));
        }
        for v in 0..8 {
            assert_eq!((inverse.at(0, v)[0], inverse.at(8, v)[0]), (0.0, 11.0));
        }
    }

    #[test]
    fn a_grid_that_stays_is_its_own_inverse() {
        let stay = Warp { x: Field::from_fn(7, 5, |x, _| x as f64), y: Field::from_fn(7, 5, |_, y| y as f64) };
        let inverse = inverse(&stay, 7, 5);
        for y in 0..5 {
            for x in 0..7 {
                assert_eq!(inverse.at(x, y), [x as f64, y as f64]);
                assert_eq!(inverse.linear([x as f64, y as f64]), [x as f64, y as f64]);
            }
        }
    }
}
