//! Regions of interest, with every method and codec that has them.

use gimc::eval::compare_region;
use gimc::{Closer, Codec, Decoder, EncodeOptions, GimChoices, Grid, J2kChoices, Mesh, Quality, Roi, RoiPlace, Task};
use trials::seal;

use crate::cli::{Folder, done, fails, number};
use crate::corpus;

fn open(name: &str) -> Mesh {
    Mesh::open(corpus::path("meshes").join(name)).unwrap()
}

/// Where x is large: about a fifth of the mesh.
fn at_one_end(mesh: &Mesh) -> RoiPlace {
    let mut corners = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for p in &mesh.positions {
        (0..3).for_each(|i| (corners[0][i], corners[1][i]) = (corners[0][i].min(p[i]), corners[1][i].max(p[i])));
    }
    corners[0][0] = corners[1][0] - 0.2 * (corners[1][0] - corners[0][0]);
    RoiPlace::Box(corners)
}

fn inside(mesh: &Mesh, place: &RoiPlace, decoded: &Mesh) -> f64 {
    compare_region(mesh, decoded, place, &Task::default()).unwrap().psnr
}

fn quality(side: u32) -> GimChoices {
    let mut choices = GimChoices::quality();
    choices.grid = Grid::Side(side);
    choices
}

#[test]
fn a_geometry_image_meets_its_psnr_in_the_region_with_fewer_bytes() {
    for (name, side, codecs) in [
        ("bumpy_sphere.ply", 65, &[Codec::Wavelet, Codec::J2k][..]),
        ("terrain.ply", 33, &[Codec::Wavelet]),
        ("torus_with_holes.ply", 33, &[Codec::Wavelet]),
        ("components.ply", 33, &[Codec::Wavelet]),
    ] {
        let mesh = open(name);
        let place = at_one_end(&mesh);
        for &codec in codecs {
            let plain = EncodeOptions::gim().codec(codec).gim_choices(quality(side)).psnr(48.0);
            let options = plain.clone().roi(Roi::new(place.clone()));
            let bytes = options.encode(&mesh).unwrap();
            let file = Decoder::new(&bytes).unwrap();
            let said = file.info().roi.clone().unwrap();
            let found = inside(&mesh, &place, &file.decode().unwrap());
            let stated = said.psnr.unwrap();
            assert!(found >= 47.9 && (found - stated).abs() < 0.1, "{name} {codec:?}: {found}, {stated} stated");
            // Of several parts one may lie wholly inside, and count for most.
            assert!(file.info().psnr.unwrap() < found || file.info().images > 1, "{name} {codec:?}");
            assert_eq!(file.info().parts.iter().map(|part| part.1).sum::<u64>(), bytes.len() as u64);
            if codec == Codec::Wavelet {
                assert_eq!(said.coarser, 2);
                let whole = plain.encode(&mesh).unwrap();
                let fewer = bytes.len() < whole.len() || file.info().images > 1;
                assert!(fewer, "{name}: {} bytes against {}", bytes.len(), whole.len());
                // Coarser levels decode too, and nobody else's steps are taken for theirs.
                for level in 1..=file.info().levels {
                    Decoder::new(&bytes).unwrap().level(level).decode().unwrap();
                }
            }
        }
    }
}

#[test]
fn the_file_says_which_samples_are_in_the_region() {
    let mesh = open("bumpy_sphere.ply");
    let place = at_one_end(&mesh);
    let options = EncodeOptions::gim().gim_choices(quality(33)).step(0.01).roi(Roi::new(place.clone()));
    let bytes = options.encode(&mesh).unwrap();
    let file = Decoder::new(&bytes).unwrap();
    let RoiPlace::Box([low, _]) = place else { unreachable!() };
    let (image, samples) = (file.geometry_image().unwrap(), file.roi_samples().unwrap());
    assert_eq!(samples.len(), 1);
    // An edge beyond the box, and a cell, may be inside too; all of the box is.
    let reach = 0.5;
    for (p, &inside) in image.points().iter().zip(&samples[0]) {
        assert!(inside || p[0] < low[0] + 0.02, "{p:?}");
        assert!(!inside || p[0] > low[0] - reach, "{p:?}");
    }
    let without = EncodeOptions::gim().gim_choices(quality(17)).step(0.05).encode(&mesh).unwrap();
    assert!(Decoder::new(&without).unwrap().roi_samples().is_err());
}

