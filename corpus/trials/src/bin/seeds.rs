//! Writes small sound files for the fuzz targets to start from.
//!
//! `cargo run -p trials --bin seeds -- fuzz/corpus`

use std::path::Path;

use gimc::{Effort, EncodeOptions, Format, Mesh};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("use: seeds FOLDER")?;
    let folder = Path::new(&folder);
    for target in ["decode", "sealed", "beside", "obj", "ply", "off", "stl", "glb", "roundtrip", "mbcim"] {
        std::fs::create_dir_all(folder.join(target))?;
    }
    for seed in 0..24_u64 {
        let shape = corpus_make::any(seed, 60);
        let mesh = Mesh::from_triangles(shape.positions, shape.triangles);
        let effort = [Effort::Fast, Effort::Default, Effort::Best][seed as usize % 3];
        let options = EncodeOptions::cgim().effort(effort);
        let options = if seed % 2 == 0 { options.bits(6) } else { options.error_relative(0.01) };
        let file = options.encode(&mesh)?;
        if let Some(noise) = trials::seal::to_noise(&file) {
            std::fs::write(folder.join(format!("sealed/{seed}")), noise)?;
        }
        std::fs::write(folder.join(format!("decode/{seed}")), file)?;
        for format in Format::ALL {
            let mut bytes = Vec::new();
            mesh.write(format, &mut bytes)?;
            std::fs::write(folder.join(format!("{format}/{seed}")), bytes)?;
        }
        std::fs::write(
            folder.join(format!("mbcim/{seed}")),
            [seed as u8, 40, 8, seed as u8, 1, seed as u8, 1, 9, 0, 30, 0, 1],
        )?;
        let choices = [&seed.to_le_bytes()[..], &[seed as u8, seed as u8, 10]].concat();
        std::fs::write(folder.join(format!("roundtrip/{seed}")), choices)?;
    }
    // One of every kind of file: regions of interest, geometry images, stages, attributes.
    for file in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../files/valid"))? {
        let file = file?;
        let (name, bytes) = (file.file_name().to_string_lossy().into_owned(), std::fs::read(file.path())?);
        if let Some(noise) = trials::seal::to_noise(&bytes) {
            std::fs::write(folder.join("sealed").join(&name), noise)?;
        }
        std::fs::write(folder.join("decode").join(&name), bytes)?;
    }
    for seed in 0..15_u8 {
        std::fs::write(folder.join(format!("beside/{seed}")), [seed % 3, seed / 3, 10 * seed])?;
    }
    Ok(())
}
