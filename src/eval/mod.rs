//! What is measured and how it is told: distances, PSNR, the same-connectivity question, resized images, rate–distortion
//! sweeps with their curves, reports.

mod curve;
mod measure;
#[cfg(feature = "encode")]
mod region;
mod report;
#[cfg(feature = "encode")]
mod resize;
mod same;
#[cfg(feature = "encode")]
mod sweep;
#[cfg(feature = "encode")]
mod verify;

pub use curve::{BdRate, PSNR_WITHOUT_LOSS, RatePoint, bd_rate, pareto};
pub use measure::{CompareOptions, Comparison, HausdorffBounds, OneSided, compare, heatmap, psnr};
#[cfg(feature = "encode")]
pub use region::{RegionComparison, compare_region};
#[cfg(feature = "encode")]
pub use report::csv::{bd_rate_csv, points_csv, read_points};
#[cfg(feature = "encode")]
pub use report::html::report_html;
pub use report::json::Json;
#[cfg(feature = "encode")]
pub use report::svg::curves_svg;
#[cfg(feature = "encode")]
pub use resize::{ResizePoint, ResizeTable, image_of, resize_table, resize_to_psnr, scaled_size, surface_of, usual_side};
pub use same::{Correspondence, Verdict, same};
#[cfg(feature = "encode")]
pub use sweep::{
    Coder, Measured, MeshCurves, OwnCoder, RoundTrip, Sweep, SweepMesh, SweepPoint, SweepTable, Swept, WayCurve, WayMean,
};
#[cfg(feature = "encode")]
pub use verify::{Check, Verification, verify};
