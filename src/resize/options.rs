//! What callers may choose, and the one door of this room.

use super::direct::direct;
use super::downsample::{Interpolation, downsample};
use super::field::Field;
use super::progressive::{Progress, Size, progressive};
use super::saliency::Energy;
use super::seam::carve;
use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::plane::{GeometryImage, Gluing, Shape};
use crate::task::Task;

/// How a geometry image is resized.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub enum ResizeMethod {
    /// Paper 004: what matters keeps its samples, step by step.
    #[default]
    Content,
    /// Even places, the nearest sample.
    Nearest,
    /// Even places, linear between samples.
    Bilinear,
    /// Even places, cubic between samples: the paper's regular down-sampling (RDS).
    Bicubic,
    /// Seam carving (SC).
    Seam,
    /// One warp, samples averaged (VR).
    Direct,
}

impl ResizeMethod {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Content, Self::Nearest, Self::Bilinear, Self::Bicubic, Self::Seam, Self::Direct];

    /// The name that the command line and `info` use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Content => "content",
            Self::Nearest => "nearest",
            Self::Bilinear => "bilinear",
            Self::Bicubic => "bicubic",
            Self::Seam => "seam",
            Self::Direct => "direct",
        }
    }
}

/// How [`resize`](Self::resize) works.
///
/// ```
/// use gimc::{GeometryImage, Gluing, ResizeOptions, Task};
/// let bowl = |p: usize| [(p % 33) as f64, (p / 33) as f64, ((p % 33) as f64 - 16.0).powi(2) / 8.0];
/// let image = GeometryImage::new(33, 33, Gluing::Open, (0..33 * 33).map(bowl).collect())?;
/// let small = ResizeOptions::default().resize(&image, 17, 17, &Task::default())?;
/// assert_eq!((small.image.width(), small.folded), (17, 0));
/// # Ok::<(), gimc::Error>(())
/// ```
#[derive(Clone, PartialEq, Debug, Default)]
#[non_exhaustive]
pub struct ResizeOptions {
    /// Which method.
    pub method: ResizeMethod,
    /// The share of the points' energy, against that of the normals; `None` for [`Self::ALPHA`], and
    /// [`Self::ALPHA_EVEN`] for baselines and the literal method.
    pub alpha: Option<f64>,
    /// `content`: a step goes no further than to as many samples as have more energy than this (equation (6)).
    /// `None`: steps of at most a fifth alone, and 0.1 if literal.
    pub lambda: Option<f64>,
    /// `content`: how many steps; `None` for as many as a limit of a fifth a step needs.
    pub steps: Option<usize>,
    /// As the paper is printed, folds and all.
    pub literal: bool,
    /// What the work may cost.
    pub limits: Limits,
}

/// A resized image, and how it was made.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Resized {
    /// The image.
    pub image: GeometryImage,
    /// Columns and rows on the way, those of the image last; empty where nothing changed.
    pub sizes: Vec<[usize; 2]>,
    /// Cells of the grid that folded on the way, over all steps.
    pub folded: usize,
    places: Option<Field<[f64; 2]>>,
}

impl Resized {
    /// From where in the original each sample comes, row by row: columns and rows, with fractions. `None` where samples
    /// do not come from one place each.
    pub fn places(&self) -> Option<&[[f64; 2]]> {
        self.places.as_ref().map(|places| &places.values[..])
    }
}

/// Bytes that resizing takes for each sample of the larger of both images (measured: 290).
const BYTES_A_SAMPLE: u64 = 320;
/// The least energy of a sample: robust; in one warp, which must not lose all flat samples at once; as printed, where
/// equations of no weight at all could not be solved.
const FLOOR: f64 = 0.02;
const FLOOR_DIRECT: f64 = 0.1;
const FLOOR_LITERAL: f64 = 1e-3;

impl ResizeOptions {
    /// The share of the points' energy that `content` takes where none is given: 0.3 to 0.5 are near the best on every
    /// mesh that was measured (docs/resize.md).
    pub const ALPHA: f64 = 0.4;
    /// The share that the baselines take and the literal method, where none is given; the paper names none.
    pub const ALPHA_EVEN: f64 = 0.5;
    /// Equation (6)'s threshold as printed.
    pub const LAMBDA_LITERAL: f64 = 0.1;

