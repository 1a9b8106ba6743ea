//! Images of vertices through files: any manifold in, the same mesh back.

use gimc::{
    AttributeKind, Boundaries, Codec, Decoder, Effort, EncodeOptions, ImageChoices, J2kChoices, Limits, Mesh, Quality, Task,
};
use proptest::prelude::*;
use trials::seal;

fn mesh(shape: &corpus_make::Shape) -> Mesh {
    Mesh::from_triangles(shape.positions.clone(), shape.triangles.iter().copied())
}

fn choices(search: usize, stages: Vec<u8>) -> ImageChoices {
    let mut choices = ImageChoices::default();
    choices.search = search;
    choices.stages = stages;
    choices
}

fn mbcim(bits: u32, search: usize, stages: Vec<u8>) -> EncodeOptions {
    EncodeOptions::cgim().bits(bits).codec(Codec::Mbcim).image(choices(search, stages))
}

fn j2k(bits: u32, quality: Quality, boundaries: Boundaries, layers: u8) -> EncodeOptions {
    let mut choices = J2kChoices::default();
    choices.quality = quality;
    choices.boundaries = boundaries;
    choices.layers = layers;
    mbcim(bits, 1, vec![]).codec(Codec::J2k).j2k(choices)
}

/// A full check of the file, the original at hand: connectivity and bound are as the file says.
fn verified(mesh: &Mesh, file: &[u8]) {
    let found = gimc::eval::verify(file, Limits::default(), Some(mesh), Task::default()).unwrap();
    assert!(found.passed(), "{:?}", found.first_failure());
}

