//! A mesh file becomes a `.gimc` file.
//!
//! `cargo run --release --example 1_encode -- corpus/meshes/bumpy_sphere.ply sphere.gimc`

#![allow(clippy::print_stdout)]

use gimc::{EncodeOptions, Mesh};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [input, output] = arguments.as_slice() else {
        return Err("use: 1_encode MESH OUT.gimc".into());
    };
    let mesh = Mesh::open(input)?;
    // No point of either surface farther than a ten-thousandth of the diagonal from the other.
    let encoded = EncodeOptions::cgim().error_relative(1e-4).encode_with(&mesh, gimc::Task::default())?;
    println!("{} bytes, within {}", encoded.bytes.len(), encoded.info.bound);
    for (part, bytes) in &encoded.info.parts {
        println!("  {part}: {bytes}");
    }
    encoded.notes.iter().for_each(|note| println!("note: {note}"));
    std::fs::write(output, encoded.bytes)?;
    Ok(())
}
