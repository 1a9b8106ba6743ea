//! The values that an axis takes: all integers of a range, or a list (a *palette*) where few occur.
//!
//! CAD models and terrains have far fewer distinct coordinates than their lattice has. With a palette,
//! residuals count entries of the list, and densities are integrated between the middles of neighbours.

#[cfg(feature = "encode")]
use super::math::ln;
#[cfg(feature = "encode")]
use crate::entropy::BitWriter;
use crate::entropy::{BitCoder, Numbers};

/// The values of one axis, in rising order.
#[derive(Debug, Clone)]
pub(super) enum Values {
    /// `0..=extent`
    All {
        /// The largest value.
        extent: i64,
    },
    /// A list.
    Palette(Vec<i32>),
    /// All integers of `-most..=most`: places on a lattice that is centred at what is expected.
    Around {
        /// The largest value.
        most: i64,
    },
}

/// A palette is taken to save this share of what shorter indices promise; the rest is had without one. What all shares
/// agree on is not tried.
#[cfg(feature = "encode")]
const SHARES: [f64; 3] = [0.5, 0.0, 1.5];

/// The ways to choose palettes for three axes that are worth a trial, the likeliest first.
#[cfg(feature = "encode")]
pub(in crate::surface) fn choices(extent: [i32; 3], positions: impl Iterator<Item = [i32; 3]> + Clone) -> Vec<[bool; 3]> {
    // For each axis: the bits that the list takes, and those that it promises.
    let promises = [0, 1, 2].map(|axis| {
        let values = positions.clone().map(|p| p[axis]);
        let mut coder = BitWriter::default();
        let vertices = values.clone().count();
        let distinct = Values::code(&mut coder, extent[axis], vertices, true, values).map_or(0, |list| list.last() + 1);
        let shorter = ln((f64::from(extent[axis]) + 1.0) / distinct as f64) * std::f64::consts::LOG2_E;
        (coder.finish().len() as f64 * 8.0, vertices as f64 * shorter)
    });
    let mut choices = Vec::new();
    for share in SHARES {
        let choice = promises.map(|(list, saved)| share * saved > list);
        if !choices.contains(&choice) {
            choices.push(choice);
        }
    }
    choices
}

impl Values {
    /// Codes the values of an axis, of which no more than `most` occur. A writer says whether as a palette, and which
    /// occur, in any order.
    pub(super) fn code<C: BitCoder>(
        coder: &mut C,
        extent: i32,
        most: usize,
        as_palette: bool,
        occurring: impl Iterator<Item = i32>,
    ) -> Option<Self> {
        if !coder.code(as_palette, 1 << 15) {
            return Some(Self::All { extent: extent.into() });
        }
        let mut list = Vec::new();
        if C::WRITES {
            list.extend(occurring);
            list.sort_unstable();
            list.dedup();
        }
        // The gaps between entries, each in the context of the last.
        let mut numbers = Numbers::new(CONTEXTS + 1);
        let count = numbers.code(coder, list.len() as u32, CONTEXTS);
        if count as usize > most {
            return None;
        }
        let mut found = Vec::new();
        let (mut gap, mut value) = (0, 0_u32);
        for i in 0..count {
            let wanted = list.get(i as usize).map_or(0, |&v| (v as u32).wrapping_sub(value));
            gap = numbers.code(coder, wanted, (gap as usize).min(CONTEXTS - 1));
            value = value.checked_add(gap)?;
            if value > extent as u32 || gap == 0 && i > 0 || coder.is_exhausted() {
                return None;
            }
            found.push(value as i32);
        }
        (!found.is_empty()).then_some(Self::Palette(found))
    }

    /// The lower edge of the value of this index, 1 to [`last`](Self::last): half-way to the one before.
    #[inline]
    pub(super) fn edge(&self, index: i64) -> f64 {
        match self {
            Self::All { .. } | Self::Around { .. } => index as f64 - 0.5,
            Self::Palette(list) => 0.5 * (f64::from(list[index as usize - 1]) + f64::from(list[index as usize])),
        }
    }

    /// The index of the value nearest to x.
    #[inline]
    pub(super) fn nearest(&self, x: f64) -> i64 {
        match self {
            // `as` takes anything that is no number to 0.
            Self::All { extent } => ((x + 0.5).floor() as i64).clamp(0, *extent),
            Self::Around { most } => ((x + 0.5).floor() as i64).clamp(-most, *most),
            Self::Palette(list) => {
                let above = list.partition_point(|&v| f64::from(v) < x);
                match (above.checked_sub(1).map(|i| list[i]), list.get(above)) {
                    (None, _) => 0,
                    (Some(low), Some(&high)) if x - f64::from(low) >= f64::from(high) - x => above as i64,
                    (Some(_), _) => above as i64 - 1,
                }
            }
        }
    }

