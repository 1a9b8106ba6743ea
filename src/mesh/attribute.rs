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

/// What an attribute means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum AttributeKind {
    /// Unit normals, three components.
    Normal,
    /// Texture coordinates, two or three components.
    TexCoord,
    /// Colours, three or four components.
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
