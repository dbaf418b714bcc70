//! Verdicts on all files of `tests/corpus` and `fuzz/corpus/scene`: the contents and warnings of a file that loads, or the reason
//! of its refusal. `CAUSTICS_BLESS=1 cargo test -p caustics-scene verdicts` writes `tests/golden/verdicts.txt`.

use std::fmt::Write;
use std::path::PathBuf;

use super::*;

/// Root of the repository.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
/// Table of verdicts, below the root.
const TABLE: &str = "tests/golden/verdicts.txt";
/// Folders of the corpora, below the root.
const CORPORA: [&str; 2] = ["tests/corpus", "fuzz/corpus/scene"];

/// Files of a corpus, sorted by name.
fn files(corpus: &str) -> Vec<PathBuf> {
    let entries = Path::new(ROOT).join(corpus).read_dir().expect("a corpus");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let mut files: Vec<_> = paths.filter(|path| path.extension().is_none_or(|end| end != "md")).collect();
    files.sort();
    files
}

/// Replaces control characters, so that a text takes one line.
fn line(text: &str) -> String {
    text.chars().flat_map(|c| if c.is_control() { c.escape_default().collect() } else { vec![c] }).collect()
}

/// Variant and text of an error. The available memory of the machine is left out.
fn refusal(error: &SceneError) -> String {
    let debug = format!("{error:?}");
    let variant = debug.split([' ', '{']).next().unwrap_or_default();
    match error {
        SceneError::Memory { file, what, .. } => format!("{variant}: {file}: {what}"),
        SceneError::WithoutExtension { extension, source, .. } => {
            format!("{variant} {extension:?}: {}", refusal(source))
        }
        error => format!("{variant}: {error}"),
    }
}

/// Lines of a file: its verdict, its warnings, and its verdict by strict reading.
fn verdict(corpus: &str, path: &Path) -> String {
    let name = path.file_name().expect("a name").to_string_lossy();
    let bytes = std::fs::read(path).expect("a file");
    let load = |strict: bool| {
        let options = LoadOptions { strict, ..LoadOptions::default() };
        super::super::read(&name, &bytes, Path::new("/no folder"), &options)
    };
    let mut text = format!("{corpus}/{name}\n");
    let mut add = |verdict: String| writeln!(text, "    {}", line(&verdict)).expect("a string");
    match load(false) {
        Ok(scene) => {
            let counts = [
                ("triangles", scene.triangles.len()),
                ("instances", scene.instances.len()),
                ("materials", scene.material_names.len()),
                ("textures", scene.textures.textures.len()),
                ("lights", scene.lights.len()),
                ("cameras", scene.cameras.len()),
                ("nodes", scene.rig.joints.len()),
            ];
            let counts = counts.map(|(name, count)| format!("{count} {name}"));
            add(format!("loads: {}", counts.join(", ")));
            scene.warnings.iter().for_each(|warning| add(format!("warning: {warning}")));
        }
        Err(error) => add(refusal(&error)),
    }
    match load(true) {
        Ok(_) => add("strict: loads".into()),
        Err(error) => add(format!("strict: {}", refusal(&error))),
    }
    text
}

/// Lines that only one of two tables has.
fn differences(ours: &str, committed: &str) -> Vec<String> {
    let lacking = |table: &str, other: &str, sign: char| -> Vec<String> {
        let known: std::collections::HashSet<&str> = other.lines().collect();
        let lines = table.lines().filter(|line| !known.contains(line));
        lines.map(|line| format!("{sign} {line}")).collect()
    };
    let mut found = lacking(committed, ours, '-');
    found.extend(lacking(ours, committed, '+'));
    // A line may also occur for several files.
    if found.is_empty() && ours != committed {
        found.push("its lines stand in another order, or more or less often".into());
    }
    found
}

#[test]
fn every_file_of_the_corpora_keeps_its_verdict() {
    let files =
        CORPORA.into_iter().flat_map(|corpus| files(corpus).into_iter().map(move |file| (corpus, file)));
    let ours: String = files.map(|(corpus, file)| verdict(corpus, &file)).collect();
    let path = Path::new(ROOT).join(TABLE);
    if std::env::var_os("CAUSTICS_BLESS").is_some() {
        std::fs::write(&path, &ours).expect("the table");
    }
    let committed = std::fs::read_to_string(&path).expect("the table");
    let found = differences(&ours, &committed.replace("\r\n", "\n"));
    assert!(found.is_empty(), "{TABLE} differs:\n{}", found.join("\n"));
}

#[test]
fn detects_a_changed_verdict() {
    let table = "a.gltf\n    loads: 2 triangles\n    strict: loads\nb.gltf\n    Mesh: b.gltf: mesh 0\n    strict: loads\n";
    assert!(differences(table, table).is_empty());
    for (from, to) in [
        ("2 triangles", "3 triangles"),
        ("Mesh: b.gltf", "Node: b.gltf"),
        ("mesh 0", "mesh 1"),
        ("    loads: 2 triangles\n", ""),
        ("b.gltf\n", "b.gltf\n    warning: one more\n"),
        ("    strict: loads\nb", "b"),
    ] {
        assert!(!differences(&table.replacen(from, to, 1), table).is_empty(), "{from:?}");
    }
}
