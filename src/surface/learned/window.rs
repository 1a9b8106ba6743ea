//! What one coordinate can still be: a stretch of its axis's values.
//!
//! All of them in a file of one stage; in a later stage, those inside the cell that the stage before has left.

use super::palette::Values;

/// The indices `low..=high` of the values of an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window<'a> {
    values: &'a Values,
    low: i64,
    high: i64,
}

impl<'a> Window<'a> {
    /// All values.
    pub(super) fn all(values: &'a Values) -> Self {
        Self { values, low: values.first(), high: values.last() }
    }

    /// The values of the cell `cell · 2^shift ..= cell · 2^shift + 2^shift − 1`; `None` if there are none.
    pub(super) fn cell(values: &'a Values, cell: i32, shift: u32) -> Option<Self> {
        let first = i64::from(cell) << shift;
        let (low, high) = (values.first_from(first), values.first_from(first + (1 << shift)) - 1);
        (low <= high).then_some(Self { values, low, high })
    }

    /// The lower edge of the value of this index: half-way to the one before; ±∞ at the ends of the window and beyond.
    #[inline]
    pub(super) fn edge(&self, index: i64) -> f64 {
        if index <= self.low {
            f64::NEG_INFINITY
        } else if index > self.high {
            f64::INFINITY
        } else {
            self.values.edge(index)
        }
    }

    /// The index of the value nearest to x.
    #[inline]
    pub(super) fn nearest(&self, x: f64) -> i64 {
        self.values.nearest(x).clamp(self.low, self.high)
    }

    /// The index of a value that occurs.
    #[inline]
    pub(super) fn index(&self, value: i32) -> i64 {
        self.values.index(value)
    }

    /// The value of an index, if the window has it.
    #[inline]
    pub(super) fn value(&self, index: i64) -> Option<i32> {
        if (self.low..=self.high).contains(&index) { self.values.value(index) } else { None }
    }

    /// Whether there is nothing to choose.
    #[inline]
    pub(super) fn is_single(&self) -> bool {
        self.low == self.high
    }

    /// No residual has a class above this.
    #[inline]
    pub(super) fn last_class(&self) -> u32 {
        ((self.high - self.low + 1) as u64).ilog2() + 1
    }
}
