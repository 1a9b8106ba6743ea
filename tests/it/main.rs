//! All integration tests, as modules of one binary: one link and not ten.

mod corpus;
mod io;
mod layers;
