//! Mesh files in and out, over files that others made.

#![allow(clippy::unwrap_used)] // in helpers of tests, which clippy does not see as tests

use std::path::PathBuf;

use gimc::{Attribute, AttributeKind, Domain, Error, Format, Label, LabelKind, Loaded, Mesh, Scalar};
use proptest::collection::vec;
use proptest::option::weighted;
use proptest::prelude::*;

/// The folder of real meshes, if the environment names one: `index.tsv` and the files beside it.
fn real_meshes() -> Option<Vec<(PathBuf, Option<[usize; 2]>)>> {
    let Some(folder) = std::env::var_os("GIMC_MESHES").map(PathBuf::from) else {
        eprintln!("skipped: GIMC_MESHES names no folder of meshes");
        return None;
    };
    let index = std::fs::read_to_string(folder.join("index.tsv")).unwrap();
    let mut lines = index.lines().map(|line| line.split('\t').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let column = |name: &str| header.iter().position(|&h| h == name).unwrap();
    let [file, vertices, faces] = ["file", "V", "F"].map(column);
    let meshes = lines.map(|row| {
        let name = PathBuf::from(row[file]);
        let name = name.file_name().unwrap();
        let path = [folder.join(name), folder.join("nasty").join(name)].into_iter().find(|path| path.exists()).unwrap();
        (path, row[vertices].parse().ok().zip(row[faces].parse().ok()).map(|(v, f)| [v, f]))
    });
    Some(meshes.collect())
}

#[test]
fn real_meshes_have_as_many_vertices_and_faces_as_others_count() {
    let Some(meshes) = real_meshes() else { return };
    assert!(meshes.len() > 60);
    for (path, counts) in meshes {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let read = Mesh::load(&path);
        match (name.as_str(), read) {
            // Faces that name a vertex that is not there are an error here; the counts were made by a reader that keeps them.
            ("nasty_malformed_obj.obj", Err(error)) => {
                assert!(error.to_string().ends_with("obj: line 28: vertex index 0, and OBJ counts from 1"), "{error}");
            }
            (_, Ok(loaded)) => {
                let found = [loaded.mesh.positions.len(), loaded.mesh.faces.len()];
                assert_eq!(Some(found), counts, "{name} {:?}", loaded.notes);
            }
            (_, Err(error)) => {
                assert_eq!(counts, None, "{error}");
                assert!(matches!(error, Error::InFile { .. }), "{error}");
                eprintln!("{error}");
            }
        }
    }
}

#[test]
fn real_meshes_come_back_from_what_is_written() {
    for (path, _) in real_meshes().unwrap_or_default() {
        let Ok(Loaded { mesh, .. }) = Mesh::load(&path) else { continue };
        for format in [Format::Obj, Format::Ply, Format::Off, Format::Glb] {
            let is_single = mesh.precision == Scalar::F32;
            if format == Format::Glb && (!mesh.faces.are_triangles() || !mesh.attributes.is_empty() || !is_single) {
                continue;
            }
            let mut bytes = Vec::new();
            let notes = mesh.write(format, &mut bytes).unwrap();
            let again = Mesh::read(&bytes, None).unwrap_or_else(|e| panic!("{} as {format}: {e}", path.display()));
            assert_eq!(again.format, format);
            let same = |a: &[f64; 3], b: &[f64; 3]| {
                a == b || a.iter().zip(b).all(|(x, y)| x.to_bits() == y.to_bits() || x.is_nan() && y.is_nan())
            };
            let what = format!("{} as {format}", path.display());
            // Text cannot tell f64 values from f32 where they are the same.
            let are_single = format != Format::Ply && mesh.positions.as_flattened().iter().all(|&x| f64::from(x as f32) == x);
            assert_eq!(again.mesh.precision, if are_single { Scalar::F32 } else { mesh.precision }, "{what}");
            assert!(again.mesh.positions.iter().zip(&mesh.positions).all(|(a, b)| same(a, b)), "{what}");
            assert_eq!(again.mesh.faces, mesh.faces, "{what}");
            assert_eq!(again.notes, [] as [&str; 0], "{what}");
            if mesh.attributes.is_empty() && mesh.labels.is_empty() {
                assert_eq!(notes, [] as [&str; 0], "{what}");
            }
        }
    }
}

/// Corners of all faces in order: position, texture coordinates, normal.
type Corners = Vec<([f32; 3], Option<[f32; 2]>, Option<[f32; 3]>)>;

fn corners_by_tobj(text: &[u8]) -> (Vec<u32>, Corners) {
    let (models, _) =
        tobj::load_obj_buf(&mut &*text, &tobj::LoadOptions::default(), |_| tobj::MTLLoadResult::Ok(Default::default()))
            .unwrap();
    let (mut arities, mut corners) = (Vec::new(), Vec::new());
    for tobj::Model { mesh, .. } in models {
        let faces = mesh.indices.len() / 3;
        arities.extend(if mesh.face_arities.is_empty() { vec![3; faces] } else { mesh.face_arities });
        for (c, &v) in mesh.indices.iter().enumerate() {
            let three = |from: &[f32], i: u32| from[3 * i as usize..][..3].try_into().unwrap();
            let two = |i: &u32| mesh.texcoords[2 * *i as usize..][..2].try_into().unwrap();
            let normal = mesh.normal_indices.get(c).map(|&i| three(&mesh.normals, i));
            corners.push((three(&mesh.positions, v), mesh.texcoord_indices.get(c).map(two), normal));
        }
    }
    (arities, corners)
}

fn corners_of(mesh: &Mesh) -> (Vec<u32>, Corners) {
    let find = |kind| mesh.attributes.iter().find(|a| a.kind == kind);
    let [texcoords, normals] = [AttributeKind::TexCoord, AttributeKind::Normal].map(find);
    let get = |attribute: Option<&Attribute>, corner: usize, vertex: u32| {
        let attribute = attribute?;
        let element = if attribute.domain == Domain::Vertex { vertex as usize } else { corner };
        Some(attribute.get(element)?.iter().map(|&x| x as f32).collect::<Vec<_>>())
    };
    let corners = mesh.faces.corners().iter().enumerate().map(|(c, &v)| {
        let texcoord = get(texcoords, c, v).map(|value| [value[0], value[1]]);
        (mesh.positions[v as usize].map(|x| x as f32), texcoord, get(normals, c, v).map(|n| n.try_into().unwrap()))
    });
    (mesh.faces.iter().map(|face| face.len() as u32).collect(), corners.collect())
}

#[test]
fn tobj_reads_the_same_corners() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.25\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nvn 0 1 0\no a\nf 1/1/1 2/2/1 3/3/1\nf 2/2/2 4/1/2 3/3/1 1/1/1\no b\nf 1/1/2 2/1/2 -1/-1/-1\n";
    assert_eq!(corners_by_tobj(text.as_bytes()), corners_of(&Mesh::read(text.as_bytes(), None).unwrap().mesh));
    for (path, _) in real_meshes().unwrap_or_default() {
        let is_obj = path.extension().is_some_and(|e| e == "obj");
        if !is_obj || path.parent().is_some_and(|folder| folder.ends_with("nasty")) {
            continue;
        }
        let bytes = std::fs::read(&path).unwrap();
        let mesh = Mesh::read(&bytes, None).unwrap().mesh;
        let (mut theirs, ours) = (corners_by_tobj(&bytes), corners_of(&mesh));
        for (their, our) in theirs.1.iter_mut().zip(&ours.1) {
            // In a model that has texture coordinates, tobj gives its first ones to corners that have none.
            their.1 = their.1.filter(|_| our.1.is_some());
        }
        assert!(theirs == ours, "{}", path.display());
    }
}

