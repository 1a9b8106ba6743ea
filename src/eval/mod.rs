//! What is measured and how it is told: distances, PSNR, the same-connectivity question, reports.

mod measure;
mod report;
mod same;
#[cfg(feature = "encode")]
mod verify;

pub use measure::{CompareOptions, Comparison, HausdorffBounds, OneSided, compare, heatmap, psnr};
pub use report::json::Json;
pub use same::{Correspondence, Verdict, same};
#[cfg(feature = "encode")]
pub use verify::{Check, Verification, verify};
