//! Table 1 of the adaptive geometry images (paper 000), made anew: parametrisations, samplings and adjustment at the paper's sampling
//! rates, beside the paper's own numbers.
//!
//! `cargo run --release --example paper_table -- FOLDER` with `cathead.obj venus.off camel.ply foot.ply mannequin.ply` in the folder;
//! further arguments choose among these.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use gimc::eval::{CompareOptions, compare};
use gimc::resample::{Adjustment, Param, Resample, Sampling};
use gimc::{Error, Mesh, Task};

/// File, samples a side, and what the paper prints: psnr of regular sampling, of Zhou et al., of its own, and the Hausdorff
/// distance before and after adjustment.
const ROWS: [(&str, usize, [f64; 5]); 5] = [
    ("cathead.obj", 45, [47.1377, 47.6548, 51.7978, 0.1379, 0.0625]),
    ("venus.off", 70, [50.3154, 50.5554, 58.9261, 0.8178, 0.0577]),
    ("camel.ply", 180, [61.4743, 56.6976, 71.2418, 0.0102, 0.0055]),
    ("foot.ply", 180, [66.4185, 51.8281, 71.3321, 0.0170, 0.0129]),
    ("mannequin.ply", 300, [59.0039, 50.2263, 68.4832, 1.6027, 0.2300]),
];

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let Some(folder) = arguments.next() else {
        eprintln!("usage: paper_table FOLDER [MESH...]");
        std::process::exit(2);
    };
    let wanted: Vec<String> = arguments.collect();
    println!("| mesh, n | parametrisation | sampling | psnr | Hausdorff | adjusted: psnr | Hausdorff | seconds |");
    println!("|---|---|---|---|---|---|---|---|");
    for (file, side, [regular, zhou, ours, before, after]) in ROWS {
        let name = file.split('.').next().unwrap_or(file);
        if !wanted.is_empty() && !wanted.iter().any(|w| w == name) {
            continue;
        }
        let mesh = Mesh::open(format!("{folder}/{file}"))?;
        println!("| {name}, {side} | *paper 000* | *regular* | *{regular:.2}* | *{before}* | *{ours:.2}* | *{after}* | |");
        println!("| | *paper 000* | *Zhou et al.* | *{zhou:.2}* | | | | |");
        for (param, called) in [(Param::Tutte, "Tutte"), (Param::Yoshizawa, "Yoshizawa"), (Param::Stretch, "Newton")] {
            for (sampling, drawn) in
                [(Sampling::Regular, "regular"), (Sampling::ZHOU, "Zhou et al."), (Sampling::Equalise, "equalised")]
            {
                if param == Param::Stretch && sampling != Sampling::Regular {
                    continue;
                }
                let start = std::time::Instant::now();
                let plain = Resample::new(side).param(param).sampling(sampling);
                let (psnr, hausdorff) = measure(&mesh, &plain)?;
                let (adjusted, lowered) = measure(&mesh, &plain.adjust(Adjustment::Hausdorff))?;
                let seconds = start.elapsed().as_secs_f64();
                println!("| | {called} | {drawn} | {psnr:.2} | {hausdorff:.4} | {adjusted:.2} | {lowered:.4} | {seconds:.1} |");
            }
        }
        let (psnr, hausdorff) = measure(&mesh, &Resample::new(side).adjust(Adjustment::Fit))?;
        println!("| | Yoshizawa | regular, fitted | {psnr:.2} | {hausdorff:.4} | | | |");
    }
    Ok(())
}

/// psnr and Hausdorff distance of a mesh's geometry image.
fn measure(mesh: &Mesh, resample: &Resample) -> Result<(f64, f64), Error> {
    let task = Task::default();
    let images = resample.images(mesh, &task)?;
    let image = images.first().ok_or(Error::Parameter("no image".into()))?;
    let back = Mesh::from_triangles(image.points().to_vec(), image.triangles());
    let compared = compare(mesh, &back, &CompareOptions::default(), &task)?;
    Ok((compared.psnr, compared.hausdorff))
}
