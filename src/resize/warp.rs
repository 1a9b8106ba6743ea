//! Where every sample goes when an image becomes smaller or larger (paper 004, II-B, equations (3) to (5)).
//!
//! Neighbours in a row want to stay one apart, neighbours in a column at one height, each as strongly as its energy
//! says; the first and the last column go to the first and the last of the target. Least squares give, for x,
//!
//! ```text
//! minimise Σ (E²ᵢⱼ + E²ᵢ₋₁ⱼ) (xᵢⱼ − xᵢ₋₁ⱼ − 1)² + Σ E²ᵢⱼ (xᵢⱼ − xᵢⱼ₊₁)²,   x = 0 and x = W − 1 on both ends,
//! ```
//!
//! and the same for y with rows and columns exchanged. (The second line of (3) is printed with the wrong sign:
//! spec/readings.md.) On an orbifold the samples of the first and the last row also stay mirrored about its middle,
//! so that what was glued stays glued.
//!
//! Solved are the shifts against the even grid, by conjugate gradients with a multigrid as preconditioner.

use super::field::Field;
use super::multigrid::Multigrid;
use crate::error::{Error, Result};
use crate::par;
use crate::plane::Gluing;
use crate::task::Task;

/// The residual at which conjugate gradients stop, relative to the first.
const PRECISION: f64 = 1e-7;
/// More iterations than any image needed (at most 60).
const MOST_ITERATIONS: usize = 2000;

/// Where every sample of an image goes.
#[derive(Clone, Debug)]
pub(crate) struct Warp {
    /// Columns of the target, with fractions.
    pub(crate) x: Field<f64>,
    /// Rows of the target, with fractions.
    pub(crate) y: Field<f64>,
}

impl Warp {
    /// The warp to `width` columns and `height` rows, for energies of at least `floor`.
    pub(crate) fn new(
        energy: &Field<f64>,
        floor: f64,
        gluing: Gluing,
        width: usize,
        height: usize,
        task: &Task<'_>,
    ) -> Result<Self> {
        let weights = Field { values: energy.values.iter().map(|e| e.max(floor) * e.max(floor)).collect(), ..*energy };
        let turned = weights.transposed();
        let (x, y) = par::join(|| positions(&weights, width, gluing, task), || positions(&turned, height, gluing, task));
        Ok(Self { x: x?, y: y?.transposed() })
    }

    /// The cells of which a triangle turned over or vanished.
    pub(crate) fn folded(&self) -> Vec<(usize, usize)> {
        let mut folded = Vec::new();
        for y in 0..self.x.height - 1 {
            for x in 0..self.x.width - 1 {
                let corner = |dx: usize, dy: usize| [self.x.at(x + dx, y + dy), self.y.at(x + dx, y + dy)];
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if area(a, b, c).min(area(a, c, d)) <= 0.0 {
                    folded.push((x, y));
                }
            }
        }
        folded
    }

    /// The same warp mixed with the even one: `share` of this.
    fn towards_even(&self, share: f64, width: usize, height: usize) -> Self {
        let mix = |field: &Field<f64>, to: usize, along_x: bool| {
            let last = if along_x { field.width } else { field.height } - 1;
            Field::from_fn(field.width, field.height, |x, y| {
                let even = if along_x { x } else { y } as f64 * (to - 1) as f64 / last as f64;
                even + share * (field.at(x, y) - even)
            })
        };
        Self { x: mix(&self.x, width, true), y: mix(&self.y, height, false) }
    }

    /// A warp without folds: where cells fold their energies are raised and the equations solved again; if that does
    /// not help, the warp is mixed with the even one, which has none.
    pub(crate) fn without_folds(
        energy: &Field<f64>,
        floor: f64,
        gluing: Gluing,
        width: usize,
        height: usize,
        task: &Task<'_>,
    ) -> Result<Self> {
        const ROUNDS: usize = 6;
        const SHARES: usize = 20;
        let mut warp = Self::new(energy, floor, gluing, width, height, task)?;
        let mut stiffer = energy.clone();
        for _ in 0..ROUNDS {
            let folded = warp.folded();
            if folded.is_empty() {
                return Ok(warp);
            }
            stiffen(&mut stiffer, &folded, floor, gluing);
            warp = Self::new(&stiffer, floor, gluing, width, height, task)?;
        }
        let shares = (0..=SHARES).rev().map(|i| i as f64 / SHARES as f64);
        let mut mixed = shares.map(|share| warp.towards_even(share, width, height));
        mixed.find(|warp| warp.folded().is_empty()).ok_or(Error::NoConvergence {
            what: "a warp without folded cells",
            after: SHARES,
            residual: 1.0,
        })
    }
}

