//! The discrete wavelet transform (Annex F): 5/3 reversible on integers, 9/7 irreversible on `f32`.
//!
//! Both are chains of lifting steps. A step changes every odd (high) sample by its two even neighbours, or every even
//! (low) one by its two odd neighbours; a neighbour beyond the end is the mirrored one, which for these kernels is
//! always the neighbour on the other side. A level is done first down the columns, then along the rows, and leaves the
//! low half before the high half in each direction, so that after all levels the sub-bands lie in the plane as in
//! Figure F.5 with LL in the corner.
//!
//! Columns are lifted in strips, a few dozen side by side; a strip and a row are the same thing to [`lift`], which
//! works on groups of samples.

use super::codestream::Transform;

/// α, β, γ, δ of Table F.4.
const LIFTING_97: [f32; 4] = [-1.586_134_3, -0.052_980_12, 0.882_911_1, 0.443_506_85];
/// K of Table F.4.
const SCALE_97: f32 = 1.230_174_1;

/// Columns that are lifted side by side: a strip of a tall plane still fits into the second-level cache.
const STRIP: usize = 32;

/// The samples of one plane that are transformed where they lie.
pub(super) struct Coefficients<T> {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) values: Vec<T>,
}

/// `levels` decompositions, each of the LL band of the one before.
pub(super) fn forward<T: Kernel>(plane: &mut Coefficients<T>, levels: u8) {
    let (mut width, mut height) = (plane.width, plane.height);
    let mut scratch = Vec::new();
    for _ in 0..levels {
        columns(plane, width, height, &mut scratch);
        rows(plane, width, height, &mut scratch);
        (width, height) = (width.div_ceil(2), height.div_ceil(2));
    }
}

fn columns<T: Kernel>(plane: &mut Coefficients<T>, width: usize, height: usize, scratch: &mut Vec<T>) {
    if height < 2 {
        return;
    }
    let low = height.div_ceil(2);
    let home = |row: usize| if row.is_multiple_of(2) { row / 2 } else { low + row / 2 };
    for x in (0..width).step_by(STRIP) {
        let across = STRIP.min(width - x);
        scratch.resize(height * across, T::default());
        for row in 0..height {
            scratch[home(row) * across..][..across].copy_from_slice(&plane.values[row * plane.width + x..][..across]);
        }
        let (l, h) = scratch.split_at_mut(low * across);
        T::analyse(l, h, across);
        for (row, strip) in scratch.chunks_exact(across).enumerate() {
            plane.values[row * plane.width + x..][..across].copy_from_slice(strip);
        }
    }
}

fn rows<T: Kernel>(plane: &mut Coefficients<T>, width: usize, height: usize, scratch: &mut Vec<T>) {
    if width < 2 {
        return;
    }
    let low = width.div_ceil(2);
    scratch.resize(width, T::default());
    for row in plane.values.chunks_mut(plane.width).take(height) {
        let row = &mut row[..width];
        let (l, h) = scratch[..width].split_at_mut(low);
        for ((l, h), pair) in l.iter_mut().zip(h.iter_mut()).zip(row.chunks_exact(2)) {
            (*l, *h) = (pair[0], pair[1]);
        }
        if width % 2 == 1 {
            l[low - 1] = row[width - 1];
        }
        T::analyse(l, h, 1);
        row.copy_from_slice(&scratch[..width]);
    }
}

/// Which of the two halves a lifting step changes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Half {
    Low,
    High,
}

impl Half {
    /// The neighbours, in the other half of `others` samples, of sample `i` of this half.
    pub(super) fn neighbours(self, i: usize, others: usize) -> [usize; 2] {
        let (before, after) = match self {
            Self::High => (Some(i), i + 1),
            Self::Low => (i.checked_sub(1), i),
        };
        // Mirrored at either end (Annex F.3.7).
        let after = if after < others { Some(after) } else { None };
        match (before, after) {
            (Some(a), Some(b)) => [a, b],
            (Some(a), None) => [a, a],
            (None, Some(b)) => [b, b],
            (None, None) => [0, 0],
        }
    }
}

