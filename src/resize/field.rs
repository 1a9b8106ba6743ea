//! Rectangles of values that belong to the samples of a geometry image, and what lies beyond the image's border.

use crate::plane::Gluing;

/// One value for every sample, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Field<T> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) values: Vec<T>,
}

impl<T: Copy> Field<T> {
    pub(crate) fn new(width: usize, height: usize, values: Vec<T>) -> Self {
        debug_assert_eq!(values.len(), width * height);
        Self { width, height, values }
    }

    pub(crate) fn from_fn(width: usize, height: usize, f: impl Fn(usize, usize) -> T) -> Self {
        let mut values = Vec::with_capacity(width * height);
        for y in 0..height {
            values.extend((0..width).map(|x| f(x, y)));
        }
        Self { width, height, values }
    }

    #[inline]
    pub(crate) fn at(&self, x: usize, y: usize) -> T {
        self.values[y * self.width + x]
    }

    pub(crate) fn row(&self, y: usize) -> &[T] {
        &self.values[y * self.width..(y + 1) * self.width]
    }

    /// Columns as rows.
    pub(crate) fn transposed(&self) -> Self {
        Self::from_fn(self.height, self.width, |x, y| self.at(y, x))
    }
}

impl Field<[f64; 2]> {
    /// The value at a fractional column and row, linear between samples; outside, that of the border.
    pub(crate) fn linear(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let cell = |at: f64, side: usize| {
            let first = (at.max(0.0) as usize).min(side - 2);
            (first, (at - first as f64).clamp(0.0, 1.0))
        };
        let ((column, across), (row, down)) = (cell(x, self.width), cell(y, self.height));
        let mix = |a: [f64; 2], b: [f64; 2], t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        let above = mix(self.at(column, row), self.at(column + 1, row), across);
        let below = mix(self.at(column, row + 1), self.at(column + 1, row + 1), across);
        mix(above, below, down)
    }
}

/// The sample of an orbifold image that continues it at a place up to a side's length outside: the image turned by
/// half a turn about the middle of the side that is crossed.
pub(crate) fn beyond(width: usize, height: usize, x: isize, y: isize) -> (usize, usize) {
    let (last_x, last_y) = (width as isize - 1, height as isize - 1);
    let (mut x, mut y) = (x, y);
    if x < 0 {
        (x, y) = (-x, last_y - y);
    } else if x > last_x {
        (x, y) = (2 * last_x - x, last_y - y);
    }
    if y < 0 {
        (x, y) = (last_x - x, -y);
    } else if y > last_y {
        (x, y) = (last_x - x, 2 * last_y - y);
    }
    (x as usize, y as usize)
}

/// Differences of neighbouring samples along the rows and along the columns, for one sample of a unit: central inside,
/// one-sided on an open border; on a glued one the surface goes on beyond it. At the four cones, where both
/// neighbours along the border are one point, they are one-sided too.
pub(crate) fn differences(field: &Field<[f64; 3]>, gluing: Gluing, x: usize, y: usize) -> ([f64; 3], [f64; 3]) {
    let (width, height) = (field.width, field.height);
    let (last_x, last_y) = (width - 1, height - 1);
    let side = x == 0 || x == last_x || y == 0 || y == last_y;
    let cone = side && (2 * x == last_x || 2 * y == last_y);
    let sub = |a: [f64; 3], b: [f64; 3], step: f64| [0, 1, 2].map(|i| (a[i] - b[i]) / step);
    if gluing == Gluing::Orbifold && !cone {
        let get = |dx: isize, dy: isize| {
            let (x, y) = beyond(width, height, x as isize + dx, y as isize + dy);
            field.at(x, y)
        };
        return (sub(get(1, 0), get(-1, 0), 2.0), sub(get(0, 1), get(0, -1), 2.0));
    }
    let ends = |at: usize, last: usize| {
        // At a cone the neighbours on the border are the same point: the one after the cone only.
        let before = if at == 0 || (gluing == Gluing::Orbifold && at < last) { at } else { at - 1 };
        (before, (at + 1).min(last))
    };
    let ((left, right), (above, below)) = (ends(x, last_x), ends(y, last_y));
    (
        sub(field.at(right, y), field.at(left, y), (right - left) as f64),
        sub(field.at(x, below), field.at(x, above), (below - above) as f64),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_the_border_of_an_orbifold_lies_a_sample_that_is_glued_rightly() {
        let shape = crate::plane::Shape::new(9, 7).unwrap();
        let (w, h) = (9, 7);
        // A step along the glued border seen from outside is the step back seen from inside.
        for y in 0..h {
            assert_eq!(beyond(w, h, -1, y as isize), (1, h - 1 - y));
        }
        for x in 0..w {
            assert_eq!(beyond(w, h, x as isize, -2), (w - 1 - x, 2));
            assert_eq!(beyond(w, h, x as isize, h as isize), (w - 1 - x, h - 2));
        }
        // On the border itself the place beyond and the place within are one point.
        for x in 0..w {
            let turned = (w - 1 - x, 0);
            let same = |a: (usize, usize)| Gluing::Orbifold.representative(shape, a.1, a.0);
            assert_eq!(same((x, 0)), same(turned));
        }
    }

    #[test]
    fn differences_of_a_plane_are_its_slopes_even_on_an_open_border() {
        let field = Field::from_fn(5, 4, |x, y| [2.0 * x as f64, 3.0 * y as f64, x as f64 - y as f64]);
        for y in 0..4 {
            for x in 0..5 {
                assert_eq!(differences(&field, Gluing::Open, x, y), ([2.0, 0.0, 1.0], [0.0, 3.0, -1.0]));
            }
        }
    }
}
