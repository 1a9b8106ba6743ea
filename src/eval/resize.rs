//! Resized geometry images, measured: paper 004's comparison of methods, and the smallest size that reaches a psnr.

use std::fmt::Write;

use super::measure::{CompareOptions, Comparison, compare};
use crate::error::{Error, Result};
use crate::gim::Resample;
use crate::mesh::{Mesh, Scalar};
use crate::plane::{GeometryImage, Gluing};
use crate::resize::{ResizeMethod, ResizeOptions, Resized};
use crate::task::Task;

/// The surface of a geometry image.
pub fn surface_of(image: &GeometryImage) -> Mesh {
    let mut mesh = Mesh::from_triangles(image.points().to_vec(), image.triangles());
    mesh.precision = Scalar::F64;
    mesh
}

/// A mesh as a geometry image of `side` samples a side: laid out by Yoshizawa's iteration, sampled at even places.
///
/// # Errors
/// Meshes that are no disk and no closed surface of genus 0; [`Error::Cancelled`].
pub fn image_of(mesh: &Mesh, side: usize, task: &Task<'_>) -> Result<GeometryImage> {
    let mut images = Resample::new(side).images(mesh, task)?;
    match (images.len(), images.pop()) {
        (1, Some(image)) => Ok(image),
        (count, _) => {
            let why = format!("a mesh of {count} components becomes as many geometry images, and 1 is resized at a time");
            Err(Error::Parameter(why))
        }
    }
}

/// The side of the image of a mesh where none is asked for: 2^k + 1, with about four samples a vertex.
pub fn usual_side(mesh: &Mesh) -> usize {
    let wanted = (4.0 * mesh.positions.len() as f64).sqrt();
    [65, 129, 257, 513].into_iter().find(|&side| side as f64 >= wanted).unwrap_or(1025)
}

/// Columns and rows of an image whose sides are a share of another's, as its gluing allows.
pub fn scaled_size(image: &GeometryImage, share: f64) -> [usize; 2] {
    let side = |n: usize| {
        let side = (share * (n - 1) as f64).round() as usize + 1;
        if image.gluing() == Gluing::Orbifold { (side | 1).max(3) } else { side.max(2) }
    };
    [side(image.width()), side(image.height())]
}

/// The smallest image that reaches a psnr against `original` (or the surface of the image itself), with its measures.
///
/// Found by bisection of the longer side, the shape kept.
///
/// # Errors
/// [`Error::Parameter`] if even the whole image does not reach it; those of [`ResizeOptions::resize`].
pub fn resize_to_psnr(
    image: &GeometryImage,
    options: &ResizeOptions,
    original: Option<&Mesh>,
    psnr: f64,
    task: &Task<'_>,
) -> Result<(Resized, Comparison)> {
    options.check()?;
    if !(psnr > 0.0 && psnr.is_finite()) {
        return Err(Error::Parameter(format!("a psnr of {psnr} dB, a positive number expected")));
    }
    let own;
    let original = if let Some(mesh) = original {
        mesh
    } else {
        own = surface_of(image);
        &own
    };
    let longer = image.width().max(image.height());
    let tried = |side: usize| {
        let [width, height] = scaled_size(image, (side - 1) as f64 / (longer - 1) as f64);
        let resized = options.resize(image, width, height, task)?;
        let measured = compare(original, &surface_of(&resized.image), &CompareOptions::default(), task)?;
        Ok::<_, Error>((resized, measured))
    };
    let mut best = tried(longer)?;
    if best.1.psnr < psnr {
        let why = format!(
            "the image of {} x {} samples itself has a psnr of {:.2} dB, and {psnr} was asked for",
            image.width(),
            image.height(),
            best.1.psnr
        );
        return Err(Error::Parameter(why));
    }
    let (mut low, mut high) = (1, longer);
    while high - low > 1 {
        task.step(1.0 - ((high - low) as f64).log2() / (longer as f64).log2())?;
        let middle = usize::midpoint(low, high);
        let found = tried(middle)?;
        if found.1.psnr >= psnr {
            (best, high) = (found, middle);
        } else {
            low = middle;
        }
    }
    Ok(best)
}

/// One method at one size, measured against the surface of the whole image as METRO does.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ResizePoint {
    /// The method, with "as printed" where it was literal.
    pub method: String,
    /// Columns and rows.
    pub size: [usize; 2],
    /// Triangles of the resized image.
    pub triangles: usize,
    /// The larger of both mean distances, as a share of the diagonal.
    pub mean: f64,
    /// The larger of both root mean square distances, as a share of the diagonal.
    pub rms_max: f64,
    /// The greatest distance, as a share of the diagonal.
    pub hausdorff: f64,
    /// `psnr` of both directions pooled, in dB.
    pub psnr: f64,
    /// Cells that folded on the way.
    pub folded: usize,
}

