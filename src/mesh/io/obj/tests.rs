use crate::mesh::io::Format;
use crate::mesh::{Attribute, AttributeKind, Domain, LabelKind, Mesh, Scalar};

fn read(text: &str) -> crate::Result<crate::Loaded> {
    Mesh::read(text.as_bytes(), Some(Format::Obj))
}

fn fails(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn every_kind_of_corner_is_read_and_counted_from_either_end() {
    let text = format!(
        "{TRIANGLE}vt 0 0\nvt 1 0\nvn 0 0 1\nvn 0 0 -1\nf 1/2/1 2/1/2 3/2/1\nf -3/-1/-2 -2/-2 -1//-1\nf 1 2 3\nf 1// 2/ +3//2\n"
    );
    let loaded = read(&text).unwrap();
    let mesh = &loaded.mesh;
    assert!(mesh.faces.iter().all(|face| face == [0, 1, 2]));
    let [vt, vn] = [&mesh.attributes[0], &mesh.attributes[1]];
    const NONE: u32 = Attribute::NONE;
    assert_eq!((vt.kind, vt.domain, vt.width, vt.len()), (AttributeKind::TexCoord, Domain::Corner, 2, 2));
    assert_eq!(vt.indices, [1, 0, 1, 1, 0, NONE, NONE, NONE, NONE, NONE, NONE, NONE]);
    assert_eq!((vn.kind, vn.domain, vn.width, vn.len()), (AttributeKind::Normal, Domain::Corner, 3, 2));
    assert_eq!(vn.indices, [0, 1, 0, 0, NONE, 1, NONE, NONE, NONE, NONE, NONE, 1]);
    assert_eq!(loaded.notes, [] as [&str; 0]);
}

#[test]
fn normals_numbered_like_the_vertices_are_normals_of_vertices() {
    let text = format!("{TRIANGLE}vn 0 0 1\nvn 0 1 0\nvn 1 0 0\nf 3//3 1//1 2//2\n");
    let mesh = read(&text).unwrap().mesh;
    assert_eq!((mesh.attributes[0].domain, mesh.attributes[0].indices.len()), (Domain::Vertex, 0));
    let mut out = Vec::new();
    assert_eq!(mesh.write(Format::Obj, &mut out).unwrap(), [] as [&str; 0]);
    assert_eq!(String::from_utf8(out).unwrap(), text);
}

#[test]
fn colours_and_weights_stand_beside_the_coordinates() {
    let mesh = read("v 0 0 0 1 0.5 0\nv 1 0 0\nv 2 0 0 0 0 1 0.25\n").unwrap().mesh;
    let colours = &mesh.attributes[0];
    assert_eq!((colours.kind, colours.domain, colours.width), (AttributeKind::Colour, Domain::Vertex, 4));
    // A colour without alpha is opaque.
    assert_eq!(colours.values, [1.0, 0.5, 0.0, 1.0, 0.0, 0.0, 1.0, 0.25]);
    assert_eq!([0, 1, 2].map(|v| colours.get(v).is_some()), [true, false, true]);
    let mesh = read("v 0 0 0 2\nv 1 0 0 .5\n").unwrap().mesh;
    assert_eq!((mesh.attributes[0].name.as_str(), mesh.attributes[0].values.as_slice()), ("w", &[2.0, 0.5][..]));
}

#[test]
fn labels_keep_their_order_and_the_face_they_start_at() {
    let text = format!("mtllib a b.mtl\no one # 1\n{TRIANGLE}g\ns off\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 2 3\ng end\n");
    let mesh = read(&text).unwrap().mesh;
    let labels = mesh.labels.iter().map(|l| (l.kind, l.name.as_str(), l.first_face)).collect::<Vec<_>>();
    assert_eq!(
        labels,
        [
            (LabelKind::MaterialLibrary, "a b.mtl", 0),
            (LabelKind::Object, "one # 1", 0),
            (LabelKind::Group, "", 0),
            (LabelKind::Smoothing, "off", 0),
            (LabelKind::Material, "red", 0),
            (LabelKind::Material, "blue", 1),
            (LabelKind::Group, "end", 2),
        ]
    );
    let mut out = Vec::new();
    mesh.write(Format::Obj, &mut out).unwrap();
    let written = String::from_utf8(out).unwrap();
    assert!(written.starts_with("mtllib a b.mtl\nv 0 0 0\n"), "{written}");
    assert_eq!(read(&written).unwrap().mesh, mesh);
}

#[test]
fn short_faces_are_kept_and_long_lines_joined() {
    let mesh = read(&format!("{TRIANGLE}f 1 \\\n 2 \\\r\n 3\nf 1 2\nf 3\nf\n")).unwrap().mesh;
    assert_eq!(mesh.faces.iter().collect::<Vec<_>>(), [&[0, 1, 2][..], &[0, 1], &[2], &[]]);
    assert_eq!(mesh.faces.triangles(), [[0, 1, 2]]);
}

#[test]
fn what_is_not_kept_is_said() {
    let loaded =
        read(&format!("{TRIANGLE}l 1 2\nl 2 3\ncurv2 1\nvt 1 1\nvn 0 0 1\nf 1//5 2//0 3//1\nf 1 2 3 # fine\n")).unwrap();
    assert_eq!(
        loaded.notes,
        [
            "2 references to values that are not there, left out (line 9: vn index 0, and OBJ counts from 1)",
            "statement \"curv2\" is not kept (1 line, the first is line 6)",
            "statement \"l\" is not kept (2 lines, the first is line 4)",
            "no corner uses `vt`: 1 value left out",
        ]
    );
    assert_eq!(
        loaded.mesh.attributes[0].indices,
        [Attribute::NONE, Attribute::NONE, 0, Attribute::NONE, Attribute::NONE, Attribute::NONE]
    );
}

#[test]
fn faces_may_come_before_their_vertices() {
    let mesh = read(&format!("f 1/1 2/1 3/1\n{TRIANGLE}vt 0 1\n")).unwrap().mesh;
    assert_eq!((mesh.faces.get(0), mesh.attributes[0].indices.as_slice()), (&[0, 1, 2][..], &[0, 0, 0][..]));
    assert_eq!(
        fails(&format!("f 1 2 3\n\nf 1 2 5\nf 1 2 4\n{TRIANGLE}v 0 0 1\n")),
        "line 3: the face names vertex 5, and the file has 4"
    );
}

#[test]
fn errors_name_the_line() {
    assert_eq!(fails("\nv 0 0\n"), "line 2: expected 3 coordinates, found 2");
    assert_eq!(fails("v 0 0 0 0 0"), "line 1: expected 3, 4, 6 or 7 numbers, found 5");
    assert_eq!(fails("v 0 0 0 0 0 0 0 0 0"), "line 1: expected 3, 4, 6 or 7 numbers, found 9");
    assert_eq!(fails("v 0 0 O"), "line 1: expected a number, found \"O\"");
    assert_eq!(fails("vn 0 0"), "line 1: expected 3 components of a normal, found 2");
    assert_eq!(fails("vt"), "line 1: expected 2 texture coordinates, found 0");
    assert_eq!(fails(&format!("{TRIANGLE}f 1 2 -4")), "line 4: vertex index -4, and there are 3 so far");
    assert_eq!(fails(&format!("{TRIANGLE}f 1 2 0")), "line 4: vertex index 0, and OBJ counts from 1");
    assert_eq!(fails(&format!("{TRIANGLE}f 1 2 3x")), "line 4: expected a corner like 1, 1/1, 1//1 or 1/1/1, found \"3x\"");
    assert_eq!(
        fails(&format!("{TRIANGLE}f 1 2 99999999999999999999")),
        "line 4: vertex index 9223372036854775807 is too great"
    );
    assert_eq!(fails("hello\nworld"), "expected OBJ statements, found no vertex (`v`)");
}

#[test]
fn the_type_of_numbers_is_seen_from_their_digits() {
    let precision = |text: &str| read(text).unwrap().mesh.precision;
    assert_eq!(precision("v 0.1 0.25 1e-5\n"), Scalar::F32);
    assert_eq!(precision("v 0.1 0.25 500000.12345\n"), Scalar::F64);
    let single = read("v 0.1 0 0\n").unwrap().mesh;
    assert_eq!(single.positions[0][0], f64::from(0.1_f32));
    let double = read("v 0.1 0 500000.12345\n").unwrap().mesh;
    assert_eq!(double.positions[0][0], 0.1);
}

#[test]
fn references_into_an_empty_list_leave_no_attribute() {
    let loaded = read(&format!("{TRIANGLE}f 1/1 2/2 3/1\n")).unwrap();
    assert_eq!(loaded.mesh.attributes, []);
    assert_eq!(loaded.notes, ["3 references to values that are not there, left out (line 4: vt index 1, and there are 0)"]);
}
