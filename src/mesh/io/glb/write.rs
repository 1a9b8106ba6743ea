//! GLB out: a mesh for each object, a primitive for each of its materials.

use std::collections::HashMap;

use byteorder::{ByteOrder, LE};
use serde_json::{Value, json};

use super::container::Container;
use super::weld::firsts_of_equal;
use crate::error::Result;
use crate::mesh::io::{Sink, count, note_losses, note_rounding};
use crate::mesh::{Attribute, AttributeKind, Domain, LabelKind, Mesh, Scalar};

/// Writes a whole file.
pub(crate) fn write(mesh: &Mesh, out: &mut Sink<'_>, notes: &mut Vec<String>) -> Result<()> {
    let kept = kept(mesh);
    note_losses(mesh, "GLB", notes, |i| kept.iter().any(|&(k, ..)| k == i));
    note_rounding("the positions", mesh.positions.as_flattened(), Scalar::F32, notes);
    note_faces(mesh, notes);
    let attributes = kept.iter().map(|&(i, ..)| &mesh.attributes[i]).collect::<Vec<_>>();

    for (attribute, (_, _, scalar)) in attributes.iter().zip(&kept) {
        note_rounding(&format!("`{}`", attribute.name), &attribute.values, *scalar, notes);
        let missing = (0..mesh.count(attribute.domain)).filter(|&i| attribute.get(i).is_none()).count();
        if missing > 0 {
            notes.push(format!("`{}` has no value in {missing} places: written as 0", attribute.name));
        }
    }

    let split = Split::new(mesh, &attributes);
    let parts = Part::all(mesh, &split);
    let unused = split.unused(&parts);
    if parts.is_empty() && !unused.is_empty() {
        notes.push(format!("GLB files do not hold vertices without triangles: {} left out", unused.len()));
    }
    let mut block = Block::default();
    let mut materials = Vec::<&str>::new();
    let mut known = HashMap::new();
    let [mut nodes, mut meshes] = [Vec::<Value>::new(), Vec::<Value>::new()];
    let mut object = None;
    // Where each split vertex stands in the part that is written.
    let mut places = vec![0; split.vertices.len()];
    for (p, part) in parts.iter().enumerate() {
        // Vertices that no triangle uses stand with the first part.
        let mut vertices = part.triangles.as_flattened().to_vec();
        vertices.extend(unused.iter().filter(|_| p == 0));
        vertices.sort_unstable();
        vertices.dedup();
        let mut primitive = json!({ "attributes": {} });
        let positions = vertices.iter().flat_map(|&v| mesh.positions[split.vertices[v as usize].0 as usize]);
        primitive["attributes"]["POSITION"] = block.accessor(&positions.collect::<Vec<_>>(), 3, Scalar::F32, true).into();
        for (attribute, (_, name, scalar)) in attributes.iter().zip(&kept) {
            let nothing = vec![0.0; attribute.width];
            let values = vertices.iter().flat_map(|&v| match split.value(v, attribute) {
                Some(index) => &attribute.values[index as usize * attribute.width..][..attribute.width],
                None => &nothing,
            });
            let values = values.copied().collect::<Vec<_>>();
            primitive["attributes"][name.as_str()] = block.accessor(&values, attribute.width, *scalar, false).into();
        }
        for (place, &v) in (0..).zip(&vertices) {
            places[v as usize] = place;
        }
        let indices = part.triangles.as_flattened().iter().map(|&v| places[v as usize]);
        primitive["indices"] = block.indices(&indices.collect::<Vec<_>>()).into();
        if let Some(name) = part.material {
            let next = materials.len();
            let material = *known.entry(name).or_insert_with(|| {
                materials.push(name);
                next
            });
            primitive["material"] = material.into();
        }
        if object.replace(part.object) != Some(part.object) {
            let mut node = json!({ "mesh": meshes.len() });
            if let Some(name) = part.object_name.filter(|name| !name.is_empty()) {
                node["name"] = name.into();
            }
            nodes.push(node);
            meshes.push(json!({ "primitives": [] }));
        }
        if let Some(Value::Array(primitives)) = meshes.last_mut().and_then(|mesh| mesh.get_mut("primitives")) {
            primitives.push(primitive);
        }
    }

    let mut scene = json!({
        "asset": { "version": "2.0", "generator": "gimc" },
        "scene": 0,
        "scenes": [{}],
        "accessors": block.accessors,
        "bufferViews": block.views,
        "buffers": [{ "byteLength": block.bytes.len() }],
    });
    // Lists are not allowed to be empty.
    if !nodes.is_empty() {
        scene["scenes"] = json!([{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }]);
        scene["nodes"] = nodes.into();
        scene["meshes"] = meshes.into();
    }
    if !materials.is_empty() {
        scene["materials"] = materials.into_iter().map(|name| json!({ "name": name })).collect();
    }
    Container::write(&scene, &block.bytes, out)
}