/// Writes and reads; the two notes lists must be empty.
fn there_and_back(mesh: &Mesh, format: Format) -> Mesh {
    let mut bytes = Vec::new();
    let notes = mesh.write(format, &mut bytes).unwrap();
    assert_eq!(notes, [] as [&str; 0]);
    let loaded = Mesh::read(&bytes, None).unwrap_or_else(|e| panic!("{e}\n{}", bytes.escape_ascii()));
    assert_eq!((loaded.format, loaded.notes), (format, Vec::<String>::new()));
    loaded.mesh
}

/// Numbers that a type can hold, with edges and infinities.
fn number(scalar: Scalar) -> BoxedStrategy<f64> {
    match scalar {
        Scalar::F32 => {
            any::<u32>().prop_map(|bits| f64::from(f32::from_bits(bits))).prop_filter("NaN", |x| !x.is_nan()).boxed()
        }
        Scalar::F64 => prop_oneof![any::<u64>().prop_map(f64::from_bits), (0..1000).prop_map(|i| f64::from(i) / 10.0)]
            .prop_filter("NaN", |x| !x.is_nan())
            .boxed(),
        integer => {
            let [least, greatest] = integer.range();
            (least as i64..=greatest as i64).prop_map(|i| i as f64).boxed()
        }
    }
}