#[test]
fn both_ways_to_draw_samples_together_lower_the_error_of_the_region() {
    let mesh = open("bumpy_sphere.ply");
    let place = at_one_end(&mesh);
    let mut choices = quality(33);
    choices.adjust = gimc::Adjust::None;
    let error = |closer: Closer| {
        let roi = Roi::new(place.clone()).closer(closer).coarser(0);
        let options = EncodeOptions::gim().gim_choices(choices.clone()).step(1e-4).roi(roi);
        let bytes = options.encode(&mesh).unwrap();
        inside(&mesh, &place, &Decoder::new(&bytes).unwrap().decode().unwrap())
    };
    let regular = error(Closer::Lines(1.0));
    let lines = error(Closer::Lines(2.0));
    let weights = error(Closer::Weights([1.0, 1.25, 1.5, 1.75, 20.0]));
    assert!(lines > regular + 1.0 && weights > regular + 0.2, "{regular}, {lines} by lines, {weights} by weights");
}

#[test]
fn exact_connectivity_has_more_bits_in_the_region_in_any_order_of_vertices() {
    let shape = corpus_make::bumpy_sphere(900, 4).shuffled(7);
    let mesh = Mesh::from_triangles(shape.positions.clone(), shape.triangles.iter().copied());
    let place = at_one_end(&mesh);
    let RoiPlace::Box([low, high]) = place else { unreachable!() };
    let is_inside = |p: &[f64; 3]| (0..3).all(|i| low[i] <= p[i] && p[i] <= high[i]);
    let longest = 2.6;
    for best in [false, true] {
        let effort = if best { gimc::Effort::Best } else { gimc::Effort::Default };
        let options = EncodeOptions::cgim().effort(effort).bits(8).roi(Roi::new(place.clone()).bits(14));
        let bytes = options.encode(&mesh).unwrap();
        let file = Decoder::new(&bytes).unwrap();
        assert_eq!(file.info().roi.as_ref().and_then(|roi| roi.bits), Some(14));
        let verified = gimc::eval::verify(&bytes, Default::default(), Some(&mesh), Task::default()).unwrap();
        assert!(verified.passed(), "{:?}", verified.first_failure());
        let back = file.decode().unwrap();
        let nearest = |p: &[f64; 3]| {
            let square = |q: &[f64; 3]| (0..3).map(|i| (p[i] - q[i]) * (p[i] - q[i])).sum::<f64>();
            back.positions.iter().map(square).fold(f64::INFINITY, f64::min).sqrt()
        };
        let worst = |wanted: bool| mesh.positions.iter().filter(|p| is_inside(p) == wanted).map(nearest).fold(0.0, f64::max);
        let (fine, coarse) = (worst(true), worst(false));
        assert!(fine < 0.9 * longest / f64::from(1 << 14), "{fine} inside");
        assert!(coarse < 0.9 * longest / f64::from(1 << 8) && coarse > 20.0 * fine, "{coarse} outside");
        assert!(file.info().bound >= coarse);
        let everywhere = EncodeOptions::cgim().effort(effort).bits(14).encode(&mesh).unwrap();
        assert!(bytes.len() < 3 * everywhere.len() / 4, "{} against {}", bytes.len(), everywhere.len());
        // Without its stage the file is one of 8 bits.
        let cut = seal::changed(&bytes, |chunks| chunks.truncate(2));
        let cut = Decoder::new(&cut).unwrap();
        assert!(cut.info().bound >= nearest(&cut.decode().unwrap().positions[0]));
        assert_eq!(cut.decode().unwrap().faces, back.faces);
    }
}

#[test]
fn jpeg_2000_brings_the_region_of_a_vertex_image_first() {
    let mesh = open("bumpy_sphere.ply");
    let place = at_one_end(&mesh);
    let mut choices = J2kChoices::default();
    choices.quality = Quality::BitsPerPixel(2.0);
    let plain = EncodeOptions::cgim().codec(Codec::J2k).j2k(choices);
    let psnr = |options: &EncodeOptions| {
        let bytes = options.encode(&mesh).unwrap();
        inside(&mesh, &place, &Decoder::new(&bytes).unwrap().decode().unwrap())
    };
    let (without, with) = (psnr(&plain), psnr(&plain.clone().roi(Roi::new(place.clone()))));
    assert!(with > without + 3.0, "{with} dB, {without} without a region");
}

