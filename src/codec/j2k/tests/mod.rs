//! What the codestreams must hold, judged by three decoders that share no code with the encoder.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // in tests, whatever the features

mod judges;
mod lossless;
mod lossy;
mod planes;
mod region;
mod robustness;
mod side_by_side;

use super::*;
use crate::limits::{Budget, Limits};
use crate::plane::{Mask, Plane, Planes, Shape};
use crate::task::Task;

fn encoded(planes: &Planes, settings: &Settings) -> Encoded {
    encode(planes, settings, &Task::default()).unwrap()
}

fn budget() -> Budget {
    Budget::new(Limits::default())
}

fn decoded(stream: &Encoded) -> Planes {
    decode(&stream.bytes, &stream.profile, &mut budget()).unwrap()
}

/// Panics, briefly, where two images differ by more than `tolerance`.
#[track_caller]
fn assert_same(found: &Planes, expected: &Planes, tolerance: i32, who: &str) {
    assert_eq!(found.shape(), expected.shape(), "{who}");
    assert_eq!(found.depths(), expected.depths(), "{who}");
    for (i, (a, b)) in found.iter().zip(expected.iter()).enumerate() {
        let differ = |(x, y): (&i32, &i32)| (x - y).abs() > tolerance;
        let count = a.samples().iter().zip(b.samples()).filter(|p| differ(*p)).count();
        if let Some(at) = a.samples().iter().zip(b.samples()).position(differ) {
            let (x, y) = (a.samples()[at], b.samples()[at]);
            panic!(
                "{who}: {count} samples of plane {i} ({}) differ by more than {tolerance}; sample {at} is {x}, not {y}",
                a.shape()
            );
        }
    }
}