/// Twice the signed area of a triangle.
pub(crate) fn area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Doubles the energy of the samples of folded cells and of those around them. (Steeper rises fold at their edge.)
fn stiffen(energy: &mut Field<f64>, folded: &[(usize, usize)], floor: f64, gluing: Gluing) {
    const REACH: usize = 4;
    let (width, height) = (energy.width, energy.height);
    let mut touched = vec![false; width * height];
    for &(x, y) in folded {
        for near_y in y.saturating_sub(REACH)..=(y + 1 + REACH).min(height - 1) {
            for near_x in x.saturating_sub(REACH)..=(x + 1 + REACH).min(width - 1) {
                touched[near_y * width + near_x] = true;
            }
        }
    }
    if gluing == Gluing::Orbifold {
        // Both sides of a glued border keep one energy.
        let turned = |p: usize| {
            let (x, y) = (p % width, p / width);
            if y == 0 || y == height - 1 { y * width + width - 1 - x } else { (height - 1 - y) * width + x }
        };
        let border = (0..width * height).filter(|p| {
            let (x, y) = (p % width, p / width);
            x == 0 || x == width - 1 || y == 0 || y == height - 1
        });
        for p in border.collect::<Vec<_>>() {
            if touched[p] {
                touched[turned(p)] = true;
            }
        }
    }
    for (e, _) in energy.values.iter_mut().zip(touched).filter(|(_, touched)| *touched) {
        *e = (2.0 * e.max(floor)).min(1.0);
    }
}

/// The columns to which the samples go.
fn positions(weights: &Field<f64>, target: usize, gluing: Gluing, task: &Task<'_>) -> Result<Field<f64>> {
    let (width, height) = (weights.width, weights.height);
    let step = (target - 1) as f64 / (width - 1) as f64;
    let even = |x: usize| x as f64 * step;
    let inner = width - 2;
    let mut shifts = vec![0.0; inner * height];
    if target != width && inner > 0 {
        let along = |x: usize, y: usize| weights.at(x, y) + weights.at(x + 1, y); // between x and x + 1
        let mut load = Vec::with_capacity(inner * height);
        for y in 0..height {
            load.extend((1..=inner).map(|x| (1.0 - step) * (along(x - 1, y) - along(x, y))));
        }
        let matrix = Multigrid::new(
            inner,
            height,
            |x, y| along(x + 1, y),
            |x, y| weights.at(x + 1, y),
            |x, y| if x == 0 { along(0, y) } else { 0.0 } + if x + 1 == inner { along(inner, y) } else { 0.0 },
        );
        shifts = solve(matrix, load, (inner, height), gluing, task)?;
    }
    Ok(Field::from_fn(width, height, |x, y| match x {
        0 => 0.0,
        x if x == width - 1 => (target - 1) as f64,
        x => even(x) + shifts[y * inner + x - 1],
    }))
}