/// One lifting step: `target[i] = f(target[i], source[a], source[b])` for the two neighbours `a` and `b` of each group.
fn lift<T: Copy>(half: Half, target: &mut [T], source: &[T], group: usize, f: impl Fn(T, T, T) -> T) {
    let (targets, sources) = (target.len() / group, source.len() / group);
    // Groups whose two neighbours both exist: from the first or second one on.
    let (first, end) = match half {
        Half::High => (0, targets.min(sources - 1)),
        Half::Low => (1, targets.min(sources)),
    };
    if first < end {
        let inner = &mut target[first * group..end * group];
        let n = inner.len();
        for ((t, a), b) in inner.iter_mut().zip(&source[..n]).zip(&source[group..][..n]) {
            *t = f(*t, *a, *b);
        }
    }
    for i in (0..first).chain(end.max(first)..targets) {
        let [a, b] = half.neighbours(i, sources);
        for k in 0..group {
            let t = &mut target[i * group + k];
            *t = f(*t, source[a * group + k], source[b * group + k]);
        }
    }
}

/// The kind of sample that a transform works on.
pub(super) trait Kernel: Copy + Default + Send + Sync {
    /// Lifts the even samples `low` and the odd samples `high`, in groups, into the two sub-bands.
    ///
    /// A signal of one sample stays as it is.
    fn analyse(low: &mut [Self], high: &mut [Self], group: usize);
}

impl Kernel for i32 {
    /// 5/3 reversible (F.4.8.1).
    fn analyse(low: &mut [i32], high: &mut [i32], group: usize) {
        if high.is_empty() {
            return;
        }
        lift(Half::High, high, low, group, |t, a, b| t - ((a + b) >> 1));
        lift(Half::Low, low, high, group, |t, a, b| t + ((a + b + 2) >> 2));
    }
}

impl Kernel for f32 {
    /// 9/7 irreversible (F.4.8.2).
    fn analyse(low: &mut [f32], high: &mut [f32], group: usize) {
        if high.is_empty() {
            return;
        }
        let [alpha, beta, gamma, delta] = LIFTING_97;
        lift(Half::High, high, low, group, |t, a, b| t + alpha * (a + b));
        lift(Half::Low, low, high, group, |t, a, b| t + beta * (a + b));
        lift(Half::High, high, low, group, |t, a, b| t + gamma * (a + b));
        lift(Half::Low, low, high, group, |t, a, b| t + delta * (a + b));
        low.iter_mut().for_each(|l| *l *= 1.0 / SCALE_97);
        high.iter_mut().for_each(|h| *h *= SCALE_97);
    }
}

/// The lifting steps of a transform in the order of synthesis, each by the half that it changes.
pub(super) fn synthesis_steps(transform: Transform) -> &'static [Half] {
    match transform {
        Transform::Reversible53 => &[Half::Low, Half::High],
        Transform::Irreversible97 => &[Half::Low, Half::High, Half::Low, Half::High],
    }
}

/// The inverse transforms, written plainly: what the decoders do, for tests only.
#[cfg(test)]
pub(super) mod synthesis {
    use super::*;

    /// A signal from its two halves.
    pub(in super::super) fn line_53(low: &[i32], high: &[i32]) -> Vec<i32> {
        let (mut low, mut high) = (low.to_vec(), high.to_vec());
        if !high.is_empty() {
            lift(Half::Low, &mut low, &high, 1, |t, a, b| t - ((a + b + 2) >> 2));
            lift(Half::High, &mut high, &low, 1, |t, a, b| t + ((a + b) >> 1));
        }
        interleave(&low, &high)
    }