    /// The choices of a method.
    pub fn new(method: ResizeMethod) -> Self {
        Self { method, ..Self::default() }
    }

    /// The same choices with another share of the points' energy.
    pub fn alpha(mut self, alpha: f64) -> Self {
        self.alpha = Some(alpha);
        self
    }

    /// The same choices with steps limited by equation (6).
    pub fn lambda(mut self, lambda: f64) -> Self {
        self.lambda = Some(lambda);
        self
    }

    /// The same choices with a number of steps.
    pub fn steps(mut self, steps: usize) -> Self {
        self.steps = Some(steps);
        self
    }

    /// The same choices, as the paper is printed.
    pub fn literal(mut self, literal: bool) -> Self {
        self.literal = literal;
        self
    }

    /// The same choices with other limits.
    pub fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// The share of the points' energy that counts; `None` for methods that ask for no energy.
    pub fn effective_alpha(&self) -> Option<f64> {
        let ours = self.method == ResizeMethod::Content && !self.literal;
        let default = if ours { Self::ALPHA } else { Self::ALPHA_EVEN };
        self.has_energy().then(|| self.alpha.unwrap_or(default))
    }

    /// The threshold that counts, if any does.
    pub fn effective_lambda(&self) -> Option<f64> {
        let default = (self.literal && self.steps.is_none()).then_some(Self::LAMBDA_LITERAL);
        if self.method == ResizeMethod::Content { self.lambda.or(default) } else { None }
    }

    /// What was done, in the words that a file tells of itself: method, sizes, shares and steps.
    pub fn history(&self, image: &GeometryImage, resized: &Resized) -> String {
        let size = |[width, height]: [usize; 2]| format!("{width} x {height}");
        let (from, to) = ([image.width(), image.height()], [resized.image.width(), resized.image.height()]);
        let literal = if self.literal { " as printed" } else { "" };
        let mut text = format!("resized from {} to {} by {}{literal}", size(from), size(to), self.method.name());
        if let Some(alpha) = self.effective_alpha() {
            text += &format!(", alpha {alpha}");
        }
        if let Some(lambda) = self.effective_lambda() {
            text += &format!(", lambda {lambda}");
        }
        if self.method == ResizeMethod::Content {
            let steps: Vec<String> = resized.sizes.iter().copied().map(size).collect();
            text += &format!(", {} steps: {}", steps.len(), steps.join(", "));
        }
        if resized.folded > 0 {
            text += &format!(", {} cells folded", resized.folded);
        }
        text
    }

    fn has_energy(&self) -> bool {
        matches!(self.method, ResizeMethod::Content | ResizeMethod::Seam | ResizeMethod::Direct)
    }

    /// Refuses choices that contradict each other or their ranges.
    pub fn check(&self) -> Result<()> {
        let refuse = |why: String| Err(Error::Parameter(why));
        if let Some(alpha) = self.alpha.filter(|alpha| !(0.0..=1.0).contains(alpha)) {
            return refuse(format!("alpha is {alpha}, 0 to 1 expected"));
        }
        if let Some(lambda) = self.lambda.filter(|lambda| !(0.0..1.0).contains(lambda)) {
            return refuse(format!("lambda is {lambda}, 0 or more and less than 1 expected"));
        }
        if let Some(steps) = self.steps.filter(|steps| !(1..=1000).contains(steps)) {
            return refuse(format!("{steps} steps, 1 to 1000 expected"));
        }
        let name = self.method.name();
        if (self.alpha.is_some() || self.literal) && !self.has_energy() {
            let what = if self.literal { "literal" } else { "alpha" };
            return refuse(format!("the method {name} weighs no energy, and {what} was given"));
        }
        if self.method != ResizeMethod::Content && (self.lambda.is_some() || self.steps.is_some()) {
            return refuse(format!("the method {name} makes no steps; lambda and steps are for content"));
        }
        if self.lambda.is_some() && self.steps.is_some() {
            return refuse("lambda chooses the steps by itself: give lambda or steps, not both".into());
        }
        Ok(())
    }

