//! What `gimc encode` can be told about geometry images.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use gimc::{GeometryImage, GimChoices, Gluing, Grid, Lattice, Limits};

use super::failure::Failure;
use super::input;

/// Flags of the method gim.
#[derive(Debug, Args)]
#[command(next_help_heading = "Geometry images")]
pub(super) struct GimFlags {
    /// Samples a side: a number, best of the form 2^k + 1 or 3 · 2^k + 1; columns and rows, such as 129x97; or auto [default: auto, as
    /// many as the target needs].
    #[arg(long, value_name = "N|WxH", value_parser = grid)]
    grid: Option<Grid>,
    /// The papers' own choices, a fast good one, or the smallest file [default]; the next four flags change parts of it.
    #[arg(long, value_enum)]
    preset: Option<Preset>,
    /// How the surface is flattened.
    #[arg(long, value_enum)]
    param: Option<Param>,
    /// What becomes the border of the image, where the surface has one.
    #[arg(long, value_enum)]
    border: Option<Border>,
    /// Where samples are taken.
    #[arg(long, value_enum)]
    sampling: Option<Sampling>,
    /// Where samples are moved.
    #[arg(long, value_enum)]
    adjust: Option<Adjust>,
    /// How the border of a picture is glued [default: as its samples show].
    #[arg(long, value_enum)]
    gluing: Option<GluingName>,
    /// The mesh that a picture was sampled from: errors are measured against it [default: the surface of the picture].
    #[arg(long, value_name = "MESH")]
    pub(super) original: Option<PathBuf>,
    /// How the image came about, to be told by `info`.
    #[arg(long, value_name = "TEXT")]
    history: Option<String>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Preset {
    /// --param yoshizawa --border square --adjust hausdorff.
    Paper,
    /// --param yoshizawa --adjust fit.
    Quality,
    /// --param stretch --adjust rate.
    Compact,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Param {
    /// Every vertex is the mean of its neighbours.
    Tutte,
    /// Neighbours weigh by mean-value coordinates.
    Meanvalue,
    /// Weights follow the stretch.
    Yoshizawa,
    /// Newton's method on the stretch.
    Stretch,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Border {
    /// The longest boundary loop if it is long for the surface; else loops are holes in a closed surface.
    Auto,
    /// Always the longest boundary loop.
    Square,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Sampling {
    /// At equal distances.
    Regular,
    /// Drawn towards the vertices.
    Zhou,
    /// On lines between which there are equally many vertices.
    Equalise,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Adjust {
    /// Nowhere: they lie on the surface.
    None,
    /// Against the gradient of the Hausdorff distance.
    Hausdorff,
    /// Along their normals, to a smaller mean distance.
    Fit,
    /// Also along the surface, to where they cost fewer bytes.
    Rate,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum GluingName {
    /// Not at all: a disk.
    Open,
    /// Each half of a side to its other half: a closed surface.
    Orbifold,
}

/// `auto`, a number, or two with an x between.
fn grid(text: &str) -> Result<Grid, String> {
    let side = |text: &str| text.parse().ok().filter(|side| (3..=8193).contains(side));
    let grid = match text.split_once(['x', 'X']) {
        _ if text == "auto" => Some(Grid::Auto),
        Some((columns, rows)) => side(columns).zip(side(rows)).map(|(columns, rows)| Grid::Size(columns, rows)),
        None => side(text).map(Grid::Side),
    };
    grid.ok_or_else(|| "auto, a whole number of samples from 3 to 8193, or two such as 129x97 are expected".into())
}

impl GimFlags {
    pub(super) fn choices(&self) -> GimChoices {
        let mut choices = match self.preset {
            Some(Preset::Paper) => GimChoices::paper(),
            Some(Preset::Quality) => GimChoices::quality(),
            None | Some(Preset::Compact) => GimChoices::compact(),
        };
        choices.grid = self.grid.unwrap_or(choices.grid);
        choices.param = match self.param {
            None => choices.param,
            Some(Param::Tutte) => gimc::Param::Tutte,
            Some(Param::Meanvalue) => gimc::Param::MeanValue,
            Some(Param::Yoshizawa) => gimc::Param::Yoshizawa,
            Some(Param::Stretch) => gimc::Param::Stretch,
        };
        choices.border = match self.border {
            None => choices.border,
            Some(Border::Auto) => gimc::Border::Auto,
            Some(Border::Square) => gimc::Border::Square,
        };
        choices.sampling = match self.sampling {
            None => choices.sampling,
            Some(Sampling::Regular) => gimc::Sampling::Regular,
            Some(Sampling::Zhou) => gimc::Sampling::ZHOU,
            Some(Sampling::Equalise) => gimc::Sampling::Equalise,
        };
        choices.adjust = match self.adjust {
            None => choices.adjust,
            Some(Adjust::None) => gimc::Adjust::None,
            Some(Adjust::Hausdorff) => gimc::Adjust::Hausdorff,
            Some(Adjust::Fit) => gimc::Adjust::Fit,
            Some(Adjust::Rate) => gimc::Adjust::Rate,
        };
        choices.history = self.history.clone();
        choices
    }

    /// The geometry image of a picture; `lattice` is what the samples of a PNG stand for.
    pub(super) fn picture(&self, file: &Path, lattice: Option<Lattice>) -> Result<GeometryImage, Failure> {
        let bytes = input::bytes(file)?;
        let gluing = self.gluing.map(|gluing| match gluing {
            GluingName::Open => Gluing::Open,
            GluingName::Orbifold => Gluing::Orbifold,
        });
        GeometryImage::from_picture(&bytes, lattice, gluing, Limits::default())
            .map_err(|e| Failure::in_file(&input::name(file), e))
    }

    /// Refuses, for a mesh, flags that are for pictures.
    pub(super) fn check_mesh(&self, file: &str) -> Result<(), Failure> {
        if self.gluing.is_none() && self.original.is_none() {
            return Ok(());
        }
        Err(Failure::wrong_use(format!("{file} is no picture, and --gluing and --original are for pictures"), None))
    }
}

/// Whether a file is a picture by its name.
pub(super) fn is_picture(file: &Path) -> bool {
    let extension = file.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    matches!(extension.as_deref(), Some("exr" | "png"))
}
