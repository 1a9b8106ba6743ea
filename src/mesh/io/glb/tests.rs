use serde_json::{Value, json};

use super::container::Container;
use crate::mesh::io::{Format, Sink};
use crate::mesh::{Attribute, AttributeKind, Domain, Label, LabelKind, Mesh, Scalar};

fn file(scene: &Value, binary: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut sink = Sink::new(&mut bytes);
    Container::write(scene, binary, &mut sink).unwrap();
    sink.finish().unwrap();
    bytes
}

fn read(scene: &Value, binary: &[u8]) -> crate::Result<crate::Loaded> {
    Mesh::read(&file(scene, binary), None)
}

/// A square of two triangles: positions, indices as bytes, and texture coordinates as shares of 255.
fn square() -> (Value, Vec<u8>) {
    let mut binary = Vec::new();
    for x in [[0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].as_flattened() {
        binary.extend(x.to_le_bytes());
    }
    binary.extend([0, 1, 2, 0, 2, 3, 0, 0]);
    binary.extend([0, 0, 7, 7, 255, 0, 7, 7, 255, 255, 7, 7, 0, 51]);
    let scene = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "floor" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 2, "TANGENT": 0 }, "indices": 1, "material": 0 }] }],
        "materials": [{ "name": "wood", "doubleSided": true }],
        "images": [{ "uri": "wood.png" }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR" },
            { "bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC2", "normalized": true },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 6 },
            { "buffer": 0, "byteOffset": 56, "byteLength": 14, "byteStride": 4 },
        ],
        "buffers": [{ "byteLength": binary.len() }],
    });
    (scene, binary)
}

#[test]
fn a_square_is_read_with_its_names_and_what_is_left_out_is_said() {
    let (scene, binary) = square();
    let loaded = read(&scene, &binary).unwrap();
    let mesh = loaded.mesh;
    assert_eq!(loaded.format, Format::Glb);
    assert_eq!(mesh.positions[2], [1.0, 1.0, 0.0]);
    assert_eq!(mesh.faces.iter().collect::<Vec<_>>(), [[0, 1, 2], [0, 2, 3]]);
    let texcoords = &mesh.attributes[0];
    assert_eq!((texcoords.domain, texcoords.scalar, texcoords.name.as_str()), (Domain::Vertex, Scalar::F32, "TEXCOORD_0"));
    assert_eq!(texcoords.values, [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, f64::from(0.2_f32)]);
    let labels = mesh.labels.iter().map(|l| (l.kind, l.name.as_str(), l.first_face)).collect::<Vec<_>>();
    assert_eq!(labels, [(LabelKind::Object, "floor", 0), (LabelKind::Material, "wood", 0)]);
    assert_eq!(
        loaded.notes,
        ["\"TANGENT\" is not kept (1 time)", "images of the scene are not kept (1)", "of materials only the names are kept",]
    );
}

#[test]
fn transforms_are_applied_and_mirrors_turn_the_faces() {
    let (mut scene, binary) = square();
    scene["nodes"] = json!([
        { "children": [1], "translation": [10, 0, 0] },
        { "mesh": 0, "scale": [-2, 1, 1], "rotation": [0, 0, 1, 0] },
    ]);
    let mesh = read(&scene, &binary).unwrap().mesh;
    // Scaled to (−2, 1), turned by half a turn, moved.
    assert_eq!(mesh.positions[2], [12.0, -1.0, 0.0]);
    assert_eq!(mesh.faces.get(0), [0, 2, 1]);
    scene["nodes"][1]["children"] = json!([0]);
    assert_eq!(read(&scene, &binary).unwrap_err().to_string(), "glTF: nodes[0] is reached twice: the nodes are no tree");
}