/// The attributes that are written, with their glTF names and types.
fn kept(mesh: &Mesh) -> Vec<(usize, String, Scalar)> {
    let mut kept = Vec::<(usize, String, Scalar)>::new();
    let [mut texcoords, mut colours] = [0, 0];
    for (i, attribute) in mesh.attributes.iter().enumerate().filter(|(_, a)| a.domain != Domain::Face) {
        let (name, scalar) = match (attribute.kind, attribute.width) {
            (AttributeKind::Normal, 3) => ("NORMAL".to_owned(), Scalar::F32),
            (AttributeKind::TexCoord, 2) => {
                texcoords += 1;
                (format!("TEXCOORD_{}", texcoords - 1), Scalar::F32)
            }
            (AttributeKind::Colour, 3 | 4) => {
                colours += 1;
                let scalar = if matches!(attribute.scalar, Scalar::U8 | Scalar::U16) { attribute.scalar } else { Scalar::F32 };
                (format!("COLOR_{}", colours - 1), scalar)
            }
            (AttributeKind::Other, 1..=4) => (format!("_{}", attribute.name), Scalar::F32),
            _ => continue,
        };
        if kept.iter().all(|(_, known, _)| *known != name) {
            kept.push((i, name, scalar));
        }
    }
    kept
}

fn note_faces(mesh: &Mesh, notes: &mut Vec<String>) {
    let [mut polygons, mut short] = [0, 0];
    for face in mesh.faces.iter() {
        polygons += usize::from(face.len() > 3);
        short += usize::from(face.len() < 3);
    }
    if polygons > 0 {
        notes.push(format!("GLB files hold triangles only: {} cut into fans", count(polygons, "polygon")));
    }
    if short > 0 {
        notes.push(format!("GLB files hold triangles only: {} of fewer than 3 corners left out", count(short, "face")));
    }
    let lost = mesh.labels.iter().filter(|l| !matches!(l.kind, LabelKind::Object | LabelKind::Material)).count();
    if lost > 0 {
        notes.push(format!("GLB files do not hold groups, smoothing and material files: {} left out", count(lost, "label")));
    }
}

/// Vertices as glTF has them: one for each combination of values that meets at a vertex.
struct Split {
    /// For each the vertex, and the corner that has its values; none for vertices that no face uses.
    vertices: Vec<(u32, Option<u32>)>,
    /// For each corner of the mesh its split vertex.
    corners: Vec<u32>,
}

impl Split {
    /// The split vertices are in order of the vertices, then of the corners that use them.
    fn new(mesh: &Mesh, attributes: &[&Attribute]) -> Self {
        let on_corners = attributes.iter().filter(|a| a.domain == Domain::Corner).copied().collect::<Vec<_>>();
        if on_corners.is_empty() {
            let vertices = (0..mesh.positions.len() as u32).map(|v| (v, None)).collect();
            return Self { vertices, corners: mesh.faces.corners().to_vec() };
        }
        let equal = on_corners.iter().map(|a| Equal::new(a)).collect::<Vec<_>>();
        let values = |corner: u32| on_corners.iter().zip(&equal).map(move |(a, equal)| equal.of(place(a, corner as usize)));
        let mut vertices = Vec::with_capacity(mesh.positions.len());
        let mut corners = vec![0; mesh.faces.corners().len()];
        let mut around = (0..corners.len() as u32).collect::<Vec<_>>();
        around.sort_by_key(|&corner| mesh.faces.corners()[corner as usize]);
        let mut rest = around.as_mut_slice();
        for v in 0..mesh.positions.len() as u32 {
            let own = rest.iter().take_while(|&&corner| mesh.faces.corners()[corner as usize] == v).count();
            let around;
            (around, rest) = rest.split_at_mut(own);
            let Some(&first) = around.first() else {
                vertices.push((v, None));
                continue;
            };
            if around.iter().all(|&corner| values(corner).eq(values(first))) {
                around.iter().for_each(|&corner| corners[corner as usize] = vertices.len() as u32);
                vertices.push((v, Some(first)));
                continue;
            }
            around.sort_unstable_by(|&a, &b| values(a).cmp(values(b)).then(a.cmp(&b)));
            let mut alike = around.chunk_by(|&a, &b| values(a).eq(values(b))).collect::<Vec<_>>();
            alike.sort_unstable_by_key(|corners| corners[0]);
            for alike in alike {
                alike.iter().for_each(|&corner| corners[corner as usize] = vertices.len() as u32);
                vertices.push((v, Some(alike[0])));
            }
        }
        Self { vertices, corners }
    }

    /// The place of a split vertex' value in an attribute's list.
    fn value(&self, vertex: u32, attribute: &Attribute) -> Option<u32> {
        let (vertex, corner) = self.vertices[vertex as usize];
        match attribute.domain {
            Domain::Corner => corner.and_then(|corner| place(attribute, corner as usize)),
            _ => place(attribute, vertex as usize),
        }
    }

