//! Attributes of a mesh as records of a file, and back.

use crate::error::Result;
use crate::format::{AttributeRecord, Header, NumberForm};
use crate::limits::Budget;
use crate::mesh::{Attribute, AttributeKind, Domain, Scalar};
use crate::surface::attributes::{self, Form, Ground, NONE, Shape, Values};

pub(super) const KINDS: [AttributeKind; 4] =
    [AttributeKind::Normal, AttributeKind::TexCoord, AttributeKind::Colour, AttributeKind::Other];
pub(super) const DOMAINS: [Domain; 3] = [Domain::Vertex, Domain::Corner, Domain::Face];
pub(super) const SCALARS: [Scalar; 8] =
    [Scalar::I8, Scalar::U8, Scalar::I16, Scalar::U16, Scalar::I32, Scalar::U32, Scalar::F32, Scalar::F64];

/// Kinds as `info` names them.
pub(super) const KIND_NAMES: [&str; 4] = ["normals", "uv", "colours", "scalars"];

/// An attribute of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct AttributeInfo {
    /// Its name.
    pub name: String,
    /// `normals`, `uv`, `colours` or `scalars`.
    pub kind: &'static str,
    /// `vertices`, `corners` or `faces`.
    pub on: &'static str,
    /// Numbers a value.
    pub width: u32,
    /// How exact it is, in words.
    pub accuracy: String,
    /// The bytes of its values.
    pub bytes: u64,
}

impl AttributeInfo {
    pub(super) fn new(record: &AttributeRecord<'_>) -> Self {
        Self {
            name: record.name.to_owned(),
            kind: KIND_NAMES[usize::from(record.kind & 3)],
            on: ["vertices", "corners", "faces"][usize::from(record.domain.min(2))],
            width: record.width.into(),
            accuracy: match &record.numbers {
                NumberForm::Integer => "integers as they are".into(),
                NumberForm::Lattice { step, .. } => format!("step {step}"),
                NumberForm::Octahedral { bits } => format!("directions of {bits} bits"),
                NumberForm::Exact => "floats bit by bit".into(),
            },
            bytes: record.stream.len() as u64,
        }
    }
}

/// What a record says before its stream is read.
pub(super) fn shape(record: &AttributeRecord<'_>) -> Shape {
    let form = match &record.numbers {
        NumberForm::Integer => Form::Integer,
        NumberForm::Lattice { low, step } => Form::Lattice { low: low.clone(), step: *step },
        NumberForm::Octahedral { bits } => Form::Octahedral { bits: u32::from(*bits) },
        NumberForm::Exact => Form::Exact,
    };
    Shape {
        kind: KINDS[usize::from(record.kind & 3)],
        domain: DOMAINS[usize::from(record.domain.min(2))],
        scalar: SCALARS[usize::from(record.scalar & 7)],
        components: form.components(record.width.into()),
        form,
        has_gaps: record.has_gaps,
    }
}

/// Memory and steps that reading a record takes at most, its values as numbers included.
pub(super) fn cost(record: &AttributeRecord<'_>, header: &Header, corners: u64) -> (u64, u64) {
    let (vertices, faces) = (u64::from(header.vertices), u64::from(header.faces));
    let elements = [vertices, corners, faces][usize::from(record.domain.min(2))];
    let components = u64::from(record.width);
    let (memory, work) = (attributes::memory(elements, vertices, faces, components), attributes::work(elements, components));
    (memory.saturating_add(numbers_memory(elements, components)), work)
}

fn numbers_memory(elements: u64, components: u64) -> u64 {
    elements.saturating_mul(8 * components + 12)
}

/// Reads the values of a record.
pub(super) fn read(record: &AttributeRecord<'_>, ground: &Ground<'_>, budget: &mut Budget) -> Result<Values> {
    let shape = shape(record);
    let values = attributes::read(record.stream, ground, &shape, budget)?;
    budget.reserve(numbers_memory(ground.elements(shape.domain) as u64, shape.components as u64))?;
    Ok(values)
}

/// The attribute of a record, its elements being in their final order.
pub(super) fn attribute(record: &AttributeRecord<'_>, values: &Values) -> Attribute {
    let Shape { kind, domain, scalar, form, components, .. } = shape(record);
    let mut attribute = Attribute {
        kind,
        name: record.name.to_owned(),
        domain,
        width: record.width.into(),
        scalar,
        values: Vec::new(),
        indices: Vec::new(),
    };
    let integers = |value: u32| &values.integers[value as usize * components..(value as usize + 1) * components];
    if domain == Domain::Corner || values.of.contains(&NONE) {
        (0..(values.integers.len() / components) as u32).for_each(|v| form.numbers(integers(v), scalar, &mut attribute.values));
        attribute.indices = values.of.iter().map(|&v| if v == NONE { Attribute::NONE } else { v }).collect();
    } else {
        values.of.iter().for_each(|&v| form.numbers(integers(v), scalar, &mut attribute.values));
    }
    attribute
}
