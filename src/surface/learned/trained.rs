//! Where learning starts: weights that fit meshes in general.
//!
//! Medians (of predictions and scales) and means (of mixing) over what the coders had learned at the
//! end of 26 meshes of all kinds, scans, CAD models and terrains, at 8, 11 and 14 bits, rounded to
//! hundredths. They are part of the format. On meshes left out of the training they save 0.9 % of
//! the positions on average and 3 to 5 % where a mesh has a few hundred vertices.

use super::contexts;
use super::features;
use crate::entropy::Start as Mixing;

/// The first weights of a coder with `F` features, `N` contexts and `E` densities.
pub(super) struct Start<const F: usize, const N: usize, const E: usize> {
    /// By class: of the features.
    pub(super) predictions: [[f64; F]; 5],
    /// By class: of the logarithms, across the normal and along it.
    pub(super) scales: [[[f64; 16]; 2]; 5],
    /// By class: of the learned shift and the local suggestion.
    pub(super) blends: [[f64; 2]; 5],
    /// Of contexts, densities and the constant: before and after the sign is known.
    pub(super) mixing: [Mixing<N, E>; 2],
}

/// Effort `default`.
#[rustfmt::skip]
pub(super) static LEAN: Start<{ features::LEAN }, { contexts::LEAN }, 1> = Start {
    predictions: [
        [0.31, 0.07, 0.11, 0.11, 0.02, 0.03, -0.01, -0.03, -0.04, 0.0, 0.0, 0.0, 0.07, 0.07, 0.01, -0.04, 0.03, -0.01, -0.01, 0.02, 0.0, 0.0, 0.0, 0.0],
        [0.61, 0.04, 0.16, 0.04, -0.01, 0.05, -0.04, -0.01, 0.01, 0.0, 0.0, -0.09, 0.09, 0.04, 0.0, -0.16, 0.01, -0.01, 0.02, 0.0, -0.01, 0.01, -0.01, 0.01],
        [0.14, 0.08, 0.10, 0.05, 0.0, 0.01, 0.0, -0.02, 0.0, 0.0, -0.03, -0.10, 0.03, 0.04, 0.01, -0.01, 0.01, -0.02, -0.01, 0.0, 0.0, 0.0, -0.01, 0.01],
        [0.0, 0.01, 0.01, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.01, -0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.02, 0.04, 0.03, 0.02, 0.02, 0.01, 0.0, 0.0, -0.01, -0.01, 0.0, -0.01, 0.0, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.01, 0.01, 0.0, 0.0, 0.01],
    ],
    scales: [
        [
            [0.0, 0.0, 0.11, 0.17, 0.0, 0.0, 0.02, 0.0, 0.09, -0.02, 0.04, 0.05, 0.07, 0.03, 0.34, 0.01],
            [0.01, 0.13, 0.01, 0.0, -0.01, -0.01, 0.04, -0.05, -0.11, 0.39, 0.02, 0.03, 0.01, 0.07, 0.43, -0.04],
        ],
        [
            [-0.40, 0.02, 0.11, 0.17, 0.0, 0.07, 0.06, 0.0, 0.06, -0.02, 0.04, 0.02, 0.09, 0.09, 0.25, 0.0],
            [0.10, 0.20, 0.04, -0.09, -0.01, 0.03, 0.02, -0.01, -0.08, 0.31, 0.01, 0.0, 0.03, 0.15, 0.30, 0.08],
        ],
        [
            [-0.23, 0.0, 0.13, 0.11, -0.02, 0.13, 0.01, -0.01, 0.03, -0.06, 0.07, 0.08, 0.14, 0.03, 0.22, 0.02],
            [0.14, 0.14, 0.04, -0.06, 0.10, 0.03, 0.0, -0.01, -0.02, 0.25, 0.0, 0.0, 0.04, 0.12, 0.24, 0.11],
        ],
        [
            [-0.01, 0.02, 0.05, 0.04, 0.04, 0.09, 0.0, 0.02, 0.01, 0.04, 0.03, 0.08, 0.09, 0.10, 0.0, -0.05],
            [0.02, 0.04, 0.0, 0.05, 0.05, 0.03, -0.02, 0.0, 0.0, 0.06, 0.06, 0.03, 0.04, 0.02, 0.0, 0.06],
        ],
        [
            [-0.01, 0.03, 0.05, -0.01, 0.05, 0.07, -0.05, 0.0, 0.06, -0.04, 0.13, 0.16, 0.08, 0.08, -0.01, -0.01],
            [0.01, 0.07, 0.02, 0.05, 0.03, 0.11, -0.01, 0.0, -0.01, 0.13, 0.03, 0.02, 0.02, 0.02, 0.0, 0.08],
        ],
    ],
    blends: [
        [0.07, 0.19],
        [0.0, 0.18],
        [0.10, 0.14],
        [0.01, 0.0],
        [0.03, 0.04],
    ],
    mixing: [
        Mixing { contexts: [10, 10, 14, 6, 5, 8, 9, 8, 9, 6, 8, 7], experts: [52], bias: -4 },
        Mixing { contexts: [5, 7, 6, 5, 7, 6, 5, 5, 5, 5, 5, 6], experts: [40], bias: -5 },
    ],
};

