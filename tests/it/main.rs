//! All integration tests, as modules of one binary: one link and not ten.

mod corpus;
mod determinism;
mod io;
mod layers;
mod robustness;
mod roundtrip;
