//! GLB in: primitives of a scene to one mesh.

use std::collections::{BTreeMap, HashMap};

use glam::{DMat3, DMat4, DVec3};
use serde_json::Value;

use super::accessor::{Allowance, Numbers, error, item, whole};
use super::container::Container;
use super::scene::{self, Placed};
use super::weld::{Origin, weld};
use crate::error::{Error, Result};
use crate::mesh::io::{count, push_face};
use crate::mesh::{Attribute, AttributeKind, Faces, Label, LabelKind, Mesh, Scalar};

/// Extensions that a file may require: they do not change where triangles are.
const HARMLESS: [&str; 4] = ["KHR_mesh_quantization", "KHR_texture_transform", "KHR_lights_punctual", "KHR_xmp_json_ld"];

/// Reads a whole file.
pub(crate) fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<Mesh> {
    let container = Container::read(bytes, notes)?;
    let scene = &container.json;
    for extension in scene.get("extensionsRequired").and_then(Value::as_array).into_iter().flatten() {
        let name = extension.as_str().unwrap_or_default();
        let is_harmless = HARMLESS.contains(&name)
            || ["KHR_materials_", "KHR_texture_", "EXT_texture_"].iter().any(|start| name.starts_with(start));
        if !is_harmless {
            return Err(Error::Unsupported { what: "glTF extension", id: name.to_owned() });
        }
    }
    let mut reader = Reader {
        scene,
        binary: container.binary,
        allowance: Allowance::new(bytes.len()),
        mesh: Mesh::default(),
        origins: Vec::new(),
        material: String::new(),
        vertices: HashMap::new(),
        slots: Vec::new(),
        left_out: BTreeMap::new(),
    };
    let placed = scene::placed(scene)?;
    for (place, mesh) in placed.iter().enumerate() {
        reader.mesh(place, mesh, placed.len() > 1)?;
    }
    reader.notes(notes);
    reader.finish(notes)
}

/// An attribute while it is collected: values, and which each corner has.
#[derive(Debug)]
pub(super) struct Slot {
    pub(super) kind: AttributeKind,
    pub(super) name: String,
    pub(super) width: usize,
    pub(super) scalar: Scalar,
    pub(super) values: Vec<f64>,
    pub(super) corners: Vec<u32>,
    /// Where the values of an accessor begin, and how many there are.
    accessors: HashMap<(u64, Transform), (u32, u32)>,
}

/// The place whose transform was applied; none where nothing changes.
type Transform = Option<usize>;

fn changed(place: usize, transform: &DMat4) -> Transform {
    (*transform != DMat4::IDENTITY).then_some(place)
}

struct Reader<'a> {
    scene: &'a Value,
    binary: &'a [u8],
    allowance: Allowance,
    mesh: Mesh,
    origins: Vec<Origin>,
    material: String,
    vertices: HashMap<(u64, Transform), (u32, u32)>,
    slots: Vec<Slot>,
    /// What is not kept, and how often.
    left_out: BTreeMap<String, usize>,
}