/// Every method at every size.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct ResizeTable {
    /// Method by method, sizes in the order asked for.
    pub points: Vec<ResizePoint>,
}

/// Paper 004's comparison (Figures 6 and 7): every method at every size, each also as printed where that differs.
///
/// # Errors
/// Those of [`ResizeOptions::resize`].
pub fn resize_table(image: &GeometryImage, sizes: &[[usize; 2]], task: &Task<'_>) -> Result<ResizeTable> {
    let original = surface_of(image);
    let plain = ResizeMethod::ALL.map(ResizeOptions::new);
    let printed =
        [ResizeMethod::Content, ResizeMethod::Direct, ResizeMethod::Seam].map(|by| ResizeOptions::new(by).literal(true));
    let all: Vec<ResizeOptions> = plain.into_iter().chain(printed).collect();
    let mut points = Vec::with_capacity(all.len() * sizes.len());
    for options in &all {
        for &size in sizes {
            task.step(points.len() as f64 / (all.len() * sizes.len()) as f64)?;
            let resized = options.resize(image, size[0], size[1], &quiet(task))?;
            let mesh = surface_of(&resized.image);
            let found = compare(&original, &mesh, &CompareOptions::default(), &quiet(task))?;
            points.push(ResizePoint {
                method: format!("{}{}", options.method.name(), if options.literal { " as printed" } else { "" }),
                size,
                triangles: mesh.faces.len(),
                mean: found.there.mean.max(found.back.mean) / found.diag,
                rms_max: found.rms_max / found.diag,
                hausdorff: found.hausdorff / found.diag,
                psnr: found.psnr,
                folded: resized.folded,
            });
        }
    }
    Ok(ResizeTable { points })
}

/// The same task, whose progress is told by another.
fn quiet<'a>(task: &Task<'a>) -> Task<'a> {
    task.without_progress()
}

impl ResizePoint {
    /// `20·log10(diag / rms_max)`, as METRO's rms would have it.
    pub fn psnr_rms_max(&self) -> f64 {
        super::psnr(1.0, self.rms_max)
    }
}

impl ResizeTable {
    /// One line a point, distances as shares of the diagonal.
    pub fn to_csv(&self) -> String {
        let mut csv = String::from("method,width,height,triangles,mean,rms_max,hausdorff,psnr,psnr_rms_max,folded\n");
        for p in &self.points {
            let ([width, height], metro) = (p.size, p.psnr_rms_max());
            // Writing to a string cannot fail.
            let _ = writeln!(
                csv,
                "{},{width},{height},{},{:.3e},{:.3e},{:.3e},{:.2},{metro:.2},{}",
                p.method, p.triangles, p.mean, p.rms_max, p.hausdorff, p.psnr, p.folded
            );
        }
        csv
    }

