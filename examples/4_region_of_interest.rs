//! A region of interest: the same mesh with more bits, or a better psnr, where it matters.
//! `cargo run --release --example 4_region_of_interest -- [MESH]`

#![allow(clippy::print_stdout)]

use gimc::eval::{CompareOptions, compare, compare_region};
use gimc::{Decoder, EncodeOptions, Mesh, Roi, RoiPlace, Task};

fn main() -> gimc::Result<()> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "corpus/meshes/bumpy_sphere.ply".into());
    let mesh = Mesh::open(name)?;
    // Where the surface is roughest; a list of vertices, a box or a picture would do too.
    let roi = Roi::new(RoiPlace::Auto);
    for (what, options) in [
        ("exact connectivity, 8 bits", EncodeOptions::cgim().bits(8)),
        ("the same, 12 bits in the region", EncodeOptions::cgim().bits(8).roi(roi.clone().bits(12))),
        ("12 bits everywhere", EncodeOptions::cgim().bits(12)),
        ("a geometry image, 55 dB", EncodeOptions::gim().psnr(55.0)),
        ("the same, 55 dB in the region", EncodeOptions::gim().psnr(55.0).roi(roi.clone())),
    ] {
        let bytes = options.encode(&mesh)?;
        let back = Decoder::new(&bytes)?.decode()?;
        let task = Task::default();
        let whole = compare(&mesh, &back, &CompareOptions::default(), &task)?;
        let region = compare_region(&mesh, &back, &roi.place, &task)?;
        println!("{what}: {} bytes, {:.1} dB, {:.1} dB in the region", bytes.len(), whole.psnr, region.psnr);
    }
    Ok(())
}
