use super::*;
use proptest::prelude::*;

/// Numbers that look random, for shuffling.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize * n) >> 31
    }

    fn shuffle<T>(&mut self, list: &mut [T]) {
        for i in (1..list.len()).rev() {
            list.swap(i, self.below(i + 1));
        }
    }
}

/// The same mesh with vertices, faces and corners in another order; and where each vertex went.
fn shuffled(mesh: &Mesh, seed: u64) -> (Mesh, Vec<u32>) {
    let mut random = Random(seed);
    let mut new: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    random.shuffle(&mut new);
    let mut positions = mesh.positions.clone();
    mesh.positions.iter().zip(&new).for_each(|(&p, &v)| positions[v as usize] = p);
    let mut faces: Vec<Vec<u32>> = mesh.faces.iter().map(|f| f.iter().map(|&v| new[v as usize]).collect()).collect();
    random.shuffle(&mut faces);
    let mut other = Mesh::from_triangles(positions, []);
    for mut face in faces {
        let n = face.len();
        face.rotate_left(random.below(n));
        other.faces.push(&face);
    }
    (other, new)
}

fn rounded(mesh: &Mesh, step: f64) -> Mesh {
    Mesh { positions: mesh.positions.iter().map(|p| p.map(|x| (x / step).round() * step)).collect(), ..mesh.clone() }
}

fn mesh(shape: corpus_make::Shape) -> Mesh {
    Mesh::from_triangles(shape.positions, shape.triangles)
}

fn with_faces(mesh: &Mesh, change: impl Fn(usize, &[u32]) -> Vec<u32>) -> Mesh {
    let mut other = Mesh::from_triangles(mesh.positions.clone(), []);
    for (i, f) in mesh.faces.iter().enumerate() {
        other.faces.push(&change(i, f));
    }
    other
}

fn verdict(a: &Mesh, b: &Mesh, tolerance: Option<f64>) -> Verdict {
    same(a, b, tolerance, &Task::default()).unwrap().verdict
}

/// A torus of `n × m` quads, each vertex like every other.
fn torus(n: u32, m: u32) -> Mesh {
    let tau = std::f64::consts::TAU;
    let angle = |i: u32, n: u32| f64::from(i) / f64::from(n) * tau;
    let at = |k: u32| (angle(k % n, n), angle(k / n, m));
    let place = |(u, v): (f64, f64)| [(3.0 + v.cos()) * u.cos(), (3.0 + v.cos()) * u.sin(), v.sin()];
    let mut mesh = Mesh::from_triangles((0..n * m).map(|k| place(at(k))).collect(), []);
    for k in 0..n * m {
        let (i, j) = (k % n, k / n);
        let v = |i: u32, j: u32| i % n + j % m * n;
        mesh.faces.push(&[v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)]);
    }
    mesh
}

/// Several meshes as one.
fn together(parts: &[&Mesh]) -> Mesh {
    let mut all = Mesh::from_triangles(Vec::new(), []);
    for part in parts {
        let first = all.positions.len() as u32;
        all.positions.extend_from_slice(&part.positions);
        for f in part.faces.iter() {
            all.faces.push(&f.iter().map(|&v| v + first).collect::<Vec<_>>());
        }
    }
    all
}