#[test]
fn strips_fans_and_soups_become_the_same_triangles() {
    let (mut scene, binary) = square();
    let primitive = &mut scene["meshes"][0]["primitives"][0];
    *primitive = json!({ "attributes": { "POSITION": 0 }, "mode": 6 });
    assert_eq!(read(&scene, &binary).unwrap().mesh.faces.iter().collect::<Vec<_>>(), [[1, 2, 0], [2, 3, 0]]);
    scene["meshes"][0]["primitives"][0]["mode"] = 5.into();
    assert_eq!(read(&scene, &binary).unwrap().mesh.faces.iter().collect::<Vec<_>>(), [[0, 1, 2], [1, 3, 2]]);

    // Six corners without indices: the diagonal's ends are there twice.
    let corners = [[0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let soup = corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    scene["meshes"][0]["primitives"][0]["mode"] = 4.into();
    scene["bufferViews"][0]["byteLength"] = 72.into();
    scene["accessors"][0]["count"] = 6.into();
    let mesh = read(&scene, &soup).unwrap().mesh;
    assert_eq!(mesh.faces.iter().collect::<Vec<_>>(), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn sparse_accessors_are_read() {
    let (mut scene, mut binary) = square();
    let start = binary.len();
    binary.extend(2_u16.to_le_bytes());
    binary.extend([5_f32, 6.0, 7.0].into_iter().flat_map(f32::to_le_bytes));
    let view = json!({ "buffer": 0, "byteOffset": start, "byteLength": 14 });
    scene["bufferViews"].as_array_mut().unwrap().push(view);
    scene["accessors"][0]["sparse"] = json!({ "count": 1, "indices": { "bufferView": 3, "componentType": 5123 }, "values": { "bufferView": 3, "byteOffset": 2 } });
    assert_eq!(read(&scene, &binary).unwrap().mesh.positions[1..3], [[1.0, 0.0, 0.0], [5.0, 6.0, 7.0]]);
}

/// Two squares side by side, with a seam in texture space along their common edge.
fn seamed() -> Mesh {
    let positions = [0.0, 1.0, 2.0].into_iter().flat_map(|x| [[x, 0.0, 0.0], [x, 1.0, 0.0]]).collect();
    let mut mesh = Mesh::from_triangles(positions, [[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]]);
    // In order of the corners that use them.
    let texcoords =
        [0.0, 0.0, 0.5, 0.0, 0.0, 1.0, 0.5, 1.0, 0.6, 0.0, 0.9, 0.0, 0.6, 1.0, 0.9, 1.0].map(|x| f64::from(x as f32));
    let attribute = |kind, name: &str, domain, width, values: &[f64], indices: &[u32]| Attribute {
        kind,
        name: name.to_owned(),
        domain,
        width,
        scalar: Scalar::F32,
        values: values.to_vec(),
        indices: indices.to_vec(),
    };
    let normals = [0.0, 0.0, 1.0].repeat(6);
    mesh.attributes = vec![
        Attribute { scalar: Scalar::U8, ..attribute(AttributeKind::Colour, "COLOR_0", Domain::Vertex, 3, &[255.0; 18], &[]) },
        attribute(AttributeKind::Normal, "NORMAL", Domain::Vertex, 3, &normals, &[]),
        attribute(AttributeKind::TexCoord, "TEXCOORD_0", Domain::Corner, 2, &texcoords, &[0, 1, 2, 2, 1, 3, 4, 5, 6, 6, 5, 7]),
        attribute(AttributeKind::Other, "quality", Domain::Vertex, 1, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], &[]),
    ];
    let label = |kind, name: &str, first_face| Label { kind, name: name.to_owned(), first_face };
    mesh.labels =
        vec![label(LabelKind::Object, "both", 0), label(LabelKind::Material, "red", 0), label(LabelKind::Material, "blue", 2)];
    mesh
}

#[test]
fn a_mesh_with_seams_comes_back_as_one_surface() {
    let mesh = seamed();
    let mut bytes = Vec::new();
    assert_eq!(mesh.write(Format::Glb, &mut bytes).unwrap(), [] as [&str; 0]);
    let loaded = Mesh::read(&bytes, None).unwrap();
    assert_eq!(loaded.notes, ["vertices of an object that differ in attributes or material only are made one: 2 fewer"]);
    assert_eq!(loaded.mesh, mesh);
}

#[test]
fn vertices_that_are_the_same_in_everything_stay_apart() {
    let mesh = Mesh::from_triangles(
        vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [5.0; 3], [0.0; 3]],
        [[0, 1, 2], [2, 1, 3]],
    );
    let mut bytes = Vec::new();
    assert_eq!(mesh.write(Format::Glb, &mut bytes).unwrap(), [] as [&str; 0]);
    let loaded = Mesh::read(&bytes, None).unwrap();
    assert_eq!((loaded.mesh, loaded.notes), (mesh, Vec::new()));
}

#[test]
fn errors_name_the_byte_or_the_item() {
    let (scene, binary) = square();
    let with = |change: &dyn Fn(&mut Value)| {
        let mut changed = scene.clone();
        change(&mut changed);
        read(&changed, &binary).unwrap_err().to_string()
    };
    assert_eq!(
        with(&|s| s["accessors"][0]["count"] = 5.into()),
        "accessors[0]: 5 rows of 12 bytes every 12 do not fit into bufferViews[0] of 48 bytes"
    );
    assert!(with(&|s| s["accessors"][0]["count"] = u64::MAX.into()).starts_with("glTF: the scene unfolds to more than 16"));
    assert_eq!(
        with(&|s| s["bufferViews"][1]["byteLength"] = 99.into()),
        "bufferViews[1]: 99 bytes from 48 on, and the block has 72"
    );
    assert_eq!(with(&|s| s["accessors"][0]["count"] = 2.into()), "meshes[0].primitives[0]: index 2, and there are 2 vertices");
    assert_eq!(with(&|s| s["nodes"][0]["mesh"] = 4.into()), "glTF: meshes[4] is named, and there is none");
    assert_eq!(with(&|s| s["nodes"][0]["scale"] = json!([1])), "nodes[0]: expected 3 numbers for scale");
    assert_eq!(
        with(&|s| s["buffers"][0]["uri"] = "a.bin".into()),
        "glTF with buffers[0] outside the file is not supported by this version"
    );
    assert_eq!(
        with(&|s| s["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])),
        "glTF extension KHR_draco_mesh_compression is not supported by this version"
    );
    let bytes = file(&scene, &binary);
    let cut = |end: usize| Mesh::read(&bytes[..end], Some(Format::Glb)).unwrap_err().to_string();
    assert_eq!(cut(11), "byte 0: expected glTF and a header of 12 bytes");
    assert_eq!(cut(100), format!("byte 8: a file of {} bytes is announced, and 100 are there", bytes.len()));
    let mut short = bytes.clone();
    short[8..12].copy_from_slice(&30_u32.to_le_bytes());
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap());
    let error = Mesh::read(&short, None).unwrap_err().to_string();
    assert_eq!(error, format!("byte 12: a chunk of {length} bytes is announced, and 10 follow"));
}