impl Reader<'_> {
    fn mesh(&mut self, place: usize, placed: &Placed, is_one_of_many: bool) -> Result<()> {
        let mesh = item(self.scene, "meshes", placed.mesh)?;
        if is_one_of_many || !placed.name.is_empty() {
            self.label(LabelKind::Object, placed.name.clone());
        }
        if placed.transform != DMat4::IDENTITY {
            self.leave_out("transforms of nodes are applied and not kept themselves".to_owned());
        }
        let primitives = mesh.get("primitives").and_then(Value::as_array);
        for (p, primitive) in primitives.into_iter().flatten().enumerate() {
            let what = format!("meshes[{}].primitives[{p}]", placed.mesh);
            self.primitive(primitive, &what, place, &placed.transform)?;
        }
        Ok(())
    }

    fn leave_out(&mut self, what: String) {
        *self.left_out.entry(what).or_default() += 1;
    }

    fn label(&mut self, kind: LabelKind, name: String) {
        self.mesh.labels.push(Label { kind, name, first_face: self.mesh.faces.len() as u32 });
    }

    fn primitive(&mut self, primitive: &Value, what: &str, place: usize, transform: &DMat4) -> Result<()> {
        let mode = whole(primitive, "mode", what)?.unwrap_or(4);
        if !matches!(mode, 4..=6) {
            self.leave_out("primitives of points or lines are not kept".to_owned());
            return Ok(());
        }
        let empty = Value::Null;
        let attributes = primitive.get("attributes").unwrap_or(&empty);
        let Some(position) = whole(attributes, "POSITION", what)? else {
            self.leave_out("primitives without positions are not kept".to_owned());
            return Ok(());
        };
        if primitive.get("targets").is_some() {
            self.leave_out("morph targets are not kept".to_owned());
        }
        self.material(primitive, what)?;
        let (first, vertices) = self.positions(position, what, place, transform)?;

        let indices = whole(primitive, "indices", what)?;
        let indices = match indices {
            Some(accessor) => Some(Numbers::read(self.scene, self.binary, accessor, &mut self.allowance)?),
            None => None,
        };
        let length = indices.as_ref().map_or(vertices as usize, |indices| indices.values.len());
        let index = |i: usize| indices.as_ref().map_or(i as f64, |indices| indices.values[i]);
        if indices.is_none() {
            self.origins[first as usize..][..vertices as usize].iter_mut().for_each(|origin| origin.is_soup = true);
        }

        let mut values = Vec::new();
        for (name, accessor) in attributes.as_object().into_iter().flatten().filter(|(name, _)| *name != "POSITION") {
            let accessor = accessor.as_u64().ok_or_else(|| error(what, format!("expected an accessor for {name}")))?;
            match self.attribute(name, accessor, place, transform)? {
                Some(attribute) => values.push(attribute),
                None => self.leave_out(format!("{} is not kept", crate::mesh::io::text::show(name.as_bytes()))),
            }
        }

        let is_mirror = transform.determinant() < 0.0;
        let triangles = if mode == 4 { length / 3 } else { length.saturating_sub(2) };
        if mode == 4 && length % 3 != 0 {
            self.leave_out("corners beyond the last whole triangle are not kept".to_owned());
        }
        for t in 0..triangles {
            let mut corners = match mode {
                4 => [3 * t, 3 * t + 1, 3 * t + 2],
                5 => [t, t + 1 + t % 2, t + 2 - t % 2],
                _ => [t + 1, t + 2, 0],
            };
            if is_mirror {
                corners.swap(1, 2);
            }
            let corners = corners.map(index);
            if let Some(v) = corners.into_iter().find(|&v| v < 0.0 || v >= vertices.into() || v.fract() != 0.0) {
                return Err(error(what, format!("index {v}, and there are {vertices} vertices")));
            }
            let corners = corners.map(|v| v as u32);
            let is_stitch = corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0];
            if mode == 5 && is_stitch {
                continue;
            }
            self.allowance.take(3 + 3 * values.len() as u64)?;
            for &(slot, start, count) in &values {
                let slot = &mut self.slots[slot];
                slot.corners.resize(self.mesh.faces.corners().len(), Attribute::NONE);
                slot.corners.extend(corners.map(|v| if v < count { start + v } else { Attribute::NONE }));
            }
            push_face(&mut self.mesh.faces, &corners.map(|v| first + v))?;
        }
        Ok(())
    }

    /// Marks where the primitive's material begins, if it is another than before.
    fn material(&mut self, primitive: &Value, what: &str) -> Result<()> {
        let name = match whole(primitive, "material", what)? {
            Some(index) => {
                let name = item(self.scene, "materials", index)?.get("name").and_then(Value::as_str);
                name.map_or_else(|| format!("material_{index}"), str::to_owned)
            }
            None => String::new(),
        };
        if self.material != name {
            self.material.clone_from(&name);
            self.label(LabelKind::Material, name);
        }
        Ok(())
    }

    /// The vertices of an accessor: the first, and how many.
    fn positions(&mut self, accessor: u64, what: &str, place: usize, transform: &DMat4) -> Result<(u32, u32)> {
        let key = changed(place, transform);
        if let Some(&known) = self.vertices.get(&(accessor, key)) {
            return Ok(known);
        }
        let mut numbers = Numbers::read(self.scene, self.binary, accessor, &mut self.allowance)?;
        if numbers.width != 3 {
            return Err(error(what, format!("expected positions of 3 numbers, found {}", numbers.width)));
        }
        let first = self.mesh.positions.len() as u32;
        let vertices = numbers.count() as u32;
        if numbers.count() + self.mesh.positions.len() >= u32::MAX as usize {
            return Err(error(what, "more vertices than indices count"));
        }
        if numbers.is_normalized {
            numbers.make_floats(true);
        }
        self.mesh.positions.extend(numbers.values.as_chunks().0.iter().map(|&point| match key {
            Some(_) => transform.transform_point3(DVec3::from_array(point)).to_array(),
            None => point,
        }));
        let origin = Origin { accessor: first, object: place as u32, is_soup: false };
        self.origins.resize(self.mesh.positions.len(), origin);
        self.vertices.insert((accessor, key), (first, vertices));
        Ok((first, vertices))
    }

    /// The slot of an attribute, where an accessor's values begin in it, and how many they are.
    fn attribute(&mut self, name: &str, accessor: u64, place: usize, transform: &DMat4) -> Result<Option<(usize, u32, u32)>> {
        let kind = match name {
            "NORMAL" => AttributeKind::Normal,
            _ if name.starts_with("TEXCOORD_") => AttributeKind::TexCoord,
            _ if name.starts_with("COLOR_") => AttributeKind::Colour,
            _ if name.starts_with('_') => AttributeKind::Other,
            _ => return Ok(None),
        };
        let key = changed(place, transform).filter(|_| kind == AttributeKind::Normal);
        let known = self.slots.iter().position(|slot| slot.name == name);
        if let Some(slot) = known
            && let Some(&(start, count)) = self.slots[slot].accessors.get(&(accessor, key))
        {
            return Ok(Some((slot, start, count)));
        }

        let mut numbers = Numbers::read(self.scene, self.binary, accessor, &mut self.allowance)?;
        let fits = match kind {
            AttributeKind::Normal => numbers.width == 3,
            AttributeKind::TexCoord => numbers.width == 2,
            AttributeKind::Colour => matches!(numbers.width, 3 | 4),
            AttributeKind::Other => true,
        };
        if !fits || (known.is_none() && self.slots.len() == MOST_SLOTS) {
            return Ok(None);
        }
        if kind != AttributeKind::Colour || !numbers.is_normalized {
            numbers.make_floats(kind != AttributeKind::Other);
        }
        if key.is_some() {
            let normal_matrix = DMat3::from_mat4(*transform).inverse().transpose();
            for normal in numbers.values.as_chunks_mut::<3>().0 {
                let turned = (normal_matrix * DVec3::from_array(*normal)).normalize_or_zero();
                *normal = turned.to_array().map(|x| Scalar::F32.nearest(x));
            }
        }
        let slot = known.unwrap_or_else(|| {
            self.slots.push(Slot {
                kind,
                name: name.to_owned(),
                width: numbers.width,
                scalar: numbers.scalar,
                values: Vec::new(),
                corners: Vec::new(),
                accessors: HashMap::new(),
            });
            self.slots.len() - 1
        });
        let count = numbers.count() as u32;
        let start = self.slots[slot].append(numbers);
        let Some(start) = start else { return Ok(None) };
        self.slots[slot].accessors.insert((accessor, key), (start, count));
        Ok(Some((slot, start, count)))
    }

    fn notes(&mut self, notes: &mut Vec<String>) {
        let left_out = std::mem::take(&mut self.left_out);
        notes.extend(left_out.into_iter().map(|(what, n)| format!("{what} ({})", count(n, "time"))));
        for list in ["animations", "skins", "cameras", "images", "textures"] {
            let items = self.scene.get(list).and_then(Value::as_array).map_or(0, Vec::len);
            if items > 0 {
                notes.push(format!("{list} of the scene are not kept ({items})"));
            }
        }
        let mut materials = self.scene.get("materials").and_then(Value::as_array).into_iter().flatten();
        if materials.any(|material| material.as_object().is_some_and(|m| m.keys().any(|key| key != "name"))) {
            notes.push("of materials only the names are kept".to_owned());
        }
    }

    fn finish(self, notes: &mut Vec<String>) -> Result<Mesh> {
        let Self { mut mesh, mut slots, origins, .. } = self;
        let corners = mesh.faces.corners().len();
        for slot in &mut slots {
            slot.corners.resize(corners, Attribute::NONE);
            slot.unite_values();
        }
        slots.retain(|slot| !slot.values.is_empty());
        let (map, vertices) = weld(&mesh.positions, &mesh.faces, &slots, &origins);
        let merged = mesh.positions.len() - vertices;
        if merged > 0 {
            notes
                .push(format!("vertices of an object that differ in attributes or material only are made one: {merged} fewer"));
            let mut positions = vec![None; vertices];
            for (position, &v) in mesh.positions.iter().zip(&map) {
                positions[v as usize].get_or_insert(*position);
            }
            mesh.positions = positions.into_iter().flatten().collect();
            let mut faces = Faces::default();
            for face in mesh.faces.iter() {
                push_face(&mut faces, &face.iter().map(|&v| map[v as usize]).collect::<Vec<_>>())?;
            }
            mesh.faces = faces;
        }
        for slot in &mut slots {
            if let Some(bare) = slot.name.strip_prefix('_').filter(|bare| !bare.is_empty()) {
                slot.name = bare.to_owned();
            }
        }
        let attributes = slots.into_iter().map(|slot| slot.into_attribute(vertices, &mesh.faces)).collect();
        let labels = std::mem::take(&mut mesh.labels);
        let plain = Mesh::from_triangles(mesh.positions, []);
        debug_assert!(mesh.faces.are_triangles());
        Ok(Mesh { faces: mesh.faces, attributes, labels, ..plain })
    }
}

