//! Hashes of images: a refactoring that must change no image compares the hashes before and after it.
//!
//! ```text
//! CAUSTICS_IMAGES=/tmp/images.txt cargo test --locked --workspace --test architecture -- --ignored images::
//! ```
//!
//! The first run writes the file. Later runs compare with it, print the number of images that differ, and fail if one
//! does. Bits differ between processors and between compilers, so that no hashes are committed. All images are those of
//! the CPU runner.

mod configurations;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use caustics::RenderedImage;
use caustics::scene::{CameraChoice, DefaultLight, LoadOptions, Staged, Staging};
use caustics::session::{RunnerChoice, Session};

use self::configurations::{ASPECT, Configuration};
use super::corpus;

/// Hashes by the names of images.
type Hashes = BTreeMap<String, String>;

/// Hash of an image's layers and of the displayed image.
#[derive(Clone, Copy)]
struct Hash(u64);

impl Hash {
    /// Hash of no data: the start of FNV-1a.
    const NEW: Hash = Hash(0xcbf2_9ce4_8422_2325);

    fn layer(&mut self, values: impl ExactSizeIterator<Item = f32>) {
        let length = values.len() as u32;
        for word in [length].into_iter().chain(values.map(f32::to_bits)) {
            for byte in word.to_le_bytes() {
                self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    }

    fn image(&mut self, image: &RenderedImage) {
        let RenderedImage { width, height, path, caustics, radius, depth, photons, auxiliary } = image;
        self.layer([*width as f32, *height as f32].into_iter());
        let vectors = [path, caustics, &auxiliary.normal, &auxiliary.albedo, &auxiliary.position];
        for vectors in vectors {
            let components: Vec<f32> = vectors.iter().flat_map(|vector| vector.to_array()).collect();
            self.layer(components.into_iter());
        }
        let motion: Vec<f32> = auxiliary.motion.iter().flat_map(|motion| motion.to_array()).collect();
        for values in [radius, depth, photons, &motion, &auxiliary.depth, &auxiliary.material] {
            self.layer(values.iter().copied());
        }
    }
}

/// A scene to render images of.
struct Source {
    name: String,
    path: PathBuf,
    configurations: Vec<Configuration>,
}

/// All committed scenes in every configuration, and the files of the corpus in a few.
fn sources() -> Vec<Source> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let committed = caustics_scenes::NAMES.map(|name| Source {
        name: name.into(),
        path: scenes.join(name).join("scene.gltf"),
        configurations: configurations::all(),
    });
    let corpus = corpus::files().into_iter().map(|path| Source {
        name: format!("corpus/{}", path.file_name().expect("a name").to_string_lossy()),
        path,
        configurations: configurations::for_methods(),
    });
    committed.into_iter().chain(corpus).collect()
}

/// Renders the images of a scene, on one thread.
fn render(source: &Source) -> Result<Hashes, Box<dyn std::error::Error>> {
    let staging = Staging {
        camera: CameraChoice::First,
        load: LoadOptions::default(),
        edits: None,
        environment: None,
        default_light: DefaultLight::Auto,
        aspect: ASPECT,
    };
    let Staged { mut scene, camera, .. } = staging.load(&source.path)?;
    // Render two frames of one pose, of which only the first has a pilot. Then move by a step, and by half of the
    // animation.
    let half = 0.5 * scene.duration();
    let times = [0.0, 0.0, 1.0 / 24.0, half.max(1.0 / 12.0)];
    let mut hashes = Hashes::new();
    for Configuration { name, run } in &source.configurations {
        scene.pose(0.0)?;
        let features = run.config.features(&scene);
        let view = scene.camera(Some(&camera))?.clone();
        let cpu = RunnerChoice::Cpu { threads: 1 };
        let mut session = Session::new(&cpu, &scene, &view, &run.config, features)?;
        let mut hash = Hash::NEW;
        for (frame, time) in times.into_iter().enumerate() {
            scene.pose(time)?;
            session.pose(&scene, &scene.camera(Some(&camera))?.clone())?;
            session.frame(frame as u32)?;
            hash.image(&session.image()?);
        }
        let last = session.image()?;
        let colors = session.display(&last)?;
        hash.layer(colors.iter().flat_map(|color| color.to_array()).collect::<Vec<_>>().into_iter());
        let name = format!("{} {name}", source.name);
        if hashes.insert(name.clone(), format!("{:016x}", hash.0)).is_some() {
            return Err(format!("two images are called {name}").into());
        }
    }
    Ok(hashes)
}

/// Renders all images, one scene per core at a time.
fn render_all(sources: &[Source]) -> Hashes {
    let (next, all) = (AtomicUsize::new(0), Mutex::new(Hashes::new()));
    let work = || {
        while let Some(source) = sources.get(next.fetch_add(1, Ordering::Relaxed)) {
            let hashes = render(source).unwrap_or_else(|error| panic!("{}: {error}", source.path.display()));
            all.lock().expect("no scene failed").extend(hashes);
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
    });
    all.into_inner().expect("no scene failed")
}

/// Writes hashes as text, one per line.
fn to_text(hashes: &Hashes) -> String {
    hashes.iter().map(|(name, hash)| format!("{hash} {name}\n")).collect()
}

fn from_text(text: &str) -> Hashes {
    let line = |line: &str| line.split_once(' ').map(|(hash, name)| (name.into(), hash.into()));
    text.lines().filter_map(line).collect()
}

/// Names of images by the outcome of a comparison.
#[derive(Debug, Default, PartialEq)]
struct Comparison {
    /// Number of images in both.
    compared: usize,
    differing: Vec<String>,
    missing: Vec<String>,
    new: Vec<String>,
}

impl Comparison {
    fn new(before: &Hashes, after: &Hashes) -> Comparison {
        let absent = |from: &Hashes, all: &Hashes| {
            all.keys().filter(|name| !from.contains_key(*name)).cloned().collect::<Vec<_>>()
        };
        let mut comparison =
            Comparison { missing: absent(after, before), new: absent(before, after), ..Default::default() };
        for (name, hash) in before {
            let Some(found) = after.get(name) else { continue };
            comparison.compared += 1;
            if found != hash {
                comparison.differing.push(name.clone());
            }
        }
        comparison
    }

