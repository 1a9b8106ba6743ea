//! A multigrid for symmetric matrices on a rectangle in which every unknown meets its neighbours only.
//!
//! The equations of a warp weigh neighbours by energies that jump by factors of thousands, where interpolation between
//! coarse unknowns must follow the weights. So every coarse grid (every second row and column) is made from the matrix
//! alone: interpolation from its rows, the coarse matrix from both ("black box multigrid": Dendy, J. Comput. Phys. 48,
//! 1982). One cycle is a symmetric positive definite preconditioner whatever the weights; it costs O(unknowns).

/// One grid: couplings to the right, below, below right and below left, positive where the matrix has −; a frame of
/// zeros around all spares every question about the border.
#[derive(Debug)]
struct Grid {
    width: usize,
    height: usize,
    stride: usize,
    centre: Vec<f64>,
    inverse: Vec<f64>,
    right: Vec<f64>,
    below: Vec<f64>,
    below_right: Vec<f64>,
    below_left: Vec<f64>,
    /// Whether the diagonal couplings are zero, as on the finest grid.
    five: bool,
    solution: Vec<f64>,
    load: Vec<f64>,
    residual: Vec<f64>,
    /// The 3 × 3 unknowns of this grid around each unknown of the next: their shares of it.
    shares: Vec<[f64; 9]>,
}

/// All grids, the finest first.
#[derive(Debug)]
pub(super) struct Multigrid {
    grids: Vec<Grid>,
}

/// Sweeps on the coarsest grid, which has at most 3 × 3 unknowns.
const COARSEST_SWEEPS: usize = 8;

impl Multigrid {
    /// From the couplings of each unknown to the right and below, and what its diagonal has beyond them.
    pub(super) fn new(
        width: usize,
        height: usize,
        right: impl Fn(usize, usize) -> f64,
        below: impl Fn(usize, usize) -> f64,
        beyond: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let mut finest = Grid::empty(width, height);
        finest.five = true;
        for y in 0..height {
            for x in 0..width {
                let k = finest.index(x, y);
                if x + 1 < width {
                    finest.right[k] = right(x, y);
                }
                if y + 1 < height {
                    finest.below[k] = below(x, y);
                }
                finest.centre[k] = beyond(x, y);
            }
        }
        for y in 0..height {
            for x in 0..width {
                let k = finest.index(x, y);
                let around = finest.right[k] + finest.right[k - 1] + finest.below[k] + finest.below[k - finest.stride];
                finest.centre[k] += around;
            }
        }
        finest.invert();
        let mut grids = vec![finest];
        loop {
            let last = grids.last_mut().expect("the finest grid");
            if last.width <= 3 && last.height <= 3 {
                break;
            }
            let coarse = last.coarser();
            grids.push(coarse);
        }
        Self { grids }
    }

    /// The matrix times a vector (row by row), written to `out`.
    pub(super) fn times(&mut self, vector: &[f64], out: &mut [f64]) {
        let finest = &mut self.grids[0];
        finest.fill_solution(vector);
        for y in 0..finest.height {
            for x in 0..finest.width {
                let k = finest.index(x, y);
                out[y * finest.width + x] = finest.centre[k] * finest.solution[k] - finest.pull(k);
            }
        }
    }

    /// One cycle for the load `vector`: about the inverse of the matrix times it.
    pub(super) fn cycle(&mut self, vector: &[f64], out: &mut [f64]) {
        let finest = &mut self.grids[0];
        let width = finest.width;
        for (y, line) in vector.chunks_exact(width).enumerate() {
            let k = finest.index(0, y);
            finest.load[k..k + width].copy_from_slice(line);
        }
        descend(&mut self.grids);
        let finest = &self.grids[0];
        for (y, line) in out.chunks_exact_mut(width).enumerate() {
            let k = finest.index(0, y);
            line.copy_from_slice(&finest.solution[k..k + width]);
        }
    }
}

fn descend(grids: &mut [Grid]) {
    let Some((grid, coarser)) = grids.split_first_mut() else { return };
    grid.solution.fill(0.0);
    let Some(next) = coarser.first_mut() else {
        (0..COARSEST_SWEEPS).for_each(|_| grid.sweep_forth());
        (0..COARSEST_SWEEPS).for_each(|_| grid.sweep_back());
        return;
    };
    grid.sweep_forth();
    grid.restrict(next);
    descend(coarser);
    grid.correct(&coarser[0]);
    grid.sweep_back();
}

