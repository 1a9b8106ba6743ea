//! How results are written down.

#[cfg(feature = "encode")]
pub(crate) mod csv;
mod doctor;
#[cfg(feature = "encode")]
pub(crate) mod html;
pub(crate) mod json;
#[cfg(feature = "encode")]
pub(crate) mod svg;
