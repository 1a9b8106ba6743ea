//! Stages: a file may be cut after any of them, and what is left decodes within the bound that it then states.

use gimc::{Codec, Decoder, Effort, EncodeOptions, ImageChoices, Mesh};
use proptest::prelude::*;
use trials::seal;

fn mesh(shape: &corpus_make::Shape) -> Mesh {
    Mesh::from_triangles(shape.positions.clone(), shape.triangles.iter().copied())
}

fn staged(codec: Codec, bits: u32, stages: Vec<u8>) -> EncodeOptions {
    let mut choices = ImageChoices::default();
    choices.stages = stages;
    EncodeOptions::cgim().bits(bits).codec(codec).image(choices)
}

/// The largest distance of two vertices of the same number.
fn farthest(a: &Mesh, b: &Mesh) -> f64 {
    let square = |p: &[f64; 3], q: &[f64; 3]| (0..3).map(|i| (p[i] - q[i]) * (p[i] - q[i])).sum::<f64>();
    a.positions.iter().zip(&b.positions).map(|(p, q)| square(p, q)).fold(0.0, f64::max).sqrt()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn all_stages_together_are_the_mesh_of_one(
        seed: u64,
        size in 1_usize..400,
        bits in 1_u32..=20,
        best: bool,
        stages in proptest::collection::vec(1_u8..6, 1..4),
    ) {
        let shape = corpus_make::any(seed, size);
        let effort = if best { Effort::Best } else { Effort::Default };
        let bytes = staged(Codec::Surface, bits, stages).effort(effort).encode(&mesh(&shape)).unwrap();
        let back = Decoder::new(&bytes).unwrap().decode().unwrap();
        trials::assert_same(&trials::on_lattice(&shape, bits), &back);
    }
}

#[test]
fn a_file_cut_after_any_stage_decodes_within_its_bound_and_ever_closer() {
    let shape = corpus_make::bumpy_sphere(900, 4);
    for codec in [Codec::Surface, Codec::Mbcim] {
        let file = staged(codec, 12, vec![2, 2, 1]).encode(&mesh(&shape)).unwrap();
        assert_eq!(seal::open(&file).len(), 5);
        let full = Decoder::new(&file).unwrap();
        let lattice_bound = full.info().bound;
        let full = full.decode().unwrap();
        let mut last = f64::INFINITY;
        for stages in 0..=3 {
            let cut = seal::changed(&file, |chunks| chunks.truncate(2 + stages));
            assert!(file.starts_with(&cut));
            let back = Decoder::new(&cut).unwrap();
            let asked = Decoder::new(&file).unwrap().stages(stages);
            assert_eq!(back.info().stages_present, stages);
            assert_eq!(back.info().bound, asked.info().bound);
            let bound = back.info().bound;
            let back = back.decode().unwrap();
            assert_eq!(back, asked.decode().unwrap());
            assert_eq!(back.faces, full.faces);
            let moved = farthest(&back, &full);
            assert!(moved <= bound - lattice_bound, "{codec:?}, stage {stages}: {moved} with a bound of {bound}");
            assert!(moved < 0.6 * last || stages == 3 && moved == 0.0, "{codec:?}, stage {stages}: {moved} after {last}");
            last = moved;
        }
    }
}

#[test]
fn stages_that_a_codec_cannot_have_are_refused() {
    let mesh = mesh(&corpus_make::sphere(20));
    let refused = |options: EncodeOptions| options.encode(&mesh).unwrap_err().to_string();
    assert!(refused(staged(Codec::Surface, 12, vec![2]).effort(Effort::Fast)).contains("effort"));
    assert!(refused(staged(Codec::Raw, 12, vec![2])).contains("stages are for the codecs"));
    assert!(refused(staged(Codec::Surface, 12, vec![2, 0])).contains("at least 1"));
    assert!(refused(staged(Codec::Surface, 12, vec![20, 20])).contains("at most 24"));
}

#[test]
fn damaged_stages_do_no_harm() {
    for stages in [vec![3], vec![1, 4]] {
        let file = staged(Codec::Surface, 10, stages).encode(&mesh(&corpus_make::torus_with_holes(160, 2, 2))).unwrap();
        for seed in 0..300_u64 {
            let damaged = seal::changed(&file, |chunks| {
                let chunk = chunks.len() - 1 - (seed % 2) as usize;
                let payload = &mut chunks[chunk].1;
                let at = (seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20) as usize % payload.len();
                payload[at] ^= 1 << (seed % 8);
            });
            let _ = trials::decode(&damaged);
        }
    }
}
