//! What every map has to be: without folds, one copy of the square, low in stretch.
#![allow(clippy::unwrap_used)]

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::chart::cross;
use super::*;
use crate::geom::Bvh;
use crate::mesh::Mesh;

fn corpus(name: &str) -> (HalfEdges, Vec<DVec3>) {
    let mesh = Mesh::open(format!("{}/corpus/meshes/{name}.ply", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let positions: Vec<DVec3> = mesh.positions.iter().map(|&p| p.into()).collect();
    (HalfEdges::new(positions.len(), mesh.faces.triangles()).unwrap(), positions)
}

fn flat(name: &str, param: Param) -> Chart {
    let (mesh, positions) = corpus(name);
    flatten(mesh, positions, param, &Task::default()).unwrap()
}

/// No fold, and the copies in the square cover it once.
fn check(chart: &Chart) {
    assert_eq!(chart.folds(), 0);
    let area: f64 = (0..chart.faces()).map(|f| 0.5 * cross(chart.flat(f))).sum();
    assert!((area - 1.0).abs() < 1e-9, "area {area}");
    let (cover, _) = chart.cover();
    let tree = Bvh::new(&cover.iter().map(|t| t.map(|p| p.extend(0.0))).collect::<Vec<_>>());
    for i in 0..33 {
        for j in 0..33 {
            let p = DVec2::new(f64::from(i), f64::from(j)) / 32.0;
            assert!(tree.closest(p.extend(0.0), 0).unwrap().distance2 < 1e-20, "nothing at {p}");
        }
    }
}

#[test]
fn closed_surfaces_cover_the_square_once_without_folds() {
    for name in ["bumpy_sphere", "sphere"] {
        for param in [Param::Tutte, Param::MeanValue, Param::Yoshizawa, Param::Stretch] {
            let chart = flat(name, param);
            assert!(chart.is_closed());
            check(&chart);
        }
    }
}

#[test]
fn a_disk_covers_the_square_once_without_folds() {
    for param in [Param::Tutte, Param::MeanValue, Param::Yoshizawa, Param::Stretch] {
        let chart = flat("terrain", param);
        assert!(!chart.is_closed());
        check(&chart);
    }
}

#[test]
fn each_parametrisation_stretches_less_than_the_one_before() {
    for name in ["bumpy_sphere", "terrain"] {
        let stretch = [Param::Tutte, Param::Yoshizawa, Param::Stretch].map(|param| flat(name, param).stretch());
        assert!(stretch[0] > stretch[1] && stretch[1] > 1.0 && stretch[2] > 1.0, "{name}: {stretch:?}");
    }
    let [yoshizawa, newton] = [Param::Yoshizawa, Param::Stretch].map(|param| flat("bumpy_sphere", param).stretch());
    assert!(newton < yoshizawa, "{yoshizawa} to {newton}");
}

#[test]
fn the_smallest_surfaces_are_charts_too() {
    let tetrahedron = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    for (triangles, count) in [(tetrahedron, 4), (vec![[0, 1, 2]], 3), (vec![[0, 1, 2], [0, 2, 3]], 4)] {
        let mesh = HalfEdges::new(count, triangles).unwrap();
        check(&flatten(mesh, corners[..count].to_vec(), Param::Stretch, &Task::default()).unwrap());
    }
}

#[test]
fn points_that_all_coincide_still_have_a_map() {
    let (mesh, positions) = corpus("sphere");
    check(&flatten(mesh, vec![DVec3::ONE; positions.len()], Param::Stretch, &Task::default()).unwrap());
}

#[test]
fn handles_and_holes_are_refused_by_name() {
    for (name, what) in [("genus_5", "5 handles"), ("torus_with_holes", "1 handles"), ("block", "1 handles")] {
        let (mesh, positions) = corpus(name);
        let error = flatten(mesh, positions, Param::Tutte, &Task::default()).unwrap_err();
        assert!(error.to_string().contains(what), "{error}");
    }
}

#[test]
fn a_cancelled_task_stops_a_map() {
    let flag = std::sync::atomic::AtomicBool::new(true);
    let (mesh, positions) = corpus("sphere");
    let task = Task::default().with_cancel(&flag);
    assert!(matches!(flatten(mesh, positions, Param::Yoshizawa, &task), Err(Error::Cancelled)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// A sheet of random heights, cut off at random: chords, ears and slivers at its border.
    #[test]
    fn ragged_sheets_have_no_folds(
        heights in prop::collection::vec(-0.5..0.5_f64, 64),
        keep in prop::collection::vec(prop::bool::weighted(0.9), 98),
    ) {
        let mut triangles = Vec::new();
        for i in 0..7_u32 {
            for j in 0..7_u32 {
                let a = 8 * i + j;
                triangles.extend([[a, a + 1, a + 9], [a, a + 9, a + 8]]);
            }
        }
        let positions: Vec<DVec3> =
            (0..64).map(|v| DVec3::new(f64::from(v / 8) * 0.1, f64::from(v % 8) * 0.1, heights[v as usize])).collect();
        let kept: Vec<_> = triangles.into_iter().zip(keep).filter(|t| t.1).map(|t| t.0).collect();
        let Ok(mesh) = HalfEdges::new(64, kept) else { return Ok(()) };
        // Several pieces, or several loops, are refused; everything else must be flat.
        if let Ok(chart) = flatten(mesh, positions, Param::Yoshizawa, &Task::default()) {
            check(&chart);
        }
    }
}