    /// Whether all compared images are equal. New and missing names are no failure, as long as one image is compared.
    fn is_equal(&self) -> bool {
        self.compared > 0 && self.differing.is_empty()
    }
}

impl std::fmt::Display for Comparison {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(formatter, "{} of {} images differ", self.differing.len(), self.compared)?;
        for (what, names) in [("differs", &self.differing), ("missing", &self.missing), ("new", &self.new)] {
            for name in names {
                writeln!(formatter, "  {what}: {name}")?;
            }
        }
        Ok(())
    }
}

#[test]
#[ignore = "compares with the file that CAUSTICS_IMAGES names"]
fn every_image_has_the_recorded_hash() {
    let file = std::env::var("CAUSTICS_IMAGES").expect("CAUSTICS_IMAGES names a file");
    let start = Instant::now();
    let after = render_all(&sources());
    let seconds = start.elapsed().as_secs();
    // Write to stdout directly: libtest hides the `println!` of a test that passes.
    let mut stdout = std::io::stdout();
    let Ok(before) = std::fs::read_to_string(&file) else {
        std::fs::write(&file, to_text(&after)).expect("CAUSTICS_IMAGES can be written");
        writeln!(stdout, "{file}: hashes of {} images written, {seconds} s", after.len()).expect("stdout");
        return;
    };
    let comparison = Comparison::new(&from_text(&before), &after);
    write!(stdout, "{file}, {seconds} s: {comparison}").expect("stdout");
    assert!(comparison.is_equal(), "images differ from {file}, or none can be compared");
}

#[test]
fn comparison_names_changed_missing_and_new_images() {
    let hashes = from_text("0a room\n0b glass ball\n0c ring\n");
    assert_eq!(to_text(&hashes), "0b glass ball\n0c ring\n0a room\n");
    let same = Comparison::new(&hashes, &hashes);
    assert!(same.is_equal());
    assert_eq!(same.to_string(), "0 of 3 images differ\n");

    let differs = Comparison::new(&hashes, &from_text("0a room\n0d glass ball\n0c ring\n"));
    assert!(!differs.is_equal());
    assert_eq!(differs.to_string(), "1 of 3 images differ\n  differs: glass ball\n");

    let renamed = Comparison::new(&hashes, &from_text("0a room\n0b glass sphere\n0c ring\n"));
    assert!(renamed.is_equal());
    let lines = "0 of 2 images differ\n  missing: glass ball\n  new: glass sphere\n";
    assert_eq!(renamed.to_string(), lines);

    // Files without a common name prove nothing.
    assert!(!Comparison::new(&hashes, &from_text("0a prism\n")).is_equal());
}

#[test]
fn hash_changes_with_one_bit_of_any_layer() {
    use glam::{Vec2, Vec3};
    let mut image = RenderedImage {
        width: 1,
        height: 1,
        path: vec![Vec3::ONE],
        caustics: vec![Vec3::ONE],
        radius: vec![1.0],
        depth: vec![1.0],
        photons: vec![1.0],
        ..RenderedImage::default()
    };
    let auxiliary = &mut image.auxiliary;
    (auxiliary.normal, auxiliary.albedo, auxiliary.position) =
        (vec![Vec3::ONE], vec![Vec3::ONE], vec![Vec3::ONE]);
    (auxiliary.depth, auxiliary.motion, auxiliary.material) = (vec![1.0], vec![Vec2::ONE], vec![1.0]);
    let hash = |image: &RenderedImage| {
        let mut hash = Hash::NEW;
        hash.image(image);
        hash.0
    };
    let next = 1.0f32.next_up();
    let changes: [fn(&mut RenderedImage, f32); 11] = [
        |image, next| image.path[0].z = next,
        |image, next| image.caustics[0].x = next,
        |image, next| image.radius[0] = next,
        |image, next| image.depth[0] = next,
        |image, next| image.photons[0] = next,
        |image, next| image.auxiliary.normal[0].y = next,
        |image, next| image.auxiliary.albedo[0].y = next,
        |image, next| image.auxiliary.position[0].y = next,
        |image, next| image.auxiliary.depth[0] = next,
        |image, next| image.auxiliary.motion[0].y = next,
        |image, next| image.auxiliary.material[0] = next,
    ];
    let mut all = vec![hash(&image)];
    for change in changes {
        let mut changed = image.clone();
        change(&mut changed, next);
        all.push(hash(&changed));
    }
    // A layer in the place of another changes the hash too.
    let caustics = std::mem::take(&mut image.caustics);
    image.auxiliary.normal.extend(caustics);
    all.push(hash(&image));
    let count = all.len();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), count);
}
