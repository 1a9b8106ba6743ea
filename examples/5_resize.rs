//! A mesh becomes a geometry image, and that a smaller one which keeps what matters.
//!
//! `cargo run --release --example 5_resize -- corpus/meshes/bumpy_sphere.ply small.ply`

#![allow(clippy::print_stdout)]

use gimc::eval::{self, CompareOptions};
use gimc::{Mesh, ResizeMethod, ResizeOptions, Task};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [input, output] = arguments.as_slice() else {
        return Err("use: 5_resize MESH OUT.ply".into());
    };
    let (mesh, task) = (Mesh::open(input)?, Task::default());
    let image = eval::image_of(&mesh, eval::usual_side(&mesh), &task)?;
    let [width, height] = eval::scaled_size(&image, 1.0 / 3.0);
    for method in [ResizeMethod::Bicubic, ResizeMethod::Content] {
        let small = ResizeOptions::new(method).resize(&image, width, height, &task)?.image;
        let surface = eval::surface_of(&small);
        let measured = eval::compare(&mesh, &surface, &CompareOptions::default(), &task)?;
        println!("{}: {width} x {height} samples, {:.2} dB", method.name(), measured.psnr);
        surface.write(gimc::Format::Ply, std::fs::File::create(output)?)?;
    }
    Ok(())
}
