//! `gimc sweep`: its tables are true, its commands make the files that they tell of, and it goes on where it stopped.

use std::collections::BTreeMap;
use std::process::Command;

use gimc::eval::{SweepPoint, read_points};

use crate::cli::{Folder, done, fails, number};
use crate::corpus;

fn mesh(name: &str) -> String {
    corpus::path("meshes").join(name).display().to_string()
}

fn text(folder: &Folder, name: &str) -> String {
    std::fs::read_to_string(folder.file(name)).unwrap()
}

fn points(folder: &Folder) -> Vec<SweepPoint> {
    read_points(&text(folder, "out/points.csv")).unwrap()
}

/// Points without what a clock says.
fn timeless(folder: &Folder) -> Vec<SweepPoint> {
    let mut points = points(folder);
    points.iter_mut().filter_map(|p| p.result.as_mut().ok()).for_each(|m| m.seconds = [0.0; 2]);
    points
}

/// A closed surface that geometry images take, small enough for a psnr to be searched.
const SPHERE: &str = "sphere.ply";

#[test]
fn every_command_of_the_table_makes_a_file_of_so_many_bytes() {
    let folder = Folder::new("sweep-commands");
    // A name that a shell would take apart, in a format with more than the shape.
    let odd = folder.file("it's $HOME.obj");
    let uv = "v 0 0 0\nv 1 0 0\nv 1 1 0.2\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/2\n";
    std::fs::write(&odd, uv).unwrap();
    let out = folder.file("out");
    let said = done(&[
        "sweep",
        &mesh(SPHERE),
        &odd,
        "--out",
        &out,
        "--ways",
        "surface,surface-fast,mbcim,raw,exr,j2k,gim",
        "--bits",
        "8,11",
        "--rate",
        "2,6",
        "--psnr",
        "40",
        "--with",
        "--codec mbcim --search 3 --seed 7 --bits {6,9}",
        "--with",
        "mended=--repair --attributes uv --uv-bits 5 --bits 9",
        "--peers",
        "-q",
    ]);
    assert!(said.text().contains("against surface"), "{}", said.text());
    let points = points(&folder);
    let mut run = BTreeMap::new();
    for point in &points {
        let Ok(measured) = &point.result else { continue };
        let command = point.command.replace("gimc encode", &format!("{} encode -q", env!("CARGO_BIN_EXE_gimc")));
        let command = command.replace("gimc decode", &format!("{} decode -q", env!("CARGO_BIN_EXE_gimc")));
        let ran = Command::new("sh").current_dir(folder.file("")).args(["-c", &command]).output().unwrap();
        assert!(ran.status.success(), "{command}: {}", String::from_utf8_lossy(&ran.stderr));
        let file = point.command.split(' ').rev().find(|w| w.ends_with(".gimc") || w.ends_with(".drc")).unwrap();
        let bytes = std::fs::metadata(folder.file(file)).unwrap().len();
        assert_eq!(bytes, measured.bytes, "{command}");
        *run.entry(&*point.way).or_insert(0) += 1;
        if point.method == "peer" {
            continue;
        }
        // And the measures are those of `gimc compare`, the bound that of the file.
        let compared = done(&["compare", &point.file, &folder.file(file), "--json"]).text();
        assert_eq!(number(&compared, "psnr"), measured.psnr, "{command}");
        assert_eq!(number(&compared, "hausdorff"), measured.hausdorff, "{command}");
        assert!(measured.bound.is_none_or(|bound| measured.hausdorff <= bound * 1.002), "{command}: {measured:?}");
        assert_eq!(measured.bpv, 8.0 * bytes as f64 / number(&compared, "vertices"));
    }
    for way in ["surface", "surface-fast", "mbcim", "raw", "exr", "j2k", "gim", "--codec mbcim --search 3 --seed 7", "mended"] {
        assert!(run.get(way).is_some_and(|&n| n >= 1), "{way} in {run:?}");
    }
    assert!(!run.contains_key("draco") || run["draco"] == 4, "{run:?}");
}

