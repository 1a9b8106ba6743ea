//! Text files: words and lines.
//!
//! A reader walks one byte slice; no word is copied. Lines end at `\n`, at `\r\n`, or at `\r` in
//! files that have no `\n` at all.

use super::number::{Decimal, Number};
use crate::error::{Error, Place, Result};

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

#[cfg(test)]
mod tests {
    use super::*;

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
}