    /// Resizes an image to `width` columns and `height` rows.
    ///
    /// The border stays the border, and a glued one stays glued. An image that has the size already is returned as
    /// it is. O(samples) for each step; seam carving O(samples) for every line.
    ///
    /// # Errors
    /// [`Error::Parameter`] for choices out of range and for sizes that no image of this gluing has (2 or more; odd
    /// where glued), [`Error::Limit`] for sizes beyond the limits, [`Error::Cancelled`].
    pub fn resize(&self, image: &GeometryImage, width: usize, height: usize, task: &Task<'_>) -> Result<Resized> {
        self.check()?;
        if image.seam_count() > 0 || image.holes().is_some() {
            return Err(Error::Parameter("an image with seams or holes; images are resized that have neither".into()));
        }
        let gluing = image.gluing();
        let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        if width == 0 || height == 0 {
            return Err(Error::Parameter(format!("a target of {width} x {height} samples; each side must be 2 or more")));
        }
        gluing.check(Shape::new(side(width), side(height))?)?;
        let samples = (width as u64 * height as u64).max(image.points().len() as u64);
        let (wanted, allowed) = (samples.saturating_mul(BYTES_A_SAMPLE), self.limits.memory);
        if wanted > allowed {
            return Err(Error::Limit { which: "memory", wanted, allowed });
        }
        if (width, height) == (image.width(), image.height()) {
            return Ok(Resized { image: image.clone(), sizes: Vec::new(), folded: 0, places: None });
        }
        self.run(image, (width, height), gluing, task)
    }