/// Effort `best`.
#[rustfmt::skip]
pub(super) static ALL: Start<{ features::ALL }, { contexts::ALL }, 4> = Start {
    predictions: [
        [0.27, 0.07, 0.15, 0.11, -0.03, 0.04, -0.01, -0.03, -0.05, 0.0, 0.0, 0.0, 0.09, 0.11, 0.03, -0.03, 0.02, 0.0, -0.02, 0.01, 0.0, 0.0, 0.0, 0.0, -0.04, 0.02, 0.0, 0.01, 0.0, 0.0, -0.02, 0.04, 0.14, -0.09, -0.15, 0.05, 0.0, -0.03, 0.03, -0.06, 0.0, -0.01, 0.03],
        [0.45, 0.23, -0.10, 0.11, -0.05, 0.16, -0.04, -0.03, -0.01, -0.01, -0.02, -0.09, 0.05, 0.03, 0.06, -0.10, 0.01, -0.01, 0.01, -0.01, -0.02, 0.01, -0.01, 0.01, 0.11, 0.01, 0.01, -0.21, 0.0, 0.04, -0.01, 0.09, 0.13, -0.35, -0.10, 0.06, -0.02, 0.0, 0.08, -0.44, 0.0, -0.14, 0.02],
        [0.21, 0.17, 0.04, 0.07, -0.01, 0.03, -0.01, -0.03, -0.01, -0.01, -0.04, -0.10, 0.04, 0.05, 0.02, -0.02, 0.0, -0.01, 0.0, 0.01, 0.0, 0.0, -0.01, 0.01, 0.01, 0.01, 0.02, -0.07, 0.01, -0.02, 0.0, -0.01, 0.02, -0.13, -0.09, 0.05, -0.04, -0.01, -0.01, -0.03, -0.02, 0.0, 0.0],
        [0.01, 0.02, 0.02, 0.02, 0.01, 0.0, 0.0, 0.0, 0.0, 0.01, -0.01, -0.04, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.01, 0.01, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.01, 0.0, 0.0],
        [0.05, 0.08, 0.06, 0.04, 0.02, 0.02, 0.0, -0.01, -0.01, -0.01, 0.0, -0.02, 0.01, 0.01, 0.0, 0.0, 0.01, 0.0, 0.0, 0.01, 0.01, 0.0, 0.0, 0.01, -0.01, 0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 0.0, 0.0, -0.02, 0.0, 0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    ],
    scales: [
        [
            [0.0, 0.01, 0.11, 0.11, 0.0, 0.0, 0.05, -0.02, 0.06, -0.01, 0.02, 0.04, 0.06, 0.06, 0.21, -0.02],
            [0.01, 0.11, 0.01, 0.02, -0.01, -0.01, 0.06, -0.03, -0.07, 0.31, 0.02, 0.06, 0.03, -0.01, 0.24, -0.03],
        ],
        [
            [-0.24, 0.02, 0.11, 0.18, 0.0, 0.08, 0.07, 0.0, 0.06, -0.02, 0.04, 0.02, 0.08, 0.08, 0.23, 0.0],
            [0.08, 0.20, 0.04, -0.07, -0.01, 0.03, 0.04, -0.02, -0.08, 0.29, 0.02, -0.01, 0.04, 0.11, 0.25, 0.08],
        ],
        [
            [-0.04, 0.02, 0.16, 0.08, 0.0, 0.09, 0.02, 0.01, 0.04, -0.02, 0.08, 0.06, 0.08, 0.05, 0.10, 0.0],
            [0.01, 0.13, 0.03, 0.01, 0.09, 0.03, 0.0, 0.02, 0.02, 0.19, 0.04, 0.01, 0.05, 0.05, 0.13, 0.09],
        ],
        [
            [0.01, 0.01, 0.05, 0.07, 0.03, 0.07, 0.0, 0.01, 0.04, 0.02, 0.03, 0.05, 0.07, 0.08, 0.0, -0.04],
            [0.01, 0.03, 0.01, 0.03, 0.03, 0.02, 0.0, 0.01, 0.0, 0.04, 0.03, 0.02, 0.02, 0.04, 0.0, 0.03],
        ],
        [
            [0.01, 0.02, 0.05, 0.05, 0.03, 0.04, 0.0, 0.0, 0.04, 0.0, 0.08, 0.08, 0.06, 0.05, -0.01, -0.01],
            [0.0, 0.04, 0.02, 0.03, 0.04, 0.06, -0.02, 0.03, 0.01, 0.06, 0.02, 0.02, 0.03, 0.03, 0.0, 0.04],
        ],
    ],
    blends: [
        [0.04, 0.12],
        [-0.02, 0.16],
        [0.02, 0.08],
        [0.0, 0.01],
        [0.04, 0.02],
    ],
    mixing: [
        Mixing { contexts: [3, 9, 11, 5, 3, 8, 7, 8, 8, 6, 7, 7, -2, 1, 0, 3, 7, 3], experts: [28, 20, 9, 1], bias: -5 },
        Mixing { contexts: [4, 5, 5, 4, 4, 4, 4, 4, 4, 5, 4, 5, 2, 3, 3, 4, 4, 3], experts: [27, 10, 14, 1], bias: -3 },
    ],
};

#[cfg(test)]
mod tests {
    use super::*;

    fn line(text: &mut String, name: &str, numbers: &[f64]) {
        *text += name;
        numbers.iter().for_each(|x| *text += &format!(" {x}"));
        *text += "\n";
    }

    fn print<const F: usize, const N: usize, const E: usize>(text: &mut String, effort: &str, start: &Start<F, N, E>) {
        for class in 0..5 {
            line(text, &format!("{effort} class {class} prediction"), &start.predictions[class]);
            line(text, &format!("{effort} class {class} scale across"), &start.scales[class][0]);
            line(text, &format!("{effort} class {class} scale along"), &start.scales[class][1]);
            line(text, &format!("{effort} class {class} blend"), &start.blends[class]);
        }
        for (when, mixing) in ["before", "after"].into_iter().zip(&start.mixing) {
            line(text, &format!("{effort} {when} the sign: contexts"), &mixing.contexts.map(f64::from));
            line(text, &format!("{effort} {when} the sign: experts"), &mixing.experts.map(f64::from));
            line(text, &format!("{effort} {when} the sign: constant"), &[mixing.bias.into()]);
        }
    }

    #[test]
    fn the_weights_are_those_of_the_specification() {
        let mut made = String::new();
        print(&mut made, "default", &LEAN);
        print(&mut made, "best", &ALL);
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("spec/vectors/trained.txt");
        if std::env::var_os("GIMC_BLESS").is_some() {
            std::fs::write(&path, &made).unwrap();
        }
        assert!(std::fs::read_to_string(path).unwrap() == made, "see spec/README.md, \"Changes\"");
    }
}