    /// A signal from its two halves: the 9/7 kernel, or the 5/3 kernel without its rounding.
    pub(in super::super) fn line_linear(transform: Transform, low: &[f64], high: &[f64]) -> Vec<f64> {
        let (mut low, mut high) = (low.to_vec(), high.to_vec());
        if !high.is_empty() {
            match transform {
                Transform::Reversible53 => {
                    lift(Half::Low, &mut low, &high, 1, |t, a, b| t - (a + b) / 4.0);
                    lift(Half::High, &mut high, &low, 1, |t, a, b| t + (a + b) / 2.0);
                }
                Transform::Irreversible97 => {
                    let [alpha, beta, gamma, delta] = LIFTING_97.map(f64::from);
                    low.iter_mut().for_each(|l| *l *= f64::from(SCALE_97));
                    high.iter_mut().for_each(|h| *h /= f64::from(SCALE_97));
                    lift(Half::Low, &mut low, &high, 1, |t, a, b| t - delta * (a + b));
                    lift(Half::High, &mut high, &low, 1, |t, a, b| t - gamma * (a + b));
                    lift(Half::Low, &mut low, &high, 1, |t, a, b| t - beta * (a + b));
                    lift(Half::High, &mut high, &low, 1, |t, a, b| t - alpha * (a + b));
                }
            }
        }
        interleave(&low, &high)
    }

    fn interleave<T: Copy>(low: &[T], high: &[T]) -> Vec<T> {
        (0..low.len() + high.len()).map(|i| if i % 2 == 0 { low[i / 2] } else { high[i / 2] }).collect()
    }

    /// A whole plane.
    pub(in super::super) fn plane<T: Copy + Default>(
        plane: &mut Coefficients<T>,
        levels: u8,
        line: impl Fn(&[T], &[T]) -> Vec<T>,
    ) {
        for level in (0..levels).rev() {
            let (width, height) = (plane.width.div_ceil(1 << level), plane.height.div_ceil(1 << level));
            for y in 0..height {
                let row = &mut plane.values[y * plane.width..][..width];
                let (l, h) = row.split_at(width.div_ceil(2));
                let whole = line(l, h);
                row.copy_from_slice(&whole);
            }
            for x in 0..width {
                let column: Vec<T> = (0..height).map(|y| plane.values[y * plane.width + x]).collect();
                let (l, h) = column.split_at(height.div_ceil(2));
                for (y, v) in line(l, h).into_iter().enumerate() {
                    plane.values[y * plane.width + x] = v;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn noise(n: usize, seed: u32) -> impl Iterator<Item = i32> {
        let mut x = seed | 1;
        (0..n).map(move |_| {
            x ^= x << 13;
            x ^= x >> 17;
            x ^= x << 5;
            (x >> 16) as i32
        })
    }

    proptest! {
        #[test]
        fn the_reversible_transform_comes_back_exactly(w in 1usize..80, h in 1usize..80, levels in 0u8..6, seed: u32) {
            let values: Vec<i32> = noise(w * h, seed).collect();
            let mut plane = Coefficients { width: w, height: h, values: values.clone() };
            forward(&mut plane, levels);
            synthesis::plane(&mut plane, levels, synthesis::line_53);
            prop_assert_eq!(plane.values, values);
        }

        #[test]
        fn the_irreversible_transform_comes_back_within_rounding(w in 1usize..80, h in 1usize..80, levels in 0u8..6, seed: u32) {
            let values: Vec<f32> = noise(w * h, seed).map(|v| v as f32).collect();
            let mut plane = Coefficients { width: w, height: h, values: values.clone() };
            forward(&mut plane, levels);
            let mut back = Coefficients { width: w, height: h, values: plane.values.iter().map(|&v| f64::from(v)).collect() };
            synthesis::plane(&mut back, levels, |l, h| synthesis::line_linear(Transform::Irreversible97, l, h));
            for (a, b) in back.values.iter().zip(&values) {
                prop_assert!((a - f64::from(*b)).abs() < 0.5, "{} came back as {}", b, a);
            }
        }
    }

    #[test]
    fn a_constant_plane_has_its_value_in_the_low_band_and_nothing_elsewhere() {
        let mut plane = Coefficients { width: 37, height: 20, values: vec![1000.0f32; 740] };
        forward(&mut plane, 2);
        for (i, v) in plane.values.iter().enumerate() {
            let in_low = i % 37 < 10 && i / 37 < 5;
            assert!((v - if in_low { 1000.0 } else { 0.0 }).abs() < 0.01, "{v} at {i}");
        }
    }
}
