//! Values on vertices, corners or faces, and names on stretches of faces.

/// The number type of values in a file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    #[default]
    F32,
    F64,
}

impl Scalar {
    /// Bytes of one number.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Whether the type holds fractions.
    pub fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// The least and the greatest number of the type.
    pub fn range(self) -> [f64; 2] {
        match self {
            Self::I8 => [i8::MIN.into(), i8::MAX.into()],
            Self::U8 => [0.0, u8::MAX.into()],
            Self::I16 => [i16::MIN.into(), i16::MAX.into()],
            Self::U16 => [0.0, u16::MAX.into()],
            Self::I32 => [i32::MIN.into(), i32::MAX.into()],
            Self::U32 => [0.0, u32::MAX.into()],
            Self::F32 => [f32::MIN.into(), f32::MAX.into()],
            Self::F64 => [f64::MIN, f64::MAX],
        }
    }

    /// `x` as the type holds it: rounded, and for integers clamped.
    pub fn nearest(self, x: f64) -> f64 {
        match self {
            Self::F64 => x,
            Self::F32 => f64::from(x as f32),
            integer => {
                let [least, greatest] = integer.range();
                // The maximum with a number turns NaN into that number.
                x.round_ties_even().max(least).min(greatest) + 0.0
            }
        }
    }
}

/// What an attribute means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum AttributeKind {
    /// Unit normals, three components.
    Normal,
    /// Texture coordinates, two or three components.
    TexCoord,
    /// Colours, three or four components; floats from 0 to 1, integers from 0 to the greatest of their type.
    Colour,
    /// Anything else, known by its name.
    Other,
}

/// What an attribute's values sit on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Domain {
    /// One value a vertex.
    Vertex,
    /// One value a corner (a vertex as one face sees it).
    Corner,
    /// One value a face.
    Face,
}

/// Values of `width` components each, on vertices, corners or faces.
#[derive(Debug, Clone, PartialEq)]
pub struct Attribute {
    /// What it means.
    pub kind: AttributeKind,
    /// The name that the file gave it (`quality`; the component names joined by spaces where there are several).
    pub name: String,
    /// What the values sit on.
    pub domain: Domain,
    /// Components a value.
    pub width: usize,
    /// The number type in the file.
    pub scalar: Scalar,
    /// The distinct values, `width` numbers each.
    pub values: Vec<f64>,
    /// For each vertex, corner or face the value it has; empty when they are simply in order.
    /// [`Attribute::NONE`] marks elements without one.
    pub indices: Vec<u32>,
}

impl Attribute {
    /// The index of an element that has no value.
    pub const NONE: u32 = u32::MAX;

    /// How many values there are; several elements may share one.
    pub fn len(&self) -> usize {
        self.values.len() / self.width.max(1)
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The value of vertex, corner or face `element`; `None` if it has none.
    pub fn get(&self, element: usize) -> Option<&[f64]> {
        let index = match self.indices.get(element) {
            Some(&index) if index == Self::NONE => return None,
            Some(&index) => index as usize,
            None if self.indices.is_empty() => element,
            None => return None,
        };
        self.values.get(index * self.width..(index + 1) * self.width)
    }

    /// Why the parts do not fit `elements` vertices, corners or faces, if they do not.
    pub(crate) fn misfit(&self, elements: usize) -> Option<String> {
        let values = self.len();
        let why = if self.width == 0 {
            "it has no components".to_owned()
        } else if !self.values.len().is_multiple_of(self.width) {
            format!("{} numbers are not whole values of {}", self.values.len(), self.width)
        } else if self.indices.is_empty() {
            if values == elements {
                return None;
            }
            format!("{values} values for {elements} elements")
        } else if self.indices.len() != elements {
            format!("{} indices for {elements} elements", self.indices.len())
        } else {
            let beyond = self.indices.iter().find(|&&i| i != Self::NONE && i as usize >= values)?;
            format!("index {beyond}, and there are {values} values")
        };
        Some(format!("attribute `{}`: {why}", self.name))
    }
}

/// What a label names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LabelKind {
    /// An object (`o` in OBJ).
    Object,
    /// A group (`g`).
    Group,
    /// A material (`usemtl`).
    Material,
    /// A smoothing group (`s`).
    Smoothing,
    /// A file of materials (`mtllib`).
    MaterialLibrary,
}

/// A name that holds from one face on, until the next label of its kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    /// What it names.
    pub kind: LabelKind,
    /// The name.
    pub name: String,
    /// The first face it holds for.
    pub first_face: u32,
}
