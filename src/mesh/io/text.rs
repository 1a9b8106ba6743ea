//! Text files of numbers: words, lines, and decimals read exactly.
//!
//! A reader walks one byte slice; no word is copied. Lines end at `\n`, at `\r\n`, or at `\r` in
//! files that have no `\n` at all.
//!
//! **What type is a decimal?** A text file does not say. Its numbers are taken as `f32` where `f32`
//! keeps every digit that was written: rounding the `f32` to as many digits gives the same decimal
//! again (0.1 is an `f32`, 0.1000000000 is not). One number of a kind that `f32` would change makes all of that kind `f64`. Files printed
//! from `f32` values therefore come back as exactly those values, and nobody's digits are lost.
//! Writers print the first number that is no `f32` with ten digits at least, so that `f64` comes
//! back as `f64`.

use crate::error::{Error, Place, Result};
use crate::mesh::Scalar;

/// How a format writes comments and long lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Syntax {
    /// No comments.
    Plain,
    /// `#` at the start of a word hides the rest of the line; a backslash joins it with the next.
    Obj,
    /// `#` anywhere hides the rest of the line.
    Off,
}

/// A text and a place in it.
#[derive(Debug, Clone)]
pub(super) struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    end_of_line: u8,
    syntax: Syntax,
}

impl Default for Text<'_> {
    fn default() -> Self {
        Self::new(&[], Syntax::Plain)
    }
}

impl<'a> Text<'a> {
    pub(super) fn new(bytes: &'a [u8], syntax: Syntax) -> Self {
        let end_of_line = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
        let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Self { bytes, at, line: 1, end_of_line, syntax }
    }

    /// The text from byte `at` on, which is the start of line `line`.
    pub(super) fn starting(bytes: &'a [u8], at: usize, line: u64, end_of_line: u8) -> Self {
        Self { bytes, at, line, end_of_line, syntax: Syntax::Plain }
    }

    pub(super) fn line(&self) -> u64 {
        self.line
    }

    /// How many bytes are left.
    pub(super) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// An error about the present line.
    pub(super) fn error(&self, why: impl Into<String>) -> Error {
        Error::malformed(Place::Line(self.line), why)
    }

    /// Bytes that join this line with the next, if the text goes on with them.
    fn joint(&self) -> Option<usize> {
        match self.bytes[self.at..] {
            [b'\\', b'\n', ..] if self.syntax == Syntax::Obj => Some(2),
            [b'\\', b'\r', b'\n', ..] if self.syntax == Syntax::Obj => Some(3),
            _ => None,
        }
    }

    /// Steps over blanks; the next byte of the line, if there is one.
    fn skip_blanks(&mut self) -> Option<u8> {
        loop {
            let &b = self.bytes.get(self.at)?;
            if b > b' ' {
                if b == b'#' && self.syntax != Syntax::Plain {
                    self.skip_to_end_of_line();
                    return None;
                }
                if b == b'\\'
                    && let Some(bytes) = self.joint()
                {
                    self.at += bytes;
                    self.line += 1;
                    continue;
                }
                return Some(b);
            }
            if b == self.end_of_line {
                return None;
            }
            self.at += 1;
        }
    }

    fn skip_to_end_of_line(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|&b| b == self.end_of_line).unwrap_or(rest.len());
    }

    /// Whether a word cannot go on with byte `b` at the present place.
    #[inline]
    fn ends_word(&self, b: u8) -> bool {
        b <= b' ' || (b == b'#' && self.syntax == Syntax::Off) || (b == b'\\' && self.joint().is_some())
    }

    /// The next word of this line.
    pub(super) fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks()?;
        let start = self.at;
        while let Some(&b) = self.bytes.get(self.at) {
            if self.ends_word(b) {
                break;
            }
            self.at += 1;
        }
        Some(&self.bytes[start..self.at])
    }

    /// The rest of this line, comment signs included, without the blanks around it.
    pub(super) fn rest(&mut self) -> &'a [u8] {
        let start = self.at;
        self.skip_to_end_of_line();
        self.bytes[start..self.at].trim_ascii()
    }

    /// How many words this line still has.
    pub(super) fn count_words(&mut self) -> usize {
        std::iter::from_fn(|| self.word()).count()
    }

    /// Goes to the start of the next line; false at the end of the text.
    pub(super) fn next_line(&mut self) -> bool {
        self.skip_to_end_of_line();
        if self.at == self.bytes.len() {
            return false;
        }
        self.at += 1;
        self.line += 1;
        true
    }

    /// Stays on this line if it has a word left, or goes to the next line that has one; false at the end of the text.
    pub(super) fn find_word(&mut self) -> bool {
        while self.skip_blanks().is_none() {
            if !self.next_line() {
                return false;
            }
        }
        true
    }

    /// The next word of this line as a number.
    pub(super) fn number(&mut self) -> Result<Option<Number>> {
        if self.skip_blanks().is_none() {
            return Ok(None);
        }
        if let Some((decimal, length)) = Decimal::scan(&self.bytes[self.at..]) {
            let start = self.at;
            self.at += length;
            let ends = self.bytes.get(self.at).is_none_or(|&b| self.ends_word(b));
            if ends && let Some(number) = decimal.number(&self.bytes[start..self.at]) {
                return Ok(Some(number));
            }
            self.at = start;
        }
        let word = self.word().unwrap_or_default();
        match Number::parse(word) {
            Some(number) => Ok(Some(number)),
            None => Err(self.error(format!("expected a number, found {}", show(word)))),
        }
    }

    /// All numbers of the rest of the line, as many as fit into `numbers`, and how many there were.
    pub(super) fn numbers(&mut self, numbers: &mut [Number]) -> Result<usize> {
        for (n, slot) in numbers.iter_mut().enumerate() {
            match self.number()? {
                Some(number) => *slot = number,
                None => return Ok(n),
            }
        }
        Ok(numbers.len() + self.count_words())
    }
}

/// A word as an error shows it.
pub(super) fn show(word: &[u8]) -> String {
    match word.get(..40) {
        Some(start) => format!("\"{}…\"", start.escape_ascii()),
        None => format!("\"{}\"", word.escape_ascii()),
    }
}

/// A name from a file. Bytes that are not UTF-8 become the replacement sign.
pub(super) fn name(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

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
    fn parse(word: &[u8]) -> Option<Self> {
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
struct Decimal {
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
    fn scan(bytes: &[u8]) -> Option<(Self, usize)> {
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
    fn number(self, word: &[u8]) -> Option<Number> {
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
    use super::*;
    use proptest::prelude::*;

    fn number(text: &str) -> Number {
        Text::new(text.as_bytes(), Syntax::Plain).number().unwrap().unwrap()
    }

    #[test]
    fn words_lines_comments_and_joints_are_told_apart() {
        let mut text = Text::new(b"\xef\xbb\xbf a  b#c # d\r\n\r\n e \\\n f", Syntax::Obj);
        assert_eq!((text.word(), text.word(), text.word()), (Some(&b"a"[..]), Some(&b"b#c"[..]), None));
        assert!(text.next_line() && text.find_word());
        assert_eq!((text.word(), text.word(), text.line()), (Some(&b"e"[..]), Some(&b"f"[..]), 4));
        assert!(!text.next_line());
        let mut text = Text::new(b"1#2\r3", Syntax::Off);
        assert_eq!((text.word(), text.word()), (Some(&b"1"[..]), None));
        assert!(text.next_line());
        assert_eq!((text.word(), text.line()), (Some(&b"3"[..]), 2));
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