    /// The psnr of every method over the triangles, as a picture.
    pub fn to_svg(&self, title: &str) -> String {
        const COLOURS: [&str; 9] =
            ["#c0392b", "#7f8c8d", "#95a5a6", "#2c3e50", "#27ae60", "#8e44ad", "#e67e22", "#d2b4de", "#82e0aa"];
        let (left, top, wide, tall) = (60.0, 40.0, 520.0, 340.0);
        let range = |f: fn(&ResizePoint) -> f64| {
            let values = self.points.iter().map(f);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        };
        let (few, many) = range(|p| (p.triangles as f64).ln());
        let (low, high) = range(|p| p.psnr.min(120.0));
        let (low, high) = ((low / 10.0).floor() * 10.0, (high / 10.0).ceil() * 10.0);
        let x = |triangles: f64| left + wide * (triangles.ln() - few) / (many - few).max(1e-9);
        let y = |psnr: f64| top + tall * (1.0 - (psnr.min(120.0) - low) / (high - low).max(1e-9));
        let mut svg = String::from(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"800\" height=\"430\" font-family=\"sans-serif\" font-size=\"12\">\n",
        );
        svg += "<rect width=\"800\" height=\"430\" fill=\"white\"/>\n";
        let escaped = title.replace('&', "&amp;").replace('<', "&lt;");
        let _ = writeln!(svg, "<text x=\"{left}\" y=\"24\" font-size=\"14\">{escaped}</text>");
        let mut tick = low;
        while tick <= high {
            let at = y(tick);
            let _ = writeln!(svg, "<line x1=\"{left}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke=\"#ddd\"/>", left + wide);
            let _ = writeln!(svg, "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{tick} dB</text>", left - 6.0, at + 4.0);
            tick += 10.0;
        }
        let mut counts: Vec<usize> = self.points.iter().map(|p| p.triangles).collect();
        counts.sort_unstable();
        counts.dedup();
        for count in counts {
            let at = x(count as f64);
            let _ = writeln!(svg, "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{count}</text>", top + tall + 18.0);
        }
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">triangles</text>",
            left + wide / 2.0,
            top + tall + 38.0
        );
        let mut names: Vec<&str> = Vec::new();
        self.points.iter().for_each(|p| {
            if !names.contains(&p.method.as_str()) {
                names.push(&p.method)
            }
        });
        for (which, name) in names.iter().enumerate() {
            let colour = COLOURS[which % COLOURS.len()];
            let dash = if name.ends_with("printed") { " stroke-dasharray=\"5 4\"" } else { "" };
            let line: Vec<String> = self
                .points
                .iter()
                .filter(|p| p.method == *name)
                .map(|p| format!("{:.1},{:.1}", x(p.triangles as f64), y(p.psnr)))
                .collect();
            let _ = writeln!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"{dash}/>",
                line.join(" ")
            );
            let at = top + 16.0 + 20.0 * which as f64;
            let right = left + wide + 20.0;
            let _ = writeln!(
                svg,
                "<line x1=\"{right}\" x2=\"{}\" y1=\"{at}\" y2=\"{at}\" stroke=\"{colour}\" stroke-width=\"2\"{dash}/>",
                right + 24.0
            );
            let _ = writeln!(svg, "<text x=\"{}\" y=\"{}\">{name}</text>", right + 30.0, at + 4.0);
        }
        svg += "</svg>\n";
        svg
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sheet with a bump that a regular grid of a third meets badly.
    fn sheet(side: usize) -> GeometryImage {
        let point = |p: usize| {
            let (x, y) = ((p % side) as f64 / (side - 1) as f64, (p / side) as f64 / (side - 1) as f64);
            let square = ((x - 0.4) * (x - 0.4) + (y - 0.55) * (y - 0.55)) * 150.0;
            [x, y, 0.4 * (-square).exp()]
        };
        GeometryImage::new(side, side, Gluing::Open, (0..side * side).map(point).collect()).unwrap()
    }

    #[test]
    fn content_beats_regular_down_sampling_where_there_is_content() {
        let table = resize_table(&sheet(61), &[[31, 31], [21, 21]], &Task::default()).unwrap();
        assert_eq!(table.points.len(), 18);
        let psnr =
            |method: &str, side: usize| table.points.iter().find(|p| p.method == method && p.size[0] == side).unwrap().psnr;
        for side in [31, 21] {
            assert!(psnr("content", side) > psnr("bicubic", side) + 3.0, "{}", table.to_csv());
        }
        let folded = |method: &str| table.points.iter().filter(|p| p.method == method).map(|p| p.folded).sum::<usize>();
        assert_eq!(folded("content"), 0);
        let csv = table.to_csv();
        assert_eq!(csv.lines().count(), 19);
        assert!(csv.lines().all(|line| line.split(',').count() == 10));
        let svg = table.to_svg("sheet & <bump>");
        assert_eq!(svg.matches("<polyline").count(), 9);
        assert!(svg.contains("sheet &amp; &lt;bump>"));
    }

    #[test]
    fn the_smallest_size_reaches_the_psnr_and_the_next_smaller_does_not() {
        let (image, options, task) = (sheet(49), ResizeOptions::default(), Task::default());
        let (small, measured) = resize_to_psnr(&image, &options, None, 50.0, &task).unwrap();
        assert!(measured.psnr >= 50.0 && small.image.width() < 49);
        let side = small.image.width() - 1;
        let smaller = options.resize(&image, side, side, &task).unwrap();
        let less = compare(&surface_of(&image), &surface_of(&smaller.image), &CompareOptions::default(), &task).unwrap();
        assert!(less.psnr < 50.0, "{} dB at {side}", less.psnr);
        let whole = resize_to_psnr(&image, &options, None, 900.0, &task).unwrap();
        assert_eq!(whole.0.image, image);
        assert!(resize_to_psnr(&image, &options, Some(&surface_of(&sheet(200))), 200.0, &task).is_err());
    }

    #[test]
    fn sizes_by_share_are_odd_where_the_border_is_glued() {
        let image = GeometryImage::new(33, 17, Gluing::Orbifold, vec![[0.0; 3]; 33 * 17]).unwrap();
        for (share, size) in [(1.0, [33, 17]), (0.5, [17, 9]), (0.3, [11, 7]), (0.001, [3, 3]), (2.0, [65, 33])] {
            assert_eq!(scaled_size(&image, share), size);
        }
        assert_eq!(scaled_size(&sheet(200), 0.5), [101, 101]);
    }
}
