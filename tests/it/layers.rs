//! Imports only point down: the picture in `src/lib.rs`, as a table that is checked.
//!
//! Reads every source file, strips comments, strings and unit tests, and finds all paths that start with `crate::` or
//! `super::` and all foreign crates. To move a room to another floor, change its row.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Wing {
    /// Sees both wings.
    Both,
    /// Never sees a byte.
    Surface,
    /// Never sees a triangle.
    Byte,
    /// Sees the ground only.
    Hall,
}

use Wing::{Both, Byte, Hall, Surface};

/// Room, floor, wing. A room may name rooms on lower floors, of its own wing or of none.
const ROOMS: &[(&str, u32, Wing)] = &[
    // The ground.
    ("error", 0, Hall),
    ("limits", 1, Hall),
    ("task", 1, Hall),
    ("par", 1, Hall),
    // 0
    ("geom", 10, Surface),
    ("sparse", 10, Surface),
    ("bits", 10, Byte),
    // 1
    ("plane", 15, Hall),
    // 2a, 2b
    ("mesh", 20, Surface),
    ("entropy", 20, Byte),
    ("distance", 25, Surface),
    ("param", 25, Surface),
    ("simplify", 25, Surface),
    ("codec", 25, Byte),
    // 3
    ("cgim", 30, Surface),
    ("gim", 30, Surface),
    ("resize", 30, Surface),
    ("format", 30, Byte),
    ("surface", 30, Both),
    // 4: the doors; the options lie lowest, what both doors say between them and the doors.
    ("options", 39, Both),
    ("images", 40, Both),
    ("extras", 40, Both),
    ("charts", 40, Both),
    ("judge", 38, Both),
    ("decode", 41, Both),
    ("encode", 42, Both),
    // 5, 6
    ("eval", 50, Both),
    ("picture", 50, Both),
    ("cli", 60, Both),
    ("main", 61, Both),
    ("lib", 62, Both),
];

/// `surface` names both wings, and only these rooms of them.
const SURFACE_SEES: &[&str] = &["error", "limits", "task", "par", "geom", "plane", "bits", "mesh", "entropy"];

const GROUND_FLOOR: u32 = 9;

/// Foreign crates and the rooms that may name them.
const FOREIGN: &[(&str, &[&str])] = &[
    ("bitvec", &["plane"]),
    ("byteorder", &["bits", "format", "mesh"]),
    ("clap", &["cli", "main"]),
    ("clap_complete", &["cli"]),
    ("crc32fast", &["bits", "format"]),
    ("exr", &["codec"]),
    ("faer", &["sparse"]),
    ("glam", &["geom", "mesh", "distance", "param", "simplify", "cgim", "gim", "resize", "encode", "eval"]),
    ("hayro_jpeg2000", &["codec"]),
    ("image", &["plane"]),
    ("rayon", &["par"]),
    ("serde_json", &["mesh"]),
];

/// Printing, the environment, the clock and other programs: who may use them.
const SIDE_EFFECTS: &[(&str, &[&str])] = &[
    ("println!", &["cli", "main"]),
    ("print!", &["cli", "main"]),
    ("eprintln!", &["cli", "main"]),
    ("eprint!", &["cli", "main"]),
    ("std::env", &["cli", "main"]),
    ("Instant::now", &["cli", "main", "task"]),
    ("SystemTime", &["cli", "main"]),
    ("Command::new", &["cli"]),
];

struct Source {
    file: PathBuf,
    /// Module path from the crate root; empty for `lib.rs` and `main.rs`.
    module: Vec<String>,
    room: String,
    code: String,
}

fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut folders = vec![root.clone()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of sources") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                // Unit tests that have a folder of their own may look anywhere, like the others.
                if !path.ends_with("tests") {
                    folders.push(path);
                }
            } else if path.extension().is_some_and(|e| e == "rs") {
                let relative = path.strip_prefix(&root).expect("below src").with_extension("");
                let mut module: Vec<String> = relative.iter().map(|s| s.to_string_lossy().into_owned()).collect();
                let room = module[0].clone();
                if module.len() == 1 && (room == "lib" || room == "main") || module.last().is_some_and(|m| m == "mod") {
                    module.pop();
                }
                let code = without_tests(&without_comments_and_strings(&std::fs::read_to_string(&path).expect("text")));
                found.push(Source { file: path, module, room, code });
            }
        }
    }
    found
}