fn tetrahedron(at: f64) -> Mesh {
    let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    Mesh::from_triangles(p.map(|[x, y, z]| [x + at, y, z]).to_vec(), [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
}

#[test]
fn a_shuffled_and_coarsely_rounded_mesh_is_the_same_and_its_vertices_are_found() {
    let original = mesh(corpus_make::bumpy_sphere(3000, 4));
    for step in [0.01, 0.1, 0.3] {
        let (other, went) = shuffled(&rounded(&original, step), 5);
        let found = same(&original, &other, Some(step * 0.501), &Task::default()).unwrap();
        assert_eq!((found.verdict, found.connectivity), (Verdict::Same, Verdict::Same), "step {step}");
        let map = found.map.unwrap();
        let right = (0..went.len()).filter(|&v| map[v] == went[v]).count();
        assert_eq!(right, went.len(), "step {step}");
        assert_eq!(verdict(&original, &other, None), Verdict::Same);
    }
}

#[test]
fn on_a_torus_where_every_vertex_is_like_every_other_positions_choose_the_map() {
    let original = torus(40, 24);
    let (other, went) = shuffled(&rounded(&original, 0.2), 9);
    for tolerance in [None, Some(0.11)] {
        let found = same(&original, &other, tolerance, &Task::default()).unwrap();
        assert_eq!(found.verdict, Verdict::Same);
        assert_eq!(found.map.unwrap(), went);
    }
}

#[test]
fn one_flipped_face_is_different() {
    for original in [mesh(corpus_make::bumpy_sphere(500, 1)), torus(12, 7), tetrahedron(0.0)] {
        let flipped =
            with_faces(
                &original,
                |i, f| {
                    if i == original.faces.len() / 2 { f.iter().rev().copied().collect() } else { f.to_vec() }
                },
            );
        for b in [flipped.clone(), shuffled(&flipped, 3).0] {
            assert_eq!(verdict(&original, &b, None), Verdict::Different);
            assert_eq!(verdict(&original, &b, Some(0.1)), Verdict::Different);
        }
    }
}

#[test]
fn a_mesh_turned_inside_out_is_the_same_only_if_it_has_a_mirror_image_of_itself() {
    let inside_out = |m: &Mesh| with_faces(m, |_, f| f.iter().rev().copied().collect());
    assert_eq!(verdict(&tetrahedron(0.0), &inside_out(&tetrahedron(0.0)), None), Verdict::Same);
    assert_eq!(verdict(&tetrahedron(0.0), &inside_out(&tetrahedron(0.0)), Some(0.1)), Verdict::Different);
    let irregular = mesh(corpus_make::bumpy_sphere(500, 1));
    assert_eq!(verdict(&irregular, &inside_out(&irregular), None), Verdict::Different);
}

#[test]
fn a_vertex_out_of_place_is_told_from_another_connectivity() {
    let original = mesh(corpus_make::terrain(800, 3));
    let (mut other, went) = shuffled(&original, 4);
    other.positions[went[17] as usize][2] += 1000.0;
    let found = same(&original, &other, Some(1e-3), &Task::default()).unwrap();
    assert_eq!((found.verdict, found.connectivity), (Verdict::Different, Verdict::Same));
    assert_eq!(found.largest_move, Some(1000.0));
    assert_eq!(verdict(&original, &other, None), Verdict::Same);
}

#[test]
fn another_diagonal_in_one_quad_is_different() {
    let original = mesh(corpus_make::grid(450));
    // Two triangles over one edge, joined across the other two corners.
    let corners = Corners::new(original.positions.len(), &original.faces);
    let c = (0..corners.len() as u32).find(|&c| corners.twin(c) != NONE && corners.face(c) > 200).unwrap();
    let d = corners.twin(c);
    let [p, q] = [c, d].map(|c| corners.vertex(corners.prev(c)));
    let (f, g) = (corners.face(c) as usize, corners.face(d) as usize);
    let (v, w) = (corners.vertex(c), corners.vertex(d));
    let other = with_faces(&original, |i, face| match i {
        i if i == f => vec![p, v, q],
        i if i == g => vec![q, w, p],
        _ => face.to_vec(),
    });
    assert_eq!(verdict(&original, &other, None), Verdict::Different);
    assert_eq!(verdict(&original, &shuffled(&other, 1).0, Some(1e-6)), Verdict::Different);
}

#[test]
fn many_equal_components_are_matched_to_those_at_their_place() {
    let parts: Vec<Mesh> = (0..300).map(|i| tetrahedron(f64::from(i % 100) * 5.0)).collect();
    let all = together(&parts.iter().collect::<Vec<_>>());
    let (other, _) = shuffled(&all, 8);
    let found = same(&all, &other, Some(1e-9), &Task::default()).unwrap();
    assert_eq!((found.verdict, found.largest_move), (Verdict::Same, Some(0.0)));
    assert_eq!(same(&all, &other, None, &Task::default()).unwrap().largest_move, Some(0.0));
    // One of them elsewhere.
    let moved = together(&parts[..299].iter().chain([&tetrahedron(-50.0)]).collect::<Vec<_>>());
    let found = same(&all, &shuffled(&moved, 2).0, Some(1e-9), &Task::default()).unwrap();
    assert_eq!((found.verdict, found.connectivity), (Verdict::Different, Verdict::Same));
}

#[test]
fn components_that_can_only_be_placed_by_giving_way_are_placed() {
    // On the line at 0 and 1 against 0.6 and −0.3 with a tolerance of 0.65: taken nearest first, 0 goes to −0.3 and 1 to
    // 0.6; the other way round 1 would stay without a place. Both orders of the first mesh must end well.
    for places in [[0.0, 1.0], [1.0, 0.0]] {
        let a = together(&[&tetrahedron(places[0]), &tetrahedron(places[1])]);
        for others in [[0.6, -0.3], [-0.3, 0.6], [0.55, -0.6], [0.4, 0.6]] {
            let b = together(&[&tetrahedron(others[0]), &tetrahedron(others[1])]);
            assert_eq!(verdict(&a, &shuffled(&b, 6).0, Some(0.65)), Verdict::Same, "{places:?} {others:?}");
        }
        let b = together(&[&tetrahedron(0.1), &tetrahedron(0.2)]);
        assert_eq!(verdict(&a, &shuffled(&b, 6).0, Some(0.65)), Verdict::Different);
    }
}

#[test]
fn vertices_and_edges_of_many_fans_are_walked_through() {
    // Three sheets on one edge, two tetrahedra on one vertex, and one face twice.
    let a = Mesh::from_triangles(
        (0..12_u32).map(|i| [f64::from(i), f64::from(i * i % 7), f64::from(i * 5 % 11)]).collect(),
        [
            [0, 1, 2],
            [1, 0, 3],
            [0, 1, 4],
            [2, 1, 5],
            [4, 1, 5],
            [6, 7, 8],
            [6, 8, 9],
            [6, 9, 7],
            [7, 9, 8],
            [6, 10, 11],
            [6, 11, 4],
            [10, 4, 11],
            [6, 4, 10],
            [0, 1, 2],
        ],
    );
    for seed in 0..20 {
        let (b, went) = shuffled(&a, seed);
        for tolerance in [None, Some(0.1)] {
            let found = same(&a, &b, tolerance, &Task::default()).unwrap();
            assert_eq!((found.verdict, found.map.as_deref()), (Verdict::Same, Some(&went[..])), "seed {seed}");
        }
        // The doubled face once only, and another one twice.
        let c = with_faces(&a, |i, f| if i == 13 { vec![2, 1, 5] } else { f.to_vec() });
        assert_eq!(verdict(&a, &shuffled(&c, seed).0, None), Verdict::Different);
    }
}

#[test]
fn coinciding_vertices_do_not_confuse_the_map() {
    let original = mesh(corpus_make::bumpy_sphere(1000, 2));
    let flat = rounded(&original, 1e9);
    let (other, _) = shuffled(&flat, 1);
    assert_eq!(verdict(&flat, &other, Some(0.0)), Verdict::Same);
    assert_eq!(verdict(&original, &other, None), Verdict::Same);
}

#[test]
fn a_heap_of_triangles_at_one_point_is_matched_without_trying_every_pair() {
    // Every vertex may go to every other one, and every triangle too: the search within the tolerance drowns.
    let k = 20_000;
    let heap = |corner: &dyn Fn(u32, u32) -> u32| {
        Mesh::from_triangles(vec![[0.0; 3]; 3 * k as usize], (0..k).map(|i| [corner(i, 0), corner(i, 1), corner(i, 2)]))
    };
    let (a, b) = (heap(&|i, c| 3 * i + c), heap(&|i, c| k * c + i));
    assert_eq!(verdict(&a, &b, Some(0.0)), Verdict::Same);
    assert_eq!(verdict(&a, &b, None), Verdict::Same);
    let mut torn = b.clone();
    torn.positions[7] = [1.0; 3];
    assert_ne!(verdict(&a, &torn, Some(0.0)), Verdict::Same);
}

#[test]
fn a_quad_against_its_two_triangles_is_the_same_and_unused_vertices_do_not_count() {
    let mut quad = Mesh::from_triangles(vec![[9.0; 3], [0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], []);
    quad.faces.push(&[1, 2, 3, 4]);
    let two = Mesh::from_triangles(quad.positions[1..].to_vec(), [[2, 3, 0], [0, 1, 2]]);
    assert_eq!(verdict(&quad, &two, Some(0.0)), Verdict::Same);
    let found = same(&quad, &two, None, &Task::default()).unwrap();
    assert_eq!(found.map.unwrap(), [Correspondence::UNUSED, 0, 1, 2, 3]);
}

#[test]
fn values_that_are_not_numbers_correspond_to_their_like() {
    let mut a = tetrahedron(0.0);
    a.positions[3] = [f64::NAN, f64::INFINITY, 0.0];
    assert_eq!(verdict(&a, &shuffled(&a, 3).0, Some(0.0)), Verdict::Same);
    assert_eq!(verdict(&a, &tetrahedron(0.0), Some(1.0)), Verdict::Different);
}

#[test]
fn nothing_is_the_same_as_nothing() {
    assert_eq!(verdict(&Mesh::default(), &Mesh::default(), Some(0.0)), Verdict::Same);
    assert_eq!(verdict(&Mesh::default(), &tetrahedron(0.0), None), Verdict::Different);
}

/// All maps, one after the other.
fn by_all_maps(a: &Mesh, b: &Mesh, tolerance: Option<f64>) -> bool {
    let (x, y) = (Shape::new(a), Shape::new(b));
    if x.used.len() != y.used.len() || x.corners.len() != y.corners.len() {
        return false;
    }
    let question = Question { tolerance, faces: canonical(&y.corners, |v| v) };
    let mut map = vec![NONE; a.positions.len()];
    fn go(k: usize, map: &mut Vec<u32>, x: &Shape, y: &Shape, question: &Question) -> bool {
        if k == x.used.len() {
            return question.answered_by(map.clone(), x, y).is_some();
        }
        y.used.iter().any(|&w| {
            if map.contains(&w) {
                return false;
            }
            map[x.used[k] as usize] = w;
            let found = go(k + 1, map, x, y, question);
            map[x.used[k] as usize] = NONE;
            found
        })
    }
    go(0, &mut map, &x, &y, &question)
}

fn soup() -> impl Strategy<Value = Mesh> {
    let corner = [0..2_i32, 0..2_i32, 0..2_i32].prop_map(|p| p.map(f64::from));
    (prop::collection::vec(corner, 6), prop::collection::vec([0..6_u32, 0..6, 0..6], 1..7), any::<bool>()).prop_map(
        |(positions, faces, distinct)| {
            let keep = |f: &[u32; 3]| !distinct || (f[0] != f[1] && f[1] != f[2] && f[2] != f[0]);
            Mesh::from_triangles(positions, faces.into_iter().filter(keep))
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn small_soups_get_the_answer_that_trying_all_maps_gives(
        (a, b, other, seed) in (soup(), soup(), 0..4_u32, any::<u64>()),
        tolerance in prop_oneof![Just(None), Just(Some(0.0)), Just(Some(0.5))],
    ) {
        // The same mesh, one corner of it changed, one vertex of it moved, or another mesh altogether.
        let mut b = match other {
            0 => b,
            1 => with_faces(&a, |i, f| if i == 0 { vec![f[0], f[1], seed as u32 % 6] } else { f.to_vec() }),
            _ => a.clone(),
        };
        if other == 2 {
            b.positions[seed as usize % 6][0] += 0.4;
        }
        let (b, _) = shuffled(&b, seed);
        let expected = if by_all_maps(&a, &b, tolerance) { Verdict::Same } else { Verdict::Different };
        prop_assert_eq!(verdict(&a, &b, tolerance), expected);
    }

    #[test]
    fn the_least_turn_is_least(list in prop::collection::vec(0..3_u32, 1..9)) {
        let turned = |t: usize| { let mut l = list.clone(); l.rotate_left(t); l };
        let least = (0..list.len()).map(turned).min().unwrap();
        prop_assert_eq!(turned(least_turn(&list)), least);
    }
}