/// The type of a kind of number, and so many of them; for text, which shows a type by its values only.
fn text_numbers(count: usize) -> BoxedStrategy<(Scalar, Vec<f64>)> {
    prop_oneof![Just(Scalar::F32), Just(Scalar::F64)]
        .prop_flat_map(move |scalar| (Just(scalar), vec(number(scalar), count)))
        .prop_map(|(scalar, values)| {
            let are_single = values.iter().all(|&x| f64::from(x as f32) == x);
            (if are_single { Scalar::F32 } else { scalar }, values)
        })
        .boxed()
}

fn polygons(vertices: usize) -> impl Strategy<Value = Vec<Vec<u32>>> {
    vec(vec(0..vertices as u32, 0..6), 0..8)
}

fn bare(vertices: usize, precision: Scalar, coordinates: &[f64], faces: &[Vec<u32>]) -> Mesh {
    let mut mesh = Mesh { precision, positions: coordinates.as_chunks().0.to_vec(), ..Mesh::default() };
    assert_eq!(mesh.positions.len(), vertices);
    faces.iter().for_each(|face| mesh.faces.push(face));
    mesh
}

/// Indices of values in order of appearance are no indices at all, unless some have none.
fn indexed(mut attribute: Attribute, indices: Vec<u32>) -> Attribute {
    let in_order = indices.len() == attribute.len() && indices.iter().zip(0..).all(|(&index, i)| index == i);
    attribute.indices = if in_order { Vec::new() } else { indices };
    attribute
}

/// Every second vertex or corner or so has a value of its own, in order.
fn some(attribute: Attribute, has: &[bool]) -> Attribute {
    let mut next = 0..;
    let indices = has.iter().map(|&has| if has { next.next().unwrap() } else { Attribute::NONE }).collect();
    indexed(attribute, indices)
}

fn attribute(kind: AttributeKind, name: &str, domain: Domain, width: usize, (scalar, values): (Scalar, Vec<f64>)) -> Attribute {
    Attribute { kind, name: name.to_owned(), domain, width, scalar, values, indices: Vec::new() }
}

/// Meshes that OBJ can hold.
fn obj_mesh() -> impl Strategy<Value = Mesh> {
    let label = (0..5_usize, "[a-z#\\\\]{0,4}( [a-zé]{1,3})?", 0..10_u32);
    (1..8_usize)
        .prop_flat_map(move |n| (text_numbers(3 * n), polygons(n), vec(label.clone(), 0..6)))
        .prop_flat_map(|((precision, coordinates), faces, labels)| {
            let mut mesh = bare(coordinates.len() / 3, precision, &coordinates, &faces);
            mesh.labels = labels
                .into_iter()
                .map(|(kind, name, face)| {
                    use LabelKind::{Group, Material, MaterialLibrary, Object, Smoothing};
                    let kind = [Object, Group, Material, Smoothing, MaterialLibrary][kind];
                    Label { kind, name: name.trim().to_owned(), first_face: face.min(mesh.faces.len() as u32) }
                })
                .collect();
            mesh.labels.sort_by_key(|label| label.first_face);
            let [vertices, corners] = [mesh.positions.len(), mesh.faces.corners().len()];
            let on_vertices = (vec(any::<bool>(), vertices), prop_oneof![Just(1), Just(3), Just(4)], Just(vertices))
                .prop_flat_map(|(has, width, vertices)| {
                    let count = has.iter().filter(|&&has| has).count();
                    (Just(has), Just(width), text_numbers(width * count), Just(vertices))
                });
            let on_corners = move |width| {
                (1..6_u32).prop_flat_map(move |values| {
                    let index = weighted(0.8, 0..values).prop_map(|index| index.unwrap_or(Attribute::NONE));
                    (text_numbers(values as usize * width), vec(index, corners))
                })
            };
            (
                Just(mesh),
                weighted(0.5, on_vertices),
                weighted(0.5, (2..=3_usize).prop_flat_map(move |width| (Just(width), on_corners(width)))),
                weighted(0.5, on_corners(3)),
            )
        })
        .prop_map(|(mut mesh, on_vertices, texcoords, normals)| {
            if let Some((has, width, numbers, _)) = on_vertices.filter(|(has, ..)| has.contains(&true)) {
                let (kind, name) = if width == 1 { (AttributeKind::Other, "w") } else { (AttributeKind::Colour, "r g b") };
                mesh.attributes.push(some(attribute(kind, name, Domain::Vertex, width, numbers), &has));
            }
            let texcoords = texcoords.map(|(width, rest)| (AttributeKind::TexCoord, "vt", width, rest));
            let normals = normals.map(|rest| (AttributeKind::Normal, "vn", 3, rest));
            for (kind, name, width, (numbers, indices)) in texcoords.into_iter().chain(normals) {
                if indices.iter().any(|&index| index != Attribute::NONE) {
                    let mut attribute = attribute(kind, name, Domain::Corner, width, numbers);
                    if attribute.len() == mesh.positions.len() && indices == mesh.faces.corners() {
                        attribute.domain = Domain::Vertex;
                        mesh.attributes.push(attribute);
                    } else {
                        mesh.attributes.push(indexed(attribute, indices));
                    }
                }
            }
            mesh
        })
}

