//! The flags of `gimc encode` about attributes.

use clap::{Args, ValueEnum};
use gimc::{AttributeChoices, Precision};

use super::positive;

/// Which attributes are kept, and how exact.
#[derive(Debug, Args)]
#[command(next_help_heading = "Attributes")]
pub(super) struct AttributeFlags {
    /// Which are kept, with commas between.
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',', default_value = "all")]
    attributes: Vec<Wanted>,
    /// Bits of normals: 2 to 20, or exact [default: 10].
    #[arg(long, value_name = "Q", value_parser = precision)]
    normal_bits: Option<Precision>,
    /// Bits of texture coordinates: 1 to 24 on their longest range, or exact [default: 12].
    #[arg(long, value_name = "Q", value_parser = precision, group = "uv accuracy")]
    uv_bits: Option<Precision>,
    /// A step for texture coordinates.
    #[arg(long, value_name = "S", value_parser = positive, group = "uv accuracy")]
    uv_step: Option<f64>,
    /// Bits of colours that are floats, or exact; integers stay as they are [default: 8].
    #[arg(long, value_name = "Q", value_parser = precision)]
    colour_bits: Option<Precision>,
    /// Bits of all other floats, or exact [default: 16].
    #[arg(long, value_name = "Q", value_parser = precision, group = "scalar accuracy")]
    scalar_bits: Option<Precision>,
    /// A step for all other floats.
    #[arg(long, value_name = "S", value_parser = positive, group = "scalar accuracy")]
    scalar_step: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Wanted {
    /// All that the mesh has.
    All,
    /// None.
    None,
    /// Normals.
    Normals,
    /// Texture coordinates.
    Uv,
    /// Colours.
    Colours,
    /// Everything else with a name.
    Scalars,
    /// Objects, groups, materials and smoothing.
    #[value(alias = "materials")]
    Groups,
}

/// `exact`, or bits.
fn precision(text: &str) -> Result<Precision, String> {
    if text == "exact" {
        return Ok(Precision::Exact);
    }
    match text.parse() {
        Ok(bits) if (1..=24).contains(&bits) => Ok(Precision::Bits(bits)),
        _ => Err("1 to 24, or exact, is expected".into()),
    }
}

impl AttributeFlags {
    pub(super) fn choices(&self) -> AttributeChoices {
        let mut choices = AttributeChoices::default();
        let step = |bits: Option<Precision>, step: Option<f64>| bits.or(step.map(Precision::Step));
        let are_wanted = |what: Wanted| self.attributes.iter().any(|&w| w == what || w == Wanted::All);
        let pick = |what, given: Option<Precision>, default| if are_wanted(what) { given.or(default) } else { None };
        choices.normals = pick(Wanted::Normals, self.normal_bits, choices.normals);
        choices.uv = pick(Wanted::Uv, step(self.uv_bits, self.uv_step), choices.uv);
        choices.colours = pick(Wanted::Colours, self.colour_bits, choices.colours);
        choices.scalars = pick(Wanted::Scalars, step(self.scalar_bits, self.scalar_step), choices.scalars);
        choices.groups = are_wanted(Wanted::Groups);
        choices
    }
}
