//! The metric of surfaces: vertices slide, the connectivity and the bound hold.

use gimc::eval::{self, CompareOptions, Verdict};
use gimc::{Accuracy, Codec, Decoder, Effort, EncodeOptions, ImageChoices, Info, Limits, Mesh, Metric, Task};
use proptest::prelude::*;
use trials::seal;

fn mesh(shape: &corpus_make::Shape) -> Mesh {
    Mesh::from_triangles(shape.positions.clone(), shape.triangles.iter().copied())
}

fn sliding() -> EncodeOptions {
    EncodeOptions::cgim().metric(Metric::Surface)
}

fn there_and_back(mesh: &Mesh, options: &EncodeOptions) -> (usize, Mesh, Info) {
    let bytes = options.encode(mesh).unwrap();
    let decoder = Decoder::new(&bytes).unwrap();
    (bytes.len(), decoder.decode().unwrap(), decoder.info().clone())
}

/// The psnr and a distance that was found, once the connectivity is seen to be the same.
fn measured(original: &Mesh, back: &Mesh) -> (f64, f64) {
    let found = eval::compare(original, back, &CompareOptions::default().exact(true), &Task::default()).unwrap();
    assert_eq!(found.same_connectivity, Verdict::Same);
    (found.psnr, found.certified.unwrap().lower)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_manifold_mesh_keeps_its_connectivity_and_its_bound(
        seed: u64,
        size in 1_usize..400,
        bits in 1_u32..=24,
        best: bool,
        flat in 0_usize..8,
    ) {
        let mut shape = corpus_make::any(seed, size);
        // Some as flat as a sheet, a line or a point: normals and tangents vanish.
        let kept = if flat > 3 { 3 } else { flat };
        shape.positions.iter_mut().for_each(|p| p[kept..].fill(0.5));
        let original = mesh(&shape);
        let effort = if best { Effort::Best } else { Effort::Default };
        let (_, mut back, info) = there_and_back(&original, &sliding().bits(bits).effort(effort).keep_order(true));
        prop_assert_eq!(info.metric, "surface");
        back.precision = original.precision;
        prop_assert_eq!(&back.faces, &original.faces);
        let (_, distance) = measured(&original, &back);
        prop_assert!(distance <= info.bound, "{} farther than {}", distance, info.bound);
    }
}

#[test]
fn at_equal_psnr_the_surface_takes_far_fewer_bytes_than_the_vertices() {
    for shape in [corpus_make::bumpy_sphere(4000, 5), corpus_make::genus(4000, 3, 2)] {
        let original = mesh(&shape);
        let (plain, back, _) = there_and_back(&original, &EncodeOptions::cgim().bits(9));
        let (psnr, _) = measured(&original, &back);
        let (bytes, back, _) = there_and_back(&original, &sliding().psnr(psnr));
        let (reached, _) = measured(&original, &back);
        assert!((psnr..psnr + 0.3).contains(&reached), "{reached} dB for {psnr}");
        assert!(bytes * 100 < plain * 89, "{bytes} bytes instead of {plain}");
    }
}

#[test]
fn a_size_that_is_asked_for_is_kept_and_used() {
    let original = mesh(&corpus_make::bumpy_sphere(2000, 5));
    for size in [1500, 2500] {
        let (bytes, ..) = there_and_back(&original, &sliding().size(size));
        assert!(bytes as u64 <= size && bytes as u64 * 100 >= size * 97, "{bytes} bytes for {size}");
    }
    let refused = sliding().size(100).encode(&original).unwrap_err().to_string();
    assert!(refused.contains("too few"), "{refused}");
}

#[test]
fn a_bound_on_the_surface_holds_where_vertices_go_farther() {
    for shape in [corpus_make::torus_with_holes(1200, 2, 3), corpus_make::block(800), corpus_make::bumpy_sphere(2000, 4)] {
        let original = mesh(&shape);
        let diagonal = eval::compare(&original, &original, &CompareOptions::default(), &Task::default()).unwrap().diag;
        for share in [1e-2, 1e-3] {
            let bound = share * diagonal;
            let (_, back, info) = there_and_back(&original, &sliding().error(bound));
            assert!(info.bound <= bound && info.bound > 0.2 * bound, "{} for {bound}", info.bound);
            let (_, distance) = measured(&original, &back);
            assert!(distance <= info.bound, "{distance} farther than {}", info.bound);
        }
        let relative = sliding().error_relative(1e-2).encode(&original).unwrap();
        assert!(Decoder::new(&relative).unwrap().info().bound <= 1e-2 * diagonal);
    }
}