impl Grid {
    fn empty(width: usize, height: usize) -> Self {
        let stride = width + 2;
        let zeros = || vec![0.0; stride * (height + 2)];
        Self {
            width,
            height,
            stride,
            centre: zeros(),
            inverse: zeros(),
            right: zeros(),
            below: zeros(),
            below_right: zeros(),
            below_left: zeros(),
            five: false,
            solution: zeros(),
            load: zeros(),
            residual: zeros(),
            shares: Vec::new(),
        }
    }

    #[inline]
    fn index(&self, x: usize, y: usize) -> usize {
        (y + 1) * self.stride + x + 1
    }

    fn invert(&mut self) {
        for (inverse, &centre) in self.inverse.iter_mut().zip(&self.centre) {
            *inverse = if centre > 0.0 { 1.0 / centre } else { 0.0 };
        }
    }

    fn fill_solution(&mut self, vector: &[f64]) {
        for (y, line) in vector.chunks_exact(self.width).enumerate() {
            let k = self.index(0, y);
            self.solution[k..k + self.width].copy_from_slice(line);
        }
    }

    /// What the neighbours of unknown `k` add to its equation.
    #[inline]
    fn pull(&self, k: usize) -> f64 {
        let (x, stride) = (&self.solution, self.stride);
        let mut sum = self.below[k] * x[k + stride] + self.below[k - stride] * x[k - stride];
        if !self.five {
            sum += self.below_right[k] * x[k + stride + 1] + self.below_right[k - stride - 1] * x[k - stride - 1];
            sum += self.below_left[k] * x[k + stride - 1] + self.below_left[k - stride + 1] * x[k - stride + 1];
        }
        sum + self.right[k] * x[k + 1] + self.right[k - 1] * x[k - 1]
    }

    /// Gauss–Seidel from the first unknown to the last.
    fn sweep_forth(&mut self) {
        for y in 0..self.height {
            let start = self.index(0, y);
            for k in start..start + self.width {
                self.solution[k] = self.inverse[k] * (self.load[k] + self.pull(k));
            }
        }
    }

    /// Gauss–Seidel from the last unknown to the first, so that the cycle is symmetric.
    fn sweep_back(&mut self) {
        for y in (0..self.height).rev() {
            let start = self.index(0, y);
            for k in (start..start + self.width).rev() {
                self.solution[k] = self.inverse[k] * (self.load[k] + self.pull(k));
            }
        }
    }

    fn restrict(&mut self, next: &mut Grid) {
        for y in 0..self.height {
            let start = self.index(0, y);
            for k in start..start + self.width {
                self.residual[k] = self.load[k] + self.pull(k) - self.centre[k] * self.solution[k];
            }
        }
        let (stride, residual) = (self.stride, &self.residual);
        for y in 0..next.height {
            for x in 0..next.width {
                let share = &self.shares[y * next.width + x];
                // The frame of the residual is zero, and so are the shares that would lie beyond it.
                let top = 2 * y * stride + 2 * x;
                let mut sum = 0.0;
                for row in 0..3 {
                    let r = &residual[top + row * stride..][..3];
                    sum += share[3 * row] * r[0] + share[3 * row + 1] * r[1] + share[3 * row + 2] * r[2];
                }
                let k = next.index(x, y);
                next.load[k] = sum;
            }
        }
    }

    fn correct(&mut self, next: &Grid) {
        for y in 0..next.height {
            for x in 0..next.width {
                let (share, value) = (&self.shares[y * next.width + x], next.solution[next.index(x, y)]);
                let top = 2 * y * self.stride + 2 * x;
                for row in 0..3 {
                    let s = &mut self.solution[top + row * self.stride..][..3];
                    (0..3).for_each(|i| s[i] += share[3 * row + i] * value);
                }
            }
        }
    }

    /// The grid of every second row and column, and the shares that lead to it.
    fn coarser(&mut self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        self.shares = self.all_shares(width, height);
        let mut coarse = Self::empty(width, height);
        for y in 0..height {
            for x in 0..width {
                let (at, k) = (y * width + x, coarse.index(x, y));
                let column = self.column(x, y, &self.shares[at]);
                let (right, below) = (x + 1 < width, y + 1 < height);
                coarse.centre[k] = against(&self.shares[at], &column, 0, 0);
                if right {
                    coarse.right[k] = -against(&self.shares[at + 1], &column, 1, 0);
                }
                if below {
                    coarse.below[k] = -against(&self.shares[at + width], &column, 0, 1);
                }
                if below && right {
                    coarse.below_right[k] = -against(&self.shares[at + width + 1], &column, 1, 1);
                }
                if below && x > 0 {
                    coarse.below_left[k] = -against(&self.shares[at + width - 1], &column, -1, 1);
                }
            }
        }
        coarse.invert();
        coarse
    }

