//! What is measured and how it is told: distances, PSNR, the same-connectivity question, resized images, reports.

mod measure;
#[cfg(feature = "encode")]
mod region;
mod report;
#[cfg(feature = "encode")]
mod resize;
mod same;
#[cfg(feature = "encode")]
mod verify;

pub use measure::{CompareOptions, Comparison, HausdorffBounds, OneSided, compare, heatmap, psnr};
#[cfg(feature = "encode")]
pub use region::{RegionComparison, compare_region};
pub use report::json::Json;
#[cfg(feature = "encode")]
pub use resize::{ResizePoint, ResizeTable, image_of, resize_table, resize_to_psnr, scaled_size, surface_of, usual_side};
pub use same::{Correspondence, Verdict, same};
#[cfg(feature = "encode")]
pub use verify::{Check, Verification, verify};
