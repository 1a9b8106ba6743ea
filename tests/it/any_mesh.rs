//! Any mesh in, the same mesh back: whatever is wrong with it.
//!
//! The slow judge: positions are made all different, so that every decoded vertex tells which one it was; then the vertices
//! and the oriented cycles of the faces must be the same as multisets.

use std::path::PathBuf;

use corpus_make::random::Random;
use gimc::{Decoder, Effort, EncodeOptions, Mesh};
use proptest::prelude::*;

/// A mesh on lattice points of 24 bits, no two vertices at one place.
fn mesh(vertices: usize, faces: &[Vec<u32>]) -> Mesh {
    // The first two span the box, so that the lattice is that of the integers.
    let place = |i: usize| match i {
        0 => [0.0; 3],
        1 => [f64::from((1 << 12) - 1); 3],
        _ => [(i * 37 % 4000) as f64, (i * 91 % 4001) as f64, i as f64],
    };
    let mut mesh = Mesh { positions: (0..vertices).map(place).collect(), ..Mesh::default() };
    faces.iter().for_each(|f| mesh.faces.push(f));
    mesh
}

/// Vertices as places and faces as cycles of places, each from its least on, sorted.
fn picture(mesh: &Mesh) -> (Vec<[i64; 3]>, Vec<Vec<[i64; 3]>>) {
    let place = |v: u32| mesh.positions[v as usize].map(|x| (x * 8.0).round() as i64);
    let mut vertices: Vec<_> = (0..mesh.positions.len() as u32).map(place).collect();
    vertices.sort_unstable();
    let cycle = |face: &[u32]| {
        let places: Vec<[i64; 3]> = face.iter().map(|&v| place(v)).collect();
        let turned = |i: usize| [&places[i..], &places[..i]].concat();
        (0..places.len()).map(turned).min().unwrap_or_default()
    };
    let mut faces: Vec<_> = mesh.faces.iter().map(cycle).collect();
    faces.sort_unstable();
    (vertices, faces)
}

/// Encodes, decodes under the memory that the file announces, and compares.
fn comes_back(mesh: &Mesh, effort: Effort) -> gimc::Info {
    let encoded = EncodeOptions::cgim().bits(12).effort(effort).encode_with(mesh, gimc::Task::default()).unwrap();
    assert!(encoded.notes.is_empty(), "{:?}", encoded.notes);
    let info = encoded.info;
    let limits = gimc::Limits::default().memory(info.memory).work(2 * info.work);
    let back = Decoder::with_limits(&encoded.bytes, limits).unwrap().decode().unwrap();
    assert_eq!(picture(mesh), picture(&back));
    assert_eq!((info.vertices as usize, info.faces as usize), (mesh.positions.len(), mesh.faces.len()));
    assert_eq!(info.parts.iter().map(|p| p.1).sum::<u64>(), encoded.bytes.len() as u64);
    comes_back_in_order(mesh, effort);
    info
}

/// The same with every coordinate bit by bit.
fn comes_back_exactly(mesh: &Mesh) {
    for keep_order in [true, false] {
        let bytes = EncodeOptions::cgim().exact().effort(Effort::Fast).keep_order(keep_order).encode(mesh).unwrap();
        let info = Decoder::new(&bytes).unwrap().info().clone();
        assert_eq!((info.bound, info.bits, info.exact), (0.0, None, true));
        let limits = gimc::Limits::default().memory(info.memory).work(2 * info.work);
        let back = Decoder::with_limits(&bytes, limits).unwrap().decode().unwrap();
        let bits = |mesh: &Mesh| mesh.positions.iter().map(|p| p.map(f64::to_bits)).collect::<Vec<_>>();
        let (mut before, mut after) = (bits(mesh), bits(&back));
        if !keep_order {
            before.sort_unstable();
            after.sort_unstable();
        }
        assert_eq!(before, after);
        assert_eq!(picture(mesh), picture(&back));
    }
}

