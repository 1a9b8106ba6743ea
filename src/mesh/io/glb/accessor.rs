//! Accessors (glTF 2.0, section 3.6.2): rows of numbers somewhere in the block.

use byteorder::{ByteOrder, LE};
use serde_json::Value;

use crate::error::{Error, Place, Result};
use crate::mesh::Scalar;

/// An error about an item of the scene.
pub(super) fn error(what: &str, why: impl std::fmt::Display) -> Error {
    Error::malformed(Place::Whole, format!("{what}: {why}"))
}

/// Item `index` of the scene's list `list`.
pub(super) fn item<'a>(scene: &'a Value, list: &str, index: u64) -> Result<&'a Value> {
    usize::try_from(index)
        .ok()
        .and_then(|i| scene.get(list)?.get(i))
        .ok_or_else(|| error("glTF", format!("{list}[{index}] is named, and there is none")))
}

/// A count or an index; `None` if it is not there.
pub(super) fn whole(of: &Value, name: &str, what: &str) -> Result<Option<u64>> {
    match of.get(name) {
        None => Ok(None),
        Some(value) => match value.as_u64() {
            Some(n) => Ok(Some(n)),
            None => Err(error(what, format!("expected an integer for {name}, found {value}"))),
        },
    }
}

/// How many numbers a file may unfold to: instances repeat what is stored once, but not without end.
///
/// Sixteen million, and more for larger files: many times what they can store.
#[derive(Debug)]
pub(super) struct Allowance {
    left: u64,
    all: u64,
}

impl Allowance {
    pub(super) fn new(bytes: usize) -> Self {
        let all = (1 << 24) + 16 * bytes as u64;
        Self { left: all, all }
    }

    pub(super) fn take(&mut self, numbers: u64) -> Result<()> {
        match self.left.checked_sub(numbers) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => Err(error("glTF", format!("the scene unfolds to more than {} numbers", self.all))),
        }
    }
}

/// The numbers of an accessor, as they are stored.
#[derive(Debug)]
pub(super) struct Numbers {
    pub(super) width: usize,
    pub(super) scalar: Scalar,
    /// Integers stand for a share of the greatest of their type.
    pub(super) is_normalized: bool,
    pub(super) values: Vec<f64>,
}

impl Numbers {
    pub(super) fn count(&self) -> usize {
        self.values.len() / self.width
    }

    pub(super) fn read(scene: &Value, binary: &[u8], index: u64, allowance: &mut Allowance) -> Result<Self> {
        let accessor = item(scene, "accessors", index)?;
        let what = format!("accessors[{index}]");
        let need = |name: &str| whole(accessor, name, &what)?.ok_or_else(|| error(&what, format!("no {name}")));
        let count = need("count")?;
        let scalar = scalar(need("componentType")?, &what)?;
        let width = match accessor.get("type").and_then(Value::as_str) {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            other => {
                return Err(error(
                    &what,
                    format!("expected the type SCALAR or VEC2 to VEC4, found {}", other.unwrap_or("none")),
                ));
            }
        };
        allowance.take(count.saturating_mul(width))?;
        let offset = whole(accessor, "byteOffset", &what)?.unwrap_or(0);
        let rows = Rows { count, width, scalar };
        let mut values = match whole(accessor, "bufferView", &what)? {
            Some(view) => rows.read(scene, binary, view, offset, &what)?,
            None => vec![0.0; (count * width) as usize],
        };
        if let Some(sparse) = accessor.get("sparse") {
            let changed = whole(sparse, "count", &what)?.unwrap_or(0);
            allowance.take(changed.saturating_mul(width + 1))?;
            let part = |name: &str, rows: &dyn Fn(&Value) -> Result<Rows>| {
                let part = sparse.get(name).ok_or_else(|| error(&what, format!("sparse without {name}")))?;
                let view = whole(part, "bufferView", &what)?.ok_or_else(|| error(&what, "sparse without bufferView"))?;
                let offset = whole(part, "byteOffset", &what)?.unwrap_or(0);
                rows(part)?.read(scene, binary, view, offset, &what)
            };
            let indices = part("indices", &|part| {
                let scalar = scalar_of(part, &what)?;
                Ok(Rows { count: changed, width: 1, scalar })
            })?;
            let replacements = part("values", &|_| Ok(Rows { count: changed, width, scalar }))?;
            for (index, value) in indices.into_iter().zip(replacements.chunks_exact(width as usize)) {
                let start = index as usize * width as usize;
                let slot = values.get_mut(start..start + width as usize);
                slot.ok_or_else(|| error(&what, format!("sparse index {index}, and there are {count}")))?
                    .copy_from_slice(value);
            }
        }
        let is_normalized = accessor.get("normalized").and_then(Value::as_bool).unwrap_or(false) && !scalar.is_float();
        Ok(Self { width: width as usize, scalar, is_normalized, values })
    }
}