fn scalar() -> impl Strategy<Value = Scalar> {
    use Scalar::{F32, F64, I8, I16, I32, U8, U16, U32};
    prop_oneof![Just(I8), Just(U8), Just(I16), Just(U16), Just(I32), Just(U32), Just(F32), Just(F64)]
}

fn numbers(count: usize) -> impl Strategy<Value = (Scalar, Vec<f64>)> {
    scalar().prop_flat_map(move |scalar| (Just(scalar), vec(number(scalar), count)))
}

/// Meshes that PLY can hold.
fn ply_mesh() -> impl Strategy<Value = Mesh> {
    use AttributeKind::{Colour, Normal, Other, TexCoord};
    let on_records = [
        (Normal, "nx ny nz", 3),
        (Colour, "red green blue", 3),
        (Colour, "diffuse_red diffuse_green diffuse_blue diffuse_alpha", 4),
        (TexCoord, "s t", 2),
        (TexCoord, "texture_u texture_v", 2),
        (Other, "quality", 1),
        (Other, "x1", 1),
    ];
    let on_corners = [(TexCoord, "texcoord", 2), (Colour, "color", 4), (Other, "stress", 5), (Normal, "normal", 3)];
    (0..8_usize)
        .prop_flat_map(|n| (numbers(3 * n), polygons(n.max(1)), Just(n)))
        .prop_flat_map(move |((precision, coordinates), faces, n)| {
            let mesh = bare(n, precision, &coordinates, if n == 0 { &[] } else { &faces });
            // Boxed: such large trees of strategies are too much for the stack of a test.
            let records = [Domain::Vertex, Domain::Face].map(|domain| {
                let count = mesh.count(domain);
                on_records.map(|(_, _, width)| weighted(0.3, numbers(width * count)).boxed())
            });
            let sizes = mesh.faces.iter().map(<[u32]>::len).collect::<Vec<_>>();
            let corners = on_corners.map(|(_, _, width)| {
                let sizes = sizes.clone();
                let has = vec(any::<bool>(), sizes.len());
                let list = has.prop_flat_map(move |mut has| {
                    has.iter_mut().zip(&sizes).for_each(|(has, &size)| *has &= size > 0);
                    let has =
                        has.iter().zip(&sizes).flat_map(|(&has, &size)| std::iter::repeat_n(has, size)).collect::<Vec<_>>();
                    let count = has.iter().filter(|&&has| has).count();
                    (numbers(width * count), Just(has))
                });
                weighted(0.3, list).boxed()
            });
            (Just(mesh), records, corners)
        })
        .prop_map(move |(mut mesh, records, corners)| {
            for (domain, records) in [Domain::Vertex, Domain::Face].into_iter().zip(records) {
                for ((kind, name, width), numbers) in on_records.into_iter().zip(records) {
                    mesh.attributes.extend(numbers.map(|numbers| attribute(kind, name, domain, width, numbers)));
                }
            }
            for ((kind, name, width), list) in on_corners.into_iter().zip(corners) {
                let list = list.filter(|(_, has)| has.contains(&true));
                mesh.attributes
                    .extend(list.map(|(numbers, has)| some(attribute(kind, name, Domain::Corner, width, numbers), &has)));
            }
            mesh
        })
}