#[test]
fn what_a_mesh_cannot_be_made_into_is_recorded_and_the_sweep_goes_on() {
    let folder = Folder::new("sweep-refused");
    // Three triangles on one edge: no surface for images.
    let fan = folder.file("fan.obj");
    std::fs::write(&fan, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n").unwrap();
    let out = folder.file("out");
    let all = ["sweep", &fan, "--out", &out, "--ways", "j2k,j2k-implied,surface", "--bits", "9", "--rate", "4", "--json"];
    let json = done(&all).text();
    assert_eq!((number(&json, "measured"), number(&json, "refused"), number(&json, "left")), (3.0, 2.0, 0.0), "{json}");
    let found = points(&folder);
    let reasons: Vec<&str> = found.iter().filter_map(|p| p.result.as_ref().err().map(String::as_str)).collect();
    assert!(reasons.len() == 2 && reasons.iter().all(|why| why.len() > 20), "{reasons:?}");
    assert!(found[2].result.is_ok() && found[2].way == "surface");
    let page = text(&folder, "out/report.html");
    assert!(page.contains("refused: "), "the reason is in the report");
    // Refused points are known as well; a mesh that nothing takes is a refusal of the whole.
    assert_eq!(number(&done(&all).text(), "known"), 3.0);
    let line = fails_with_notes(1, &["sweep", &fan, "--out", &folder.file("none"), "--ways", "j2k", "--rate", "2"]);
    assert!(line.contains("fan.obj: refused in every way: "), "{line}");
}

/// Like `fails`, for a command that says more before its failure.
fn fails_with_notes(code: i32, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_gimc")).args(arguments).output().unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{err}");
    err
}

#[test]
fn points_do_not_depend_on_the_jobs_nor_on_where_the_sweep_stopped() {
    let (one, three) = (Folder::new("sweep-one"), Folder::new("sweep-three"));
    let sphere = folder_mesh(&one, SPHERE);
    let torus = folder_mesh(&one, "torus_with_holes.ply");
    let all = |folder: &Folder, more: &[&str]| {
        let out = folder.file("out");
        let common = [
            "sweep",
            &sphere,
            &torus,
            "--out",
            &out,
            "--ways",
            "surface,mbcim,j2k",
            "--bits",
            "7,9",
            "--rate",
            "1,3",
            "--json",
        ];
        done(&[&common, more].concat()).text()
    };
    assert_eq!(number(&all(&one, &["--jobs", "1"]), "measured"), 12.0);
    assert_eq!(number(&all(&three, &["--jobs", "3", "--threads", "2"]), "measured"), 12.0);
    assert_eq!(timeless(&one), timeless(&three));
    let whole = text(&one, "out/points.csv");

    // As if it had been stopped after five points: those are kept to the letter, the others come again.
    let begun: String = whole.split_inclusive('\n').take(6).collect();
    std::fs::write(one.file("out/points.csv"), &begun).unwrap();
    let json = all(&one, &["--jobs", "2"]);
    assert_eq!((number(&json, "known"), number(&json, "measured")), (5.0, 7.0));
    assert!(text(&one, "out/points.csv").starts_with(&begun));
    assert_eq!(timeless(&one), timeless(&three));

    // All is known: nothing is measured, and the table stays as it is to the last digit.
    let before = text(&one, "out/points.csv");
    assert_eq!(number(&all(&one, &[]), "measured"), 0.0);
    assert_eq!(text(&one, "out/points.csv"), before);
    assert_eq!(number(&all(&one, &["--fresh"]), "measured"), 12.0);

    // Other settings are added; those of before stay.
    done(&["sweep", &sphere, "--out", &one.file("out"), "--ways", "none", "--with", "--bits {8,10}", "-q"]);
    let points = points(&one);
    assert_eq!(points.len(), 14);
    assert!(points[12..].iter().all(|p| p.way == "surface" && p.mesh == "sphere"));

    // A mesh that changed is measured again, and its old points are gone.
    std::fs::copy(mesh("block.ply"), &sphere).unwrap();
    let json = all(&one, &[]);
    assert_eq!((number(&json, "known"), number(&json, "measured")), (6.0, 6.0));
    let found = self::points(&one);
    let block = std::fs::metadata(mesh("block.ply")).unwrap().len();
    assert!(found.len() == 12 && found.iter().filter(|p| p.mesh == "sphere").all(|p| p.file_bytes == block));
}