/// More kinds of attributes are not told apart.
const MOST_SLOTS: usize = 64;

impl Numbers {
    /// Integers that mean shares become floats, and the others too `if_plain`.
    fn make_floats(&mut self, if_plain: bool) {
        if self.scalar.is_float() || !(self.is_normalized || if_plain) {
            return;
        }
        if self.is_normalized {
            let greatest = self.scalar.range()[1];
            self.values.iter_mut().for_each(|x| *x = Scalar::F32.nearest((*x / greatest).max(-1.0)));
        }
        self.scalar = Scalar::F32;
        self.is_normalized = false;
    }
}

impl Slot {
    /// Adds an accessor's values; the number of the first. None if they are not of this kind.
    fn append(&mut self, mut numbers: Numbers) -> Option<u32> {
        if numbers.scalar != self.scalar {
            if self.kind == AttributeKind::Colour {
                // Floats from 0 to 1, where both are understood.
                numbers.make_floats(true);
                if !self.scalar.is_float() {
                    let greatest = self.scalar.range()[1];
                    self.values.iter_mut().for_each(|x| *x = Scalar::F32.nearest(*x / greatest));
                    self.scalar = Scalar::F32;
                }
            } else {
                self.scalar = Scalar::F64;
            }
        }
        if numbers.width != self.width {
            if self.kind != AttributeKind::Colour {
                return None;
            }
            let opaque = if self.scalar.is_float() { 1.0 } else { self.scalar.range()[1] };
            for (width, values) in [(&mut self.width, &mut self.values), (&mut numbers.width, &mut numbers.values)] {
                if *width == 3 {
                    *values = values.chunks_exact(3).flat_map(|c| [c[0], c[1], c[2], opaque]).collect();
                    *width = 4;
                }
            }
        }
        // The last number is the one that means no value.
        let start = u32::try_from(self.values.len() / self.width + numbers.count()).ok()? - numbers.count() as u32;
        self.values.append(&mut numbers.values);
        Some(start)
    }
}
