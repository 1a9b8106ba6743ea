//! The program as people and scripts call it: commands, exit codes, streams, and nothing half-written.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use crate::corpus;

/// A folder of its own for one test, removed at the end.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("gimc-cli-{}-{test}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn file(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }

    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

pub(crate) struct Said {
    code: i32,
    out: Vec<u8>,
    err: String,
}

impl Said {
    pub(crate) fn text(&self) -> String {
        String::from_utf8(self.out.clone()).unwrap()
    }
}

fn mesh(name: &str) -> String {
    corpus::path("meshes").join(name).display().to_string()
}

fn gimc_with(input: &[u8], arguments: &[&str]) -> Said {
    let mut child = Command::new(env!("CARGO_BIN_EXE_gimc"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let input = input.to_vec();
    let feeder = std::thread::spawn(move || stdin.write_all(&input).ok());
    let Output { status, stdout, stderr } = child.wait_with_output().unwrap();
    feeder.join().unwrap();
    Said { code: status.code().unwrap(), out: stdout, err: String::from_utf8(stderr).unwrap() }
}

fn gimc(arguments: &[&str]) -> Said {
    gimc_with(b"", arguments)
}

/// Runs a command that must succeed.
pub(crate) fn done(arguments: &[&str]) -> Said {
    let said = gimc(arguments);
    assert_eq!(said.code, 0, "{arguments:?}: {}", said.err);
    said
}

/// Runs a command that must fail, with a line on stderr, and a hint or none.
pub(crate) fn fails(code: i32, arguments: &[&str]) -> String {
    let said = gimc(arguments);
    assert_eq!(said.code, code, "{arguments:?}: {}", said.err);
    let lines: Vec<&str> = said.err.lines().collect();
    assert!(lines[0].starts_with("gimc: "), "{}", said.err);
    assert!(lines.len() == 1 || lines.len() == 2 && lines[1].starts_with("hint: "), "{}", said.err);
    lines[0].to_owned()
}

/// The number after `"key":` in a line of JSON, if it is there.
pub(crate) fn number(json: &str, key: &str) -> f64 {
    let start = json.find(&format!("\"{key}\":")).unwrap_or_else(|| panic!("no {key} in {json}")) + key.len() + 3;
    let text: String = json[start..].chars().take_while(|c| !",}]".contains(*c)).collect();
    text.parse().unwrap_or_else(|_| panic!("{key} is {text}"))
}

/// A small strict reader of JSON: panics unless `text` is one value, and gives the keys of the outermost object.
fn keys(text: &str) -> Vec<String> {
    struct Reader<'a>(&'a [u8], usize);
    impl Reader<'_> {
        fn space(&mut self) {
            while self.0.get(self.1).is_some_and(u8::is_ascii_whitespace) {
                self.1 += 1;
            }
        }
        fn take(&mut self, byte: u8) {
            self.space();
            assert_eq!(self.0.get(self.1).map(|&b| b as char), Some(byte as char), "at byte {}", self.1);
            self.1 += 1;
        }
        fn peek(&mut self) -> u8 {
            self.space();
            self.0[self.1]
        }
        fn string(&mut self) -> String {
            self.take(b'"');
            let start = self.1;
            while self.0[self.1] != b'"' {
                assert!(self.0[self.1] >= 0x20, "a control character in a string");
                self.1 += if self.0[self.1] == b'\\' { 2 } else { 1 };
            }
            self.1 += 1;
            String::from_utf8(self.0[start..self.1 - 1].to_vec()).unwrap()
        }
        fn value(&mut self) -> Vec<String> {
            let mut keys = Vec::new();
            match self.peek() {
                b'{' | b'[' => {
                    let (open, close) = if self.peek() == b'{' { (b'{', b'}') } else { (b'[', b']') };
                    self.take(open);
                    while self.peek() != close {
                        if open == b'{' {
                            keys.push(self.string());
                            self.take(b':');
                        }
                        self.value();
                        if self.peek() != close {
                            self.take(b',');
                            assert_ne!(self.peek(), close, "a comma at the end");
                        }
                    }
                    self.take(close);
                }
                b'"' => drop(self.string()),
                _ => {
                    let rest = std::str::from_utf8(&self.0[self.1..]).unwrap();
                    let word: String = rest.chars().take_while(|c| !",]}".contains(*c) && !c.is_whitespace()).collect();
                    assert!(["true", "false", "null"].contains(&&*word) || word.parse::<f64>().is_ok(), "{word}");
                    self.1 += word.len();
                }
            }
            keys
        }
    }
    let mut reader = Reader(text.as_bytes(), 0);
    let keys = reader.value();
    reader.space();
    assert_eq!(reader.1, text.len(), "something follows the JSON value");
    keys
}