fn folder_mesh(folder: &Folder, name: &str) -> String {
    std::fs::copy(mesh(name), folder.file(name)).unwrap();
    folder.file(name)
}

#[cfg(unix)]
#[test]
fn a_sweep_that_is_killed_leaves_a_whole_table_and_goes_on() {
    let folder = Folder::new("sweep-killed");
    let out = folder.file("out");
    let (sphere, arguments) =
        (mesh("bumpy_sphere.ply"), ["--ways", "surface", "--bits", "5,6,7,8,9,10,11,12,13,14,15,16", "-q"]);
    let start =
        || Command::new(env!("CARGO_BIN_EXE_gimc")).args(["sweep", &sphere, "--out", &out]).args(arguments).spawn().unwrap();
    // Killed soon after it has a point, and again.
    for least in [1, 3] {
        let mut child = start();
        for _ in 0..6000 {
            let lines = std::fs::read_to_string(folder.file("out/points.csv")).map_or(0, |text| text.lines().count());
            if lines > least {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(points(&folder).len() >= least, "a table that can be read, with the points so far");
    }
    let before = points(&folder);
    let json = done(&[&["sweep", &sphere, "--out", &out], &arguments[..], &["--json"]].concat()).text();
    assert_eq!(number(&json, "known"), before.len() as f64);
    assert_eq!(points(&folder).len(), 12);
    assert_eq!(&points(&folder)[..before.len()], &before[..]);
}

#[test]
fn a_deadline_keeps_the_points_so_far() {
    let folder = Folder::new("sweep-deadline");
    let (sphere, out) = (mesh("bumpy_sphere.ply"), folder.file("out"));
    let said = fails(1, &["sweep", &sphere, "--out", &out, "--ways", "gim", "--psnr", "55,60", "--deadline", "1e-6", "-q"]);
    assert!(said.contains("stopped: the deadline passed; 2 points are missing"), "{said}");
    assert_eq!(points(&folder).len(), 0);
    assert!(text(&folder, "out/report.html").contains("</html>"));
}

#[test]
fn tables_of_others_and_damaged_ones_are_refused_and_left_alone() {
    let folder = Folder::new("sweep-damaged");
    let (sphere, out) = (mesh(SPHERE), folder.file("out"));
    let sweep = ["sweep", &sphere, "--out", &out, "--ways", "surface", "--bits", "7,8", "-q"];
    done(&sweep);
    let sound = text(&folder, "out/points.csv");
    for (damaged, said) in [
        ("id,name\n1,x\n".to_owned(), "line 1: no table of `gimc sweep`"),
        (sound[..sound.len() - 9].to_owned(), "line 3: the last line is cut off"),
        (sound.replacen(",done,", ",dome,", 1), "line 2: status is `dome`"),
        (sound.replacen(",surface,", ",", 1), "line 2: 29 fields, 30 expected"),
        (String::new(), "the table is empty"),
    ] {
        std::fs::write(folder.file("out/points.csv"), &damaged).unwrap();
        let line = fails(1, &sweep);
        assert!(line.contains("points.csv: ") && line.contains(said), "{line}");
        assert_eq!(text(&folder, "out/points.csv"), damaged);
    }
    std::fs::write(folder.file("out/points.csv"), [0x80, 0xff]).unwrap();
    assert!(fails(1, &sweep).contains("UTF-8"));
    // A folder that is a file; meshes that are none, before anything is measured.
    let file = folder.file("file");
    std::fs::write(&file, "precious").unwrap();
    assert!(fails(1, &["sweep", &sphere, "--out", &file]).contains("is a file, and a folder"));
    assert_eq!(text(&folder, "file"), "precious");
    assert!(
        fails(1, &["sweep", &sphere, "no-such.ply", "--out", &folder.file("new")])
            .contains("no-such.ply: there is no such file")
    );
    assert!(fails(1, &["sweep", &file, "--out", &folder.file("new")]).contains("file: the content is not OBJ"));
    assert!(!std::path::Path::new(&folder.file("new")).exists());
}

#[test]
fn a_mesh_from_stdin_is_swept_and_its_command_reads_stdin() {
    let folder = Folder::new("sweep-stdin");
    let input = std::fs::File::open(mesh(SPHERE)).unwrap();
    let arguments = ["sweep", "-", "--out", &folder.file("out"), "--ways", "surface", "--bits", "8"];
    let said = Command::new(env!("CARGO_BIN_EXE_gimc")).args(arguments).stdin(input).output().unwrap();
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    let [point] = &points(&folder)[..] else { panic!("one point") };
    assert_eq!((&*point.mesh, &*point.command), ("stdin", "gimc encode - stdin-bits-8.gimc --bits 8"));
}

#[test]
fn wrong_use_of_a_sweep_is_told() {
    let (sphere, folder) = (mesh(SPHERE), Folder::new("sweep-use"));
    let out = folder.file("out");
    for (more, said) in [
        (&["--ways", "surfaces"][..], "surfaces"),
        (&["--bits", "99"], "1 to 24"),
        (&["--psnr", "0"], "positive"),
        (&["--with", "--no-such-flag"], "--no-such-flag"),
        (&["--with", "--bits 8 --json"], "not for one point of a sweep"),
        (&["--with", "--history 'open"], "does not end"),
        (&["--with", "extra.gimc --bits 8"], "extra.gimc"),
        (&["--reference", "gin"], "--reference gin: there is no such way among "),
        (&["--ways", "none"], "no way to go"),
        (&["--jobs", "0"], "0"),
    ] {
        let line = fails(2, &[&["sweep", &sphere, "--out", &out], more].concat());
        assert!(line.contains(said), "{line}");
    }
    fails(2, &["sweep", "--out", &out]);
    fails(2, &["sweep", &sphere]);
    assert!(!std::path::Path::new(&out).exists());
}

#[test]
fn the_report_needs_nothing_but_itself_and_escapes_what_it_shows() {
    let folder = Folder::new("sweep-report");
    let evil = folder.file("<b onclick='x'>&amp;.ply");
    std::fs::copy(mesh(SPHERE), &evil).unwrap();
    let out = folder.file("out");
    done(&[
        "sweep",
        &evil,
        "--out",
        &out,
        "--ways",
        "surface,mbcim",
        "--bits",
        "7,9",
        "--with",
        "<i>\"way\"</i>=--bits {8,10,exact}",
        "-q",
    ]);
    let page = text(&folder, "out/report.html");
    assert!(page.contains("&lt;b onclick=&#39;x&#39;&gt;&amp;amp;") && page.contains("&lt;i&gt;&quot;way&quot;&lt;/i&gt;"));
    for bad in ["<b ", "<i>", "src=", "href=", "url(", "@import", "<link", "<iframe"] {
        assert!(!page.contains(bad), "{bad}");
    }
    assert!(page.contains("no loss"), "the exact file is in the table");
    let addresses: Vec<&str> = page.match_indices("http").map(|(i, _)| &page[i..i + 26]).collect();
    assert_eq!(addresses, ["http://www.w3.org/2000/svg"], "the name of SVG, which nothing loads");
    let picture = text(&folder, "out/curves.svg");
    assert!(page.contains(&picture));
    is_well_formed(&picture);
    // Every way but the reference has its delta rate.
    let rates = text(&folder, "out/bd_rate.csv");
    assert_eq!(rates.lines().count(), 1 + 2 + 2, "{rates}");
}

/// Tags open and close in order, and every attribute is quoted.
fn is_well_formed(xml: &str) {
    let mut open = Vec::new();
    let mut rest = xml;
    while let Some(start) = rest.find('<') {
        let end = start + rest[start..].find('>').expect("a tag that ends");
        let tag = &rest[start + 1..end];
        assert!(tag.matches('"').count().is_multiple_of(2) && !tag.contains('<'), "{tag}");
        let name: String = tag.trim_start_matches('/').chars().take_while(|c| c.is_alphanumeric()).collect();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "{tag}");
        } else if !tag.ends_with('/') {
            open.push(name);
        }
        rest = &rest[end + 1..];
    }
    assert!(open.is_empty(), "{open:?}");
}
