//! What every map has to be: without folds, one copy of the square, low in stretch.
#![allow(clippy::unwrap_used)]

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::chart::cross;
use super::*;
use crate::geom::Bvh;
use crate::mesh::Mesh;
use crate::plane::Gluing;

impl Chart {
    fn is_closed(&self) -> bool {
        self.gluing == Gluing::Orbifold
    }
}

fn corpus(name: &str) -> (HalfEdges, Vec<DVec3>) {
    let mesh = Mesh::open(format!("{}/corpus/meshes/{name}.ply", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let positions: Vec<DVec3> = mesh.positions.iter().map(|&p| p.into()).collect();
    (HalfEdges::new(positions.len(), mesh.faces.triangles()).unwrap(), positions)
}

fn how(param: Param) -> Flattening {
    Flattening { param, border: Border::Auto }
}

fn flat(name: &str, param: Param) -> Chart {
    let (mesh, positions) = corpus(name);
    flatten(mesh, positions, how(param), &Task::default()).unwrap()
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
        check(&flatten(mesh, corners[..count].to_vec(), how(Param::Stretch), &Task::default()).unwrap());
    }
}

#[test]
fn points_that_all_coincide_still_have_a_map() {
    let (mesh, positions) = corpus("sphere");
    check(&flatten(mesh, vec![DVec3::ONE; positions.len()], how(Param::Stretch), &Task::default()).unwrap());
}

#[test]
fn handles_are_cut_along_seams_whose_sides_lie_opposite_each_other() {
    for (name, genus) in [("genus_5", 5), ("torus_with_holes", 1), ("block", 1)] {
        for param in [Param::Tutte, Param::Yoshizawa, Param::Stretch] {
            let chart = flat(name, param);
            check(&chart);
            let seams = chart.seams.as_ref().unwrap();
            let squares = u64::from(seams.grains()) * 2;
            assert_eq!(seams.vertices(squares) as i64 - (squares * squares) as i64, 2 - 2 * genus, "{name}");
        }
    }
}

#[test]
fn both_sides_of_a_seam_hold_the_same_points() {
    let (mesh, positions) = corpus("genus_5");
    let chart = flatten(mesh, positions, how(Param::Yoshizawa), &Task::default()).unwrap();
    let seams = chart.seams.as_ref().unwrap();
    let squares = 4 * seams.grains() as usize;
    let flat: Vec<[DVec3; 3]> = (0..chart.faces()).map(|f| chart.flat(f).map(|p| p.extend(0.0))).collect();
    let tree = Bvh::new(&flat);
    let at = |row: usize, column: usize| {
        let u = DVec2::new(row as f64, column as f64) / squares as f64;
        let hit = tree.closest(u.extend(0.0), 0).unwrap();
        let ([a, b, c], face) = (tree.triangles()[hit.slot as usize].map(DVec3::truncate), tree.id(hit.slot) as usize);
        let (area, solid) = (cross([a, b, c]), chart.solid(face));
        solid[0] * (cross([u, b, c]) / area) + solid[1] * (cross([a, u, c]) / area) + solid[2] * (cross([a, b, u]) / area)
    };
    let points: Vec<[f64; 3]> =
        (0..=squares).flat_map(|r| (0..=squares).map(move |c| at(r, c).to_array()).collect::<Vec<_>>()).collect();
    let image = crate::plane::GeometryImage::new(squares + 1, squares + 1, Gluing::Open, points.clone()).unwrap();
    let sewn = image.with_seams(seams.clone()).unwrap();
    let far = |(p, q): (&[f64; 3], &[f64; 3])| DVec3::from(*p).distance(DVec3::from(*q));
    let worst = sewn.points().iter().zip(&points).map(far).fold(0.0, f64::max);
    assert!(worst < 1e-9, "{worst}");
}

#[test]
fn what_is_nearly_closed_is_laid_out_as_if_it_were() {
    let (mesh, positions) = corpus("sphere");
    let without = |dropped: &dyn Fn(usize, [u32; 3]) -> bool| {
        let kept = mesh.triangles().iter().enumerate().filter(|(f, t)| !dropped(*f, **t));
        let triangles = kept.map(|(_, t)| *t).collect();
        let part = HalfEdges::new(positions.len(), triangles).unwrap();
        flatten(part, positions.clone(), how(Param::Yoshizawa), &Task::default()).unwrap()
    };
    let middle = positions.iter().sum::<DVec3>() / positions.len() as f64;
    let is_below = |t: [u32; 3]| t.iter().any(|&v| positions[v as usize].z < middle.z);
    let small_mesh = HalfEdges::new(positions.len(), mesh.triangles()[1..].to_vec()).unwrap();
    let (small, half) = (without(&|f, _| f == 0), without(&|_, t| is_below(t)));
    assert!(small.is_closed() && (0..small.faces()).any(|f| small.is_filling(f)));
    assert!(!half.is_closed() && !(0..half.faces()).any(|f| half.is_filling(f)));
    check(&small);
    check(&half);
    let square = Flattening { border: Border::Square, ..how(Param::Yoshizawa) };
    let disk = flatten(small_mesh, positions.clone(), square, &Task::default()).unwrap();
    assert!(!disk.is_closed());
    check(&disk);
}

#[test]
fn a_cancelled_task_stops_a_map() {
    let flag = std::sync::atomic::AtomicBool::new(true);
    let (mesh, positions) = corpus("sphere");
    let task = Task::default().with_cancel(&flag);
    assert!(matches!(flatten(mesh, positions, how(Param::Yoshizawa), &task), Err(Error::Cancelled)));
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
        // Several pieces are refused; everything else must be flat.
        if let Ok(chart) = flatten(mesh, positions, how(Param::Yoshizawa), &Task::default()) {
            check(&chart);
        }
    }
}
