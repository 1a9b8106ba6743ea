//! The whole chain on the corpus' meshes and, where `GIMC_MESHES` names a folder, on real ones.
#![allow(clippy::unwrap_used)]

use std::collections::HashMap;

use super::*;
use crate::charts;
use crate::eval::{CompareOptions, compare};
use crate::mesh::{Mesh, Scalar};
use crate::plane::Gluing;

fn corpus(name: &str) -> Mesh {
    Mesh::open(format!("{}/corpus/meshes/{name}.ply", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn images(mesh: &Mesh, request: &Resample) -> Vec<GeometryImage> {
    request.images(mesh, &Task::default()).unwrap()
}

fn as_mesh(image: &GeometryImage) -> Mesh {
    Mesh::from_triangles(image.points().to_vec(), image.triangles())
}

/// psnr and Hausdorff distance.
fn quality(mesh: &Mesh, image: &GeometryImage) -> (f64, f64) {
    let options = CompareOptions::default().samples(50_000);
    let c = compare(mesh, &as_mesh(image), &options, &Task::default()).unwrap();
    (c.psnr, c.hausdorff)
}

fn is_closed(image: &GeometryImage) -> bool {
    let mut edges = HashMap::new();
    for t in image.triangles() {
        (0..3).for_each(|i| *edges.entry((t[i], t[(i + 1) % 3])).or_insert(0) += 1);
    }
    edges.iter().all(|(&(a, b), &n)| n == 1 && edges.contains_key(&(b, a)))
}

/// Six times the volume inside.
fn volume(mesh: &Mesh) -> f64 {
    let p = |v: u32| glam::DVec3::from(mesh.positions[v as usize]);
    mesh.faces.triangles().into_iter().map(|[a, b, c]| p(a).dot(p(b).cross(p(c)))).sum()
}

#[test]
fn a_closed_surface_stays_closed_near_and_the_right_way_out() {
    let mesh = corpus("bumpy_sphere");
    for param in [Param::Tutte, Param::Yoshizawa, Param::Stretch] {
        let image = &images(&mesh, &Resample::new(65).param(param))[0];
        assert_eq!(image.gluing(), Gluing::Orbifold);
        assert!(is_closed(image));
        let (psnr, _) = quality(&mesh, image);
        assert!(psnr > 40.0, "{param:?}: {psnr}");
        assert!((volume(&as_mesh(image)) / volume(&mesh) - 1.0).abs() < 0.05);
    }
}

#[test]
fn a_terrain_is_a_disk_that_faces_up_like_the_mesh() {
    let mesh = corpus("terrain");
    let image = &images(&mesh, &Resample::new(100))[0];
    let (psnr, _) = quality(&mesh, image);
    assert!(image.gluing() == Gluing::Open && psnr > 50.0, "{psnr}");
    let up = |m: &Mesh| -> f64 {
        let p = |v: u32| glam::DVec3::from(m.positions[v as usize]);
        m.faces.triangles().into_iter().map(|[a, b, c]| (p(b) - p(a)).cross(p(c) - p(a)).z).sum()
    };
    assert!((up(&as_mesh(image)) / up(&mesh) - 1.0).abs() < 0.1);
}

#[test]
fn fitting_brings_an_image_nearer_and_keeps_it_closed() {
    let mesh = corpus("bumpy_sphere");
    let [plain, fitted] = [Adjustment::None, Adjustment::Fit].map(|a| images(&mesh, &Resample::new(65).adjust(a)).remove(0));
    let (before, after) = (quality(&mesh, &plain).0, quality(&mesh, &fitted).0);
    assert!(is_closed(&fitted) && after > before + 1.0, "{before} to {after}");
}

#[test]
fn hausdorff_adjustment_lowers_the_greatest_distance_and_keeps_a_surface_closed() {
    let mesh = corpus("bumpy_sphere");
    let [plain, adjusted] =
        [Adjustment::None, Adjustment::Hausdorff].map(|a| images(&mesh, &Resample::new(33).adjust(a)).remove(0));
    let (before, after) = (quality(&mesh, &plain), quality(&mesh, &adjusted));
    assert!(is_closed(&adjusted) && after.1 < 0.8 * before.1, "{before:?} to {after:?}");
}

#[test]
fn every_way_to_sample_a_closed_surface_keeps_it_closed() {
    let mesh = corpus("bumpy_sphere");
    for sampling in [Sampling::Regular, Sampling::ZHOU, Sampling::Equalise] {
        let image = &images(&mesh, &Resample::new(65).sampling(sampling))[0];
        // Glued samples are welded; that they were one point before shows in the distance.
        let (psnr, _) = quality(&mesh, image);
        assert!(is_closed(image) && psnr > 40.0, "{sampling:?}: {psnr}");
    }
}

/// A long thin finger on a round foot: Tutte's map crowds its tip into the middle of the square.
fn finger() -> Mesh {
    let (around, rings) = (24_u32, 30_u32);
    let mut positions = Vec::new();
    for ring in 0..rings {
        for i in 0..around {
            let angle = (f64::from(i) + 0.5 * f64::from(ring % 2)) / f64::from(around) * std::f64::consts::TAU;
            positions.push([angle.cos(), angle.sin(), 0.3 * f64::from(ring)]);
        }
    }
    positions.push([0.0, 0.0, 0.3 * f64::from(rings) + 0.5]);
    let at = |ring: u32, i: u32| ring * around + i % around;
    let mut triangles = Vec::new();
    for i in 0..around {
        for ring in 0..rings - 1 {
            let shift = ring % 2;
            triangles.push([at(ring, i), at(ring, i + 1), at(ring + 1, i + shift)]);
            triangles.push([at(ring, i + 1 - shift), at(ring + 1, i + 1), at(ring + 1, i)]);
        }
        triangles.push([at(rings - 1, i), at(rings - 1, i + 1), rings * around]);
    }
    Mesh::from_triangles(positions, triangles)
}

#[test]
fn equal_densities_of_vertices_rescue_what_tutte_crowds() {
    let mesh = finger();
    let tutte = Resample::new(65).param(Param::Tutte);
    let [regular, equal] = [Sampling::Regular, Sampling::Equalise]
        .map(|sampling| quality(&mesh, &images(&mesh, &tutte.clone().sampling(sampling))[0]).0);
    assert!(equal > regular + 3.0, "{regular} to {equal}");
}

#[test]
fn every_component_has_an_image_of_a_size_that_suits_its_area() {
    let mesh = corpus("components");
    let images = images(&mesh, &Resample::new(65));
    assert_eq!(images.len(), 12);
    let halves_well = |n: usize| n.is_power_of_two() || (n.is_multiple_of(3) && (n / 3).is_power_of_two());
    assert!(images.iter().all(|i| halves_well(i.width() - 1)) && images.iter().any(|i| i.width() == 65));
    assert!(images.iter().any(|i| i.width() < 65));
}

#[test]
fn surfaces_with_handles_and_holes_keep_them_all() {
    for (name, side) in [("genus_5", 129), ("torus_with_holes", 65), ("block", 65), ("components", 65)] {
        let mesh = corpus(name);
        let made = images(&mesh, &Resample::new(side));
        let back = charts::mesh(&made, Scalar::F64).unwrap();
        let (before, after) = (mesh.inspect(), back.inspect());
        assert!(after.is_manifold(), "{name}: {after:?}");
        assert_eq!(
            (after.genus, after.boundary_loops, after.components),
            (before.genus, before.boundary_loops, before.components),
            "{name}"
        );
        let c = compare(&mesh, &back, &CompareOptions::default().samples(50_000), &Task::default()).unwrap();
        assert!(c.psnr > 35.0, "{name}: {}", c.psnr);
    }
}

#[test]
fn adjusting_keeps_seams_and_holes() {
    for (name, adjust) in
        [("torus_with_holes", Adjustment::Hausdorff), ("torus_with_holes", Adjustment::Fit), ("genus_5", Adjustment::Hausdorff)]
    {
        let mesh = corpus(name);
        let made = [Adjustment::None, adjust].map(|a| images(&mesh, &Resample::new(129).adjust(a)).remove(0));
        let measured = made.each_ref().map(|image| {
            let back = charts::mesh(&[image], Scalar::F64).unwrap();
            assert_eq!(back.inspect().genus, mesh.inspect().genus);
            compare(&mesh, &back, &CompareOptions::default().samples(50_000), &Task::default()).unwrap()
        });
        let better = match adjust {
            Adjustment::Hausdorff => measured[1].hausdorff < measured[0].hausdorff,
            _ => measured[1].psnr > measured[0].psnr,
        };
        assert!(better, "{name}, {adjust:?}: {measured:?}");
    }
}

#[test]
fn sides_that_do_not_fit_are_refused_with_some_that_do() {
    let error = Resample::new(60).images(&corpus("genus_5"), &Task::default()).unwrap_err();
    assert!(error.to_string().contains("such as 129"), "{error}");
    assert!(matches!(Resample::new(64).images(&corpus("sphere"), &Task::default()), Err(Error::Parameter(_))));
    assert!(matches!(Resample::new(1).images(&corpus("terrain"), &Task::default()), Err(Error::Parameter(_))));
}

#[test]
fn shrinking_and_fitting_take_turns() {
    let mesh = corpus("sphere");
    let edges = HalfEdges::new(mesh.positions.len(), mesh.faces.triangles()).unwrap();
    let atlas =
        Atlas::new(&edges, &mesh.positions, Flattening { param: Param::Yoshizawa, border: Border::Auto }, &Task::default())
            .unwrap();
    let image = atlas.sample(33, Sampler::default(), &Task::default()).unwrap().remove(0);
    let calls = std::sync::atomic::AtomicUsize::new(0);
    // Drops nothing; what comes back is what fitting alone makes of it.
    let shrink = |image: &GeometryImage| {
        calls.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        Ok(image.clone())
    };
    let adjusted =
        atlas.maps()[0].adjust(image.clone(), Adjust::Rate { shrink: &shrink, rounds: 3 }, &Task::default()).unwrap();
    assert_eq!(calls.into_inner(), 3);
    assert!(quality(&mesh, &adjusted).0 > quality(&mesh, &image).0);
}

#[test]
fn the_same_image_comes_from_any_number_of_threads() {
    let mesh = corpus("bumpy_sphere");
    let make = |threads| {
        crate::with_threads(threads, || images(&mesh, &Resample::new(65).param(Param::Stretch).adjust(Adjustment::Fit)))
            .unwrap()
    };
    assert_eq!(make(1), make(3));
}

#[test]
fn shapes_of_all_kinds_have_images_of_their_topology_or_a_refusal() {
    let mut counts = [0, 0];
    for seed in 0..200 {
        let shape = corpus_make::any(seed, 150);
        let mesh = Mesh::from_triangles(shape.positions, shape.triangles);
        match Resample::new(33).images(&mesh, &Task::default()) {
            Ok(images) => {
                let (before, after) = (mesh.inspect(), charts::mesh(&images, Scalar::F64).unwrap().inspect());
                assert!(after.is_manifold(), "seed {seed}");
                assert!(before.boundary_loops > 0 || (after.boundary_loops, after.genus) == (0, before.genus), "seed {seed}");
                counts[0] += 1;
            }
            Err(Error::Unsupported { .. } | Error::Parameter(_)) => counts[1] += 1,
            Err(e) => panic!("seed {seed}: {e}"),
        }
    }
    assert!(counts[0] > 150, "{counts:?}");
}

#[test]
fn the_units_of_a_mesh_do_not_matter() {
    let mesh = corpus("sphere");
    let image = |mesh: &Mesh| images(mesh, &Resample::new(33).param(Param::Stretch).adjust(Adjustment::Fit)).remove(0);
    let expected = image(&mesh);
    for scale in [2.0_f64.powi(-300), 2.0_f64.powi(300)] {
        let mut scaled = mesh.clone();
        scaled.positions.iter_mut().flatten().for_each(|x| *x *= scale);
        let found = image(&scaled);
        let same = found.points().iter().zip(expected.points()).all(|(p, q)| (0..3).all(|i| p[i] / scale == q[i]));
        assert!(same, "{scale:e}");
    }
}

/// Every mesh of the folder: an image, or a refusal that says what else to do; never a panic.
#[test]
fn real_meshes_have_images_or_a_refusal_with_a_way_out() {
    let Ok(folder) = std::env::var("GIMC_MESHES") else {
        eprintln!("skipped: GIMC_MESHES is not set");
        return;
    };
    let folders = [std::path::PathBuf::from(&folder), std::path::Path::new(&folder).join("nasty")];
    let files = folders.iter().filter_map(|f| std::fs::read_dir(f).ok()).flatten().flatten().map(|f| f.path());
    for file in files.filter(|f| f.is_file()) {
        let Ok(mesh) = Mesh::open(&file) else { continue };
        if mesh.faces.len() > 30_000 {
            continue;
        }
        match Resample::new(33).images(&mesh, &Task::default()) {
            Ok(images) => {
                assert!(images.iter().all(|i| i.gluing() == Gluing::Open || is_closed(i)), "{}", file.display());
                assert!(charts::mesh(&images, Scalar::F64).unwrap().inspect().is_manifold(), "{}", file.display());
            }
            Err(e) => {
                let told = e.hint().is_some() || e.to_string().contains("samples a side");
                assert!(told || matches!(e, Error::Mesh(_)), "{}: {e}", file.display());
            }
        }
    }
}