#[test]
fn the_main_job_works_from_mesh_to_mesh() {
    let folder = Folder::new("main");
    let (file, back) = (folder.file("a.gimc"), folder.file("b.ply"));
    let original = mesh("torus_with_holes.ply");
    let encoded = done(&["encode", &original, &file, "--bits", "12", "--json"]).text();
    assert_eq!(
        keys(&encoded)[..10],
        ["vertices", "faces", "method", "codec", "effort", "bytes", "bpv", "bits", "step", "bound"]
    );
    let size = std::fs::metadata(&file).unwrap().len() as f64;
    assert_eq!(number(&encoded, "bytes"), size);
    assert_eq!(number(&encoded, "bpv"), 8.0 * size / number(&encoded, "vertices"));
    assert!(number(&encoded, "bound") <= 3_f64.sqrt() / 2.0 * number(&encoded, "step") * 1.001);
    done(&["decode", &file, &back]);
    done(&["verify", &file, &original]);
    let compared = done(&["compare", &original, &back, "--json", "--exact", "--same-connectivity"]).text();
    for key in [
        "rms",
        "rms_max",
        "hausdorff",
        "psnr",
        "psnr_vertex",
        "normal_rms",
        "samples",
        "diag",
        "same_connectivity",
        "vertices",
        "faces",
    ] {
        assert!(keys(&compared).iter().any(|k| k == key), "{key} is missing");
    }
    assert!(number(&compared, "hausdorff") <= number(&encoded, "bound") * 1.002);
    assert_eq!(folder.names(), ["a.gimc", "b.ply"], "nothing else is left behind");
}

#[test]
fn info_adds_up_and_says_all_in_one_object() {
    let folder = Folder::new("info");
    let file = folder.file("a.gimc");
    done(&["encode", &mesh("genus_5.ply"), &file, "--error-rel", "1e-4"]);
    let info = done(&["info", &file, "--json"]).text();
    assert_eq!(info.lines().count(), 1);
    for key in ["method", "codec", "vertices", "faces", "bytes", "box", "step", "bound", "parts", "chunks", "memory", "work"] {
        assert!(keys(&info).iter().any(|k| k == key), "{key} is missing");
    }
    let parts = &info[info.find("\"parts\":{").unwrap() + 9..];
    let parts = &parts[..parts.find('}').unwrap()];
    let sum: f64 = parts.split(',').map(|part| part.split(':').nth(1).unwrap().parse::<f64>().unwrap()).sum();
    assert_eq!(sum, std::fs::metadata(&file).unwrap().len() as f64);
    assert_eq!(number(&info, "bytes"), sum);
    let diagonal = number(&done(&["compare", &mesh("genus_5.ply"), &file, "--json"]).text(), "diag");
    assert!(number(&info, "bound") <= 1e-4 * diagonal);
    let text = done(&["info", &file]).text();
    assert!(text.contains("2,492") && text.contains("chunk HEAD"), "{text}");
}

#[test]
fn every_format_comes_out_by_its_extension_and_goes_in_again() {
    let folder = Folder::new("formats");
    let file = folder.file("a.gimc");
    done(&["encode", &mesh("sphere.ply"), &file]);
    for extension in ["obj", "ply", "off", "stl", "glb"] {
        let (out, again) = (folder.file(&format!("m.{extension}")), folder.file("again.gimc"));
        done(&["decode", &file, &out]);
        done(&["encode", &out, &again]);
        let info = done(&["info", &again, "--json"]).text();
        assert_eq!((number(&info, "vertices"), number(&info, "faces")), (162.0, 320.0), "{extension}");
    }
}