    /// This matrix times the shares of one coarse unknown: 5 × 5 values around it.
    fn column(&self, x: usize, y: usize, share: &[f64; 9]) -> [f64; 25] {
        // The shares in a frame of two zeros.
        let mut wide = [0.0; 49];
        (0..9).for_each(|i| wide[7 * (i / 3 + 2) + i % 3 + 2] = share[i]);
        let mut column = [0.0; 25];
        for (j, fy) in (0..5).zip(2 * y..).filter(|&(_, fy)| (2..self.height + 2).contains(&fy)) {
            for (i, fx) in (0..5).zip(2 * x..).filter(|&(_, fx)| (2..self.width + 2).contains(&fx)) {
                let (k, at, stride) = (self.index(fx - 2, fy - 2), 7 * (j + 1) + i + 1, self.stride);
                let mut sum = self.centre[k] * wide[at];
                sum -= self.right[k] * wide[at + 1] + self.right[k - 1] * wide[at - 1];
                sum -= self.below[k] * wide[at + 7] + self.below[k - stride] * wide[at - 7];
                if !self.five {
                    sum -= self.below_right[k] * wide[at + 8] + self.below_right[k - stride - 1] * wide[at - 8];
                    sum -= self.below_left[k] * wide[at + 6] + self.below_left[k - stride + 1] * wide[at - 6];
                }
                column[5 * j + i] = sum;
            }
        }
        column
    }

    /// What the unknowns of this grid take from those of the next, sorted by the latter.
    fn all_shares(&self, width: usize, height: usize) -> Vec<[f64; 9]> {
        let mut shares = vec![[0.0; 9]; width * height];
        let mut give = |x: usize, y: usize, which: usize, share: f64| {
            if x < width && y < height {
                shares[y * width + x][which] = share;
            }
        };
        for fy in 0..self.height {
            for fx in 0..self.width {
                let (k, x, y) = (self.index(fx, fy), fx / 2, fy / 2);
                match (fx % 2, fy % 2) {
                    (0, 0) => give(x, y, 4, 1.0),
                    (1, 0) => {
                        let [left, right] = self.between_columns(k);
                        give(x, y, 5, left);
                        give(x + 1, y, 3, right);
                    }
                    (0, _) => {
                        let [above, below] = self.between_rows(k);
                        give(x, y, 7, above);
                        give(x, y + 1, 1, below);
                    }
                    _ => {
                        let [above_left, above_right, below_left, below_right] = self.between_both(k);
                        give(x, y, 8, above_left);
                        give(x + 1, y, 6, above_right);
                        give(x, y + 1, 2, below_left);
                        give(x + 1, y + 1, 0, below_right);
                    }
                }
            }
        }
        shares
    }

    /// The shares that an unknown between two coarse columns takes from its left and its right.
    fn between_columns(&self, k: usize) -> [f64; 2] {
        let stride = self.stride;
        let left = self.right[k - 1] + self.below_right[k - stride - 1] + self.below_left[k];
        let right = self.right[k] + self.below_left[k - stride + 1] + self.below_right[k];
        split(left, right, self.centre[k] - self.below[k] - self.below[k - stride])
    }

    /// The shares that an unknown between two coarse rows takes from above and from below.
    fn between_rows(&self, k: usize) -> [f64; 2] {
        let stride = self.stride;
        let above = self.below[k - stride] + self.below_right[k - stride - 1] + self.below_left[k - stride + 1];
        let below = self.below[k] + self.below_left[k] + self.below_right[k];
        split(above, below, self.centre[k] - self.right[k] - self.right[k - 1])
    }

    /// The shares that an unknown between both takes from the four around it, clockwise rows first.
    fn between_both(&self, k: usize) -> [f64; 4] {
        let stride = self.stride;
        let (up, down) = (self.between_columns(k - stride), self.between_columns(k + stride));
        let (left, right) = (self.between_rows(k - 1), self.between_rows(k + 1));
        let (above, below) = (self.below[k - stride], self.below[k]);
        let (before, after) = (self.right[k - 1], self.right[k]);
        let sums = [
            self.below_right[k - stride - 1] + above * up[0] + before * left[0],
            self.below_left[k - stride + 1] + above * up[1] + after * right[0],
            self.below_left[k] + below * down[0] + before * left[1],
            self.below_right[k] + below * down[1] + after * right[1],
        ];
        sums.map(|sum| sum * self.inverse[k])
    }
}

