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

/// Digits of identities: those of today, and those of results that were measured before.
const LENGTHS: [usize; 2] = [DIGITS, 16];

/// The folder of the results in a folder.
pub fn results_folder(folder: &Path) -> PathBuf {
    folder.join("cells")
}

/// Makes the folder of the results.
pub fn create(folder: &Path) -> anyhow::Result<()> {
    let results = results_folder(folder);
    std::fs::create_dir_all(&results).with_context(|| format!("cannot create {}", results.display()))
}

/// The file of a result.
pub fn file(folder: &Path, identity: &str) -> PathBuf {
    results_folder(folder).join(format!("{identity}.json"))
}

/// Writes a result in the place of an older one.
pub fn write(folder: &Path, result: &RunResult) -> anyhow::Result<()> {
    let mut text = serde_json::to_string_pretty(result)?;
    text.push('\n');
    Ok(Target::claim(&file(folder, &result.identity), true)?.finish(text.as_bytes())?)
}

/// The result of this identity, if it is there and whole.
pub fn read(folder: &Path, identity: &str) -> Option<RunResult> {
    read_file(&file(folder, identity)).ok()
}

/// The result in a file.
pub fn read_file(path: &Path) -> anyhow::Result<RunResult> {
    let bytes = file::read_file(path).with_context(|| format!("cannot read {}", path.display()))?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    parse(&bytes, &stem)
        .with_context(|| format!("{} is no result of a run configuration; measure it again", path.display()))
}

/// The result in the bytes of a file of this stem. Its names lead nowhere but into the folder of the file: the identity is
/// the stem, hexadecimal digits, and images are PNGs beside it.
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

/// Results of a run: on disk, or in memory for who wants no files.
#[derive(Debug, Default)]
pub struct Results {
    folder: Option<PathBuf>,
    in_memory: RefCell<BTreeMap<String, RunResult>>,
}

impl Results {
    /// Results in a folder, which is made, or in memory.
    ///
    /// # Errors
    /// A folder that cannot be made.
    pub fn new(folder: Option<&Path>) -> anyhow::Result<Results> {
        folder.map_or(Ok(()), create)?;
        Ok(Results { folder: folder.map(Path::to_path_buf), in_memory: RefCell::default() })
    }

    /// The result of this identity, if it is there and whole.
    pub fn read(&self, identity: &str) -> Option<RunResult> {
        match &self.folder {
            Some(folder) => read(folder, identity),
            None => self.in_memory.borrow().get(identity).cloned(),
        }
    }

    /// Keeps a result in the place of an older one.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, result: &RunResult) -> anyhow::Result<()> {
        match &self.folder {
            Some(folder) => write(folder, result),
            None => {
                self.in_memory.borrow_mut().insert(result.identity.clone(), result.clone());
                Ok(())
            }
        }
    }

    /// Keeps an image beside the results; its name, or none in memory.
    ///
    /// # Errors
    /// A file that cannot be written.
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

/// All results of a folder in the order of their identities; a file that is none is an error.
pub fn read_all(folder: &Path) -> anyhow::Result<Vec<RunResult>> {
    let results = results_folder(folder);
    let entries = results.read_dir().with_context(|| format!("cannot read {}", results.display()))?;
    let mut paths = entries.map(|entry| Ok(entry?.path())).collect::<anyhow::Result<Vec<PathBuf>>>()?;
    // A part of a file has a name that starts with a dot.
    let hidden =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "json") && !hidden(path));
    paths.sort();
    paths.iter().map(|path| read_file(path)).collect()
}

/// Where a measure of now comes from.
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