fn without_comments_and_strings(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let (mut out, mut i) = (String::new(), 0);
    while i < chars.len() {
        match (at(i), at(i + 1)) {
            ('/', '/') => {
                while i < chars.len() && at(i) != '\n' {
                    i += 1;
                }
            }
            ('/', '*') => {
                i += 2;
                while i < chars.len() && (at(i), at(i + 1)) != ('*', '/') {
                    i += 1;
                }
                i += 2;
            }
            ('r', '"' | '#') if !out.ends_with(|c: char| c.is_alphanumeric() || c == '_') => {
                let hashes = (i + 1..).take_while(|&j| at(j) == '#').count();
                if at(i + 1 + hashes) == '"' {
                    i += 2 + hashes;
                    while i < chars.len() && !(at(i) == '"' && (1..=hashes).all(|j| at(i + j) == '#')) {
                        i += 1;
                    }
                    i += 1 + hashes;
                    out.push_str("\"\"");
                } else {
                    out.push('r');
                    i += 1;
                }
            }
            ('"', _) => {
                i += 1;
                while i < chars.len() && at(i) != '"' {
                    i += if at(i) == '\\' { 2 } else { 1 };
                }
                i += 1;
                out.push_str("\"\"");
            }
            // Character literals that would look like the start of something else.
            ('\'', '\\') => {
                i += 3;
                while i < chars.len() && at(i) != '\'' {
                    i += 1;
                }
                i += 1;
            }
            ('\'', _) if at(i + 2) == '\'' => i += 3,
            (c, _) => {
                out.push(c);
                i += 1;
            }
        }
    }
    out
}

/// Unit tests may look anywhere: their judges often live in other rooms.
fn without_tests(code: &str) -> String {
    let mut out = String::new();
    let mut rest = code;
    while let Some(start) = rest.find("#[cfg(test)]") {
        out.push_str(&rest[..start]);
        rest = &rest[start + "#[cfg(test)]".len()..];
        let end = rest.find([';', '{']).map_or(rest.len(), |i| i + 1);
        let mut depth = i32::from(rest[..end].ends_with('{'));
        let mut skip = end;
        for (i, c) in rest[end..].char_indices() {
            if depth == 0 {
                break;
            }
            depth += i32::from(c == '{') - i32::from(c == '}');
            skip = end + i + c.len_utf8();
        }
        rest = &rest[skip..];
    }
    out.push_str(rest);
    out
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The first segments that the use tree at the start of `text` leads to: `{a::b, c}` gives `a` and `c`.
fn heads(text: &str) -> Vec<String> {
    let text = text.trim_start();
    let Some(inside) = text.strip_prefix('{') else {
        let word: String = text.chars().take_while(|&c| is_word(c)).collect();
        return if word.is_empty() { vec![] } else { vec![word] };
    };
    let (mut depth, mut start, mut found) = (0, true, Vec::new());
    for (i, c) in inside.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => start = true,
            c if start && !c.is_whitespace() => {
                found.extend(heads(&inside[i..]));
                start = false;
            }
            _ => {}
        }
    }
    found
}

/// Where in `code` the path segment `word::` starts a path.
fn paths<'a>(code: &'a str, word: &'a str) -> impl Iterator<Item = usize> + 'a {
    code.match_indices(word).map(|(i, _)| i).filter(move |&i| {
        let before = code[..i].trim_end();
        !code[..i].ends_with(is_word) && !before.ends_with("::") && code[i + word.len()..].starts_with("::")
    })
}

/// The rooms that a source names, by `crate::` and `super::`.
fn named(source: &Source, exported: &BTreeMap<String, String>) -> BTreeSet<String> {
    let mut names = Vec::new();
    for i in paths(&source.code, "crate") {
        names.extend(heads(&source.code[i + "crate::".len()..]));
    }
    for i in paths(&source.code, "super") {
        let mut rest = &source.code[i..];
        let mut module = &source.module[..];
        while let Some(after) = rest.strip_prefix("super::") {
            module = &module[..module.len().saturating_sub(1)];
            rest = after;
        }
        match module.first() {
            Some(room) => names.push(room.clone()),
            None => names.extend(heads(rest)),
        }
    }
    names.into_iter().map(|name| exported.get(&name).cloned().unwrap_or(name)).collect()
}

/// What `lib.rs` re-exports, and from which room: `crate::Error` is an arrow to `error`.
fn exports(sources: &[Source]) -> BTreeMap<String, String> {
    let lib = sources.iter().find(|s| s.room == "lib").expect("lib.rs");
    let mut exported = BTreeMap::new();
    for statement in lib.code.split(';') {
        let Some((_, path)) = statement.split_once("pub use ").or_else(|| statement.split_once("pub(crate) use ")) else {
            continue;
        };
        let path = path.trim().trim_start_matches("crate::");
        let room: String = path.chars().take_while(|&c| is_word(c)).collect();
        let names = path.split(|c: char| !is_word(c)).filter(|w| !w.is_empty());
        exported.extend(names.filter(|&n| n != room && n != "self").map(|n| (n.to_owned(), room.clone())));
    }
    exported
}

fn row(room: &str) -> Option<(u32, Wing)> {
    ROOMS.iter().find(|r| r.0 == room).map(|r| (r.1, r.2))
}