/// Shares in proportion to the pull of both sides; less than 1 together where a fixed value pulls too.
fn split(one: f64, other: f64, all: f64) -> [f64; 2] {
    let (one, other) = (one.max(0.0), other.max(0.0));
    let all = all.max(one + other);
    if all > 0.0 { [one / all, other / all] } else { [0.0; 2] }
}

/// The shares of the coarse unknown `right` and `down` of another times that one's column.
fn against(share: &[f64; 9], column: &[f64; 25], right: isize, down: isize) -> f64 {
    let mut sum = 0.0;
    for (j, row) in (0..3).map(|j| (j, 2 * down + j + 1)).filter(|&(_, row)| row < 5) {
        for (i, at) in (0..3).map(|i| (i, 2 * right + i + 1)).filter(|&(_, at)| (0..5).contains(&at)) {
            sum += share[(3 * j + i) as usize] * column[(5 * row + at) as usize];
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights that jump from patch to patch by factors up to 2500, as squared energies of at least 0.02 do.
    fn weight(x: usize, y: usize, which: usize) -> f64 {
        let patch = (x / 3 * 2_654_435_761 + y / 4 * 40_503) % 1_000_003;
        let grain = 0.5 + ((x * 31 + y * 17 + which * 7) % 11) as f64 / 11.0;
        grain * if patch.is_multiple_of(3) { 1.0 } else { 4e-4 + 1e-2 * (patch as f64 / 1_000_003.0) }
    }

    fn matrix(width: usize, height: usize) -> Multigrid {
        let beyond = |x: usize, y: usize| if x == 0 || x + 1 == width { weight(x, y, 2) } else { 0.0 };
        Multigrid::new(width, height, |x, y| weight(x, y, 0), |x, y| weight(x, y, 1), beyond)
    }

    fn dense(width: usize, height: usize, f: impl Fn(&mut Multigrid, &[f64], &mut [f64])) -> Vec<Vec<f64>> {
        let (n, mut grids) = (width * height, matrix(width, height));
        let column = |k: usize| {
            let unit: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i == k))).collect();
            let mut out = vec![0.0; n];
            f(&mut grids, &unit, &mut out);
            out
        };
        (0..n).map(column).collect()
    }

    #[test]
    fn the_matrix_is_that_of_the_couplings() {
        let (width, height) = (6, 5);
        let rows = dense(width, height, |grids, unit, out| grids.times(unit, out));
        for (k, row) in rows.iter().enumerate() {
            let (x, y) = (k % width, k / width);
            let mut expected = vec![0.0; width * height];
            let mut meet = |other: Option<usize>, weight: f64| {
                expected[k] += weight;
                if let Some(other) = other {
                    expected[other] = -weight;
                }
            };
            if x + 1 < width {
                meet(Some(k + 1), weight(x, y, 0));
            }
            if x > 0 {
                meet(Some(k - 1), weight(x - 1, y, 0));
            }
            if y + 1 < height {
                meet(Some(k + width), weight(x, y, 1));
            }
            if y > 0 {
                meet(Some(k - width), weight(x, y - 1, 1));
            }
            if x == 0 || x + 1 == width {
                meet(None, weight(x, y, 2));
            }
            assert!(row.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-15));
        }
    }

    #[test]
    fn a_cycle_is_symmetric_and_positive_for_any_size() {
        for (width, height) in [(1, 1), (1, 9), (9, 1), (4, 7), (8, 8), (13, 6)] {
            let rows = dense(width, height, |grids, unit, out| grids.cycle(unit, out));
            for i in 0..rows.len() {
                assert!(rows[i][i] > 0.0);
                for j in 0..i {
                    let (a, b) = (rows[i][j], rows[j][i]);
                    assert!((a - b).abs() <= 1e-9 * (rows[i][i] * rows[j][j]).sqrt(), "{width} x {height}: {a} and {b}");
                }
            }
        }
    }

    #[test]
    fn cycles_alone_solve_equations_whose_weights_jump() {
        let (width, height) = (61, 47);
        let mut grids = matrix(width, height);
        let wanted: Vec<f64> = (0..width * height).map(|k| ((k * 37) % 101) as f64 / 50.0 - 1.0).collect();
        let mut load = vec![0.0; wanted.len()];
        grids.times(&wanted, &mut load);
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let first = norm(&load);
        let (mut more, mut image) = (vec![0.0; load.len()], vec![0.0; load.len()]);
        for _ in 0..30 {
            grids.cycle(&load, &mut more);
            grids.times(&more, &mut image);
            load.iter_mut().zip(&image).for_each(|(l, i)| *l -= i);
        }
        assert!(norm(&load) < 1e-5 * first, "{} of {first} left", norm(&load));
    }
}
