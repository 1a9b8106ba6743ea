//! The ways that a sweep goes by itself, and those that its user brings.

use clap::builder::PossibleValue;

use super::words::{expanded, words};

/// What changes along a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Along {
    Bits,
    Rate,
    Psnr,
}

/// A way by name.
#[derive(Debug)]
pub(super) struct Way {
    pub(super) name: &'static str,
    /// Arguments of `gimc encode` that stay the same.
    fixed: &'static str,
    along: Along,
    about: &'static str,
}

/// All of them. Another is one line.
pub(super) const WAYS: &[Way] = &[
    Way { name: "surface", fixed: "", along: Along::Bits, about: "connectivity kept, the default codec; over --bits" },
    Way { name: "surface-fast", fixed: "--effort fast", along: Along::Bits, about: "the same with less time; over --bits" },
    Way { name: "surface-best", fixed: "--effort best", along: Along::Bits, about: "the same with more time; over --bits" },
    Way {
        name: "surface-metric",
        fixed: "--metric surface",
        along: Along::Psnr,
        about: "connectivity kept, vertices may slide along the surface; over --psnr",
    },
    Way { name: "mbcim", fixed: "--codec mbcim", along: Along::Bits, about: "as base colours and index map; over --bits" },
    Way { name: "raw", fixed: "--codec raw", along: Along::Bits, about: "as an image, sample by sample; over --bits" },
    Way { name: "exr", fixed: "--codec exr", along: Along::Bits, about: "as an OpenEXR picture; over --bits" },
    Way { name: "j2k", fixed: "--codec j2k", along: Along::Rate, about: "as lossy JPEG 2000; over --rate" },
    Way {
        name: "j2k-implied",
        fixed: "--codec j2k --boundaries implied",
        along: Along::Rate,
        about: "the same with the paper's cluster phase; over --rate",
    },
    Way { name: "gim", fixed: "--method gim", along: Along::Psnr, about: "sampled anew, as wavelets; over --psnr" },
    Way {
        name: "gim-quality",
        fixed: "--method gim --preset quality",
        along: Along::Psnr,
        about: "the same in less time; over --psnr",
    },
    Way { name: "gim-j2k", fixed: "--method gim --codec j2k", along: Along::Psnr, about: "as JPEG 2000; over --psnr" },
];

/// For `--help`.
pub(super) fn names() -> Vec<PossibleValue> {
    let none = PossibleValue::new("none").help("only those of --with and --peers");
    WAYS.iter().map(|way| PossibleValue::new(way.name).help(way.about)).chain([none]).collect()
}

/// A point that is wanted of every mesh.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Setting {
    /// The curve.
    pub(super) way: String,
    /// Arguments of `gimc encode`.
    pub(super) words: Vec<String>,
}

impl Way {
    /// The points of the way.
    pub(super) fn settings(&self, bits: &[String], rate: &[String], psnr: &[String]) -> Vec<Setting> {
        let (flag, values) = match self.along {
            Along::Bits => ("--bits", bits),
            Along::Rate => ("--rate", rate),
            Along::Psnr => ("--psnr", psnr),
        };
        let setting = |value: &String| {
            let fixed = self.fixed.split_whitespace().map(str::to_owned);
            Setting { way: self.name.into(), words: fixed.chain([flag.into(), value.clone()]).collect() }
        };
        values.iter().map(setting).collect()
    }
}

/// Flags whose values move a point along its curve: settings that differ in nothing else are one way.
const ALONG_A_CURVE: &[&str] =
    &["--bits", "--step", "--error", "--error-rel", "--lattice", "--psnr", "--size", "--rate", "--lossless"];

/// The points of a text such as `--codec mbcim --bits {8,10}` or `searched=--codec mbcim --search 20 --bits 9`.
///
/// Before the first `=` may stand the name of the way; without one it is the text, less lists and what else moves a point along
/// its curve.
pub(super) fn of_text(text: &str) -> Result<Vec<Setting>, String> {
    let named = text.split_once('=').filter(|(name, _)| !name.trim_start().starts_with('-') && !name.trim().is_empty());
    let (name, arguments) = match named {
        Some((name, arguments)) => (Some(name.trim().to_owned()), arguments),
        None => (None, text),
    };
    let way = match name {
        Some(name) => name,
        None => way_of(&words(&without_lists(arguments))?),
    };
    let mut settings = Vec::new();
    for line in expanded(arguments) {
        let words = words(&line)?;
        if words.is_empty() {
            return Err("arguments of `gimc encode` are expected".into());
        }
        settings.push(Setting { way: way.clone(), words });
    }
    Ok(settings)
}

/// Stands for a list.
const LIST: char = '\u{1}';

fn without_lists(line: &str) -> String {
    let list = line.find('{').and_then(|from| line[from..].find('}').map(|length| (from, from + length)));
    match list {
        Some((from, to)) => format!("{}{LIST}{}", &line[..from], without_lists(&line[to + 1..])),
        None => line.to_owned(),
    }
}

fn way_of(words: &[String]) -> String {
    let (mut kept, mut skip) = (Vec::new(), false);
    for word in words {
        let flag = word.split('=').next().unwrap_or(word);
        if std::mem::take(&mut skip) {
            continue;
        }
        if ALONG_A_CURVE.contains(&flag) {
            skip = flag == word && flag != "--lossless";
        } else if word.contains(LIST) {
            // The flag before goes with its values.
            kept.pop_if(|flag: &mut &str| !word.starts_with('-') && flag.starts_with("--"));
        } else {
            kept.push(word.as_str());
        }
    }
    if kept.is_empty() { "surface".into() } else { kept.join(" ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_that_differ_along_a_curve_are_one_way() {
        let ways = |text: &str| of_text(text).unwrap().into_iter().map(|s| (s.way, s.words.join(" "))).collect::<Vec<_>>();
        let found = ways("--method cgim --bits {9,11} --effort best");
        let way = "--method cgim --effort best".to_owned();
        assert_eq!(
            found,
            [
                (way.clone(), "--method cgim --bits 9 --effort best".into()),
                (way, "--method cgim --bits 11 --effort best".into())
            ]
        );
        assert_eq!(ways("--bits=9"), [("surface".into(), "--bits=9".into())]);
        assert_eq!(ways("j2k exact = --codec j2k --lossless"), [("j2k exact".into(), "--codec j2k --lossless".into())]);
        assert_eq!(ways("--codec j2k --lossless")[0].0, "--codec j2k");
        let [first, second] = &ways("--search {5, 9} --codec mbcim")[..] else { panic!("two points") };
        assert_eq!((&*first.0, &*second.0, &*second.1), ("--codec mbcim", "--codec mbcim", "--search 9 --codec mbcim"));
        assert_eq!(ways("--codec={mbcim,raw} --bits 9")[1], ("surface".into(), "--codec=raw --bits 9".into()));
        assert!(of_text("name=").is_err() && of_text("'open").is_err());
    }

    #[test]
    fn every_way_by_name_is_understood_by_encode() {
        let one = |text: &str| vec![text.to_owned()];
        for way in WAYS {
            let [setting] = &way.settings(&one("9"), &one("1.5"), &one("55"))[..] else { panic!("{}", way.name) };
            let (options, repair) = super::super::super::encode::asked(&setting.words).unwrap();
            assert!(
                repair.is_none() && way.name.contains(&format!("{:?}", options.codec).to_lowercase())
                    || way.along == Along::Psnr
            );
        }
    }
}
