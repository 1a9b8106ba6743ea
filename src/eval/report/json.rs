//! JSON output: the one writer behind every `--json`.

use std::fmt;

/// A JSON value; objects keep the order in which their members are given.
///
/// ```
/// # use gimc::eval::Json;
/// let point = Json::object([("method", "cgim".into()), ("bytes", 1042_u64.into()), ("psnr", f64::NAN.into())]);
/// assert_eq!(point.to_string(), r#"{"method":"cgim","bytes":1042,"psnr":null}"#);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Json {
    /// `null`: not known, or a number that JSON has no word for.
    Null,
    /// `true` or `false`.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// Any number; NaN and infinities are written as `null`.
    Number(f64),
    /// A string.
    Text(String),
    /// An array.
    List(Vec<Json>),
    /// An object.
    Object(Vec<(String, Json)>),
}

impl Json {
    /// An object of these members, in this order.
    pub fn object<K: Into<String>>(members: impl IntoIterator<Item = (K, Json)>) -> Self {
        Self::Object(members.into_iter().map(|(k, v)| (k.into(), v)).collect())
    }

    /// An array.
    pub fn list<T: Into<Json>>(items: impl IntoIterator<Item = T>) -> Self {
        Self::List(items.into_iter().map(Into::into).collect())
    }

    /// Adds members to an object, behind those that it has; anything else stays as it is.
    pub fn extend<K: Into<String>>(&mut self, more: impl IntoIterator<Item = (K, Json)>) {
        if let Self::Object(members) = self {
            members.extend(more.into_iter().map(|(k, v)| (k.into(), v)));
        }
    }

    /// The member of an object, if this is one and has it.
    pub fn get(&self, key: &str) -> Option<&Json> {
        match self {
            Self::Object(members) => members.iter().find(|(k, _)| k == key).map(|(_, v)| v),
            _ => None,
        }
    }
}

impl fmt::Display for Json {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null => f.write_str("null"),
            Self::Bool(x) => write!(f, "{x}"),
            Self::Integer(x) => write!(f, "{x}"),
            // Debug gives the shortest digits that read back the same, with an exponent where that is shorter.
            Self::Number(x) if x.is_finite() => write!(f, "{x:?}"),
            Self::Number(_) => f.write_str("null"),
            Self::Text(s) => write_text(f, s),
            Self::List(items) => {
                f.write_str("[")?;
                for (i, item) in items.iter().enumerate() {
                    write!(f, "{}{item}", if i > 0 { "," } else { "" })?;
                }
                f.write_str("]")
            }
            Self::Object(members) => {
                f.write_str("{")?;
                for (i, (key, value)) in members.iter().enumerate() {
                    f.write_str(if i > 0 { "," } else { "" })?;
                    write_text(f, key)?;
                    write!(f, ":{value}")?;
                }
                f.write_str("}")
            }
        }
    }
}

fn write_text(f: &mut fmt::Formatter<'_>, s: &str) -> fmt::Result {
    f.write_str("\"")?;
    for c in s.chars() {
        match c {
            '"' => f.write_str("\\\"")?,
            '\\' => f.write_str("\\\\")?,
            '\n' => f.write_str("\\n")?,
            c if (c as u32) < 0x20 => write!(f, "\\u{:04x}", c as u32)?,
            c => write!(f, "{c}")?,
        }
    }
    f.write_str("\"")
}

impl From<bool> for Json {
    fn from(x: bool) -> Self {
        Self::Bool(x)
    }
}

impl From<f64> for Json {
    fn from(x: f64) -> Self {
        Self::Number(x)
    }
}

impl From<i64> for Json {
    fn from(x: i64) -> Self {
        Self::Integer(x)
    }
}

impl From<u32> for Json {
    fn from(x: u32) -> Self {
        Self::Integer(x.into())
    }
}

impl From<u64> for Json {
    fn from(x: u64) -> Self {
        i64::try_from(x).map_or(Self::Number(x as f64), Self::Integer)
    }
}

impl From<usize> for Json {
    fn from(x: usize) -> Self {
        Self::from(x as u64)
    }
}

impl From<&str> for Json {
    fn from(x: &str) -> Self {
        Self::Text(x.into())
    }
}

impl From<String> for Json {
    fn from(x: String) -> Self {
        Self::Text(x)
    }
}

impl<T: Into<Json>> From<Option<T>> for Json {
    fn from(x: Option<T>) -> Self {
        x.map_or(Self::Null, Into::into)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_numbers_read_back() {
        let value = Json::object([
            ("say \"x\"", Json::from("a\\b\n\u{1}é")),
            ("small", 1e-300.into()),
            ("one", 1.0.into()),
            ("none", Json::from(None::<f64>)),
            ("list", Json::list([1_u32, 2])),
        ]);
        let text = r#"{"say \"x\"":"a\\b\n\u0001é","small":1e-300,"one":1.0,"none":null,"list":[1,2]}"#;
        assert_eq!(value.to_string(), text);
        assert_eq!(value.get("one"), Some(&Json::Number(1.0)));
    }

    #[test]
    fn what_json_has_no_word_for_is_null() {
        assert_eq!(Json::from(f64::INFINITY).to_string(), "null");
        assert_eq!(Json::from(f64::NAN).to_string(), "null");
        assert_eq!(Json::from(u64::MAX).to_string(), "1.8446744073709552e19");
    }
}
