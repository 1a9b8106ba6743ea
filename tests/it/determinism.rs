//! One mesh and one set of options give one file: with any number of threads, every time.

use gimc::{Decoder, Effort, EncodeOptions, Mesh};

#[test]
fn files_and_meshes_are_the_same_for_any_number_of_threads() {
    // Large enough for several streams of positions.
    let shape = corpus_make::sphere(600_000);
    let mesh = Mesh::from_triangles(shape.positions, shape.triangles);
    let options = EncodeOptions::cgim().bits(10).effort(Effort::Fast);
    let made = [1, 2, 3].map(|n| gimc::with_threads(n, || options.encode(&mesh)).unwrap().unwrap());
    assert!(made[0] == made[1] && made[0] == made[2]);
    let read = [1, 2, 3].map(|n| gimc::with_threads(n, || Decoder::new(&made[0]).unwrap().decode()).unwrap().unwrap());
    assert!(read[0] == read[1] && read[0] == read[2]);
}

#[test]
fn the_same_call_gives_the_same_bytes_again_at_every_effort() {
    for effort in [Effort::Fast, Effort::Default, Effort::Best] {
        for seed in 0..10 {
            let shape = corpus_make::any(seed, 500);
            let mesh = Mesh::from_triangles(shape.positions, shape.triangles);
            let options = EncodeOptions::cgim().bits(11).effort(effort);
            assert_eq!(options.encode(&mesh).unwrap(), options.encode(&mesh).unwrap());
        }
    }
}

#[test]
fn what_was_decoded_encodes_to_a_file_that_decodes_to_the_same_surface() {
    let shape = corpus_make::bumpy_sphere(700, 9);
    let mesh = Mesh::from_triangles(shape.positions.clone(), shape.triangles.iter().copied());
    let options = EncodeOptions::cgim().bits(11);
    let once = Decoder::new(&options.encode(&mesh).unwrap()).unwrap().decode().unwrap();
    let twice = Decoder::new(&options.encode(&once).unwrap()).unwrap().decode().unwrap();
    let placed = trials::on_lattice(&shape, 11);
    trials::assert_same(&placed, &once);
    // The box of the decoded mesh is that of the original, so the lattice is the same and nothing moves again.
    trials::assert_same(&placed, &twice);
}
