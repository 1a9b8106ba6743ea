//! Which kind of mesh file: by name, by extension, by the first bytes.

use std::fmt;
use std::path::Path;

use super::stl;

/// A kind of mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ (text).
    Obj,
    /// The Stanford polygon format (text, or binary in either byte order).
    Ply,
    /// Geomview's OFF (text).
    Off,
    /// Stereolithography triangles (text or binary).
    Stl,
    /// The binary form of glTF 2.0.
    Glb,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 5] = [Self::Obj, Self::Ply, Self::Off, Self::Stl, Self::Glb];

    /// The usual extension, which is also the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Off => "off",
            Self::Stl => "stl",
            Self::Glb => "glb",
        }
    }

    /// The format of that name, in small or capital letters.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name().eq_ignore_ascii_case(name))
    }

    /// The format that a file name's extension stands for.
    pub fn from_path(path: &Path) -> Option<Self> {
        Self::from_name(path.extension()?.to_str()?)
    }

    /// The format that a file's content looks like.
    pub fn detect(bytes: &[u8]) -> Option<Self> {
        if let Some(sure) = Self::magic(bytes) {
            return Some(sure);
        }
        if stl::is_binary(bytes) {
            return Some(Self::Stl);
        }
        // The first word that is no comment tells the text formats apart.
        let lines = bytes.get(..bytes.len().min(1 << 16))?.split(|&b| b == b'\n' || b == b'\r');
        let line = lines.map(<[u8]>::trim_ascii).find(|line| !line.is_empty() && line[0] != b'#')?;
        let word = line.split(u8::is_ascii_whitespace).next()?;
        match word {
            b"solid" => Some(Self::Stl),
            b"v" | b"vn" | b"vt" | b"vp" | b"f" | b"o" | b"g" | b"s" | b"mtllib" | b"usemtl" => Some(Self::Obj),
            _ if word.ends_with(b"OFF") && word.len() <= 8 => Some(Self::Off),
            _ => None,
        }
    }

    /// The format that the first bytes prove, whatever the file is called.
    pub(super) fn magic(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [b'p', b'l', b'y', b'\r' | b'\n', ..] => Some(Self::Ply),
            [b'g', b'l', b'T', b'F', ..] => Some(Self::Glb),
            _ => None,
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_tells_the_format_where_the_name_does_not() {
        assert_eq!(Format::detect(b"ply\nformat ascii 1.0\n"), Some(Format::Ply));
        assert_eq!(Format::detect(b"# made by hand\r\n\r\nCOFF\n"), Some(Format::Off));
        assert_eq!(Format::detect(b"# made by hand\nmtllib a.mtl\n"), Some(Format::Obj));
        assert_eq!(Format::detect(b"solid cube\n"), Some(Format::Stl));
        assert_eq!(Format::detect(&[0; 84]), Some(Format::Stl));
        assert_eq!(Format::detect(b"GIF89a"), None);
        assert_eq!(Format::detect(b""), None);
        assert_eq!(Format::from_path(Path::new("a/B.OBJ")), Some(Format::Obj));
    }
}
