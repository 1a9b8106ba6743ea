//! Geometry images through files, with every codec.

use gimc::{Accuracy, Codec, Decoder, EncodeOptions, GeometryImage, GimChoices, Gluing, Mesh, Task};
use trials::seal;

/// A closed surface: points of the square, each the same where the pillow's border is glued.
fn pillow(side: usize) -> GeometryImage {
    let wave = |x: f64| {
        let t = 2.0 * (x - x.floor()) - 1.0;
        4.0 * t * (1.0 - t.abs())
    };
    let at = |p: usize| {
        let (u, v) = ((p % side) as f64 / (side - 1) as f64, (p / side) as f64 / (side - 1) as f64);
        // Each is the same at (−u, 1 − v) and at (1 − u, −v).
        let even = wave(u + 0.25) * wave(v + 0.25);
        [wave((u + v) / 2.0 + 0.25), wave((u - v) / 2.0), even + 0.2 * wave(u) * wave(v)]
    };
    GeometryImage::new(side, side, Gluing::Orbifold, (0..side * side).map(at).collect()).unwrap()
}

/// A sheet with hills.
fn sheet(width: usize, height: usize) -> GeometryImage {
    let at = |p: usize| {
        let (x, y) = ((p % width) as f64 / (width - 1) as f64, (p / width) as f64 / (height - 1) as f64);
        let hill = |a: f64, b: f64, w: f64| 1.0 / (1.0 + ((x - a) * (x - a) + (y - b) * (y - b)) / w);
        [1000.0 + x, 0.7 * y, 0.3 * hill(0.3, 0.4, 0.02) - 0.2 * hill(0.8, 0.7, 0.01)]
    };
    GeometryImage::new(width, height, Gluing::Open, (0..width * height).map(at).collect()).unwrap()
}

const CODECS: [Codec; 4] = [Codec::Wavelet, Codec::J2k, Codec::Raw, Codec::Exr];

fn encoded(image: &GeometryImage, options: &EncodeOptions) -> Vec<u8> {
    options.encode_image(image, None, Task::default()).unwrap().bytes
}

fn psnr(image: &GeometryImage, back: &Mesh) -> f64 {
    let mut original = Mesh::from_triangles(image.points().to_vec(), image.triangles());
    original.precision = gimc::Scalar::F64;
    gimc::eval::compare(&original, back, &Default::default(), &Task::default()).unwrap().psnr
}

#[test]
fn a_file_reaches_the_psnr_asked_for_says_so_and_keeps_its_bound() {
    for (image, codecs) in [(pillow(17), &CODECS[..2]), (sheet(20, 27), &CODECS[2..])] {
        for &codec in codecs {
            let mut last = 0;
            for target in [45.0, 60.0] {
                let bytes = encoded(&image, &EncodeOptions::gim().codec(codec).psnr(target));
                let file = Decoder::new(&bytes).unwrap();
                let stated = file.info().psnr.unwrap();
                let back = file.decode().unwrap();
                let measured = psnr(&image, &back);
                assert!(stated >= target - 0.01 && (measured - stated).abs() < 0.1, "{codec:?}: {measured}, {stated} stated");
                assert!(bytes.len() > last, "{codec:?}");
                last = bytes.len();
                let original = Mesh::from_triangles(image.points().to_vec(), image.triangles());
                let verified = gimc::eval::verify(&bytes, Default::default(), Some(&original), Task::default()).unwrap();
                assert!(verified.passed(), "{codec:?}: {:?}", verified.first_failure());
            }
        }
    }
}

#[test]
fn the_wavelet_takes_fewer_bytes_than_the_others() {
    let image = sheet(65, 65);
    let sizes = CODECS.map(|codec| encoded(&image, &EncodeOptions::gim().codec(codec).psnr(60.0)).len());
    assert!(sizes[1..].iter().all(|&size| sizes[0] < size), "{sizes:?}");
}

#[test]
fn every_level_of_a_closed_image_is_a_closed_mesh() {
    let bytes = encoded(&pillow(65), &EncodeOptions::gim().step(0.01));
    let levels = Decoder::new(&bytes).unwrap().info().levels;
    assert_eq!(levels, 4);
    for level in 0..=levels {
        let mesh = Decoder::new(&bytes).unwrap().level(level).decode().unwrap();
        let side = 64_usize >> level;
        assert_eq!((mesh.positions.len(), mesh.faces.len()), (side * side + 2, 2 * side * side));
        let seen = mesh.inspect();
        assert!(seen.is_manifold() && seen.boundary_loops == 0 && seen.components == 1, "level {level}: {seen:?}");
    }
}

