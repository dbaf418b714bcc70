//! Finds a scene by its path or its name.

use std::path::{Path, PathBuf};

use super::SceneError;

/// Folder of scenes that are made on demand, unless the caller names another.
pub const MADE: &str = "scenes/generated";

/// Finds the file of a scene. The argument is a .gltf or .glb file, a folder with a `scene.gltf`, or the name of a folder in
/// `scenes/` or in [`MADE`].
pub fn resolve(argument: &str) -> Result<PathBuf, SceneError> {
    let path = Path::new(argument);
    let is_scene = |path: &Path| {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        matches!(extension.to_ascii_lowercase().as_str(), "gltf" | "glb")
    };
    if is_scene(path) || path.is_file() {
        return Ok(path.into());
    }
    resolve_in(&folders(), argument)
}

/// Finds the file of a scene, given its folder or the name of a folder within `folders`.
fn resolve_in(folders: &[PathBuf], argument: &str) -> Result<PathBuf, SceneError> {
    let path = Path::new(argument);
    // A name has one component: an empty argument would otherwise find the folder of scenes itself.
    let is_name = path.components().count() == 1;
    let named = folders.iter().filter(|_| is_name).map(|folder| folder.join(path));
    std::iter::once(path.to_path_buf())
        .chain(named)
        .map(|folder| folder.join("scene.gltf"))
        .find(|file| file.is_file())
        .ok_or_else(|| match caustics_scenes::ON_DEMAND.contains(&argument) {
            true => SceneError::NotMade { name: argument.into() },
            false => SceneError::Unknown { argument: argument.into(), known: names().join(", ") },
        })
}

/// Names of the scenes that [`resolve`] finds without a path, sorted.
pub fn names() -> Vec<String> {
    let entries = folders().into_iter().filter_map(|folder| folder.read_dir().ok()).flatten().flatten();
    let mut names: Vec<String> = entries
        .filter(|entry| entry.path().join("scene.gltf").is_file())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names.dedup();
    names
}

/// Folders of scenes: those of the current folder, then those of the source tree, each followed by its made scenes.
fn folders() -> [PathBuf; 4] {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    ["scenes".into(), MADE.into(), source.join("generated"), source]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_unknown_names_list_the_known_scenes() {
        for argument in ["no-such-scene", "", "no/such/scene", "."] {
            let error = resolve(argument).unwrap_err().to_string();
            assert!(error.contains(".glb"), "{error}");
        }
    }

    #[test]
    fn scene_on_demand_is_found_once_made_and_its_error_names_the_command() {
        let folder = tempfile::tempdir().unwrap();
        let folders = [folder.path().join("scenes"), folder.path().join(MADE)];
        let error = resolve_in(&folders, "bar").unwrap_err().to_string();
        assert!(error.contains("caustics scene make bar"), "{error}");
        let file = folders[1].join("bar/scene.gltf");
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, "{}").unwrap();
        assert_eq!(resolve_in(&folders, "bar").unwrap(), file);
    }

    #[test]
    fn paths_pass_whether_they_exist_or_not() {
        assert_eq!(resolve("missing.glb").unwrap(), Path::new("missing.glb"));
    }
}