#[test]
fn dashes_are_stdin_and_stdout() {
    let folder = Folder::new("pipes");
    let original = std::fs::read(mesh("sphere.ply")).unwrap();
    let encoded = gimc_with(&original, &["encode", "-", "-", "--bits", "9"]);
    assert_eq!(encoded.code, 0, "{}", encoded.err);
    done(&["encode", &mesh("sphere.ply"), &folder.file("a.gimc"), "--bits", "9"]);
    assert!(encoded.out == std::fs::read(folder.file("a.gimc")).unwrap(), "stdout carries the file and nothing else");
    let decoded = gimc_with(&encoded.out, &["decode", "-", "-", "--format", "off"]);
    assert!(decoded.text().starts_with("OFF"), "{}", decoded.err);
    let inspected = gimc_with(&decoded.out, &["inspect", "-", "--json"]);
    assert_eq!(number(&inspected.text(), "vertices"), 162.0);
    assert_eq!(gimc_with(&encoded.out, &["info", "-"]).code, 0);
    assert_eq!(gimc_with(&encoded.out, &["verify", "-", &mesh("sphere.ply")]).code, 0);
    assert_eq!(gimc_with(&original, &["compare", "-", &mesh("sphere.ply")]).code, 0);
    let refused = gimc_with(b"GIF89a", &["encode", "-", "-"]);
    assert_eq!((refused.code, refused.out.len()), (1, 0));
    assert!(refused.err.starts_with("gimc: stdin: "), "{}", refused.err);
    fails(2, &["encode", &mesh("sphere.ply"), "-", "--json"]);
    fails(2, &["compare", "-", "-"]);
}

#[test]
fn a_failure_leaves_the_target_as_it_was() {
    let folder = Folder::new("atomic");
    let (target, bad) = (folder.file("target.gimc"), folder.file("bad.ply"));
    std::fs::write(&target, "precious").unwrap();
    std::fs::write(&bad, "ply\nformat ascii 1.0\nelement vertex 3\n").unwrap();
    let line = fails(1, &["encode", &bad, &target]);
    assert!(line.contains("bad.ply"), "{line}");
    fails(1, &["encode", &mesh("terrain.ply"), &target, "--error", "1e-12"]);
    fails(1, &["encode", &mesh("terrain.ply"), &target, "--deadline", "1e-9"]);
    fails(1, &["decode", &target, &folder.file("new.ply")]);
    assert_eq!(std::fs::read(&target).unwrap(), b"precious");
    assert_eq!(folder.names(), ["bad.ply", "target.gimc"]);
    // And it is replaced when all went well.
    done(&["encode", &mesh("sphere.ply"), &target]);
    assert!(std::fs::read(&target).unwrap().starts_with(b"gimc"));
    fails(1, &["encode", &mesh("sphere.ply"), &folder.file("no/such/folder/a.gimc")]);
    fails(1, &["encode", &mesh("sphere.ply"), &folder.0.display().to_string()]);
}

