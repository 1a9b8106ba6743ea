//! A mesh in, a file, the same mesh back.

use gimc::{Decoder, Effort, EncodeOptions, Mesh};
use proptest::prelude::*;

use crate::corpus;

const EFFORTS: [Effort; 3] = [Effort::Fast, Effort::Default, Effort::Best];

fn mesh(shape: &corpus_make::Shape) -> Mesh {
    Mesh::from_triangles(shape.positions.clone(), shape.triangles.iter().copied())
}

fn there_and_back(mesh: &Mesh, options: &EncodeOptions) -> (Mesh, gimc::Info) {
    let bytes = options.encode(mesh).unwrap();
    let decoder = Decoder::new(&bytes).unwrap();
    (decoder.decode().unwrap(), decoder.info().clone())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_manifold_mesh_comes_back_with_every_vertex_on_its_lattice_point(
        seed: u64,
        size in 1_usize..600,
        bits in 1_u32..=24,
        effort in 0_usize..3,
    ) {
        trials::roundtrip_of(&corpus_make::any(seed, size), bits, EFFORTS[effort]);
    }
}

#[test]
fn the_meshes_of_the_corpus_come_back_at_every_effort() {
    for (file, name, faces, seed) in corpus_make::COMMITTED {
        let shape = corpus_make::by_name(name, faces, seed).unwrap();
        assert_eq!(Mesh::open(corpus::path("meshes").join(file)).unwrap(), mesh(&shape));
        for (effort, bits) in EFFORTS.into_iter().zip([8, 12, 16]) {
            trials::roundtrip_of(&shape, bits, effort);
        }
    }
}

#[test]
fn a_bound_that_is_asked_for_holds_and_is_not_wasted() {
    let shape = corpus_make::torus_with_holes(900, 3, 5);
    let original = mesh(&shape);
    for bound in [1e-1, 1e-3, 1e-5] {
        let (back, info) = there_and_back(&original, &EncodeOptions::cgim().error(bound));
        assert!(info.bound <= bound, "{} > {bound}", info.bound);
        assert!(info.bound >= 0.5 * bound, "{} is far below {bound}", info.bound);
        // Every decoded vertex has an original within the bound; which one is not known without the order.
        for q in &back.positions {
            let square = |p: &[f64; 3]| (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>();
            let nearest = original.positions.iter().map(square).fold(f64::INFINITY, f64::min).sqrt();
            assert!(nearest <= info.bound, "{nearest} > {}", info.bound);
        }
    }
}

#[test]
fn a_bound_below_what_f32_can_hold_is_refused() {
    let shape = corpus_make::terrain(300, 8);
    assert!(EncodeOptions::cgim().error(1e-9).encode(&mesh(&shape)).is_err());
}

#[test]
fn two_files_on_one_lattice_agree_where_they_meet() {
    let grid = |shift: f64| {
        let mut shape = corpus_make::grid(50);
        shape.positions.iter_mut().for_each(|p| *p = [0.3 + p[0] + shift, 0.7 + p[1], 0.1]);
        mesh(&shape)
    };
    let options = EncodeOptions::cgim().lattice([-1.0, 0.25, 0.0], 0.013);
    let (left, right) = (there_and_back(&grid(0.0), &options).0, there_and_back(&grid(5.0), &options).0);
    let border = |mesh: &Mesh| {
        let mut border: Vec<[u64; 3]> =
            mesh.positions.iter().filter(|p| (p[0] - 5.3).abs() < 0.1).map(|p| p.map(f64::to_bits)).collect();
        border.sort_unstable();
        border
    };
    assert_eq!(border(&left).len(), 6);
    assert_eq!(border(&left), border(&right));
}

#[test]
fn a_mesh_without_extent_comes_back() {
    let shape = corpus_make::Shape { positions: vec![[3.0, -2.0, 7.5]; 3], triangles: vec![[0, 1, 2]] };
    for options in [EncodeOptions::cgim(), EncodeOptions::cgim().error_relative(1e-3), EncodeOptions::cgim().error(0.5)] {
        let (back, info) = there_and_back(&mesh(&shape), &options);
        assert_eq!(back.positions, shape.positions);
        assert_eq!(info.bound, 0.0);
    }
}

#[test]
fn what_cannot_be_a_mesh_is_refused_with_its_place() {
    let corners = |n: usize| (0..n).map(|i| [i as f64, (i * i) as f64, 1.0]).collect::<Vec<_>>();
    let refused = |mesh: Mesh| match EncodeOptions::cgim().encode(&mesh) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("was not refused"),
    };
    assert_eq!(refused(Mesh::from_triangles(corners(0), [])), "the mesh has no faces");
    let out_of_range = Mesh::from_triangles(corners(3), [[0, 1, 3]]);
    assert_eq!(refused(out_of_range), "face 0 names vertex 3, and there are 3 vertices");
    let mut not_finite = Mesh::from_triangles(corners(3), [[0, 1, 2]]);
    not_finite.positions[1][2] = f64::NAN;
    assert_eq!(refused(not_finite), "vertex 1 has a coordinate that is not a finite number");
}
