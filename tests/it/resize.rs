//! `gimc resize` from file to file, what its pictures show, and how it does on real meshes.

use gimc::eval::{self, CompareOptions};
use gimc::{Decoder, EncodeOptions, GeometryImage, Gluing, Mesh, ResizeMethod, ResizeOptions, Task};

use crate::cli::{Folder, done, fails, number};
use crate::corpus;

/// A sheet with two bumps.
fn sheet(width: usize, height: usize) -> GeometryImage {
    let at = |p: usize| {
        let (x, y) = ((p % width) as f64 / (width - 1) as f64, (p / width) as f64 / (height - 1) as f64);
        let bump = |a: f64, b: f64, w: f64| (-((x - a) * (x - a) + (y - b) * (y - b)) * w).exp();
        [x, 0.7 * y, 0.3 * bump(0.3, 0.4, 120.0) - 0.2 * bump(0.8, 0.7, 200.0)]
    };
    GeometryImage::new(width, height, Gluing::Open, (0..width * height).map(at).collect()).unwrap()
}

fn stored(folder: &Folder, image: &GeometryImage) -> String {
    let file = folder.file("full.gimc");
    std::fs::write(&file, EncodeOptions::gim().bits(16).encode_image(image, None, Task::default()).unwrap().bytes).unwrap();
    file
}

fn image(file: &str) -> GeometryImage {
    Decoder::new(&std::fs::read(file).unwrap()).unwrap().geometry_image().unwrap()
}

#[test]
fn every_method_resizes_a_stored_image_and_the_file_tells_how() {
    let folder = Folder::new("resize");
    let full = stored(&folder, &sheet(61, 49));
    let mut psnr = Vec::new();
    for by in ["content", "bicubic", "rds", "bilinear", "nearest", "seam", "direct"] {
        let out = folder.file(&format!("{by}.gimc"));
        let said = done(&["resize", &full, &out, "--to", "25x20", "--by", by, "--json"]).text();
        let small = image(&out);
        assert_eq!((small.width(), small.height()), (25, 20));
        psnr.push((by, number(&said, "psnr")));
        let info = done(&["info", &out]).text();
        let name = if by == "rds" { "bicubic" } else { by };
        assert!(info.contains(&format!("resized from 61 x 49 to 25 x 20 by {name}")), "{info}");
        done(&["verify", &out]);
        let measured = done(&["compare", &full, &out, "--json"]).text();
        assert!((number(&measured, "psnr") - number(&said, "psnr")).abs() < 0.15, "{said} {measured}");
    }
    let of = |by: &str| psnr.iter().find(|p| p.0 == by).unwrap().1;
    assert!(of("content") > of("bicubic") + 3.0 && of("bicubic") == of("rds"), "{psnr:?}");
    // What was resized can be resized again, and tells both.
    let again = folder.file("again.gimc");
    done(&["resize", &folder.file("content.gimc"), &again, "--to", "20", "--alpha", "0.25", "--steps", "2", "--codec", "raw"]);
    let history = Decoder::new(&std::fs::read(&again).unwrap()).unwrap().info().history.clone().unwrap();
    assert!(
        history.contains("to 25 x 20 by content, alpha 0.4, 5 steps")
            && history.contains("to 20 x 20 by content, alpha 0.25, 2 steps")
    );
}

#[test]
fn as_printed_cells_fold_and_the_program_says_so() {
    let folder = Folder::new("resize-literal");
    let full = stored(&folder, &sheet(61, 61));
    let out = folder.file("printed.gimc");
    let said = done(&["resize", &full, &out, "--to", "20x20", "--literal", "--json"]).text();
    assert!(number(&said, "folded") > 20.0, "{said}");
    assert!(done(&["info", &out]).text().contains("by content as printed, alpha 0.5, lambda 0.1"));
    let lambda = done(&["resize", &full, &out, "--to", "40x40", "--lambda", "0.2", "--json"]).text();
    assert_eq!(number(&lambda, "folded"), 0.0);
    assert_eq!(number(&lambda, "lambda"), 0.2);
}

