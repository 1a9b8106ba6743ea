//! Images of vertices through files: any manifold in, the same mesh back.

use gimc::{Codec, Decoder, Effort, EncodeOptions, ImageChoices, Mesh};
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

#[test]
fn the_meshes_of_the_corpus_come_back_as_images() {
    for (_, name, faces, seed) in corpus_make::COMMITTED {
        survives(&corpus_make::by_name(name, faces, seed).unwrap(), 11, &mbcim(11, 1, vec![]).effort(Effort::Fast));
    }
}

#[test]
fn damaged_image_files_do_no_harm() {
    for (i, shape) in
        [corpus_make::sphere(60), corpus_make::torus_with_holes(160, 2, 2), corpus_make::genus(300, 2, 3)].iter().enumerate()
    {
        let codec = [Codec::Mbcim, Codec::Raw, Codec::Exr][i];
        let stages = if i == 0 { vec![2] } else { vec![] };
        let file = mbcim(8, 1 + i, stages).codec(codec).encode(&mesh(shape)).unwrap();
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

#[test]
fn one_mesh_and_one_seed_give_one_file_for_any_number_of_threads() {
    let shape = corpus_make::bumpy_sphere(700, 9);
    let options = mbcim(10, 30, vec![]);
    let made = [1, 2, 3].map(|n| gimc::with_threads(n, || options.encode(&mesh(&shape))).unwrap().unwrap());
    assert!(made[0] == made[1] && made[0] == made[2]);
}
