//! How results are written down.

pub(crate) mod json;
