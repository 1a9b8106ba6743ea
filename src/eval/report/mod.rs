//! How results are written down.

mod doctor;
pub(crate) mod json;
