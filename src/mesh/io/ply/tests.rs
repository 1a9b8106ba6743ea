use crate::mesh::io::Format;
use crate::mesh::{AttributeKind, Domain, Mesh, Scalar};

fn read(bytes: &[u8]) -> crate::Result<crate::Loaded> {
    Mesh::read(bytes, Some(Format::Ply))
}

fn fails(bytes: &[u8]) -> String {
    read(bytes).unwrap_err().to_string()
}

const HEADER: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";

#[test]
fn properties_may_come_in_any_order_and_type() {
    let text = "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nelement face 1\r\nproperty uchar flag\r\n\
                property list int short vertex_index\r\nproperty list uchar float texcoord\r\nelement vertex 3\r\n\
                property double z\r\nproperty uchar blue\r\nproperty uchar red\r\nproperty uchar green\r\nproperty float quality\r\n\
                property int x\r\nproperty float y\r\nend_header\r\n7 3 2 1 0 6 0 0 .5 0 0 1\r\n\
                9 3 1 2 .25 7 8\r\n19 13 11 12 .5 17 18\r\n29 23 21 22 .75 27 28";
    let loaded = read(text.as_bytes()).unwrap();
    let mesh = &loaded.mesh;
    assert_eq!(mesh.positions, [[7.0, 8.0, 9.0], [17.0, 18.0, 19.0], [27.0, 28.0, 29.0]]);
    assert_eq!((mesh.precision, mesh.faces.get(0)), (Scalar::F64, &[2, 1, 0][..]));
    let all =
        mesh.attributes.iter().map(|a| (a.kind, a.name.as_str(), a.domain, a.scalar, a.values.as_slice())).collect::<Vec<_>>();
    assert_eq!(
        all,
        [
            (
                AttributeKind::Colour,
                "red green blue",
                Domain::Vertex,
                Scalar::U8,
                &[1.0, 2.0, 3.0, 11.0, 12.0, 13.0, 21.0, 22.0, 23.0][..]
            ),
            (AttributeKind::Other, "quality", Domain::Vertex, Scalar::F32, &[0.25, 0.5, 0.75]),
            (AttributeKind::Other, "flag", Domain::Face, Scalar::U8, &[7.0]),
            (AttributeKind::TexCoord, "texcoord", Domain::Corner, Scalar::F32, &[0.0, 0.0, 0.5, 0.0, 0.0, 1.0]),
        ]
    );
    assert_eq!(loaded.notes, [] as [&str; 0]);
    assert_eq!(mesh.check().map_err(|e| e.to_string()), Ok(()));
}

#[test]
fn unknown_elements_and_lists_are_skipped_and_named() {
    let text = format!(
        "{HEADER}property list uchar int neighbours\nelement camera 1\nproperty float fov\nproperty list uchar int x\nelement nothing 99999999999\nend_header\n\
         0 0 0 2 1 2\n1 0 0 0\n0 1 0 1 0\n60 2 1 1\n"
    );
    let loaded = read(text.as_bytes()).unwrap();
    assert_eq!(loaded.mesh.positions.len(), 3);
    assert_eq!(
        loaded.notes,
        [
            "list `neighbours` of the vertices is not kept",
            "element `camera` is not kept (1 record)",
            "element `nothing` is not kept (99999999999 records)",
        ]
    );
}

#[test]
fn strips_become_triangles_that_all_face_the_same_way() {
    let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\n\
                property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 2 2\n8 0 1 2 3 -1 2 3 4\n";
    let mesh = read(text.as_bytes()).unwrap().mesh;
    assert_eq!(mesh.faces.iter().collect::<Vec<_>>(), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
}

#[test]
fn errors_name_the_line_or_the_byte() {
    assert_eq!(fails(b"plx\n"), "line 1: expected ply, found \"plx\"");
    assert_eq!(fails(b"ply\nformat ascii 1.0\n"), "line 2: expected end_header, found the end of the file");
    assert_eq!(fails(b"ply\nelement vertex -3\n"), "line 2: expected the number of records of `vertex`, found \"-3\"");
    let header = format!("{HEADER}end_header\n");
    assert_eq!(fails(format!("{header}0 0 0\n0 0\n0 0 0").as_bytes()), "line 9: the line ends before its record does");
    assert_eq!(
        fails(format!("{header}0 0 0\n0 0 0 0\n0 0 0").as_bytes()),
        "line 9: the line goes on after its record, for 1 more values"
    );
    assert_eq!(fails(format!("{header}0 0 0\n0 zero 0\n0 0 0").as_bytes()), "line 9: expected a number, found \"zero\"");
    assert_eq!(
        fails(format!("{header}0 0 0\n").as_bytes()),
        "line 9: 3 records of `vertex` are announced, and the file ends after 1"
    );
    let many = header.replace("vertex 3", "vertex 99999999999");
    assert_eq!(fails(many.as_bytes()), "line 3: 99999999999 records of `vertex` are announced, and 0 bytes follow");
    let faces = format!("{HEADER}element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n0 0 0\n0 0 0\n");
    assert_eq!(fails(format!("{faces}3 0 1 3").as_bytes()), "line 13: face 0 names vertex 3, and there are 3 (counted from 0)");
    assert_eq!(fails(format!("{faces}-1 0 1").as_bytes()), "line 13: a list of -1 values, and 4 bytes follow");
    assert_eq!(fails(format!("{faces}3 0 1.5 2").as_bytes()), "line 13: expected an integer, found 1.5");
    let binary = b"ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty uchar x\nproperty uchar y\nproperty uchar z\n\
                   element face 1\nproperty list uint uint vertex_indices\nend_header\nabc\xff\xff\xff\xffabcd";
    assert_eq!(fails(binary), "byte 169: a list of 4294967295 values, and 4 bytes follow");
    assert_eq!(fails(&[&binary[..169], b"\0\0\0\x01\0"].concat()), "byte 173: 4 bytes of a record are expected, and 1 follow");
}