/// The same with `keep_order`: everything is where it was.
fn comes_back_in_order(mesh: &Mesh, effort: Effort) {
    let bytes = EncodeOptions::cgim().bits(12).effort(effort).keep_order(true).encode(mesh).unwrap();
    let info = Decoder::new(&bytes).unwrap().info().clone();
    let limits = gimc::Limits::default().memory(info.memory).work(2 * info.work);
    let back = Decoder::with_limits(&bytes, limits).unwrap().decode().unwrap();
    assert_eq!(mesh.faces, back.faces);
    let places = |mesh: &Mesh| mesh.positions.iter().map(|p| p.map(|x| (x * 8.0).round() as i64)).collect::<Vec<_>>();
    assert_eq!(places(mesh), places(&back));
    assert!(info.parts.iter().any(|p| p.0 == "order"));
    assert_eq!(info.parts.iter().map(|p| p.1).sum::<u64>(), bytes.len() as u64);
}

const EFFORTS: [Effort; 3] = [Effort::Fast, Effort::Default, Effort::Best];

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_soup_of_polygons_comes_back(
        vertices in 2_u32..24,
        faces in proptest::collection::vec(proptest::collection::vec(0_u32..1000, 0..8), 0..60),
        effort in 0_usize..3,
    ) {
        let faces: Vec<Vec<u32>> = faces.iter().map(|f| f.iter().map(|v| v % vertices).collect()).collect();
        comes_back(&mesh(vertices as usize, &faces), EFFORTS[effort]);
    }

    #[test]
    fn any_soup_of_triangles_comes_back(
        vertices in 3_u32..200,
        faces in proptest::collection::vec(proptest::array::uniform3(0_u32..1000), 1..300),
        effort in 0_usize..3,
    ) {
        let faces: Vec<Vec<u32>> = faces.iter().map(|f| f.iter().map(|v| v % vertices).collect()).collect();
        comes_back(&mesh(vertices as usize, &faces), EFFORTS[effort]);
    }

    #[test]
    fn a_sound_mesh_with_any_damage_comes_back(seed: u64, size in 1_usize..400, damage in 1_u64..40, effort in 0_usize..3) {
        let shape = corpus_make::any(seed, size);
        let mut random = Random::new(seed ^ 1);
        let mut vertices = shape.positions.len();
        let mut faces: Vec<Vec<u32>> = shape.triangles.iter().map(|t| t.to_vec()).collect();
        for _ in 0..random.below(damage) {
            let f = random.below(faces.len() as u64) as usize;
            let v = random.below(vertices as u64) as u32;
            match random.below(8) {
                0 => faces[f].reverse(),
                1 => faces.push(faces[f].clone()),
                2 => faces.push(faces[f].iter().rev().copied().collect()),
                3 => faces[f] = vec![v, faces[f][0], faces[f][0]],
                4 => faces[f][0] = v,
                5 => vertices += 1,
                6 => faces[f].push(v),
                _ => faces.iter_mut().flatten().filter(|w| **w == v).for_each(|w| *w = (v + 1) % vertices as u32),
            }
        }
        comes_back(&mesh(vertices, &faces), EFFORTS[effort]);
    }
}

