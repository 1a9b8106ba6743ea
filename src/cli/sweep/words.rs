//! Lines of arguments as text: taken apart and put together as a POSIX shell does it, and lists in braces.

/// The words of a line: blanks part them, quotation marks and backslashes keep them together.
pub(super) fn words(line: &str) -> Result<Vec<String>, String> {
    let (mut words, mut word, mut is_open) = (Vec::new(), String::new(), false);
    let mut chars = line.chars();
    while let Some(c) = chars.next() {
        match c {
            c if c.is_whitespace() => {
                if std::mem::take(&mut is_open) {
                    words.push(std::mem::take(&mut word));
                }
                continue;
            }
            '\\' => word.push(chars.next().ok_or("a backslash at the end of the line")?),
            '\'' | '"' => loop {
                match chars.next().ok_or_else(|| format!("a quotation mark ({c}) that does not end"))? {
                    end if end == c => break,
                    '\\' if c == '"' => word.push(chars.next().ok_or("a backslash at the end of the line")?),
                    other => word.push(other),
                }
            },
            c => word.push(c),
        }
        is_open = true;
    }
    if is_open {
        words.push(word);
    }
    Ok(words)
}

/// A word as a shell takes it.
pub(super) fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c) || !c.is_ascii();
    if !word.is_empty() && word.chars().all(is_plain) && !word.chars().any(char::is_whitespace) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// Words as one line.
pub(super) fn line<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    words.into_iter().map(quoted).collect::<Vec<_>>().join(" ")
}

/// Every line that comes of one with lists such as `--bits {8,10,12}`, the last list changing fastest.
pub(super) fn expanded(line: &str) -> Vec<String> {
    let list = line.find('{').and_then(|from| line[from..].find('}').map(|length| (from, from + length)));
    let Some((from, to)) = list else { return vec![line.to_owned()] };
    let rest = expanded(&line[to + 1..]);
    let parts = line[from + 1..to].split(',').map(str::trim);
    parts.flat_map(|part| rest.iter().map(move |rest| format!("{}{part}{rest}", &line[..from]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_come_apart_as_in_a_shell() {
        let line = r#"--history 'by hand, "twice"' --x a\ b "c 'd' \" e" ''"#;
        assert_eq!(words(line).unwrap(), ["--history", "by hand, \"twice\"", "--x", "a b", "c 'd' \" e", ""]);
        assert_eq!(words("  ").unwrap(), [""; 0]);
        assert!(words("a 'b").unwrap_err().contains("does not end"));
        assert!(words("a \\").is_err());
    }

    #[test]
    fn what_is_quoted_comes_apart_again() {
        let all = ["plain-1.5", "two words", "it's", "\"", "", "$HOME", "a\\b", "{1,2}", "é", "\u{a0}"];
        assert_eq!(words(&line(all)).unwrap(), all);
        assert_eq!(line(["--bits", "8", "a b"]), "--bits 8 'a b'");
    }

    #[test]
    fn lists_in_braces_become_lines() {
        assert_eq!(expanded("--bits {8, 10}"), ["--bits 8", "--bits 10"]);
        assert_eq!(expanded("{a,b} x {1,2}"), ["a x 1", "a x 2", "b x 1", "b x 2"]);
        assert_eq!(expanded("--stage-bits 2,2"), ["--stage-bits 2,2"]);
        assert_eq!(expanded("no } list {"), ["no } list {"]);
    }
}