#[test]
fn levels_of_detail_are_files_of_their_own_and_a_psnr_finds_its_size() {
    let folder = Folder::new("resize-lod");
    let full = stored(&folder, &sheet(65, 65));
    done(&["resize", &full, &folder.file("small.gimc"), "--lod", "0.5,0.25"]);
    assert_eq!(folder.names(), ["full.gimc", "small-17x17.gimc", "small-33x33.gimc"]);
    let out = folder.file("by-psnr.gimc");
    let said = done(&["resize", &full, &out, "--psnr", "55", "--json"]).text();
    assert!(number(&said, "psnr") > 54.8 && number(&said, "width") < 64.0, "{said}");
    let bicubic = done(&["resize", &full, &out, "--psnr", "55", "--by", "bicubic", "--json"]).text();
    assert!(number(&bicubic, "width") > number(&said, "width"), "{said} {bicubic}");
}

#[test]
fn a_mesh_becomes_an_image_first_and_a_closed_one_stays_closed() {
    let folder = Folder::new("resize-mesh");
    let sphere = corpus::path("meshes").join("bumpy_sphere.ply").display().to_string();
    let out = folder.file("sphere.gimc");
    done(&["resize", &sphere, &out, "--to", "33x33", "--grid", "65"]);
    let info = Decoder::new(&std::fs::read(&out).unwrap()).unwrap().info().clone();
    assert_eq!((info.gluing, info.image), (Some(Gluing::Orbifold), Some([33, 33])));
    assert!(info.history.unwrap().starts_with("sampled 65 x 65; resized from 65 x 65 to 33 x 33 by content"));
    let mesh = folder.file("sphere.ply");
    done(&["decode", &out, &mesh]);
    let seen = Mesh::open(&mesh).unwrap().inspect();
    assert!(seen.is_manifold() && seen.boundary_loops == 0 && seen.components == 1, "{seen:?}");
    assert!(fails(1, &["resize", &sphere, &out, "--to", "32x32", "--grid", "65"]).contains("odd"));
}

