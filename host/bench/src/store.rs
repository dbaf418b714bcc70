//! Results on disk: `FOLDER/cells/<identity>.json`, with the PNGs that they name beside them.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::{Context, anyhow, ensure};
use glam::Vec3;

use super::result::{Provenance, RunResult};
use caustics::file;
use caustics::hash::DIGITS;
use caustics::output::png;
use caustics::output::target::Target;
use caustics::program::program;
use caustics::{kernels, machine, memory};

/// Digits of identities: current ones, and those of older results.
const LENGTHS: [usize; 2] = [DIGITS, 16];

/// Returns the subfolder that holds an experiment's results.
pub fn results_folder(folder: &Path) -> PathBuf {
    folder.join("cells")
}

/// Creates the folder of the results.
pub fn create(folder: &Path) -> anyhow::Result<()> {
    let results = results_folder(folder);
    std::fs::create_dir_all(&results).with_context(|| format!("cannot create {}", results.display()))
}

/// Returns the path of a result.
pub fn file(folder: &Path, identity: &str) -> PathBuf {
    results_folder(folder).join(format!("{identity}.json"))
}

/// Writes a result, replacing an older one.
pub fn write(folder: &Path, result: &RunResult) -> anyhow::Result<()> {
    let mut text = serde_json::to_string_pretty(result)?;
    text.push('\n');
    Ok(Target::claim(&file(folder, &result.identity), true)?.finish(text.as_bytes())?)
}

/// Returns the result of an identity; none where it is missing or damaged.
pub fn read(folder: &Path, identity: &str) -> Option<RunResult> {
    read_file(&file(folder, identity)).ok()
}

/// Reads the result in a file.
pub fn read_file(path: &Path) -> anyhow::Result<RunResult> {
    let bytes = file::read_file(path).with_context(|| format!("cannot read {}", path.display()))?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    parse(&bytes, &stem)
        .with_context(|| format!("{} is no result of a run configuration; measure it again", path.display()))
}

/// Parses the result in a file of this stem. Its names stay within the file's folder: the identity is the stem, in
/// hexadecimal digits, and images are PNGs beside it.
pub fn parse(bytes: &[u8], stem: &str) -> anyhow::Result<RunResult> {
    memory::check(memory::json_parse_bytes(bytes)).map_err(|short| anyhow!("it would take {short}"))?;
    let mut result: RunResult = serde_json::from_slice(bytes)?;
    result.config.rename();
    let RunResult { identity, error, .. } = &result;
    let is_digit = |digit: u8| digit.is_ascii_digit() || (b'a'..=b'f').contains(&digit);
    let is_hash = LENGTHS.contains(&identity.len()) && identity.bytes().all(is_digit);
    ensure!(
        is_hash && identity == stem,
        "its identity {identity:?} is not its name, {DIGITS} hexadecimal digits"
    );
    let images = error.iter().flat_map(|error| [&error.image, &error.error_map, &error.reference]);
    for name in images.flatten() {
        let is_plain = name.chars().all(|letter| letter.is_ascii_alphanumeric() || "-_.".contains(letter));
        let is_image = is_plain && name.ends_with(".png") && !name.starts_with('.');
        ensure!(is_image, "its image {name:?} is not the name of a PNG beside it");
    }
    Ok(result)
}

/// Results of a run: on disk, or in memory where the user wants no files.
#[derive(Debug, Default)]
pub struct Results {
    folder: Option<PathBuf>,
    in_memory: RefCell<BTreeMap<String, RunResult>>,
}

impl Results {
    /// Keeps results in a folder, which is created, or in memory.
    ///
    /// # Errors
    /// If the folder cannot be created.
    pub fn new(folder: Option<&Path>) -> anyhow::Result<Results> {
        folder.map_or(Ok(()), create)?;
        Ok(Results { folder: folder.map(Path::to_path_buf), in_memory: RefCell::default() })
    }

    /// Returns the result of an identity; none where it is missing or damaged.
    pub fn read(&self, identity: &str) -> Option<RunResult> {
        match &self.folder {
            Some(folder) => read(folder, identity),
            None => self.in_memory.borrow().get(identity).cloned(),
        }
    }

    /// Keeps a result, replacing an older one.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, result: &RunResult) -> anyhow::Result<()> {
        match &self.folder {
            Some(folder) => write(folder, result),
            None => {
                self.in_memory.borrow_mut().insert(result.identity.clone(), result.clone());
                Ok(())
            }
        }
    }

    /// Writes an image beside the results. Returns its name, or none in memory.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_png(
        &self,
        name: String,
        width: u32,
        height: u32,
        colors: &[Vec3],
    ) -> anyhow::Result<Option<String>> {
        let Some(folder) = &self.folder else { return Ok(None) };
        let bytes = png::encode(width, height, colors)?;
        Target::claim(&results_folder(folder).join(&name), true)?.finish(&bytes)?;
        Ok(Some(name))
    }
}

/// Reads all results of a folder, in the order of their identities. A file that is not a result is an error.
pub fn read_all(folder: &Path) -> anyhow::Result<Vec<RunResult>> {
    let results = results_folder(folder);
    let entries = results.read_dir().with_context(|| format!("cannot read {}", results.display()))?;
    let mut paths = entries.map(|entry| Ok(entry?.path())).collect::<anyhow::Result<Vec<PathBuf>>>()?;
    // Skip unfinished files, whose names start with a dot.
    let hidden =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "json") && !hidden(path));
    paths.sort();
    paths.iter().map(|path| read_file(path)).collect()
}

/// Provenance of a measure taken now.
pub fn provenance(device: String, seed: u32, wall_s: f64) -> Provenance {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    Provenance {
        commit: program().commit.clone(),
        kernels: kernels::SOURCES.into(),
        device,
        machine: machine::description().into(),
        seed,
        wall_s,
        unix_s: now.map_or(0, |time| time.as_secs()),
    }
}
