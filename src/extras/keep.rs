//! How an encoder keeps attributes: the form of their numbers, and their streams.

use super::attributes::{DOMAINS, KINDS, SCALARS, shape};
use crate::error::Result;
use crate::format::{AttributeRecord, NumberForm};
use crate::mesh::{Attribute, AttributeKind, Domain, Faces, Scalar};
use crate::options::{AttributeChoices, Precision};
use crate::surface::attributes::{self, Form, Ground, NONE, Values, form};
use crate::surface::renumber::Renumbering;

/// How each attribute is kept, by its number; what is not kept, or changed, goes to `notes`.
pub(crate) fn choose(attributes: &[Attribute], choices: &AttributeChoices, notes: &mut Vec<String>) -> Vec<(usize, Form)> {
    let mut kept = Vec::new();
    for (i, attribute) in attributes.iter().enumerate() {
        if attribute.width > 255 {
            notes.push(format!("attribute `{}` was left out: values of more than 255 numbers", attribute.name));
        } else if let Some(precision) = choices.precision(attribute.kind) {
            kept.push((i, form_of(attribute, precision, notes)));
        } else {
            notes.push(format!("attribute `{}` was left out, as asked", attribute.name));
        }
    }
    kept
}

fn form_of(attribute: &Attribute, precision: Precision, notes: &mut Vec<String>) -> Form {
    if !attribute.scalar.is_float() {
        return Form::Integer;
    }
    let is_finite = attribute.values.iter().all(|x| x.is_finite());
    if !is_finite && precision != Precision::Exact {
        notes.push(format!("attribute `{}` has values that are not finite, and is kept exactly", attribute.name));
    }
    let ranges = (0..attribute.width).map(|i| {
        let column = attribute.values.iter().skip(i).step_by(attribute.width);
        column.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)])
    });
    let ranges: Vec<[f64; 2]> = ranges.map(|r| if r[0] <= r[1] { r } else { [0.0; 2] }).collect();
    let single = |x: f64| if f64::from(x as f32) > x { f64::from((x as f32).next_down()) } else { f64::from(x as f32) };
    let low: Vec<f64> = ranges.iter().map(|r| if attribute.scalar == Scalar::F64 { r[0] } else { single(r[0]) }).collect();
    let side = ranges.iter().zip(&low).map(|(r, low)| r[1] - low).fold(0.0, f64::max);
    let step = match precision {
        _ if !is_finite => return Form::Exact,
        Precision::Exact => return Form::Exact,
        Precision::Bits(bits) if attribute.kind == AttributeKind::Normal && attribute.width == 3 => {
            let squares = attribute.values.chunks_exact(3).map(|v| v.iter().map(|x| x * x).sum::<f64>());
            let (least, most) = squares.fold((1.0_f64, 1.0_f64), |(a, b), s| (a.min(s), b.max(s)));
            if least > 0.25 {
                if !(0.99..1.01).contains(&least) || !(0.99..1.01).contains(&most) {
                    notes.push(format!("attribute `{}`: normals are made as long as 1", attribute.name));
                }
                return Form::Octahedral { bits: bits.clamp(2, form::MAX_NORMAL_BITS) };
            }
            // Some are no directions: kept as three numbers.
            side / ((1_u64 << bits) - 1) as f64
        }
        Precision::Bits(bits) => side / ((1_u64 << bits) - 1) as f64,
        Precision::Step(step) => step,
    };
    let is_possible = step > 0.0 && step.is_finite() && side / step < (1_u64 << form::MAX_BITS) as f64;
    match (is_possible, side > 0.0) {
        (true, _) => Form::Lattice { low, step },
        (false, false) => Form::Lattice { low, step: 1.0 },
        (false, true) => {
            notes.push(format!("attribute `{}` is kept exactly: no lattice is fine enough", attribute.name));
            Form::Exact
        }
    }
}

/// A record's stream, for a mesh whose order has changed; the record is to be completed with it.
pub(super) fn write<'a>(
    attribute: &'a Attribute,
    form: &Form,
    ground: &Ground<'_>,
    order: &Renumbering,
    old_faces: &Faces,
) -> Result<(AttributeRecord<'a>, Vec<u8>)> {
    let place = |x: Option<usize>| x.unwrap_or(0) as u8;
    let domain = place(DOMAINS.iter().position(|&d| d == attribute.domain));
    let old: Vec<u32> = match attribute.domain {
        Domain::Vertex => order.vertices.clone(),
        Domain::Face => order.faces.clone(),
        Domain::Corner => {
            let faces = ground.faces.iter().zip(&order.faces).zip(&order.turns);
            let corners = faces.flat_map(|((face, &old), &turn)| {
                let (n, start) = (face.len() as u32, old_faces.range(old as usize).start as u32);
                (0..n).map(move |i| start + (i + n - turn) % n)
            });
            corners.collect()
        }
    };
    let value = |e: u32| match attribute.indices.get(e as usize) {
        Some(&index) if index == Attribute::NONE => NONE,
        Some(&index) => index,
        None => e,
    };
    let mut values = Values { integers: Vec::new(), of: old.into_iter().map(value).collect() };
    for number in attribute.values.chunks_exact(attribute.width) {
        form.integers(number, attribute.scalar, &mut values.integers);
    }
    let record = AttributeRecord {
        kind: place(KINDS.iter().position(|&k| k == attribute.kind)),
        domain,
        scalar: place(SCALARS.iter().position(|&s| s == attribute.scalar)),
        has_gaps: values.of.contains(&NONE),
        width: attribute.width as u8,
        name: &attribute.name,
        numbers: match form {
            Form::Integer => NumberForm::Integer,
            Form::Lattice { low, step } => NumberForm::Lattice { low: low.clone(), step: *step },
            Form::Octahedral { bits } => NumberForm::Octahedral { bits: *bits as u8 },
            Form::Exact => NumberForm::Exact,
        },
        stream: &[],
    };
    let stream = attributes::write(ground, &shape(&record), &values)?;
    Ok((record, stream))
}