#[test]
fn moebius_strips_fans_on_an_edge_bow_ties_and_quads_come_back() {
    let strip: Vec<Vec<u32>> =
        (0..9_u32).map(|i| if i < 8 { vec![2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1] } else { vec![16, 1, 0, 17] }).collect();
    let fan = vec![vec![0, 1, 2], vec![1, 0, 3], vec![0, 1, 4], vec![0, 1, 5]];
    let bow_tie = vec![vec![0, 1, 2], vec![0, 3, 4]];
    let cube =
        [[0, 1, 2, 3], [7, 6, 5, 4], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]].map(|q| q.to_vec()).to_vec();
    for effort in EFFORTS {
        for (vertices, faces) in [(18, &strip), (6, &fan), (5, &bow_tie), (8, &cube), (4, &vec![]), (3, &vec![vec![0, 1]])] {
            let info = comes_back(&mesh(vertices, faces), effort);
            assert!(!info.manifold);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_soup_comes_back_as_an_image_of_vertices(
        vertices in 3_u32..40,
        faces in proptest::collection::vec(proptest::collection::vec(0_u32..1000, 1..6), 1..60),
        codec in 0_usize..2,
    ) {
        let faces: Vec<Vec<u32>> = faces.iter().map(|f| f.iter().map(|v| v % vertices).collect()).collect();
        let mesh = mesh(vertices as usize, &faces);
        for keep_order in [false, true] {
            let codec = [gimc::Codec::Mbcim, gimc::Codec::Raw][codec];
            match EncodeOptions::cgim().bits(12).codec(codec).keep_order(keep_order).encode(&mesh) {
                Ok(bytes) => {
                    let back = Decoder::new(&bytes).unwrap().decode().unwrap();
                    prop_assert_eq!(picture(&mesh), picture(&back));
                    prop_assert!(!keep_order || mesh.faces == back.faces);
                }
                // There may be no face of three different corners.
                Err(error) => prop_assert_eq!(error.to_string(), gimc::Error::from(gimc::MeshDefect::Empty).to_string()),
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_finite_coordinates_come_back_bit_by_bit(
        bits in proptest::collection::vec(proptest::array::uniform3(any::<u64>()), 3..40),
        faces in proptest::collection::vec(proptest::array::uniform3(0_u32..1000), 1..60),
        is_double: bool,
        is_tame: bool,
    ) {
        let number = |bits: u64| {
            let x = match (is_double, is_tame) {
                (true, false) => f64::from_bits(bits),
                (false, false) => f64::from(f32::from_bits(bits as u32)),
                (true, true) => (bits % 2001) as f64 / 1000.0 - 1.0,
                (false, true) => f64::from((bits % 2001) as f32 / 1000.0 - 1.0),
            };
            // The box must have a diagonal.
            if x.is_finite() && x.abs() < 1e100 { x } else { -0.0 }
        };
        let mut mesh = Mesh { positions: bits.iter().map(|p| p.map(number)).collect(), ..Mesh::default() };
        if is_double {
            mesh.precision = gimc::Scalar::F64;
        }
        let count = mesh.positions.len() as u32;
        faces.iter().for_each(|f| mesh.faces.push(&f.map(|v| v % count)));
        comes_back_exactly(&mesh);
    }
}

#[test]
fn a_sound_mesh_pays_nothing() {
    let shape = corpus_make::torus_with_holes(900, 3, 5);
    let faces: Vec<Vec<u32>> = shape.triangles.iter().map(|t| t.to_vec()).collect();
    let info = comes_back(&mesh(shape.positions.len(), &faces), Effort::Default);
    assert!(info.manifold);
    assert_eq!(info.chunks.iter().map(|c| c.tag.as_str()).collect::<Vec<_>>(), ["HEAD", "SURF"]);
}

#[test]
fn names_of_stretches_of_faces_come_back_with_their_faces() {
    use gimc::{Label, LabelKind};
    let shape = corpus_make::sphere(200);
    let mut mesh = mesh(shape.positions.len(), &shape.triangles.iter().map(|t| t.to_vec()).collect::<Vec<_>>());
    let last = mesh.faces.len() as u32;
    let kinds = [LabelKind::MaterialLibrary, LabelKind::Object, LabelKind::Group, LabelKind::Material, LabelKind::Smoothing];
    for (i, first_face) in [0, 0, 3, 3, 40, 41, 90, 150, last].into_iter().enumerate() {
        mesh.labels.push(Label { kind: kinds[i % 5], name: format!("name {}", i % 3), first_face });
    }
    let back = |options: EncodeOptions| Decoder::new(&options.encode(&mesh).unwrap()).unwrap().decode().unwrap();
    let in_order = back(EncodeOptions::cgim().bits(12).keep_order(true));
    assert_eq!((&in_order.labels, &in_order.faces), (&mesh.labels, &mesh.faces));
    let back = back(EncodeOptions::cgim().bits(12));
    assert_eq!(back.labels, mesh.labels);
    // Stretch by stretch the faces are the same.
    let starts = [0, 3, 40, 41, 90, 150, last];
    for ends in starts.windows(2) {
        let part = |mesh: &Mesh| {
            let mut part = Mesh { positions: mesh.positions.clone(), ..Mesh::default() };
            (ends[0]..ends[1]).for_each(|f| part.faces.push(mesh.faces.get(f as usize)));
            picture(&part)
        };
        assert_eq!(part(&mesh), part(&back));
    }
}

/// The shared meshes, if their folder is known.
fn shared(what: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("GIMC_MESHES") else {
        eprintln!("skipped: GIMC_MESHES names no folder");
        return None;
    };
    Some(PathBuf::from(folder).join(what))
}

/// What happens to each file of the folder `nasty`: it comes back, or is refused with these words.
const NASTY: &[(&str, Option<&str>)] = &[
    ("nasty_cube-shuffled_off.off", None),
    ("nasty_cube_binary_header_with_rn_newline_ply.ply", None),
    ("nasty_cube_quads_ply.ply", None),
    ("nasty_deg_faces_obj.obj", None),
    ("nasty_degenerate_mesh_obj.obj", None),
    ("nasty_degtri_sliding_off.off", None),
    ("nasty_extra_vertex_obj.obj", None),
    ("nasty_fan3_obj.obj", None),
    ("nasty_hourglass_ico_obj.obj", None),
    ("nasty_inf_nan_obj.obj", Some("not a finite number")),
    ("nasty_invalid_off.off", Some("line")),
    ("nasty_malformed_obj.obj", Some("line")),
    ("nasty_many_small_holes_ply.ply", None),
    ("nasty_mesh_with_colors_off.off", None),
    ("nasty_moebius_obj.obj", None),
    ("nasty_mpi_off.off", None),
    ("nasty_multiple_tetrahedrons_obj.obj", None),
    ("nasty_negative_indices_obj.obj", None),
    ("nasty_non_manif_hole_ply.ply", None),
    ("nasty_non_manifold_wrap_obj.obj", None),
    ("nasty_notenoughindices_obj.obj", None),
    ("nasty_platonic_shelf_big_endian_ply.ply", None),
    ("nasty_polygonfaces_obj.obj", None),
    ("nasty_soup_stl.stl", None),
    ("nasty_t_ply.ply", None),
    ("nasty_test_extra_whitespace_ply.ply", None),
    ("nasty_test_more_datatypes_ply.ply", None),
    ("nasty_test_sphere_ascii_stl.stl", None),
    ("nasty_triangle_with_degenerate_tex_coords_obj.obj", None),
    ("nasty_two_objects_obj.obj", None),
];

/// The same vertices and faces, each vertex by the lattice point that it belongs to.
fn same_on_the_lattice(mesh: &Mesh, back: &Mesh, info: &gimc::Info) -> bool {
    let picture_of = |m: &Mesh| {
        let mut m = m.clone();
        let place = |x: f64, i: usize| ((x - info.origin[i]) / info.step + 0.5).floor() / 8.0;
        m.positions.iter_mut().for_each(|p| *p = [0, 1, 2].map(|i| place(p[i], i)));
        picture(&m)
    };
    picture_of(mesh) == picture_of(back)
}

#[test]
fn the_nasty_meshes_come_back_or_are_refused_as_the_table_says() {
    let Some(folder) = shared("nasty") else { return };
    for &(file, refusal) in NASTY {
        let encoded = Mesh::open(folder.join(file))
            .and_then(|mesh| Ok((EncodeOptions::cgim().encode_with(&mesh, gimc::Task::default())?, mesh)));
        match (encoded, refusal) {
            (Ok((encoded, mesh)), None) => {
                let back = Decoder::new(&encoded.bytes).unwrap().decode().unwrap();
                assert!(same_on_the_lattice(&mesh, &back, &encoded.info), "{file} changed");
            }
            (Err(error), Some(words)) => assert!(error.to_string().contains(words), "{file}: {error}"),
            (Ok(_), Some(words)) => panic!("{file} was not refused: {words}"),
            (Err(error), None) => panic!("{file}: {error}"),
        }
    }
}

#[test]
fn the_other_shared_meshes_that_are_no_manifolds_come_back() {
    for file in ["teapot.obj", "pirate.obj", "sponza.obj", "dragon_res4.ply", "bunny_zipper.ply"] {
        let Some(path) = shared(file) else { return };
        let mesh = Mesh::open(path).unwrap();
        let encoded = EncodeOptions::cgim().effort(Effort::Fast).encode_with(&mesh, gimc::Task::default()).unwrap();
        let back = Decoder::new(&encoded.bytes).unwrap().decode().unwrap();
        assert!(same_on_the_lattice(&mesh, &back, &encoded.info), "{file} changed");
    }
}