#[cfg(unix)]
#[test]
fn links_stay_links_and_devices_stay_devices() {
    let folder = Folder::new("links");
    let (real, link) = (folder.file("real.gimc"), folder.file("link.gimc"));
    std::fs::write(&real, "old").unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    done(&["encode", &mesh("sphere.ply"), &link]);
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
    assert!(std::fs::read(&real).unwrap().starts_with(b"gimc"));
    done(&["encode", &mesh("sphere.ply"), "/dev/null"]);
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn wrong_use_is_told_from_refusal_by_the_exit_code() {
    let sphere = mesh("sphere.ply");
    for arguments in [
        &["encode"][..],
        &["frobnicate"],
        &["encode", &sphere, "out.gimc", "--bits", "25"],
        &["encode", &sphere, "out.gimc", "--bits", "0"],
        &["encode", &sphere, "out.gimc", "--step", "-1"],
        &["encode", &sphere, "out.gimc", "--bits", "8", "--step", "1"],
        &["encode", &sphere, "out.gimc", "--lattice", "0,0,0"],
        &["encode", &sphere, "out.gimc", "--effort", "heroic"],
        &["encode", &sphere, "out.gimc", "--no-such-flag"],
        &["decode", "in.gimc", "mesh.xyz"],
        &["decode", "in.gimc", "mesh.ply", "--limit-memory", "much"],
        &["completions", "no-such-shell"],
    ] {
        fails(2, arguments);
    }
    assert!(fails(1, &["info", "no-such-file"]).contains("no-such-file: there is no such file"));
    assert!(fails(1, &["info", &sphere]).contains("not a gimc file"));
    assert!(!Path::new("out.gimc").exists());
    assert_eq!(gimc(&[]).code, 2);
}

#[test]
fn help_version_and_completions_go_to_stdout() {
    let help = done(&["help"]).text();
    for command in ["encode", "decode", "info", "verify", "inspect", "compare", "sweep", "completions"] {
        assert!(help.contains(command), "{command}");
        assert!(done(&["help", command]).text().contains("Usage: gimc"), "{command}");
        assert!(done(&[command, "--help"]).text().contains("Usage: gimc"), "{command}");
    }
    assert!(done(&["--version"]).text().contains(env!("CARGO_PKG_VERSION")));
    for shell in ["bash", "zsh", "fish"] {
        assert!(done(&["completions", shell]).text().contains("error-rel"), "{shell}");
    }
}

#[test]
fn verify_finds_damage_and_broken_promises() {
    let folder = Folder::new("verify");
    let file = folder.file("a.gimc");
    done(&["encode", &mesh("genus_5.ply"), &file, "--bits", "10"]);
    let json = done(&["verify", &file, &mesh("genus_5.ply"), "--json"]).text();
    assert_eq!(keys(&json), ["passed", "checks"]);
    assert!(json.starts_with("{\"passed\":true"), "{json}");
    assert!(fails(1, &["verify", &file, &mesh("sphere.ply")]).contains("connectivity"));
    let sound = std::fs::read(&file).unwrap();
    let mut damaged = sound.clone();
    damaged[60] ^= 4;
    std::fs::write(&file, damaged).unwrap();
    assert!(fails(1, &["verify", &file]).contains("checksum"));
    // A bound that is too good to be true: the last four bytes of the header.
    let lie = trials::seal::changed(&sound, |chunks| {
        let end = chunks[0].1.len();
        chunks[0].1[end - 4..].copy_from_slice(&1e-9_f32.to_le_bytes());
    });
    std::fs::write(&file, lie).unwrap();
    done(&["verify", &file]);
    fails(1, &["verify", &file, &mesh("genus_5.ply")]);
}

#[test]
fn compare_tells_a_changed_surface_and_paints_it() {
    let folder = Folder::new("compare");
    let (file, heat) = (folder.file("a.gimc"), folder.file("heat.ply"));
    done(&["encode", &mesh("bumpy_sphere.ply"), &file, "--bits", "6"]);
    let json = done(&["compare", &mesh("bumpy_sphere.ply"), &file, "--json", "--heatmap", &heat]).text();
    assert!((30.0..60.0).contains(&number(&json, "psnr")), "{json}");
    let head = String::from_utf8_lossy(&std::fs::read(&heat).unwrap()[..400]).into_owned();
    assert!(head.contains("property uchar red") && head.contains("distance"), "{head}");
    let line = fails_after_result(&["compare", &mesh("bumpy_sphere.ply"), &mesh("genus_5.ply"), "--same-connectivity"]);
    assert!(line.contains("connectivity differs"), "{line}");
}

/// Runs a command that prints its result and then exits with 1.
fn fails_after_result(arguments: &[&str]) -> String {
    let said = gimc(arguments);
    assert_eq!(said.code, 1, "{}", said.err);
    assert!(!said.out.is_empty());
    said.err
}

#[test]
fn inspect_names_faults_in_plain_words_and_in_json() {
    let folder = Folder::new("inspect");
    let bad = folder.file("bad.obj");
    std::fs::write(&bad, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\nv 7 7 7\nf 1 2 3\nf 2 1 4\nf 1 2 5\n").unwrap();
    let text = done(&["inspect", &bad]).text();
    assert!(text.contains("1 edge has more than two faces") && text.contains("1 vertex is used by no face"), "{text}");
    assert!(text.contains("not an oriented manifold"), "{text}");
    let json = done(&["inspect", &bad, "--json"]).text();
    assert_eq!((number(&json, "non_manifold_edges"), number(&json, "isolated_vertices")), (1.0, 1.0));
    done(&["encode", &bad, &folder.file("out.gimc")]);
    std::fs::write(&bad, "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n").unwrap();
    let said = gimc(&["encode", &bad, &folder.file("out.gimc")]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("vertex 2 has a coordinate that is not a finite number"), "{}", said.err);
    let said = gimc(&["inspect", &mesh("sphere.ply"), &folder.file("none.obj"), &mesh("torus_with_holes.ply")]);
    assert_eq!(said.code, 1, "one of several files is not there");
    assert!(said.err.contains("none.obj: there is no such file"), "{}", said.err);
    assert!(said.text().contains("sphere.ply\n") && said.text().contains("torus_with_holes.ply\n"), "{}", said.text());
    let good = done(&["inspect", &mesh("torus_with_holes.ply"), "--json"]).text();
    assert_eq!((number(&good, "genus"), number(&good, "boundary_loops"), number(&good, "components")), (1.0, 5.0, 1.0));
}

#[test]
fn quiet_is_silent_and_notes_are_on_stderr() {
    let folder = Folder::new("quiet");
    let (named, out) = (folder.file("named.obj"), folder.file("out.gimc"));
    std::fs::write(&named, "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n").unwrap();
    let said = done(&["encode", &named, &out, "--attributes", "groups"]);
    assert!(said.err.contains("note: ") && said.err.contains("left out"), "{}", said.err);
    assert!(said.out.is_empty());
    let said = done(&["encode", &named, &out, "--attributes", "none", "--quiet"]);
    assert!(said.err.is_empty() && said.out.is_empty(), "{}", said.err);
}

#[test]
fn limits_of_the_command_line_hold() {
    let folder = Folder::new("limits");
    let (file, out) = (folder.file("a.gimc"), folder.file("b.ply"));
    done(&["encode", &mesh("bumpy_sphere.ply"), &file]);
    for limit in ["--limit-memory", "--limit-vertices", "--limit-work"] {
        let said = gimc(&["decode", &file, &out, limit, "1K"]);
        assert_eq!(said.code, 1, "{limit}");
        assert!(said.err.contains(&format!("hint: if the file is trusted, raise the limit: {limit} ")), "{}", said.err);
    }
    assert_eq!(folder.names(), ["a.gimc"]);
    done(&["decode", &file, &out, "--limit-memory", "64M", "--threads", "2", "--deadline", "60"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_that_promises_a_huge_mesh_does_not_get_the_memory() {
    let folder = Folder::new("huge");
    let file = folder.file("a.gimc");
    done(&["encode", &mesh("sphere.ply"), &file, "--bits", "8"]);
    let sound = std::fs::read(&file).unwrap();
    // 162 vertices are the varint a2 01; 60 million of them are below the default limits.
    let huge = trials::seal::changed(&sound, |chunks| {
        assert_eq!(chunks[0].1[2..4], [0xa2, 0x01]);
        chunks[0].1.splice(2..4, [0x80, 0x8e, 0xce, 0x1c]);
    });
    std::fs::write(&file, huge).unwrap();
    let script = format!("ulimit -v 600000; exec {} decode {file} {}", env!("CARGO_BIN_EXE_gimc"), folder.file("b.ply"));
    let output = Command::new("sh").args(["-c", &script]).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let script = format!("{} completions bash | head -c 10 > /dev/null; echo ${{PIPESTATUS[0]}}", env!("CARGO_BIN_EXE_gimc"));
    let Ok(output) = Command::new("bash").args(["-c", &script]).output() else { return };
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "0", "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn repair_says_what_it_does_and_attributes_are_kept_as_asked() {
    let folder = Folder::new("repair");
    let (soup, out, back) = (folder.file("soup.obj"), folder.file("out.gimc"), folder.file("back.obj"));
    let text = "v 0 0 0\nv 0 1 0\nv 1 0 0\nv 0 0 0\nv 1 0 0\nv 0 0 0.1\nvt 0 0.1\nvt 1 0\nvt 0.3 1\n";
    std::fs::write(&soup, format!("{text}f 1/1 2/2 3/3\nf 4/2 5/1 6/3\n")).unwrap();
    let said = done(&["encode", &soup, &out, "--repair", "--uv-bits", "exact", "--bits", "exact"]);
    assert!(said.err.contains("repair: weld 2 vertices"), "{}", said.err);
    let info = done(&["info", &out, "--json"]).text();
    assert_eq!((number(&info, "vertices"), number(&info, "bound")), (4.0, 0.0));
    assert!(info.contains("\"exact\":true") && info.contains("\"floats bit by bit\""), "{info}");
    done(&["decode", &out, &back]);
    let text = std::fs::read_to_string(&back).unwrap();
    assert!(["v 0 0 0.1\n", "vt 0 0.1\n", "vt 0.3 1\n"].iter().all(|line| text.contains(line)), "{text}");
    let said = gimc(&["encode", &soup, &out, "--weld", "0.1"]);
    assert_eq!(said.code, 2, "welding is part of repairing");
}
