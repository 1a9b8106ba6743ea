//! What resizing sees and does: the saliency of a geometry image, and its grid as it was warped.

use crate::error::{Error, Result};
use crate::plane::{GeometryImage, Plane, Planes, Shape, write_png};
use crate::resize::{Energy, Field, ResizeOptions, saliency};
use crate::task::Task;

/// How much the surface changes from sample to sample, black for nothing and white for most (paper 004, Figure 2).
///
/// # Errors
/// Choices out of range, and an image that is too large for a picture.
pub fn saliency_png(image: &GeometryImage, options: &ResizeOptions) -> Result<Vec<u8>> {
    let energy = energy(image, options)?;
    let bright = energy.values.iter().map(|e| (255.0 * e + 0.5) as i32).collect();
    write_png(&Planes::new(vec![Plane::new(image.shape(), 8, bright)?])?)
}

/// The saliency as it lies in the resized image, and on it lines of the original's grid: where they crowd, samples were
/// lost.
///
/// # Errors
/// As [`ResizeOptions::resize`], and methods under which samples do not come from one place each.
pub fn warp_png(
    image: &GeometryImage,
    options: &ResizeOptions,
    width: usize,
    height: usize,
    task: Task<'_>,
) -> Result<Vec<u8>> {
    /// Lines along the longer side, and pixels along it.
    const LINES: usize = 50;
    const PIXELS: usize = 640;
    /// Shades of saliency: few of them make small pictures.
    const SHADES: f64 = 12.0;
    let energy = energy(image, options)?;
    let resized = options.resize(image, width, height, &task)?;
    let places = match resized.places() {
        Some(places) => Field::new(width, height, places.to_vec()),
        None if (width, height) == (image.width(), image.height()) => {
            Field::from_fn(width, height, |x, y| [x as f64, y as f64])
        }
        None => {
            let why = format!("the method {} has no warp to show; content has", options.method.name());
            return Err(Error::Parameter(why));
        }
    };
    let scale = (PIXELS / width.max(height)).clamp(1, 64);
    let apart = (image.width().max(image.height()) as f64 / LINES as f64).max(1.0);
    let side = |n: usize| ((n - 1) * scale + 1) as u32;
    let shape = Shape::new(side(width), side(height))?;
    // The place in the original under each pixel, one more on both axes to see where a line is crossed.
    let under = Field::from_fn(shape.width() + 1, shape.height() + 1, |x, y| {
        places.linear([x as f64 / scale as f64, y as f64 / scale as f64])
    });
    let mut planes = [Vec::new(), Vec::new(), Vec::new()];
    for y in 0..shape.height() {
        for x in 0..shape.width() {
            let place = under.at(x, y);
            let line = |at: [f64; 2], axis: usize| (at[axis] / apart).floor();
            let crossed = (0..2).any(|axis| {
                let here = line(place, axis);
                here != line(under.at(x + 1, y), axis) || here != line(under.at(x, y + 1), axis)
            });
            let sample = (energy.at(place[0].round() as usize, place[1].round() as usize) * SHADES).round() / SHADES;
            // Saliency warm on white, lines dark.
            let colour =
                if crossed { [40, 40, 60] } else { [255.0, 255.0 - 120.0 * sample, 255.0 - 200.0 * sample].map(|c| c as i32) };
            (0..3).for_each(|i| planes[i].push(colour[i]));
        }
    }
    write_png(&Planes::new(planes.into_iter().map(|samples| Plane::new(shape, 8, samples)).collect::<Result<_>>()?)?)
}

fn energy(image: &GeometryImage, options: &ResizeOptions) -> Result<Field<f64>> {
    options.check()?;
    let how = if options.literal { Energy::Paper } else { Energy::Robust };
    Ok(saliency(image, options.effective_alpha().unwrap_or(ResizeOptions::ALPHA), how))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::{Gluing, read_rgb};

    /// A sheet with one sharp fold at a third of its width.
    fn roof() -> GeometryImage {
        let point = |p: usize| {
            let (x, y) = ((p % 40) as f64 / 39.0, (p / 40) as f64 / 39.0);
            [x, y, (x - 1.0 / 3.0).abs()]
        };
        GeometryImage::new(40, 40, Gluing::Open, (0..1600).map(point).collect()).unwrap()
    }

    #[test]
    fn the_fold_is_the_bright_line_of_the_saliency() {
        let pixels = read_rgb(&saliency_png(&roof(), &ResizeOptions::default()).unwrap());
        let bright = |x: usize| (0..40).map(|y| u32::from(pixels[y * 40 + x][0])).sum::<u32>();
        let brightest = (0..40).max_by_key(|&x| bright(x)).unwrap();
        assert!((12..=14).contains(&brightest), "column {brightest}");
        assert!(bright(brightest) > 2 * bright(30));
    }

    #[test]
    fn grid_lines_are_as_many_as_in_the_original_and_crowd_where_samples_were_lost() {
        let png = warp_png(&roof(), &ResizeOptions::default(), 20, 20, Task::default()).unwrap();
        let pixels = read_rgb(&png);
        let side = 19 * 32 + 1;
        assert_eq!(pixels.len(), side * side);
        // A row along which no line runs; a line that leans is two pixels wide here and there.
        let is_dark = |x: usize, y: usize| pixels[y * side + x] == [40, 40, 60];
        let row = (side / 3..2 * side / 3).min_by_key(|&y| (0..side).filter(|&x| is_dark(x, y)).count()).unwrap();
        let dark: Vec<usize> = (1..side).filter(|&x| is_dark(x, row) && !is_dark(x - 1, row)).collect();
        assert!((36..=39).contains(&dark.len()), "{} lines", dark.len());
        let gaps: Vec<usize> = dark.windows(2).map(|w| w[1] - w[0]).collect();
        let at_the_fold = gaps[11..14].iter().sum::<usize>();
        let on_the_plain = gaps[28..31].iter().sum::<usize>();
        assert!(at_the_fold as f64 > 1.3 * on_the_plain as f64, "{gaps:?}");
    }

    #[test]
    fn a_method_without_a_warp_is_refused() {
        let options = ResizeOptions::new(crate::resize::ResizeMethod::Bicubic);
        let refused = warp_png(&roof(), &options, 20, 20, Task::default()).expect_err("refused");
        assert!(refused.to_string().contains("no warp"));
    }
}
