//! Loads the run configurations of folders of results: every `DIR/cells/*.json`, and the images beside them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use crate::parameter::{PARAMETERS, Parameter, Values};
use crate::result::RunResult;
use crate::store;

/// A measured run configuration, and the folder of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Contents of its file.
    pub result: RunResult,
    /// Folder of its images.
    pub folder: PathBuf,
}

impl Measured {
    /// Path of one of its images.
    pub fn beside(&self, name: &Option<String>) -> Option<PathBuf> {
        Some(self.folder.join(name.as_ref()?))
    }
}

/// Loads all run configurations, sorted by scene and name, with warnings. Of two files of one identity, the later measure
/// counts.
pub fn load(folders: &[PathBuf]) -> anyhow::Result<(Vec<Measured>, Vec<String>)> {
    let mut known: BTreeMap<String, Measured> = BTreeMap::new();
    let mut warnings = Vec::new();
    for folder in folders {
        for path in files(&folder.join("cells"))? {
            let run = read(&path)?;
            let identity = run.result.identity.clone();
            match known.get(&identity) {
                Some(other) if other.result == run.result => continue,
                Some(other) => {
                    let later = other.result.provenance.unix_s > run.result.provenance.unix_s;
                    warnings.push(format!("{identity} was measured more than once: the last one counts"));
                    if later {
                        continue;
                    }
                }
                None => {}
            }
            known.insert(identity, run);
        }
    }
    if known.is_empty() {
        let names: Vec<_> = folders.iter().map(|folder| folder.display().to_string()).collect();
        bail!("no result in {}: a folder of results holds cells/*.json", names.join(", "));
    }
    let mut runs: Vec<Measured> = known.into_values().collect();
    runs.sort_by(|a, b| order(&a.result).partial_cmp(&order(&b.result)).unwrap_or(std::cmp::Ordering::Equal));
    Ok((runs, warnings))
}

/// Sort key: configurations of one scene are together, and those that differ only in their paths are adjacent.
fn order(result: &RunResult) -> (&str, &str, Vec<String>, Vec<f64>, &str) {
    let config = &result.config;
    let is_name = |parameter: &&&Parameter| matches!(parameter.values, Values::Names(_));
    let names = PARAMETERS.iter().filter(is_name).map(|parameter| config.text(parameter)).collect();
    let numbers = PARAMETERS
        .iter()
        .rev()
        .filter(|parameter| !is_name(parameter))
        .map(|parameter| config.number(parameter))
        .collect();
    (&config.scene, &config.camera, names, numbers, &result.identity)
}

/// The JSON files of a folder, in order of their names.
fn files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let entries = folder.read_dir().with_context(|| format!("cannot read {}", folder.display()))?;
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.with_context(|| format!("cannot read {}", folder.display()))?.path();
        if path.extension().is_some_and(|extension| extension == "json") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn read(path: &Path) -> anyhow::Result<Measured> {
    Ok(Measured { result: store::read_file(path)?, folder: path.parent().unwrap_or(Path::new("")).into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: &str = "000000000000000a";

    fn write(folder: &Path, name: &str, result: &RunResult) {
        std::fs::create_dir_all(folder.join("cells")).unwrap();
        std::fs::write(folder.join("cells").join(name), serde_json::to_vec(result).unwrap()).unwrap();
    }

    #[test]
    fn damaged_files_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let whole = RunResult { identity: A.into(), ..RunResult::default() };
        write(folder.path(), "000000000000000a.json", &whole);
        assert_eq!(load(&[folder.path().into()]).unwrap().0.len(), 1);
        let damaged = folder.path().join("cells/000000000000000b.json");
        for bytes in [&b"{\"identity\": \"b\""[..], b"{}", b"", b"[1]", b"\xff\xfe"] {
            std::fs::write(&damaged, bytes).unwrap();
            let error = format!("{:#}", load(&[folder.path().into()]).unwrap_err());
            assert!(error.contains("000000000000000b.json"), "{error}");
        }
    }

    #[test]
    fn folders_without_a_result_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let missing = format!("{:#}", load(&[folder.path().into()]).unwrap_err());
        assert!(missing.contains(&folder.path().join("cells").display().to_string()), "{missing}");
        std::fs::create_dir(folder.path().join("cells")).unwrap();
        let empty = format!("{:#}", load(&[folder.path().into()]).unwrap_err());
        assert!(
            empty.contains("no result in") && empty.contains(&folder.path().display().to_string()),
            "{empty}"
        );
    }

    #[test]
    fn the_later_of_two_measures_counts() {
        let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        let paths = folders.each_ref().map(|folder| folder.path().to_path_buf());
        let mut result = RunResult { identity: A.into(), ..RunResult::default() };
        for (path, unix_s) in paths.iter().zip([20, 10]) {
            result.provenance.unix_s = unix_s;
            write(path, "000000000000000a.json", &result);
        }
        for folders in [[paths[0].clone(), paths[1].clone()], [paths[1].clone(), paths[0].clone()]] {
            let (runs, warnings) = load(&folders).unwrap();
            assert_eq!((runs.len(), runs[0].result.provenance.unix_s, warnings.len()), (1, 20, 1));
        }
        assert!(load(&[paths[0].clone(), paths[0].clone()]).unwrap().1.is_empty());
    }
}