    /// The index of a value that occurs.
    #[inline]
    pub(super) fn index(&self, value: i32) -> i64 {
        match self {
            Self::All { .. } | Self::Around { .. } => value.into(),
            Self::Palette(list) => list.partition_point(|&v| v < value) as i64,
        }
    }

    /// The value of an index, if there is one.
    #[inline]
    pub(super) fn value(&self, index: i64) -> Option<i32> {
        match self {
            Self::All { extent } => (0..=*extent).contains(&index).then_some(index as i32),
            Self::Around { most } => (-most..=*most).contains(&index).then_some(index as i32),
            Self::Palette(list) => usize::try_from(index).ok().and_then(|i| list.get(i)).copied(),
        }
    }

    /// The index of the first value.
    #[inline]
    pub(super) fn first(&self) -> i64 {
        if let Self::Around { most } = self { -most } else { 0 }
    }

    /// The index of the last value.
    #[inline]
    pub(super) fn last(&self) -> i64 {
        match self {
            Self::All { extent: last } | Self::Around { most: last } => *last,
            Self::Palette(list) => list.len() as i64 - 1,
        }
    }

    /// The index of the first value that is no less than x; one beyond the last if there is none.
    #[inline]
    pub(super) fn first_from(&self, x: i64) -> i64 {
        match self {
            Self::All { extent } => x.clamp(0, extent + 1),
            Self::Around { most } => x.clamp(-most, most + 1),
            Self::Palette(list) => list.partition_point(|&v| i64::from(v) < x) as i64,
        }
    }
}

/// Contexts of a gap: the gap before it, up to this.
const CONTEXTS: usize = 21;

#[cfg(test)]
mod tests {
    use super::super::window::Window;
    use super::*;
    use crate::entropy::{BitReader, BitWriter};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_values_come_back_and_each_is_nearest_to_itself(
            mut occurring in proptest::collection::vec(0..10_000_i32, 1..50), copies in 1_usize..60,
        ) {
            let mut writer = BitWriter::default();
            let all = occurring.iter().copied().cycle().take(occurring.len() * copies);
            let written = Values::code(&mut writer, 9_999, occurring.len() * copies, copies % 2 == 0, all).unwrap();
            let bytes = writer.finish();
            let read = Values::code(&mut BitReader::new(&bytes), 9_999, 50, false, std::iter::empty()).unwrap();
            occurring.sort_unstable();
            for &value in &occurring {
                let index = read.index(value);
                prop_assert_eq!(written.index(value), index);
                prop_assert_eq!(read.value(index), Some(value));
                prop_assert_eq!(read.nearest(f64::from(value)), index);
                let window = Window::all(&read);
                prop_assert!(window.edge(index) < f64::from(value) && f64::from(value) < window.edge(index + 1));
                let cell = Window::cell(&read, value >> 3, 3).unwrap();
                prop_assert_eq!(cell.value(index), Some(value));
                prop_assert!(cell.edge(index) < f64::from(value) && f64::from(value) < cell.edge(index + 1));
                prop_assert_eq!(cell.nearest(-1e9), read.first_from(i64::from(value >> 3 << 3)));
            }
        }
    }

    #[test]
    fn a_list_that_repeats_an_entry_or_is_longer_than_its_vertices_is_refused() {
        let read = |gaps: &[u32], most: usize| {
            let (mut writer, mut numbers, mut gap) = (BitWriter::default(), Numbers::new(CONTEXTS + 1), 0);
            writer.code(true, 1 << 15);
            numbers.code(&mut writer, gaps.len() as u32, CONTEXTS);
            for &next in gaps {
                gap = numbers.code(&mut writer, next, (gap as usize).min(CONTEXTS - 1));
            }
            Values::code(&mut BitReader::new(&writer.finish()), 9, most, false, std::iter::empty())
        };
        assert!(read(&[0, 4, 5], 3).is_some());
        assert!(read(&[0, 4, 0, 5], 4).is_none());
        assert!(read(&[0, 4, 5], 2).is_none());
        assert!(read(&[0, 4, 6], 3).is_none());
    }

    #[test]
    fn a_palette_is_used_where_few_values_occur_often() {
        // Few; all; and a tenth that lies evenly.
        let values = |i: i32| [i % 50 * 80, i, i / 10 * 10];
        assert_eq!(choices([4095; 3], (0..4096).map(values)), [[true, false, true], [false; 3]]);
    }
}