fn survives(shape: &corpus_make::Shape, bits: u32, options: &EncodeOptions) {
    let bytes = options.encode(&mesh(shape)).unwrap();
    let back = Decoder::new(&bytes).unwrap().decode().unwrap();
    trials::assert_same(&trials::on_lattice(shape, bits), &back);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_manifold_mesh_comes_back_from_index_map_and_base_colours(
        seed: u64,
        size in 1_usize..400,
        bits in 1_u32..=24,
        search in 1_usize..4,
        stages in proptest::collection::vec(1_u8..5, 0..4),
    ) {
        survives(&corpus_make::any(seed, size), bits, &mbcim(bits, search, stages));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 120, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_manifold_mesh_comes_back_from_planes_of_samples(
        seed: u64,
        size in 1_usize..300,
        // Few bits: many neighbours share a colour, and only walls part them.
        bits in 1_u32..=16,
        search in 1_usize..3,
        exr: bool,
    ) {
        let codec = if exr { Codec::Exr } else { Codec::Raw };
        survives(&corpus_make::any(seed, size), bits, &mbcim(bits, search, vec![]).codec(codec));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_manifold_mesh_comes_back_from_jpeg_2000_without_loss(seed: u64, size in 1_usize..300, bits in 1_u32..=16, implied: bool) {
        let boundaries = if implied { Boundaries::Implied } else { Boundaries::Exact };
        survives(&corpus_make::any(seed, size), bits, &j2k(bits, Quality::Lossless, boundaries, 1));
    }

    #[test]
    fn any_manifold_mesh_comes_back_from_an_image_made_as_the_paper_makes_it(seed: u64, size in 1_usize..200, raw: bool) {
        let mut options = mbcim(10, 1, vec![]).codec(if raw { Codec::Raw } else { Codec::Mbcim });
        options.image.paper = true;
        survives(&corpus_make::any(seed, size), 10, &options);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn at_any_rate_a_lossy_file_keeps_what_it_says_of_itself(
        seed: u64,
        size in 30_usize..300,
        bits in 4_u32..=14,
        rate in 0.5_f64..12.0,
        layers in 1_u8..4,
        implied: bool,
    ) {
        let boundaries = if implied { Boundaries::Implied } else { Boundaries::Exact };
        let mesh = mesh(&corpus_make::any(seed, size));
        // A rate may be too low for a stream, or for a face; then there is no file.
        if let Ok(encoded) = j2k(bits, Quality::BitsPerPixel(rate), boundaries, layers).encode_with(&mesh, Task::default()) {
            prop_assert!(implied || encoded.info.connectivity_exact, "with its borders stored the connectivity is certain");
            verified(&mesh, &encoded.bytes);
        }
    }
}

#[test]
fn a_psnr_that_is_asked_for_is_reached_and_not_by_far_exceeded() {
    let mesh = mesh(&corpus_make::bumpy_sphere(2000, 5));
    for (wanted, boundaries) in [(50.0, Boundaries::Exact), (60.0, Boundaries::Exact), (65.0, Boundaries::Implied)] {
        let file = j2k(12, Quality::Psnr(wanted), boundaries, 1).encode(&mesh).unwrap();
        verified(&mesh, &file);
        let back = Decoder::new(&file).unwrap().decode().unwrap();
        let psnr = gimc::eval::compare(&mesh, &back, &Default::default(), &Task::default()).unwrap().psnr;
        assert!((wanted..wanted + 2.0).contains(&psnr), "{psnr} dB for {wanted}");
    }
    let why = j2k(8, Quality::Psnr(120.0), Boundaries::Exact, 1).encode(&mesh).unwrap_err().to_string();
    assert!(why.contains("take more bits"), "{why}");
}

#[test]
fn normals_come_back_with_the_positions() {
    let mesh = mesh(&corpus_make::bumpy_sphere(600, 2));
    for codec in [Codec::Raw, Codec::Exr, Codec::J2k] {
        let mut options = mbcim(12, 1, vec![]).codec(codec);
        options.image.normals = Some(12);
        let file = options.encode(&mesh).unwrap();
        assert_eq!(Decoder::new(&file).unwrap().info().normal_bits, 12);
        let back = Decoder::new(&file).unwrap().decode().unwrap();
        let normals = back.attributes.iter().find(|a| a.kind == AttributeKind::Normal).expect("normals");
        // The sphere is bumpy, but nowhere do its normals point inwards.
        let centre = [0, 1, 2].map(|i| back.positions.iter().map(|p| p[i]).sum::<f64>() / back.positions.len() as f64);
        for (v, p) in back.positions.iter().enumerate() {
            let n = normals.get(v).unwrap();
            assert!((n.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-6);
            assert!((0..3).map(|i| n[i] * (p[i] - centre[i])).sum::<f64>() > 0.0, "{codec:?}: the normal of vertex {v}");
        }
    }
}

#[test]
fn a_codestream_that_is_not_what_the_container_states_is_refused() {
    let mesh = mesh(&corpus_make::sphere(60));
    let file = j2k(8, Quality::Lossless, Boundaries::Exact, 1).encode(&mesh).unwrap();
    let other = j2k(9, Quality::Lossless, Boundaries::Exact, 1).encode(&mesh).unwrap();
    // The container of the one around the codestream of the other: another depth.
    let start = |payload: &[u8]| payload.windows(4).position(|w| w == [0xff, 0x4f, 0xff, 0x51]).unwrap();
    let stream = seal::open(&other)[1].1[start(&seal::open(&other)[1].1)..].to_vec();
    let mixed = seal::changed(&file, |chunks| {
        let at = start(&chunks[1].1);
        chunks[1].1.truncate(at);
        chunks[1].1.extend(&stream);
    });
    let why = Decoder::new(&mixed).unwrap().decode().unwrap_err().to_string();
    assert!(why.contains("JPEG 2000") && why.contains("depths"), "{why}");
}

#[test]
fn the_meshes_of_the_corpus_come_back_as_images() {
    for (_, name, faces, seed) in corpus_make::COMMITTED {
        survives(&corpus_make::by_name(name, faces, seed).unwrap(), 11, &mbcim(11, 1, vec![]).effort(Effort::Fast));
    }
}

#[test]
fn damaged_image_files_do_no_harm() {
    let (sphere, torus, genus) =
        (corpus_make::sphere(60), corpus_make::torus_with_holes(160, 2, 2), corpus_make::genus(300, 2, 3));
    let mut paper = mbcim(8, 1, vec![]);
    paper.image.paper = true;
    let files = [
        mbcim(8, 1, vec![2]).encode(&mesh(&sphere)),
        mbcim(8, 2, vec![]).codec(Codec::Raw).encode(&mesh(&torus)),
        mbcim(8, 3, vec![]).codec(Codec::Exr).encode(&mesh(&genus)),
        paper.encode(&mesh(&torus)),
        j2k(8, Quality::BitsPerPixel(6.0), Boundaries::Exact, 2).encode(&mesh(&sphere)),
        j2k(8, Quality::Lossless, Boundaries::Implied, 1).encode(&mesh(&sphere)),
    ];
    for file in files {
        let file = file.unwrap();
        assert!(trials::decode(&file).is_ok());
        for (i, (_, payload)) in seal::open(&file).iter().enumerate() {
            for end in 0..payload.len() {
                drop(trials::decode(&seal::changed(&file, |chunks| chunks[i].1.truncate(end))));
                for bit in 0..8 {
                    drop(trials::decode(&seal::changed(&file, |chunks| chunks[i].1[end] ^= 1 << bit)));
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn whatever_the_fuzzer_of_images_may_choose_is_survived(bytes in proptest::collection::vec(any::<u8>(), 0..60)) {
        trials::image(&bytes);
    }
}

#[test]
fn one_mesh_and_one_seed_give_one_file_for_any_number_of_threads() {
    let shape = corpus_make::bumpy_sphere(700, 9);
    let options = mbcim(10, 30, vec![]);
    let made = [1, 2, 3].map(|n| gimc::with_threads(n, || options.encode(&mesh(&shape))).unwrap().unwrap());
    assert!(made[0] == made[1] && made[0] == made[2]);
}