#[test]
fn faces_keep_the_side_they_show_where_the_step_is_not_larger_than_they_are() {
    for shape in [corpus_make::torus_with_holes(1200, 2, 3), corpus_make::bumpy_sphere(2000, 4)] {
        let encoded = sliding().bits(9).encode_with(&mesh(&shape), Task::default()).unwrap();
        assert_eq!(encoded.notes, Vec::<String>::new());
    }
}

#[test]
fn verify_finds_that_the_bound_holds_and_says_so_when_it_does_not() {
    let original = mesh(&corpus_make::torus_with_holes(600, 2, 1));
    let bytes = sliding().bits(8).encode(&original).unwrap();
    let found = eval::verify(&bytes, Limits::default(), Some(&original), Task::default()).unwrap();
    assert!(found.passed(), "{found:?}");
    let mut other = original.clone();
    other.positions.iter_mut().for_each(|p| p[2] *= 1.2);
    let found = eval::verify(&bytes, Limits::default(), Some(&other), Task::default()).unwrap();
    assert_eq!(found.first_failure().map(|f| f.0), Some("bound"));
}

#[test]
fn attributes_stay_with_their_vertices() {
    let shape = corpus_make::bumpy_sphere(300, 2);
    let mut original = mesh(&shape);
    original.attributes.push(gimc::Attribute {
        kind: gimc::AttributeKind::Other,
        name: "number".into(),
        domain: gimc::Domain::Vertex,
        width: 1,
        scalar: gimc::Scalar::I32,
        values: (0..original.positions.len()).map(|v| v as f64).collect(),
        indices: Vec::new(),
    });
    let encoded = sliding().bits(8).keep_order(true).encode_with(&original, Task::default()).unwrap();
    assert!(encoded.notes.iter().any(|note| note.contains("attributes stay with their vertices")), "{:?}", encoded.notes);
    let back = Decoder::new(&encoded.bytes).unwrap().decode().unwrap();
    assert_eq!(back.attributes, original.attributes);
    assert_eq!(back.faces, original.faces);
}

#[test]
fn what_sliding_vertices_cannot_have_is_refused() {
    let original = mesh(&corpus_make::sphere(40));
    let refused = |options: EncodeOptions| options.encode(&original).unwrap_err().to_string();
    let mut stages = ImageChoices::default();
    stages.stages = vec![2];
    assert!(refused(sliding().image(stages)).contains("stages"));
    let mut region = sliding();
    region.roi = Some(gimc::Roi::new(gimc::RoiPlace::Auto));
    assert!(refused(region).contains("regions of interest"));
    assert!(refused(sliding().effort(Effort::Fast)).contains("effort"));
    assert!(refused(sliding().exact()).contains("bit by bit"));
    assert!(refused(sliding().lattice([0.0; 3], 0.1)).contains("lattice of your own"));
    assert!(refused(sliding().codec(Codec::Mbcim)).contains("codec surface"));
    assert!(refused(EncodeOptions::gim().metric(Metric::Surface)).contains("method cgim"));
    assert!(refused(EncodeOptions::cgim().accuracy(Accuracy::Psnr(70.0))).contains("metric surface"));
    assert!(refused(sliding().step(1e-9)).contains("too small"));
    let fin = Mesh::from_triangles(
        vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]],
        [[0, 1, 2], [0, 1, 3], [0, 1, 4]],
    );
    assert!(sliding().encode(&fin).unwrap_err().to_string().contains("oriented manifolds"));
}

#[test]
fn damaged_streams_do_no_harm_and_damaged_fields_are_refused() {
    let file = sliding().bits(9).encode(&mesh(&corpus_make::torus_with_holes(160, 2, 2))).unwrap();
    for seed in 0..400_u64 {
        let damaged = seal::changed(&file, |chunks| {
            let payload = &mut chunks[1].1;
            let at = (seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20) as usize % payload.len();
            payload[at] ^= 1 << (seed % 8);
        });
        let _ = trials::decode(&damaged);
    }
    // The flags after the effort; the limit after them; the effort itself; stages beside sliding vertices.
    let fields: [(&[u8], &str); 4] = [(&[17, 8], "flags"), (&[17, 7, 8], "limit"), (&[16], "effort"), (&[21], "stage")];
    for (bytes, why) in fields {
        let damaged = seal::changed(&file, |chunks| chunks[1].1[..bytes.len()].copy_from_slice(bytes));
        let error = Decoder::new(&damaged).and_then(|d| d.decode()).unwrap_err().to_string();
        assert!(error.contains(why), "{error}");
    }
}