#[test]
fn every_surface_keeps_its_handles_and_holes_through_a_file_and_at_every_level() {
    for (name, codecs) in
        [("genus_5", &CODECS[..]), ("torus_with_holes", &CODECS[..]), ("components", &CODECS[..1]), ("block", &CODECS[..1])]
    {
        let mesh = Mesh::open(format!("{}/corpus/meshes/{name}.ply", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let before = mesh.inspect();
        let mut choices = GimChoices::quality();
        choices.grid = gimc::Grid::Side(129);
        for &codec in codecs {
            let step = 0.002 * before.diagonal;
            let options = EncodeOptions::gim().codec(codec).accuracy(Accuracy::Step(step)).gim_choices(choices.clone());
            let bytes = options.encode(&mesh).unwrap();
            let info = Decoder::new(&bytes).unwrap().info().clone();
            assert_eq!(info.images, before.components, "{name}");
            for level in 0..=info.levels {
                let seen = Decoder::new(&bytes).unwrap().level(level).decode().unwrap().inspect();
                assert!(seen.is_manifold() && seen.components == before.components, "{name}, level {level}: {seen:?}");
                if level == 0 || before.boundary_loops == 0 {
                    assert_eq!(
                        (seen.genus, seen.boundary_loops),
                        (before.genus, before.boundary_loops),
                        "{name}, level {level}"
                    );
                }
            }
            let verified = gimc::eval::verify(&bytes, Default::default(), Some(&mesh), Task::default()).unwrap();
            assert!(verified.passed(), "{name}, {codec:?}: {:?}", verified.first_failure());
        }
    }
}

#[test]
fn damage_to_seams_holes_and_several_images_does_no_harm() {
    for name in ["torus_with_holes", "components"] {
        let mesh = Mesh::open(format!("{}/corpus/meshes/{name}.ply", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let mut choices = GimChoices::quality();
        choices.grid = gimc::Grid::Side(17);
        let file = EncodeOptions::gim().accuracy(Accuracy::Step(0.1)).gim_choices(choices).encode(&mesh).unwrap();
        for (i, (_, payload)) in seal::open(&file).iter().enumerate().take(3) {
            for at in 0..payload.len().min(60) {
                drop(trials::decode(&seal::changed(&file, |chunks| chunks[i].1.truncate(at))));
                for bit in 0..8 {
                    drop(trials::decode(&seal::changed(&file, |chunks| chunks[i].1[at] ^= 1 << bit)));
                }
            }
        }
    }
}

#[test]
fn sizes_and_errors_are_kept() {
    let image = sheet(65, 65);
    for size in [200, 500, 2000] {
        let bytes = encoded(&image, &EncodeOptions::gim().size(size));
        assert!(bytes.len() as u64 <= size && bytes.len() as u64 * 10 > size * 9, "{} of {size} bytes", bytes.len());
    }
    assert!(EncodeOptions::gim().size(30).encode_image(&image, None, Task::default()).is_err());
    for error in [0.01, 0.001] {
        let bytes = encoded(&image, &EncodeOptions::gim().error(error));
        let bound = Decoder::new(&bytes).unwrap().info().bound;
        assert!(bound <= error * 1.01, "{bound} of {error}");
    }
}

#[test]
fn a_history_is_told_and_damage_does_no_harm() {
    let mut choices = GimChoices::default();
    choices.history = Some("sampled by hand; resized to 17 x 17".into());
    for codec in CODECS {
        let options = EncodeOptions::gim().codec(codec).accuracy(Accuracy::Step(0.02)).gim_choices(choices.clone());
        let file = encoded(&pillow(17), &options);
        assert_eq!(Decoder::new(&file).unwrap().info().history, choices.history);
        for (i, (_, payload)) in seal::open(&file).iter().enumerate() {
            for end in 0..payload.len().min(300) {
                drop(trials::decode(&seal::changed(&file, |chunks| chunks[i].1.truncate(end))));
                for bit in 0..8 {
                    drop(trials::decode(&seal::changed(&file, |chunks| chunks[i].1[end] ^= 1 << bit)));
                }
            }
        }
    }
}

#[test]
fn an_image_gives_one_file_for_any_number_of_threads() {
    let image = pillow(17);
    let made = [1, 2, 3].map(|n| gimc::with_threads(n, || encoded(&image, &EncodeOptions::gim().psnr(60.0))).unwrap());
    assert!(made[0] == made[1] && made[0] == made[2]);
}

#[test]
fn what_is_for_the_other_method_is_refused() {
    let image = sheet(9, 9);
    let refused = |options: EncodeOptions| options.encode_image(&image, None, Task::default()).unwrap_err().to_string();
    assert!(refused(EncodeOptions::gim().codec(Codec::Surface)).contains("wavelet"));
    assert!(refused(EncodeOptions::cgim()).contains("method gim"));
    assert!(refused(EncodeOptions::gim().psnr(-3.0)).contains("psnr"));
    let mesh = Mesh::from_triangles(image.points().to_vec(), image.triangles());
    assert!(EncodeOptions::cgim().psnr(60.0).encode(&mesh).is_err());
    assert!(EncodeOptions::cgim().codec(Codec::Wavelet).encode(&mesh).is_err());
    assert!(EncodeOptions::cgim().gim_choices(GimChoices::paper()).encode(&mesh).is_err());
    let file = EncodeOptions::cgim().encode(&mesh).unwrap();
    assert!(Decoder::new(&file).unwrap().geometry_image().is_err());
}
