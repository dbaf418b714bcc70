//! Results on disk: `FOLDER/cells/<identity>.json`, with the PNGs that they name beside them.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::Context;

use super::result::{CellResult, Provenance};
use crate::kernels;
use crate::output::target::Target;

/// The folder of the results in a folder.
pub fn cells(folder: &Path) -> PathBuf {
    folder.join("cells")
}

/// Makes the folder of the results.
pub fn create(folder: &Path) -> anyhow::Result<()> {
    let cells = cells(folder);
    std::fs::create_dir_all(&cells).with_context(|| format!("cannot create {}", cells.display()))
}

/// The file of a result.
pub fn file(folder: &Path, identity: &str) -> PathBuf {
    cells(folder).join(format!("{identity}.json"))
}

/// Writes a result in the place of an older one.
pub fn write(folder: &Path, result: &CellResult) -> anyhow::Result<()> {
    let mut text = serde_json::to_string_pretty(result)?;
    text.push('\n');
    Ok(Target::claim(&file(folder, &result.identity), true)?.finish(text.as_bytes())?)
}

/// The result of this identity, if it is there and whole.
pub fn read(folder: &Path, identity: &str) -> Option<CellResult> {
    let bytes = std::fs::read(file(folder, identity)).ok()?;
    let result: CellResult = serde_json::from_slice(&bytes).ok()?;
    (result.identity == identity).then_some(result)
}

/// All results of a folder in the order of their identities; a file that is none is an error.
pub fn read_all(folder: &Path) -> anyhow::Result<Vec<CellResult>> {
    let cells = cells(folder);
    let entries = cells.read_dir().with_context(|| format!("cannot read {}", cells.display()))?;
    let mut paths = entries.map(|entry| Ok(entry?.path())).collect::<anyhow::Result<Vec<PathBuf>>>()?;
    // A part of a file has a name that starts with a dot.
    let hidden =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "json") && !hidden(path));
    paths.sort();
    let of = |path: &PathBuf| {
        let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        serde_json::from_slice(&bytes).with_context(|| format!("{} is no result of a cell", path.display()))
    };
    paths.iter().map(of).collect()
}

/// Where a measure of now comes from.
pub fn provenance(device: String, seed: u32, wall_s: f64) -> Provenance {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    Provenance {
        commit: env!("CAUSTICS_COMMIT").into(),
        kernels: kernels::SOURCES.into(),
        device,
        seed,
        wall_s,
        unix_s: now.map_or(0, |time| time.as_secs()),
    }
}
