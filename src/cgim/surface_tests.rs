//! Any manifold to an image and back: spheres, handles, holes, several pieces.
//!
//! [`image`](super::stack::image) compares every image with its mesh before it hands it out, so an
//! image that comes is right; the tests here also look at what is in it.

use super::align::Contact;
use super::random_meshes::Growing;
use super::rng::Random;
use super::search::Search;
use super::stack::image;
use crate::mesh::HalfEdges;
use crate::task::Task;

fn options(random: &mut Random, contact: Contact) -> Search {
    Search { trials: 1 + random.below(4), seed: random.next(), contact, ..Search::default() }
}

fn every_kind_survives(make: impl Fn(&mut Random) -> HalfEdges, count: u64) {
    for seed in 0..count {
        let mut random = Random::new(seed, 3);
        let mesh = make(&mut random);
        for contact in [Contact::Slash, Contact::Overlap] {
            let options = options(&mut random, contact);
            let image = image(&mesh, &options, &Task::default()).unwrap_or_else(|e| panic!("seed {seed}, {contact:?}: {e}"));
            assert!(image.side.extra.is_empty(), "seed {seed}: the sweep made a wrong cell");
        }
    }
}

#[test]
fn three_hundred_spheres_come_back_however_they_are_opened() {
    every_kind_survives(
        |random| {
            let size = random.below(120);
            Growing::sphere().grow(size, random).half_edges()
        },
        300,
    );
}

#[test]
fn two_hundred_tori_come_back() {
    every_kind_survives(
        |random| {
            let (n, size) = (3 + random.below(4) as u32, random.below(100));
            Growing::torus(n).grow(size, random).half_edges()
        },
        200,
    );
}

#[test]
fn three_hundred_spheres_and_tori_with_holes_come_back() {
    every_kind_survives(
        |random| {
            let start = if random.below(2) == 0 { Growing::sphere() } else { Growing::torus(4) };
            let (size, holes) = (20 + random.below(100), 1 + random.below(8));
            start.grow(size, random).with_holes(holes, random).half_edges()
        },
        300,
    );
}

#[test]
fn several_pieces_are_stacked_in_one_image() {
    every_kind_survives(
        |random| {
            let mut triangles = Vec::new();
            let mut vertices = 0;
            for _ in 0..2 + random.below(5) {
                let size = random.below(40);
                let piece = match random.below(3) {
                    0 => Growing::sphere().grow(size, random),
                    1 => Growing::torus(3).grow(size, random).with_holes(2, random),
                    _ => Growing::triangle().grow_disk(size, random),
                };
                triangles.extend(piece.triangles.iter().map(|t| t.map(|v| v + vertices)));
                vertices += piece.vertices;
            }
            HalfEdges::new(vertices as usize, triangles).unwrap()
        },
        200,
    );
}