/// Conjugate gradients, preconditioned. On an orbifold within the shifts whose first and last rows are mirrored.
fn solve(
    mut matrix: Multigrid,
    load: Vec<f64>,
    (width, height): (usize, usize),
    gluing: Gluing,
    task: &Task<'_>,
) -> Result<Vec<f64>> {
    let mirror = |v: &mut [f64]| {
        if gluing == Gluing::Orbifold {
            mirror_row(&mut v[..width]);
            mirror_row(&mut v[(height - 1) * width..]);
        }
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut residual = load;
    mirror(&mut residual);
    let mut solution = vec![0.0; residual.len()];
    let (mut near, mut image) = (vec![0.0; residual.len()], vec![0.0; residual.len()]);
    matrix.cycle(&residual, &mut near);
    mirror(&mut near);
    let mut direction = near.clone();
    let mut size = dot(&residual, &near);
    let wanted = size * PRECISION * PRECISION;
    let mut iterations = 0;
    while size > wanted {
        if iterations == MOST_ITERATIONS {
            return Err(Error::NoConvergence {
                what: "the warp",
                after: iterations,
                residual: (size / wanted).sqrt() * PRECISION,
            });
        }
        if task.is_over() {
            return Err(Error::Cancelled);
        }
        iterations += 1;
        matrix.times(&direction, &mut image);
        mirror(&mut image);
        let length = size / dot(&direction, &image);
        solution.iter_mut().zip(&direction).for_each(|(s, d)| *s += length * d);
        residual.iter_mut().zip(&image).for_each(|(r, i)| *r -= length * i);
        matrix.cycle(&residual, &mut near);
        mirror(&mut near);
        let next = dot(&residual, &near);
        let share = next / size;
        direction.iter_mut().zip(&near).for_each(|(d, n)| *d = n + share * *d);
        size = next;
    }
    Ok(solution)
}

/// The nearest row that changes its sign when it is turned round.
fn mirror_row(row: &mut [f64]) {
    let last = row.len() - 1;
    for i in 0..=last / 2 {
        let odd = (row[i] - row[last - i]) / 2.0;
        (row[i], row[last - i]) = (odd, -odd);
    }
    if last.is_multiple_of(2) {
        row[last / 2] = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::super::saliency::{Energy, saliency};
    use super::super::test_images::{bump, pillow, rough};
    use super::*;

    fn warp(energy: &Field<f64>, gluing: Gluing, to: (usize, usize)) -> Warp {
        Warp::new(energy, 0.02, gluing, to.0, to.1, &Task::default()).unwrap()
    }

    /// The equations of the paper, one row each, as a dense least-squares problem with the given signs.
    fn dense(energy: &Field<f64>, floor: f64, target: usize, gluing: Gluing) -> Field<f64> {
        let (width, height) = (energy.width, energy.height);
        let last = (target - 1) as f64;
        // Unknowns: the inner columns; on an orbifold the right halves of the first and last rows follow the left.
        let value = |x: usize, y: usize| -> (Option<(usize, f64)>, f64) {
            let of = |x: usize| y * width + x;
            let glued = gluing == Gluing::Orbifold && (y == 0 || y == height - 1);
            match x {
                0 => (None, 0.0),
                x if x == width - 1 => (None, last),
                x if glued && 2 * x == width - 1 => (None, last / 2.0),
                x if glued && 2 * x > width - 1 => (Some((of(width - 1 - x), -1.0)), last),
                x => (Some((of(x), 1.0)), 0.0),
            }
        };
        let n = width * height;
        let mut normal = vec![vec![0.0; n + 1]; n];
        let mut equation = |terms: [((usize, usize), f64); 2], right: f64, weight: f64| {
            let mut row = vec![0.0; n];
            let mut rest = right;
            for ((x, y), sign) in terms {
                let (unknown, fixed) = value(x, y);
                rest -= sign * fixed;
                if let Some((k, factor)) = unknown {
                    row[k] += sign * factor;
                }
            }
            for i in (0..n).filter(|&i| row[i] != 0.0) {
                for j in (0..n).filter(|&j| row[j] != 0.0) {
                    normal[i][j] += weight * weight * row[i] * row[j];
                }
                normal[i][n] += weight * weight * row[i] * rest;
            }
        };
        for y in 0..height {
            for x in 0..width {
                let e = energy.at(x, y).max(floor);
                if x > 0 {
                    equation([((x, y), 1.0), ((x - 1, y), -1.0)], 1.0, e);
                }
                if x + 1 < width {
                    equation([((x + 1, y), 1.0), ((x, y), -1.0)], 1.0, e);
                }
                if y + 1 < height {
                    equation([((x, y), 1.0), ((x, y + 1), -1.0)], 0.0, e);
                }
            }
        }
        // Gauss, where unknowns that do not occur stay 0.
        for k in 0..n {
            if normal[k][k] == 0.0 {
                continue;
            }
            for i in 0..n {
                if i != k && normal[i][k] != 0.0 {
                    let by = normal[i][k] / normal[k][k];
                    for j in 0..=n {
                        normal[i][j] -= by * normal[k][j];
                    }
                }
            }
        }
        Field::from_fn(width, height, |x, y| {
            let (unknown, fixed) = value(x, y);
            fixed + unknown.map_or(0.0, |(k, factor)| factor * normal[k][n] / normal[k][k])
        })
    }

    #[test]
    fn the_solution_is_that_of_the_papers_equations_solved_densely() {
        for (width, height, to) in [(7, 5, (5, 3)), (6, 9, (8, 4)), (3, 3, (2, 2)), (11, 4, (5, 7))] {
            let energy = saliency(&rough(width, height, Gluing::Open), 0.4, Energy::Robust);
            let warp = warp(&energy, Gluing::Open, to);
            let x = dense(&energy, 0.02, to.0, Gluing::Open);
            let y = dense(&energy.transposed(), 0.02, to.1, Gluing::Open).transposed();
            for p in 0..width * height {
                assert!((warp.x.values[p] - x.values[p]).abs() < 1e-6, "{} and {}", warp.x.values[p], x.values[p]);
                assert!((warp.y.values[p] - y.values[p]).abs() < 1e-6, "{} and {}", warp.y.values[p], y.values[p]);
            }
        }
    }

    #[test]
    fn on_an_orbifold_it_is_the_solution_among_those_that_stay_glued() {
        for (width, height, to) in [(9, 7, (5, 5)), (5, 11, (3, 7)), (7, 7, (9, 5))] {
            let energy = saliency(&rough(width, height, Gluing::Orbifold), 0.4, Energy::Robust);
            let warp = warp(&energy, Gluing::Orbifold, to);
            let x = dense(&energy, 0.02, to.0, Gluing::Orbifold);
            let y = dense(&energy.transposed(), 0.02, to.1, Gluing::Orbifold).transposed();
            for p in 0..width * height {
                assert!((warp.x.values[p] - x.values[p]).abs() < 1e-6);
                assert!((warp.y.values[p] - y.values[p]).abs() < 1e-6);
            }
            for i in 0..width {
                assert!((warp.x.at(i, 0) + warp.x.at(width - 1 - i, 0) - (to.0 - 1) as f64).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn an_image_that_keeps_its_size_stays_where_it_is() {
        let energy = saliency(&pillow(9, 9), 0.5, Energy::Robust);
        let warp = warp(&energy, Gluing::Orbifold, (9, 9));
        assert!((0..81).all(|p| warp.x.values[p] == (p % 9) as f64 && warp.y.values[p] == (p / 9) as f64));
    }

    #[test]
    fn samples_of_much_energy_keep_their_distance() {
        let image = bump(41, 41, 0.3);
        let energy = saliency(&image, 0.3, Energy::Robust);
        let warp = Warp::new(&energy, 0.02, Gluing::Open, 33, 33, &Task::default()).unwrap();
        let gap = |x: usize| warp.x.at(x + 1, 20) - warp.x.at(x, 20);
        assert!(gap(16) > 0.9 && gap(2) < 0.75, "{} at the bump, {} at the border", gap(16), gap(2));
    }

    #[test]
    fn equation_3_as_printed_would_pull_the_samples_together() {
        // E (x₁ − x₂) = E beside E (x₂ − x₁) = E: their least squares is x₂ = x₁, all of a row at one place.
        let sum = |gap: f64| (gap - 1.0) * (gap - 1.0) + (-gap - 1.0) * (-gap - 1.0);
        assert!(sum(0.0) < sum(0.5) && sum(0.0) < sum(-0.5));
        let read = |gap: f64| 2.0 * (gap - 1.0) * (gap - 1.0);
        assert!(read(1.0) < read(0.9) && read(1.0) < read(1.1));
    }

    #[test]
    fn folds_are_found_and_undone() {
        // A narrow gorge of low energy beside a cliff that refuses to move, shrunk by much more than a fifth.
        let energy = Field::from_fn(40, 40, |x, y| if (x / 7 + y / 5) % 2 == 0 { 1.0 } else { 0.001 });
        let task = Task::default();
        let folded = Warp::new(&energy, 0.001, Gluing::Open, 12, 12, &task).unwrap().folded();
        assert!(folded.len() > 20, "only {} cells fold", folded.len());
        let mended = Warp::without_folds(&energy, 0.001, Gluing::Open, 12, 12, &task).unwrap();
        assert!(mended.folded().is_empty());
        assert!((0..40).all(|i| mended.x.at(0, i) == 0.0 && mended.x.at(39, i) == 11.0 && mended.y.at(i, 39) == 11.0));
    }
}