/// Meshes that OFF can hold.
fn off_mesh() -> impl Strategy<Value = Mesh> {
    let colours = |count: usize| {
        (3..=4_usize).prop_flat_map(move |width| {
            let bytes = vec(number(Scalar::U8), width * count).prop_map(|values| (Scalar::U8, values));
            (Just(width), prop_oneof![bytes, text_numbers(width * count)])
        })
    };
    (1..8_usize)
        .prop_flat_map(|n| (text_numbers(3 * n), polygons(n)))
        .prop_flat_map(move |((precision, coordinates), faces)| {
            let n = coordinates.len() / 3;
            let mesh = bare(n, precision, &coordinates, &faces);
            let on_faces = vec(any::<bool>(), faces.len()).prop_flat_map(move |has| {
                let count = has.iter().filter(|&&has| has).count();
                (Just(has), colours(count))
            });
            let [normals, texcoords] = [3, 2].map(|width| weighted(0.5, text_numbers(width * n)));
            (Just(mesh), normals, texcoords, weighted(0.5, colours(n)), weighted(0.5, on_faces))
        })
        .prop_map(|(mut mesh, normals, texcoords, colours, on_faces)| {
            let name = |width: usize| if width == 4 { "r g b a" } else { "r g b" };
            let normals = normals.map(|n| attribute(AttributeKind::Normal, "nx ny nz", Domain::Vertex, 3, n));
            let texcoords = texcoords.map(|n| attribute(AttributeKind::TexCoord, "s t", Domain::Vertex, 2, n));
            let colours = colours.map(|(width, n)| attribute(AttributeKind::Colour, name(width), Domain::Vertex, width, n));
            let on_faces = on_faces
                .filter(|(has, _)| has.contains(&true))
                .map(|(has, (width, n))| some(attribute(AttributeKind::Colour, name(width), Domain::Face, width, n), &has));
            mesh.attributes = [normals, texcoords, colours, on_faces].into_iter().flatten().collect();
            mesh
        })
}

proptest! {
    #[test]
    fn obj_gives_back_all_that_it_can_hold(mesh in obj_mesh()) {
        prop_assert_eq!(there_and_back(&mesh, Format::Obj), mesh);
    }

    #[test]
    fn ply_gives_back_all_that_it_can_hold(mesh in ply_mesh()) {
        prop_assert_eq!(there_and_back(&mesh, Format::Ply), mesh);
    }

    #[test]
    fn off_gives_back_all_that_it_can_hold(mesh in off_mesh()) {
        prop_assert_eq!(there_and_back(&mesh, Format::Off), mesh);
    }
}

/// A file of each format with everything in it that the format has.
fn rich_files() -> Vec<(Format, Vec<u8>)> {
    let text = "mtllib a.mtl\no cube\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0.5 1 1 1\nvt 0 0\nvt 1 0.25\nvn 0 0 1\n\
                usemtl red\ns 1\nf 1/1/1 2/2/1 3/1/1\nf -4//-1 -2//-1 -1//-1 \\\n1//1\ng rest\nf 1 2\nl 1 2\n";
    let ply = "ply\nformat ascii 1.0\ncomment x\nelement vertex 3\nproperty float x\nproperty double y\nproperty short z\nproperty uchar red\n\
               property uchar green\nproperty uchar blue\nproperty list char int more\nelement face 2\nproperty list uchar uint vertex_indices\n\
               property float q\nproperty list uchar float texcoord\nelement edge 1\nproperty int a\nend_header\n0 0 0 1 2 3 1 7\n1 0 0 4 5 6 0\n\
               0 1 0 7 8 9 2 7 8\n3 0 1 2 .5 6 0 0 1 0 0 1\n2 0 1 .25 0\n4\n";
    let off = "STCNOFF # all\n3 2 0\n0 0 0 0 0 1 1 0 0.5 0 0\n1 0 0 0 0 1 1 0 0.5 0 0\n0 1 0 0 0 1 1 0 0.5 1 1\n3 0 1 2 255 0 0\n2 0 1\n";
    let stl = "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a b\n";
    let mut files = vec![
        (Format::Obj, text.as_bytes().to_vec()),
        (Format::Ply, ply.as_bytes().to_vec()),
        (Format::Off, off.as_bytes().to_vec()),
        (Format::Stl, stl.as_bytes().to_vec()),
    ];
    for (format, text) in files.clone() {
        // The binary twins of PLY and STL; and of OBJ as GLB.
        let mesh = Mesh::read(&text, Some(format)).unwrap().mesh;
        let mut bytes = Vec::new();
        let format = if format == Format::Obj { Format::Glb } else { format };
        mesh.write(format, &mut bytes).unwrap();
        files.push((format, bytes));
    }
    files
}