#[test]
fn the_papers_comparison_is_one_command() {
    let folder = Folder::new("resize-metro");
    let full = stored(&folder, &sheet(49, 49));
    done(&["resize", &full, &folder.file("metro.csv"), "--metro", "0.6,0.4"]);
    assert_eq!(folder.names(), ["full.gimc", "metro.csv", "metro.svg"]);
    let csv = std::fs::read_to_string(folder.file("metro.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 9 * 2);
    for method in ["content,", "content as printed,", "bicubic,", "seam,", "direct,"] {
        assert_eq!(csv.lines().filter(|line| line.starts_with(method)).count(), 2, "{csv}");
    }
    assert!(std::fs::read_to_string(folder.file("metro.svg")).unwrap().contains("full, 49 x 49 samples"));
}

#[test]
fn saliency_and_warp_are_pictures() {
    let folder = Folder::new("resize-view");
    let full = stored(&folder, &sheet(40, 30));
    for what in ["saliency", "warp"] {
        let out = folder.file(&format!("{what}.png"));
        done(&["view", &full, &out, "--what", what]);
        assert!(std::fs::read(&out).unwrap().starts_with(b"\x89PNG"));
    }
    done(&["view", &full, &folder.file("warp.png"), "--what", "warp", "--to", "12x9"]);
    let mesh = corpus::path("meshes").join("bumpy_sphere.ply").display().to_string();
    let plain = folder.file("plain.gimc");
    done(&["encode", &mesh, &plain]);
    assert!(fails(1, &["view", &plain, &folder.file("x.png"), "--what", "saliency"]).contains("no geometry image"));
}

#[test]
fn what_cannot_be_is_refused_in_one_line() {
    let folder = Folder::new("resize-refused");
    let (full, out) = (stored(&folder, &sheet(20, 20)), folder.file("out.gimc"));
    let mesh = corpus::path("meshes").join("bumpy_sphere.ply").display().to_string();
    let plain = folder.file("plain.gimc");
    done(&["encode", &mesh, &plain]);
    for (code, arguments, why) in [
        (1, vec![&full as &str, &out, "--to", "0x5"], "0 x 5"),
        (1, vec![&full, &out, "--to", "1x1"], "2 or more"),
        (1, vec![&full, &out, "--to", "2000000x5"], "1048576"),
        (1, vec![&full, &out, "--to", "100000x100000"], "memory"),
        (2, vec![&full, &out, "--to", "5by5"], "two whole numbers"),
        (2, vec![&full, &out], "--to"),
        (2, vec![&full, &out, "--to", "5x5", "--psnr", "50"], "--psnr"),
        (2, vec![&full, &out, "--to", "5x5", "--alpha", "2"], "alpha is 2"),
        (2, vec![&full, &out, "--to", "5x5", "--lambda", "1.5"], "lambda is 1.5"),
        (2, vec![&full, &out, "--to", "5x5", "--steps", "0"], "0 steps"),
        (2, vec![&full, &out, "--to", "5x5", "--by", "seam", "--steps", "2"], "makes no steps"),
        (2, vec![&full, &out, "--to", "5x5", "--grid", "30"], "--grid"),
        (1, vec![&full, &out, "--psnr", "2000"], "itself has a psnr"),
        (1, vec![&plain, &out, "--to", "5x5"], "no geometry image"),
    ] {
        let said = fails(code, &[&["resize"], &arguments[..]].concat());
        assert!(said.contains(why), "{arguments:?}: {said}");
    }
    assert!(!folder.names().contains(&"out.gimc".to_owned()));
}

/// The shared meshes that are a disk or a closed surface of genus 0 and not tiny: name, samples a side.
const MESHES: [(&str, usize); 10] = [
    ("camel.ply", 200),
    ("foot.ply", 300),
    ("mannequin.ply", 300),
    ("lion_head.ply", 257),
    ("davidhead.ply", 257),
    ("club.ply", 257),
    ("spot.obj", 129),
    ("bunny_hoppe.ply", 257),
    ("venus_closed.ply", 257),
    ("armadillo_52k.ply", 257),
];

#[test]
fn content_is_4_db_above_bicubic_on_at_least_8_of_10_meshes_at_a_third_of_the_side() {
    let Some(folder) = std::env::var_os("GIMC_MESHES").map(std::path::PathBuf::from) else {
        eprintln!("skipped: GIMC_MESHES names no folder of meshes");
        return;
    };
    let (mut found, mut told) = (0, String::new());
    for (name, side) in MESHES {
        let path = folder.join(name);
        if !path.exists() {
            eprintln!("skipped: {} is not there", path.display());
            return;
        }
        let task = Task::default();
        let image = eval::image_of(&Mesh::open(&path).unwrap(), side, &task).unwrap();
        let original = eval::surface_of(&image);
        let [width, height] = eval::scaled_size(&image, 1.0 / 3.0);
        let psnr = |method: ResizeMethod| {
            let resized = ResizeOptions::new(method).resize(&image, width, height, &task).unwrap();
            assert!(method != ResizeMethod::Content || resized.folded == 0);
            eval::compare(&original, &eval::surface_of(&resized.image), &CompareOptions::default(), &task).unwrap().psnr
        };
        let (content, bicubic) = (psnr(ResizeMethod::Content), psnr(ResizeMethod::Bicubic));
        told += &format!("{name} {side} to {width}: content {content:.2}, bicubic {bicubic:.2} dB\n");
        found += usize::from(content >= bicubic + 4.0);
    }
    eprintln!("{told}");
    assert!(found >= 8, "{found} of 10:\n{told}");
}