#[test]
fn regions_that_other_choices_have_no_use_for_are_refused() {
    let mesh = open("sphere.ply");
    let roi = || Roi::new(RoiPlace::Auto);
    for (options, why) in [
        (EncodeOptions::cgim().roi(roi()), "needs its bits"),
        (EncodeOptions::cgim().bits(12).roi(roi().bits(12)), "more are expected"),
        (EncodeOptions::cgim().step(0.1).roi(roi().bits(12)), "no step"),
        (EncodeOptions::cgim().effort(gimc::Effort::Fast).roi(roi().bits(14)), "effort"),
        (EncodeOptions::cgim().codec(Codec::Raw).roi(roi()), "codecs surface and j2k"),
        (EncodeOptions::cgim().codec(Codec::J2k).roi(roi()), "without loss"),
        (EncodeOptions::gim().roi(roi().bits(14)), "exact connectivity"),
        (EncodeOptions::gim().error(0.1).roi(roi()), "an error holds on all"),
        (EncodeOptions::gim().roi(roi().coarser(9)), "2^9"),
        (EncodeOptions::gim().roi(roi().closer(Closer::Lines(0.5))), "lines 0.5 times"),
        (EncodeOptions::gim().roi(Roi::new(RoiPlace::Vertices(vec![1 << 20]))), "vertex 1048576"),
        (EncodeOptions::gim().roi(Roi::new(RoiPlace::Box([[50.0; 3], [60.0; 3]]))), "without a vertex"),
    ] {
        let said = options.encode(&mesh).unwrap_err().to_string();
        assert!(said.contains(why), "{said}");
    }
}

#[test]
fn the_program_takes_regions_as_boxes_lists_and_pictures() {
    let folder = Folder::new("roi");
    let mesh = corpus::path("meshes").join("bumpy_sphere.ply").display().to_string();
    let (by_box, list, picture) = (folder.file("box.txt"), folder.file("list.txt"), folder.file("picture.png"));
    std::fs::write(&by_box, "box 0.5 -9 -9 9 9 9\n").unwrap();
    std::fs::write(&list, (0..60).map(|v| format!("{v} ")).collect::<String>()).unwrap();
    let (file, back) = (folder.file("a.gimc"), folder.file("a.ply"));
    let encode = |roi: &str, more: &[&str]| {
        let gim = ["encode", &mesh, &file, "--method", "gim", "--preset", "quality", "--grid", "33", "--json", "--roi", roi];
        done(&[&gim[..], more].concat()).text()
    };
    for roi in [&by_box, &list] {
        encode(roi, &["--psnr", "45"]);
        done(&["decode", &file, &back, "--quiet"]);
        let compared = done(&["compare", &mesh, &back, "--roi", roi, "--json"]).text();
        assert!(number(&compared, "psnr_roi") > 44.9 && number(&compared, "area_roi") < 0.6, "{compared}");
    }
    // What the region became is a picture, and a picture may be the region of the next file.
    done(&["view", &file, &picture, "--what", "roi"]);
    let json = encode(&picture, &["--step", "0.02", "--roi-weights", "1,1.25,1.5,1.75,20", "--roi-coarser", "3"]);
    assert!(number(&json, "roi") > 0.0, "{json}");
    assert!(done(&["info", &file, "--json"]).text().contains("\"coarser\":3"));
    let said = fails(1, &["compare", &mesh, &back, "--roi", &picture]);
    assert!(said.contains("picture"), "{said}");
    std::fs::write(&list, "1\n2\nmany\n").unwrap();
    assert!(fails(1, &["encode", &mesh, &file, "--method", "gim", "--roi", &list]).contains("line 3"));
    fails(2, &["encode", &mesh, &file, "--method", "gim", "--roi-coarser", "1"]);
}

#[test]
fn a_grid_may_have_other_columns_than_rows() {
    let folder = Folder::new("grid");
    let file = folder.file("a.gimc");
    let encode = |mesh: &str, grid: &str| {
        let mesh = corpus::path("meshes").join(mesh).display().to_string();
        ["encode", &mesh, &file, "--method", "gim", "--preset", "quality", "--step", "0.5", "--grid", grid].map(str::to_owned)
    };
    for (mesh, sizes) in [("terrain.ply", [(20, 33), (49, 17)]), ("sphere.ply", [(17, 33), (33, 9)])] {
        for (columns, rows) in sizes {
            let arguments = encode(mesh, &format!("{columns}x{rows}"));
            done(&arguments.each_ref().map(String::as_str));
            let info = done(&["info", &file, "--json"]).text();
            assert_eq!((number(&info, "columns"), number(&info, "rows")), (f64::from(columns), f64::from(rows)));
            done(&["verify", &file]);
        }
    }
    for (mesh, grid, why) in [("components.ply", "33x17", "components"), ("genus_5.ply", "129x257", "seams")] {
        let arguments = encode(mesh, grid);
        let said = fails(1, &arguments.each_ref().map(String::as_str));
        assert!(said.contains(why), "{said}");
    }
}
