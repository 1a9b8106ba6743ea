//! Steps: what integers stand for (spec/wavelet.md, "Quantiser").
//!
//! One step Δ for all: a coefficient that is wrong by e makes the image wrong by e · g, where g is the norm of its basis
//! function, so its own step is Δ / g. Along the two tangents the steps are twice as large.

/// Norms of the basis functions on a line: of a sample and of a detail, 1, 2, … levels up.
static NORMS: [[f64; 2]; 16] = [
    [1.280_868_845_744_949_7, 0.809_253_957_527_201_4],
    [1.791_585_284_610_043_3, 0.966_665_794_657_171_4],
    [2.531_513_435_878_13, 1.339_398_972_437_139_1],
    [3.579_887_714_410_727, 1.891_148_865_979_367_4],
    [5.062_705_906_005_233, 2.674_189_216_350_251_6],
    [7.159_745_549_772_852, 3.781_846_759_086_094_7],
    [10.125_409_097_686_017, 5.348_336_440_767_932],
    [14.319_490_856_093_2, 7.563_689_703_035_003],
    [20.250_818_173_683_466, 10.696_672_539_329_432],
    [28.638_981_710_261_21, 15.127_379_375_582_747],
    [40.501_636_347_366_93, 21.393_345_078_658_864],
    [57.277_963_420_522_42, 30.254_758_751_165_494],
    [81.003_272_694_733_86, 42.786_690_157_317_73],
    [114.555_926_841_044_84, 60.509_517_502_330_99],
    [162.006_545_389_467_72, 85.573_380_314_635_46],
    [229.111_853_682_089_68, 121.019_035_004_661_98],
];

/// The most levels.
pub(super) const MAX_LEVELS: u8 = 16;

/// A tangential step is so many normal ones.
const TANGENTIAL: f64 = 2.0;
/// A decoder takes a value to be so much (of a step) smaller than the middle of its interval.
const TOWARDS_ZERO: f64 = 0.02;
/// No index may be larger.
pub(super) const MAX_INDEX: i32 = 1 << 30;

/// Where a detail stands: at an odd column, an odd row, or both.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Band {
    Column,
    Row,
    Both,
}

impl Band {
    /// The band of a place, `None` at a coarse sample.
    #[inline]
    pub(super) fn of(row: usize, column: usize) -> Option<Self> {
        match (row % 2, column % 2) {
            (0, 0) => None,
            (0, _) => Some(Self::Column),
            (_, 0) => Some(Self::Row),
            _ => Some(Self::Both),
        }
    }
}

/// The steps of details of `level` (0 is the finest) along the normal and the two tangents.
pub(super) fn steps(step: f64, level: u8, band: Band) -> [f64; 3] {
    let [sample, detail] = NORMS[usize::from(level)];
    let norm = if band == Band::Both { detail * detail } else { detail * sample };
    let along = step / norm;
    [along, TANGENTIAL * along, TANGENTIAL * along]
}

/// The step of the coarse samples that are left after so many levels.
pub(super) fn coarse_step(step: f64, levels: u8) -> f64 {
    match levels.checked_sub(1) {
        None => step,
        Some(last) => step / (NORMS[usize::from(last)][0] * NORMS[usize::from(last)][0]),
    }
}

/// The value that an index stands for.
#[inline]
pub(super) fn value(index: i32, step: f64) -> f64 {
    let size = f64::from(index.unsigned_abs());
    match index {
        0 => 0.0,
        _ if index > 0 => (size - TOWARDS_ZERO) * step,
        _ => -((size - TOWARDS_ZERO) * step),
    }
}

#[cfg(test)]
mod tests {
    use super::super::lifting::Grid;
    use super::*;
    use crate::plane::{Gluing, Shape};

    /// The norm of what one coefficient makes of an image of zeros.
    fn synthesised(level: u8, row: usize, column: usize) -> f64 {
        let side = 24 << (level + 1);
        let mut sides = vec![side + 1];
        (0..=level).for_each(|l| sides.push(sides[usize::from(l)] / 2 + 1));
        let grid = |n: usize| Grid {
            shape: Shape::new(n as u32, n as u32).unwrap(),
            gluing: Gluing::Open,
            points: vec![[0.0; 3]; n * n],
        };
        let mut fine = grid(sides[usize::from(level)]);
        let middle = sides[usize::from(level) + 1] / 2 * 2;
        let width = fine.shape.width();
        fine.points[(middle + row) * width + middle + column][0] = 1.0;
        fine.synthesise();
        for l in (0..level).rev() {
            let mut finer = grid(sides[usize::from(l)]);
            finer.put_coarse(&fine);
            finer.synthesise();
            fine = finer;
        }
        fine.points.iter().map(|p| p[0] * p[0]).sum::<f64>().sqrt()
    }

    #[test]
    fn the_norms_are_those_of_the_basis_functions() {
        for level in 0..3 {
            for (band, row, column) in [(Band::Column, 0, 1), (Band::Row, 1, 0), (Band::Both, 1, 1)] {
                let norm = 1.0 / steps(1.0, level, band)[0];
                assert!((norm - synthesised(level, row, column)).abs() < 1e-9, "level {level}, {band:?}: {norm}");
            }
            assert!((1.0 / coarse_step(1.0, level + 1) - synthesised(level, 0, 0)).abs() < 1e-9);
        }
        for [a, b] in NORMS.windows(2).skip(8).map(|w| [w[0], w[1]]) {
            assert!((0..2).all(|i| (b[i] / a[i] - 2_f64.sqrt()).abs() < 1e-3), "{a:?} {b:?}");
        }
    }

    #[test]
    fn an_index_stands_for_a_value_near_its_own() {
        for (index, wanted) in [(0, 0.0), (1, 0.98), (-1, -0.98), (7, 6.98)] {
            assert!((value(index, 1.0) - wanted).abs() < 1e-12);
        }
    }
}