    /// The split vertices that no triangle uses.
    fn unused(&self, parts: &[Part<'_>]) -> Vec<u32> {
        let mut used = vec![false; self.vertices.len()];
        parts.iter().flat_map(|part| part.triangles.as_flattened()).for_each(|&v| used[v as usize] = true);
        (0..).zip(used).filter(|(_, used)| !used).map(|(v, _)| v).collect()
    }
}

/// Which values of an attribute are written alike.
struct Equal {
    firsts: Vec<u32>,
    /// The value that is written where there is none, if some element has it.
    nothing: Option<u32>,
}

impl Equal {
    fn new(attribute: &Attribute) -> Self {
        let firsts = firsts_of_equal(&attribute.values, attribute.width);
        let is_nothing =
            |&i: &u32| attribute.values[i as usize * attribute.width..][..attribute.width].iter().all(|&x| x == 0.0);
        let nothing = firsts.iter().copied().find(is_nothing);
        Self { firsts, nothing }
    }

    fn of(&self, value: Option<u32>) -> Option<u32> {
        value.map_or(self.nothing, |value| Some(self.firsts[value as usize]))
    }
}

/// The place of an element's value in an attribute's list.
fn place(attribute: &Attribute, element: usize) -> Option<u32> {
    match attribute.indices.get(element) {
        Some(&index) => (index != Attribute::NONE).then_some(index),
        None => Some(element as u32),
    }
}

/// The triangles of one material in one object.
struct Part<'a> {
    /// The number of the object, from 0.
    object: usize,
    object_name: Option<&'a str>,
    material: Option<&'a str>,
    /// Of split vertices.
    triangles: Vec<[u32; 3]>,
}

impl<'a> Part<'a> {
    /// All parts, by object, then in order of their first triangles.
    fn all(mesh: &'a Mesh, split: &Split) -> Vec<Self> {
        let mut labels = mesh.labels.iter().collect::<Vec<_>>();
        labels.sort_by_key(|label| label.first_face);
        let mut labels = labels.into_iter().peekable();
        let [mut object_name, mut material] = [None, None];
        let mut object = 0;
        let mut parts = Vec::<Self>::new();
        let mut known = HashMap::new();
        let mut first = 0;
        for (f, face) in mesh.faces.iter().enumerate() {
            while let Some(label) = labels.next_if(|label| label.first_face as usize <= f) {
                match label.kind {
                    LabelKind::Object => (object, object_name) = (object + 1, Some(label.name.as_str())),
                    LabelKind::Material => material = Some(label.name.as_str()).filter(|name| !name.is_empty()),
                    _ => {}
                }
            }
            let corners = &split.corners[first..first + face.len()];
            first += face.len();
            if corners.len() < 3 {
                continue;
            }
            let part = *known.entry((object, material)).or_insert_with(|| {
                parts.push(Self { object, object_name, material, triangles: Vec::new() });
                parts.len() - 1
            });
            parts[part].triangles.extend((2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]));
        }
        parts
    }
}

/// The block of numbers as it grows.
#[derive(Default)]
struct Block {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Block {
    /// Adds numbers; the accessor's number. Rows begin at multiples of four bytes, as they must.
    fn accessor(&mut self, values: &[f64], width: usize, scalar: Scalar, with_box: bool) -> usize {
        let start = self.bytes.len();
        let stride = (width * scalar.size()).next_multiple_of(4);
        let component_type = match scalar {
            Scalar::U8 => 5121,
            Scalar::U16 => 5123,
            _ => 5126,
        };
        for row in values.chunks_exact(width) {
            for &x in row {
                match scalar {
                    Scalar::U8 => self.bytes.push(scalar.nearest(x) as u8),
                    Scalar::U16 => self.bytes.extend((scalar.nearest(x) as u16).to_le_bytes()),
                    _ => self.bytes.extend((x as f32).to_le_bytes()),
                }
            }
            self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        }
        let mut view = json!({ "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start, "target": 34962 });
        if stride != width * scalar.size() {
            view["byteStride"] = stride.into();
        }
        self.views.push(view);
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][width - 1];
        let count = values.len() / width;
        let view = self.views.len() - 1;
        let mut accessor = json!({ "bufferView": view, "componentType": component_type, "count": count, "type": kind });
        if component_type != 5126 {
            accessor["normalized"] = true.into();
        }
        if with_box {
            let rows =
                self.bytes[start..].chunks_exact(12).map(|row| [0, 4, 8].map(|at| f64::from(LE::read_f32(&row[at..at + 4]))));
            let finite = rows.filter(|row| row.iter().all(|x| x.is_finite()));
            let ends = finite.fold(None, |ends: Option<[[f64; 3]; 2]>, p| {
                let [low, high] = ends.unwrap_or([p, p]);
                Some([[0, 1, 2].map(|i| low[i].min(p[i])), [0, 1, 2].map(|i| high[i].max(p[i]))])
            });
            let [low, high] = ends.unwrap_or_default();
            accessor["min"] = json!(low);
            accessor["max"] = json!(high);
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds indices of vertices; the accessor's number.
    fn indices(&mut self, indices: &[u32]) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
        let length = self.bytes.len() - start;
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length, "target": 34963 }));
        let view = self.views.len() - 1;
        self.accessors.push(json!({ "bufferView": view, "componentType": 5125, "count": length / 4, "type": "SCALAR" }));
        self.accessors.len() - 1
    }
}
