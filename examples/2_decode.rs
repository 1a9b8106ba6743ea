//! A `.gimc` file from a stranger becomes a mesh, within limits.
//!
//! `cargo run --release --example 2_decode -- sphere.gimc sphere.obj`

#![allow(clippy::print_stdout)]

use gimc::{Decoder, Limits};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [input, output] = arguments.as_slice() else {
        return Err("use: 2_decode IN.gimc MESH".into());
    };
    let bytes = std::fs::read(input)?;
    // The header is read and checked; nothing large has been made yet.
    let file = Decoder::with_limits(&bytes, Limits::default().memory(256 << 20).vertices(1_000_000))?;
    let info = file.info();
    println!("{} vertices, {} faces, within {}; needs {} bytes", info.vertices, info.faces, info.bound, info.memory);
    let mesh = file.decode()?;
    for note in mesh.save(output)? {
        println!("note: {note}");
    }
    Ok(())
}
