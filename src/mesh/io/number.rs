//! Decimals, read exactly.
//!
//! **What type is a decimal?** A text file does not say. Its numbers are taken as `f32` where `f32`
//! keeps every digit that was written: rounding the `f32` to as many digits gives the same decimal
//! again (0.1 is an `f32`, 0.1000000000 is not). One number of a kind that `f32` would change makes all of that kind `f64`. Files printed
//! from `f32` values therefore come back as exactly those values, and nobody's digits are lost.
//! Writers print the first number that is no `f32` with ten digits at least, so that `f64` comes
//! back as `f64`.

use crate::mesh::Scalar;

/// A number read from text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Number {
    /// The nearest `f64`.
    pub(super) value: f64,
    /// The nearest `f32` (not the same as rounding `value`, rarely).
    pub(super) single: f32,
    /// Whether `single` keeps all digits that were written.
    pub(super) is_single: bool,
    /// Whether it was written as more than an integer.
    pub(super) has_point: bool,
}

impl Number {
    pub(super) const ZERO: Self = Self { value: 0.0, single: 0.0, is_single: true, has_point: false };

    /// The slow way, for any spelling.
    pub(super) fn parse(word: &[u8]) -> Option<Self> {
        let text = std::str::from_utf8(word).ok()?;
        let value: f64 = text.parse().ok().or_else(|| special(text))?;
        let single: f32 = text.parse().unwrap_or(value as f32);
        let is_single = keeps_digits(value, single, Decimal::scan(word).map(|(decimal, _)| decimal));
        let has_point = !word.iter().all(|b| matches!(b, b'0'..=b'9' | b'-' | b'+'));
        Some(Self { value, single, is_single, has_point })
    }

    /// The number in a type: what a typed file means by it, if the type can hold it.
    pub(super) fn typed(&self, scalar: Scalar) -> Option<f64> {
        match scalar {
            Scalar::F64 => Some(self.value),
            Scalar::F32 => Some(self.single.into()),
            integer => {
                let [least, greatest] = integer.range();
                (self.value >= least && self.value <= greatest && self.value.fract() == 0.0).then_some(self.value)
            }
        }
    }
}

/// The names that some C libraries print for what is not a number: `1.#INF`, `-1.#IND00`, `nan(ind)`.
fn special(text: &str) -> Option<f64> {
    let (sign, text) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    let text = text.to_ascii_lowercase();
    if text.starts_with("1.#inf") {
        Some(sign * f64::INFINITY)
    } else if text.starts_with("1.#ind")
        || text.starts_with("1.#qnan")
        || text.starts_with("1.#snan")
        || text.starts_with("nan(")
    {
        Some(f64::NAN)
    } else {
        None
    }
}

/// Powers of ten that `f64` holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21,
    1e22,
];

/// ±`mantissa` · 10^`exponent`, with the digits as written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Decimal {
    negative: bool,
    mantissa: u64,
    /// Digits from the first that is not 0 on.
    digits: u32,
    exponent: i32,
    has_point: bool,
}

impl Decimal {
    /// The decimal at the start of `bytes` and its length; `None` for other spellings and more than 19 digits.
    #[inline]
    pub(super) fn scan(bytes: &[u8]) -> Option<(Self, usize)> {
        let mut i = usize::from(matches!(bytes.first(), Some(b'-' | b'+')));
        let mut decimal =
            Self { negative: bytes.first() == Some(&b'-'), mantissa: 0, digits: 0, exponent: 0, has_point: false };
        let whole = decimal.take_digits(bytes, &mut i);
        let mut fraction = 0;
        if bytes.get(i) == Some(&b'.') {
            i += 1;
            decimal.has_point = true;
            fraction = decimal.take_digits(bytes, &mut i);
            decimal.exponent = i32::try_from(fraction).ok()?.checked_neg()?;
        }
        if whole + fraction == 0 || decimal.digits > 19 {
            return None;
        }
        if let Some(b'e' | b'E') = bytes.get(i) {
            i += 1;
            decimal.has_point = true;
            let minus = bytes.get(i) == Some(&b'-');
            i += usize::from(matches!(bytes.get(i), Some(b'-' | b'+')));
            let mut power = Self { negative: minus, mantissa: 0, digits: 0, exponent: 0, has_point: false };
            if power.take_digits(bytes, &mut i) == 0 || power.digits > 6 {
                return None;
            }
            let power = power.mantissa as i32;
            decimal.exponent = decimal.exponent.checked_add(if minus { -power } else { power })?;
        }
        Some((decimal, i))
    }

    #[inline]
    fn take_digits(&mut self, bytes: &[u8], i: &mut usize) -> usize {
        let start = *i;
        while let Some(digit) = bytes.get(*i).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
            self.mantissa = self.mantissa.wrapping_mul(10).wrapping_add(digit.into());
            self.digits += u32::from(self.digits > 0 || digit > 0);
            *i += 1;
        }
        *i - start
    }

    /// The number, if one exact operation gives it (Clinger's fast path); `word` is its text.
    #[inline]
    pub(super) fn number(self, word: &[u8]) -> Option<Number> {
        if self.mantissa > 1 << 53 || self.exponent.unsigned_abs() > 22 {
            return None;
        }
        let power = POWERS[self.exponent.unsigned_abs() as usize];
        let size = if self.exponent < 0 { self.mantissa as f64 / power } else { self.mantissa as f64 * power };
        let value = if self.negative { -size } else { size };
        // Rounding twice, to f64 and then to f32, goes wrong only where the first lands midway between two f32.
        let is_midway = value.to_bits() & 0x1fff_ffff == 0x1000_0000;
        let is_normal = size == 0.0 || size >= f64::from(f32::MIN_POSITIVE);
        if is_midway || !is_normal {
            return Number::parse(word);
        }
        let single = value as f32;
        // Any f32 keeps six digits.
        let is_single = (self.digits <= 6 && size < 1e30) || keeps_digits(value, single, Some(self));
        Some(Number { value, single, is_single, has_point: self.has_point })
    }
}