/// Whatever the bytes are, there is a mesh that fits together or an error with a text.
fn is_harmless(bytes: &[u8], format: Option<Format>) {
    match Mesh::read(bytes, format) {
        Ok(loaded) => {
            let mut mesh = loaded.mesh;
            mesh.positions.as_flattened_mut().iter_mut().for_each(|x| *x = if x.is_finite() { *x } else { 0.0 });
            mesh.check().unwrap_or_else(|e| panic!("{e}: {}", bytes.escape_ascii()));
            // Scenes may repeat what they hold.
            assert!(loaded.format == Format::Glb || mesh.positions.len() + mesh.faces.corners().len() <= bytes.len() + 1);
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

#[test]
fn files_cut_anywhere_or_with_any_bit_changed_do_no_harm() {
    for (format, bytes) in rich_files() {
        for end in 0..bytes.len() {
            is_harmless(&bytes[..end], Some(format));
            is_harmless(&bytes[..end], None);
        }
        let mut changed = bytes.clone();
        for bit in 0..8 * bytes.len() {
            changed[bit / 8] ^= 1 << (bit % 8);
            is_harmless(&changed, Some(format));
            changed[bit / 8] = bytes[bit / 8];
        }
        for i in 0..bytes.len() {
            for byte in *b"\0\n\r #-9/\\.e\xff" {
                changed[i] = byte;
                is_harmless(&changed, Some(format));
                changed[i] = bytes[i];
            }
        }
    }
}

proptest! {
    #[test]
    fn pieces_of_files_in_any_order_do_no_harm(pieces in vec((0..8_usize, any::<prop::sample::Index>(), 0..30_usize), 0..12), start in 0..60_usize) {
        let files = rich_files();
        let (format, first) = &files[start % files.len()];
        let mut bytes = first[..start.min(first.len())].to_vec();
        for (file, place, length) in pieces {
            let from = &files[file].1;
            let at = place.index(from.len());
            bytes.extend_from_slice(&from[at..(at + length).min(from.len())]);
        }
        is_harmless(&bytes, Some(*format));
        is_harmless(&bytes, None);
    }

    #[test]
    fn any_bytes_do_no_harm(bytes in vec(any::<u8>(), 0..200), format in 0..5_usize) {
        is_harmless(&bytes, Some(Format::ALL[format]));
        is_harmless(&[b"ply\nformat binary_little_endian 1.0\n", bytes.as_slice()].concat(), None);
    }
}

proptest! {
    #[test]
    fn scenes_with_other_numbers_in_them_do_no_harm(changes in vec((any::<prop::sample::Index>(), 0..12_usize), 1..4)) {
        let (_, bytes) = rich_files().into_iter().find(|(format, _)| *format == Format::Glb).unwrap();
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let mut scene = String::from_utf8(bytes[20..20 + length].to_vec()).unwrap();
        for (place, number) in changes {
            let digits = scene.match_indices(|c: char| c.is_ascii_digit()).map(|(at, _)| at).collect::<Vec<_>>();
            let at = *place.get(&digits);
            let number = ["0", "1", "2", "3", "7", "-1", "4294967295", "18446744073709551615", "1e300", "null", "[]", "5126"][number];
            scene.replace_range(at..=at, number);
        }
        scene.extend(std::iter::repeat_n(' ', scene.len().next_multiple_of(4) - scene.len()));
        let mut changed = bytes[..20].to_vec();
        changed.extend(scene.as_bytes());
        changed.extend(&bytes[20 + length..]);
        let all = changed.len() as u32;
        changed[8..12].copy_from_slice(&all.to_le_bytes());
        changed[12..16].copy_from_slice(&(scene.len() as u32).to_le_bytes());
        is_harmless(&changed, None);
    }
}
