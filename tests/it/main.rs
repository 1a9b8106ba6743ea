//! All integration tests, as modules of one binary: one link and not ten.

#![allow(clippy::unwrap_used)] // what a test does not expect should fail it

mod any_mesh;
mod attributes;
mod cli;
mod conformance;
mod corpus;
mod determinism;
mod grids;
mod images;
mod inspect;
mod io;
mod layers;
mod resize;
mod robustness;
mod roi;
mod roundtrip;
mod sliding;
mod spec;
mod stages;
mod sweep;
