//! Every file of `tests/corpus` loads and renders to its image in `tests/golden/corpus`.
//! `CAUSTICS_BLESS=1 cargo test --workspace --test architecture corpus` writes the images: look at them before you
//! commit them.

use caustics::render_config::Paths;
use std::path::{Path, PathBuf};

use caustics::accumulation::Accumulation;
use caustics::image_file::Channels;
use caustics::output::exr;
use caustics::scene::{CameraChoice, DefaultLight, LoadOptions, Staged, Staging};
use caustics::{RenderConfig, RenderedImage, Session};
use caustics_kernels::interface::choice::PixelFilter;
use caustics_tests::failed_image;

const SIZE: (usize, usize) = (32, 18);
/// Frames of an image: enough to see a wrong texture or normal through the noise, which is the same each time.
const FRAMES: u32 = 4;
/// Time of the pose (s): in the middle of the animations.
const TIME: f64 = 0.5;
/// Relative difference by last bits, which vary between processors and compilers.
const SAME: f32 = 1e-3;
/// Pixels that may differ because a last bit sends a path elsewhere: 0.2 % per frame, as in the parity tests, rounded
/// up to 1 %.
const STRAYS: usize = SIZE.0 * SIZE.1 / 100;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Renders the image of a file, with a default light where it has none.
fn image(path: &Path) -> RenderedImage {
    let aspect = SIZE.0 as f64 / SIZE.1 as f64;
    let staging = Staging {
        camera: CameraChoice::First,
        load: LoadOptions::default(),
        edits: None,
        environment: None,
        default_light: DefaultLight::Auto,
        aspect,
    };
    let Staged { mut scene, camera, .. } =
        staging.load(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    scene.pose(TIME).expect("a pose");
    let config = RenderConfig {
        width: SIZE.0 as u32,
        height: SIZE.1 as u32,
        light_paths: Paths::Count(2000),
        pixel_filter: PixelFilter::Box,
        ..RenderConfig::default()
    };
    let mut session = Session::builder(&scene).camera(&camera).config(config).build().expect("a session");
    let mut sums = Accumulation::default();
    for frame in 0..FRAMES {
        session.frame(frame).expect("a frame");
        sums.add(&session.image().expect("its image"));
    }
    let mean = sums.mean();
    RenderedImage { width: SIZE.0, height: SIZE.1, path: mean.beauty(), ..RenderedImage::default() }
}

/// The values of the beauty layer, pixel by pixel.
fn values(bytes: &[u8]) -> Vec<[f32; 3]> {
    let channels = Channels::decode(bytes).expect("an image");
    assert_eq!((channels.width, channels.height), SIZE);
    let [r, g, b] = channels.layer("").expect("a beauty layer");
    r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect()
}

/// Number of pixels that differ by more than last bits, relative to the pixel plus the image's mean.
fn differing(ours: &[[f32; 3]], golden: &[[f32; 3]]) -> usize {
    let mean = golden.iter().flatten().sum::<f32>() / (3 * golden.len()) as f32;
    // NaN differs, because it compares false.
    let same = |a: f32, b: f32| (a - b).abs() <= SAME * (a.abs().max(b.abs()) + mean);
    ours.iter().zip(golden).filter(|(a, b)| !(0..3).all(|channel| same(a[channel], b[channel]))).count()
}

pub fn files() -> Vec<PathBuf> {
    let entries =
        folder("corpus").read_dir().expect("the corpus").map(|entry| entry.expect("an entry").path());
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|end| end == "gltf" || end == "glb");
    let mut files: Vec<_> = entries.filter(is_scene).collect();
    files.sort();
    files
}

#[test]
fn every_file_of_the_corpus_renders_to_its_golden_image() {
    let golden = folder("golden/corpus");
    let blesses = std::env::var_os("CAUSTICS_BLESS").is_some();
    let mut wrong = Vec::new();
    let files = files();
    for path in &files {
        let name = path.file_name().expect("a name").to_string_lossy();
        let bytes = exr::encode(&image(path), None, &Default::default()).expect("an EXR file");
        let file = golden.join(format!("{name}.exr"));
        if blesses {
            std::fs::create_dir_all(&golden).expect("a folder");
            std::fs::write(&file, &bytes).expect("a golden image");
        }
        let ours = values(&bytes);
        assert!(ours.iter().flatten().all(|value| value.is_finite()), "{name}");
        let lit = ours.iter().flatten().filter(|value| **value > 0.0).count();
        assert!(lit > 0, "{name} is black");
        let there = std::fs::read(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let count = differing(&ours, &values(&there));
        if count > STRAYS {
            let gray = |pixels: &[[f32; 3]]| -> Vec<f64> {
                pixels.iter().map(|pixel| f64::from(pixel.iter().sum::<f32>()) / 3.0).collect()
            };
            let maps = failed_image::write(&name, SIZE.0, &gray(&ours), &gray(&values(&there)), &[]);
            wrong.push(format!("{name}: {count} pixels, maps in {}", maps.display()));
        }
    }
    assert!(files.len() >= caustics_scenes::corpus::ALL.len());
    assert!(wrong.is_empty(), "differ from tests/golden/corpus: {}", wrong.join(", "));
    // Reject images of files that no longer exist.
    assert_eq!(golden.read_dir().expect("a folder").count(), files.len());
}

#[test]
fn detects_changes_of_a_golden_image() {
    let golden =
        |name: &str| values(&std::fs::read(folder("golden/corpus").join(name)).expect("a golden image"));
    let plain = golden("plain.gltf.exr");
    assert_eq!(differing(&plain, &plain), 0);
    // Brighten, tint, shift by a column, patch 4 x 4 pixels, set to NaN, and take two other files.
    let brighter: Vec<_> = plain.iter().map(|color| color.map(|value| 1.01 * value)).collect();
    let tinted: Vec<_> = plain.iter().map(|&[r, g, b]| [r, g, 0.98 * b]).collect();
    let mut moved = plain.clone();
    moved.rotate_right(1);
    let mut patched = plain.clone();
    for pixel in 0..16 {
        patched[(8 + pixel / 4) * SIZE.0 + 14 + pixel % 4] = [0.5; 3];
    }
    let broken = vec![[f32::NAN; 3]; plain.len()];
    for other in [
        brighter,
        tinted,
        moved,
        patched,
        broken,
        golden("no-normals.gltf.exr"),
        golden("several-scenes.gltf.exr"),
    ] {
        let count = differing(&other, &plain);
        assert!(count > STRAYS, "{count}");
    }
}