    fn run(&self, image: &GeometryImage, target: Size, gluing: Gluing, task: &Task<'_>) -> Result<Resized> {
        let energy = if self.literal { Energy::Paper } else { Energy::Robust };
        let floor = |robust: f64| if self.literal { FLOOR_LITERAL } else { robust };
        let alpha = self.effective_alpha().unwrap_or(Self::ALPHA);
        let even = |by: Interpolation| (downsample(image, target.0, target.1, by), 0);
        let (points, folded) = match self.method {
            ResizeMethod::Content => {
                let (lambda, steps, floor) = (self.effective_lambda(), self.steps, floor(FLOOR));
                let how = Progress { alpha, lambda, steps, energy, floor, literal: self.literal };
                let done = progressive(image, target, &how, task)?;
                let image = GeometryImage::new(target.0, target.1, gluing, done.points)?;
                let sizes = done.sizes.iter().map(|&(width, height)| [width, height]).collect();
                return Ok(Resized { image, sizes, folded: done.folded, places: done.places });
            }
            ResizeMethod::Nearest => even(Interpolation::Nearest),
            ResizeMethod::Bilinear => even(Interpolation::Bilinear),
            ResizeMethod::Bicubic => even(Interpolation::Bicubic),
            ResizeMethod::Seam => (carve(image, target, alpha, energy, task)?, 0),
            ResizeMethod::Direct => direct(image, target, alpha, energy, floor(FLOOR_DIRECT), task)?,
        };
        let image = GeometryImage::new(target.0, target.1, gluing, points)?;
        Ok(Resized { image, sizes: vec![[target.0, target.1]], folded, places: None })
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_images::{bump, pillow};
    use super::*;

    fn all() -> impl Iterator<Item = ResizeOptions> {
        let options = ResizeMethod::ALL.into_iter().map(ResizeOptions::new);
        let literal = [ResizeMethod::Content, ResizeMethod::Seam, ResizeMethod::Direct];
        options.chain(literal.into_iter().map(|method| ResizeOptions::new(method).literal(true)))
    }

    #[test]
    fn every_method_makes_images_of_the_size_asked_for_whose_border_stays() {
        for options in all() {
            for (image, target) in [(bump(25, 31, 0.4), (11, 17)), (bump(12, 9, 0.4), (17, 9)), (pillow(25, 25), (13, 9))] {
                let resized = options.resize(&image, target.0, target.1, &Task::default()).unwrap();
                let small = &resized.image;
                assert_eq!((small.width(), small.height(), small.gluing()), (target.0, target.1, image.gluing()));
                assert_eq!(resized.sizes.last(), Some(&[target.0, target.1]));
                if image.gluing() == Gluing::Open && !options.literal && options.method != ResizeMethod::Direct {
                    for row in 0..target.1 {
                        let ends = [small.point(row, 0)[0], small.point(row, target.0 - 1)[0] - 1.0];
                        assert!(ends.iter().all(|end| end.abs() < 1e-12), "{options:?}: {ends:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn an_image_that_has_the_size_already_is_returned_as_it_is() {
        for options in all() {
            for image in [bump(13, 11, 0.4), pillow(9, 11)] {
                let same = options.resize(&image, image.width(), image.height(), &Task::default()).unwrap();
                assert_eq!((same.image, same.sizes.len()), (image, 0));
            }
        }
    }

    #[test]
    fn what_no_image_can_be_is_refused_and_says_why() {
        let refused = |options: &ResizeOptions, image: &GeometryImage, width, height| {
            options.resize(image, width, height, &Task::default()).expect_err("refused").to_string()
        };
        let (open, glued, default) = (bump(9, 9, 0.1), pillow(9, 9), ResizeOptions::default());
        assert!(refused(&default, &open, 0, 5).contains("0 x 5"));
        assert!(refused(&default, &open, 5, 1).contains("2 or more"));
        assert!(refused(&default, &glued, 5, 4).contains("odd"));
        assert!(refused(&default, &glued, 1, 1).contains("3 or more"));
        assert!(refused(&default, &open, 1 << 21, 5).contains("1048576"));
        let limit = default.resize(&open, 1 << 15, 1 << 15, &Task::default());
        assert!(matches!(limit, Err(Error::Limit { which: "memory", .. })));
        for (options, why) in [
            (default.clone().alpha(1.5), "alpha is 1.5"),
            (default.clone().alpha(f64::NAN), "alpha is NaN"),
            (default.clone().lambda(1.0), "lambda is 1"),
            (default.clone().steps(0), "0 steps"),
            (default.clone().steps(3).lambda(0.1), "not both"),
            (ResizeOptions::new(ResizeMethod::Seam).steps(3), "makes no steps"),
            (ResizeOptions::new(ResizeMethod::Bicubic).alpha(0.5), "weighs no energy"),
            (ResizeOptions::new(ResizeMethod::Nearest).literal(true), "literal"),
        ] {
            let text = refused(&options, &open, 5, 5);
            assert!(text.contains(why), "{text}");
        }
    }

    #[test]
    fn the_history_tells_method_sizes_shares_and_steps() {
        let image = bump(30, 20, 0.3);
        let told =
            |options: &ResizeOptions| options.history(&image, &options.resize(&image, 20, 15, &Task::default()).unwrap());
        let by = ResizeOptions::new;
        assert_eq!(
            told(&by(ResizeMethod::Content).alpha(0.25)),
            "resized from 30 x 20 to 20 x 15 by content, alpha 0.25, 2 steps: 24 x 17, 20 x 15"
        );
        assert_eq!(told(&by(ResizeMethod::Bicubic)), "resized from 30 x 20 to 20 x 15 by bicubic");
        assert!(told(&by(ResizeMethod::Content).literal(true)).contains("by content as printed, alpha 0.5, lambda 0.1, "));
        assert!(!told(&by(ResizeMethod::Seam)).contains("folded"));
    }

    #[test]
    fn a_task_that_is_over_stops_every_method_that_takes_long() {
        let flag = std::sync::atomic::AtomicBool::new(true);
        let task = Task::default().with_cancel(&flag);
        for method in [ResizeMethod::Content, ResizeMethod::Seam, ResizeMethod::Direct] {
            let stopped = ResizeOptions::new(method).resize(&bump(30, 30, 0.3), 10, 10, &task);
            assert!(matches!(stopped, Err(Error::Cancelled)), "{method:?}");
        }
    }

    #[test]
    fn results_do_not_depend_on_the_number_of_threads() {
        let image = pillow(51, 41);
        let run = || ResizeOptions::default().resize(&image, 21, 17, &Task::default()).map(|r| r.image);
        let one = crate::par::with_threads(1, run).unwrap().unwrap();
        for threads in [2, 3] {
            assert_eq!(crate::par::with_threads(threads, run).unwrap().unwrap(), one);
        }
    }
}