/// Why `from` may not name `to`.
fn objection(from: &str, to: &str) -> Option<String> {
    if from == to {
        return None;
    }
    let ((floor, wing), (below, other)) = (row(from)?, row(to)?);
    if below >= floor {
        return Some(format!("{from} (floor {floor}) names {to} (floor {below}): arrows point down"));
    }
    if from == "surface" && !SURFACE_SEES.contains(&to) {
        return Some(format!("surface names {to}, which is not one of the rooms it may see"));
    }
    match (wing, other) {
        (Surface, Byte) => Some(format!("{from} is in the surface wing and names {to} of the byte wing")),
        (Byte, Surface) => Some(format!("{from} is in the byte wing and names {to} of the surface wing")),
        (Surface | Byte, Both) => Some(format!("{from} is in one wing and names {to}, which sees both")),
        (Hall, _) if below > GROUND_FLOOR => Some(format!("{from} is in the hall and names {to}, which is not the ground")),
        _ => None,
    }
}

#[test]
fn imports_only_point_down() {
    let sources = sources();
    let exported = exports(&sources);
    let mut wrong = Vec::new();
    for source in &sources {
        if row(&source.room).is_none() {
            wrong.push(format!("{}: room {} has no row in the table of layers.rs", source.file.display(), source.room));
        }
        for to in named(source, &exported) {
            if let Some(why) = objection(&source.room, &to) {
                wrong.push(format!("{}: {why}", source.file.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn every_foreign_crate_is_named_in_its_rooms_only() {
    let manifest = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml")).expect("Cargo.toml");
    let section = manifest.split("\n[").find(|s| s.starts_with("dependencies]")).expect("[dependencies]");
    let mut wrong = Vec::new();
    for line in section.lines().skip(1).filter(|l| !l.trim_start().starts_with('#')) {
        let Some((name, _)) = line.split_once('=') else { continue };
        let name = name.trim().replace('-', "_");
        let Some((_, rooms)) = FOREIGN.iter().find(|f| f.0 == name) else {
            wrong.push(format!("crate {name} has no row in the table of layers.rs"));
            continue;
        };
        for source in sources() {
            let used = paths(&source.code, &name).next().is_some() || source.code.contains(&format!("use {name};"));
            if used && !rooms.contains(&source.room.as_str()) {
                wrong.push(format!("{}: names {name}, which belongs to {rooms:?}", source.file.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn only_the_command_line_prints_starts_programs_and_reads_the_environment_and_the_clock() {
    let mut wrong = Vec::new();
    for source in sources() {
        for (what, rooms) in SIDE_EFFECTS {
            let found = source.code.match_indices(what).any(|(i, _)| !source.code[..i].ends_with(is_word));
            if found && !rooms.contains(&source.room.as_str()) {
                wrong.push(format!("{}: {what}", source.file.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn the_picture_in_lib_rs_shows_every_room() {
    let lib = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).expect("lib.rs");
    let picture: Vec<&str> = lib.lines().filter(|l| l.starts_with("//!")).collect();
    for source in sources().iter().filter(|s| s.room != "lib") {
        let shown = picture.iter().any(|l| l.split(|c: char| !is_word(c)).any(|w| w == source.room));
        assert!(shown, "the picture in src/lib.rs lacks the room {}", source.room);
    }
}

#[test]
fn the_judge_itself_sees_arrows_that_point_up_or_sideways() {
    let judge = |file: &str, text: &str| {
        let module: Vec<String> = file.split('/').map(str::to_owned).collect();
        let code = without_tests(&without_comments_and_strings(text));
        let source = Source { file: file.into(), room: module[0].clone(), module, code };
        let exported = BTreeMap::from([("Mesh".to_owned(), "mesh".to_owned())]);
        named(&source, &exported).iter().filter_map(|to| objection(&source.room, to)).count()
    };
    assert_eq!(judge("mesh/io", "use crate::error::Error; use crate::{geom::aabb, limits};"), 0);
    assert_eq!(judge("mesh/io", "use crate::{error::{Error, Place}, format::chunk};"), 1);
    assert_eq!(judge("format/read", "fn f() -> crate::Mesh { super::super::geom::x() }"), 2);
    assert_eq!(judge("plane/mask", "use super::quantise; use crate::bits::Reader;"), 1);
    assert_eq!(judge("entropy/range", "// crate::mesh\nconst S: &str = \"crate::mesh\"; use crate::bits::Writer;"), 0);
    assert_eq!(
        judge("geom/bvh", "#[cfg(test)]\nmod tests { use crate::mesh::Mesh; fn f() { if true {} } }\nuse crate::eval;"),
        1
    );
    assert_eq!(judge("surface/walk", "use crate::mesh::HalfEdges; use crate::entropy::Model; use crate::format::Tag;"), 1);
    assert_eq!(judge("distance/directed", "use crate::mesh::Mesh; use crate::geom::bvh; use crate::param::tutte;"), 1);
}
