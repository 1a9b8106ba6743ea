//! `gimc compare A B`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use gimc::Format;
use gimc::eval::{self, CompareOptions, Comparison, Json, RegionComparison, Verdict};

use super::failure::Failure;
use super::table::{Table, number, thousands};
use super::{Common, Outcome, input, output};

/// Measure how far two meshes are from each other. The first is the original.
#[derive(Debug, Args)]
pub(super) struct Compare {
    /// The original.
    a: PathBuf,
    /// The other.
    b: PathBuf,
    /// Certify the Hausdorff distance.
    #[arg(long)]
    exact: bool,
    /// Points on each surface [default: 10 a face, at least 200000].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    samples: Option<u64>,
    /// Exit with 1 unless the two have the same connectivity, up to the order of vertices and faces.
    #[arg(long)]
    same_connectivity: bool,
    /// Write the original with the distance of each vertex as a colour and as a scalar.
    #[arg(long, value_name = "OUT.ply")]
    heatmap: Option<PathBuf>,
    /// Also measure from a region of the original: a file as for `encode --roi`, but no picture, or auto.
    #[arg(long, value_name = "FILE|auto")]
    roi: Option<String>,
    #[command(flatten)]
    common: Common,
}

impl Compare {
    pub(super) fn run(self) -> Outcome {
        let [a, b] = [&self.a, &self.b];
        if a == b && a.as_os_str() == "-" {
            return Err(Failure::wrong_use("only one of the two meshes can come from stdin", None));
        }
        let ((a, _), (b, _)) = (input::mesh(a, None)?, input::mesh(b, None)?);
        let mut options = CompareOptions::default().exact(self.exact);
        if let Some(samples) = self.samples {
            options = options.samples(samples as usize);
        }
        let file = input::name(&self.b);
        let measured = self
            .common
            .run("comparing", |task| eval::compare(&a, &b, &options, &task))
            .map_err(|e| Failure::in_file(&file, e))?;
        if let Some(heatmap) = &self.heatmap {
            let format = Format::from_path(heatmap).unwrap_or(Format::Ply);
            let painted =
                self.common.run("painting", |task| eval::heatmap(&a, &b, &task)).map_err(|e| Failure::in_file(&file, e))?;
            output::write(heatmap, |out| painted.write(format, out))?;
        }
        let roi = super::roi::place(self.roi.as_deref())?;
        let of_region = roi.map(|roi| self.common.run("comparing", |task| eval::compare_region(&a, &b, &roi, &task)));
        let of_region = of_region.transpose().map_err(|e| Failure::in_file(&file, e))?;
        output::print(&if self.common.json {
            let mut json = measured.to_json();
            json.extend(of_region.iter().flat_map(region_json));
            format!("{json}\n")
        } else {
            text(&measured, of_region.as_ref())
        })?;
        if self.same_connectivity && measured.same_connectivity != Verdict::Same {
            let text = match measured.same_connectivity {
                Verdict::Different => format!("{file}: the connectivity differs from that of {}", self.a.display()),
                _ => format!("{file}: whether the connectivity is the same could not be decided"),
            };
            return Err(Failure::Refused { text, hint: None });
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn region_json(found: &RegionComparison) -> Vec<(&'static str, Json)> {
    vec![
        ("rms_roi", found.rms.into()),
        ("hausdorff_roi", found.hausdorff.into()),
        ("psnr_roi", found.psnr.into()),
        ("area_roi", found.share.into()),
        ("samples_roi", found.samples.into()),
    ]
}

fn text(m: &Comparison, region: Option<&RegionComparison>) -> String {
    let mut table = Table::default();
    let share = |x: f64| format!("{}  ({} of the diagonal)", number(x), number(x / m.diag));
    table.row("rms", share(m.rms));
    table.row("rms_max", share(m.rms_max));
    table.row("hausdorff", share(m.hausdorff));
    if let Some(bounds) = m.certified {
        table.row("  certified", format!("between {} and {}", number(bounds.lower), number(bounds.upper)));
    }
    table.row("psnr", format!("{:.3} dB", m.psnr));
    if let Some(psnr) = m.psnr_vertex {
        table.row("psnr_vertex", format!("{psnr:.3} dB"));
    }
    if let Some(angle) = m.normal_rms {
        table.row("normal_rms", format!("{} degrees", number(angle)));
    }
    if let Some(region) = region {
        table.row("region", format!("{:.1} % of the area of the first", 100.0 * region.share));
        table.row("  rms", share(region.rms));
        table.row("  hausdorff", share(region.hausdorff));
        table.row("  psnr", format!("{:.3} dB", region.psnr));
    }
    let same = match m.same_connectivity {
        Verdict::Same => "yes",
        Verdict::Different => "no",
        Verdict::Undecided => "could not be decided",
    };
    table.row("same connectivity", same);
    let counts = |n: [usize; 2]| format!("{}, {}", thousands(n[0] as u64), thousands(n[1] as u64));
    table.row("vertices", counts(m.vertices));
    table.row("faces", counts(m.faces));
    table.row("samples", thousands(m.samples as u64));
    table.to_string()
}