/// Whether `single`, rounded to the digits that were written, is what was written.
fn keeps_digits(value: f64, single: f32, decimal: Option<Decimal>) -> bool {
    if f64::from(single) == value || value.is_nan() {
        return true;
    }
    let Some(mut decimal) = decimal else { return false };
    // Zeros before the point may be padding, as in 70823650.0 for 70823648.
    let mut bare = decimal;
    while bare.mantissa.is_multiple_of(10) && bare.mantissa != 0 {
        bare = Decimal { mantissa: bare.mantissa / 10, digits: bare.digits - 1, exponent: bare.exponent + 1, ..bare };
    }
    if bare.exponent >= 0 {
        decimal = bare;
    }
    if decimal.digits > 9 {
        return false;
    }
    let mut unit = 1.0;
    let mut steps = decimal.exponent.unsigned_abs().min(400) as usize;
    while steps > 0 {
        let power = POWERS[steps.min(22)];
        unit = if decimal.exponent < 0 { unit / power } else { unit * power };
        steps -= steps.min(22);
    }
    // A little more than half a unit: decimals midway between two (0.25 printed as 0.3) are
    // not exact in f64, by less than 10^9 times its precision.
    (value - f64::from(single)).abs() <= 0.500_000_5 * unit
}

/// Watches the numbers of one kind to tell their type in the end.
#[derive(Debug, Default)]
pub(super) struct Digits {
    needs_f64: bool,
    /// Numbers whose nearest `f32` is not their `f64` rounded.
    ties: Vec<(usize, f32)>,
}

impl Digits {
    /// Number `index` of its kind.
    #[inline]
    pub(super) fn see(&mut self, index: usize, number: &Number) {
        self.needs_f64 |= !number.is_single;
        if number.single != number.value as f32 && !number.value.is_nan() {
            self.ties.push((index, number.single));
        }
    }

    /// The numbers have got other indices.
    pub(super) fn renumber(&mut self, index: impl Fn(usize) -> usize) {
        for (old, _) in &mut self.ties {
            *old = index(*old);
        }
    }

    /// The type of all the numbers, and the numbers in that type.
    pub(super) fn settle(&self, values: &mut [f64]) -> Scalar {
        if self.needs_f64 {
            return Scalar::F64;
        }
        for value in &mut *values {
            *value = f64::from(*value as f32);
        }
        for &(index, single) in &self.ties {
            values[index] = single.into();
        }
        Scalar::F32
    }
}

#[cfg(test)]
mod tests {
    use super::super::text::{Syntax, Text};
    use super::*;
    use proptest::prelude::*;

    fn number(text: &str) -> Number {
        Text::new(text.as_bytes(), Syntax::Plain).number().unwrap().unwrap()
    }

    #[test]
    fn odd_spellings_are_read_and_others_named() {
        assert_eq!(number("+.5e1").value, 5.0);
        assert_eq!(number("-Inf").value, f64::NEG_INFINITY);
        assert!(number("-nan").value.is_nan() && number("-1.#IND00").value.is_nan());
        assert_eq!(number("123456789012345678901234567890").value, 123456789012345678901234567890.0);
        assert!(number("-0").value.is_sign_negative());
        let error = Text::new(b"\n1.2.3", Syntax::Plain);
        let mut error = error;
        error.next_line();
        assert_eq!(error.number().unwrap_err().to_string(), "line 2: expected a number, found \"1.2.3\"");
    }

    #[test]
    fn f32_is_taken_only_where_it_keeps_every_digit() {
        for kept in [
            "0.1",
            "0.100000001",
            "7.163748",
            "0.10000000149011612",
            "1e-3",
            "-14.173321",
            "nan",
            "16777216",
            "99.123459",
            "70823650.0",
        ] {
            assert!(number(kept).is_single, "{kept}");
        }
        for lost in [
            "99.123456",
            "0.1000000015",
            "16777217",
            "5123456.12",
            "1e39",
            "1e-60",
            "0.30000000000000004",
            "0.1000000000",
            "1.000000000e-1",
        ] {
            assert!(!number(lost).is_single, "{lost}");
        }
    }

    proptest! {
        #[test]
        fn every_decimal_is_read_as_the_nearest_number(m in any::<u64>(), shift in 0_u32..64, e in -50_i32..50) {
            let m = m >> shift;
            for text in [format!("{m}e{e}"), format!("{}.{:07}e{e}", m / 10_000_000, m % 10_000_000)] {
                prop_assert_eq!(number(&text).value, text.parse::<f64>().unwrap());
                prop_assert_eq!(number(&text).single, text.parse::<f32>().unwrap());
            }
        }

        #[test]
        fn an_f32_that_was_printed_comes_back(bits in any::<u32>(), digits in 0_usize..9) {
            let x = f32::from_bits(bits);
            prop_assume!(x.is_finite());
            let shortest = number(&format!("{x:?}"));
            prop_assert!(shortest.is_single && shortest.single == x);
            let cut = number(&format!("{x:.digits$e}"));
            prop_assert!(cut.is_single, "{x:.digits$e}");
        }
    }
}