fn scalar_of(of: &Value, what: &str) -> Result<Scalar> {
    scalar(whole(of, "componentType", what)?.unwrap_or(0), what)
}

fn scalar(component_type: u64, what: &str) -> Result<Scalar> {
    Ok(match component_type {
        5120 => Scalar::I8,
        5121 => Scalar::U8,
        5122 => Scalar::I16,
        5123 => Scalar::U16,
        5125 => Scalar::U32,
        5126 => Scalar::F32,
        other => return Err(error(what, format!("unknown componentType {other}"))),
    })
}

/// Rows of numbers of one type.
#[derive(Clone, Copy)]
struct Rows {
    count: u64,
    width: u64,
    scalar: Scalar,
}

impl Rows {
    /// Reads them from a view of the block.
    fn read(self, scene: &Value, binary: &[u8], view: u64, offset: u64, what: &str) -> Result<Vec<f64>> {
        let view_name = format!("bufferViews[{view}]");
        let view = item(scene, "bufferViews", view)?;
        let number = |name: &str| whole(view, name, &view_name);
        let buffer = number("buffer")?.unwrap_or(0);
        if buffer != 0 || item(scene, "buffers", buffer)?.get("uri").is_some() {
            let id = format!("buffers[{buffer}] outside the file");
            return Err(Error::Unsupported { what: "glTF with", id });
        }
        let start = number("byteOffset")?.unwrap_or(0);
        let length = number("byteLength")?.ok_or_else(|| error(&view_name, "no byteLength"))?;
        let end = start.checked_add(length).filter(|&end| end <= binary.len() as u64);
        let Some(end) = end else {
            return Err(error(&view_name, format!("{length} bytes from {start} on, and the block has {}", binary.len())));
        };
        let bytes = &binary[start as usize..end as usize];

        let size = self.width * self.scalar.size() as u64;
        let stride = number("byteStride")?.unwrap_or(size);
        // The last row need not fill its stride.
        let wanted = match self.count.checked_sub(1) {
            None => Some(0),
            Some(before) => before.checked_mul(stride).and_then(|n| n.checked_add(size)).and_then(|n| n.checked_add(offset)),
        };
        if stride < size || wanted.is_none_or(|wanted| wanted > length) {
            let count = self.count;
            return Err(error(
                what,
                format!("{count} rows of {size} bytes every {stride} do not fit into {view_name} of {length} bytes"),
            ));
        }
        let mut values = Vec::with_capacity((self.count * self.width) as usize);
        for row in 0..self.count {
            let row = &bytes[(offset + row * stride) as usize..][..size as usize];
            values.extend(row.chunks_exact(self.scalar.size()).map(|number| match self.scalar {
                Scalar::I8 => f64::from(number[0] as i8),
                Scalar::U8 => f64::from(number[0]),
                Scalar::I16 => f64::from(LE::read_i16(number)),
                Scalar::U16 => f64::from(LE::read_u16(number)),
                Scalar::I32 => f64::from(LE::read_i32(number)),
                Scalar::U32 => f64::from(LE::read_u32(number)),
                Scalar::F32 => f64::from(LE::read_f32(number)),
                Scalar::F64 => LE::read_f64(number),
            }));
        }
        Ok(values)
    }
}
