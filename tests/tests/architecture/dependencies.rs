//! Third-party code of the project: its licences, sources, duplicate versions, and permission for unsafe code.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::layers::files;
use crate::root;

#[path = "../../../kernels/builder/src/fingerprint.rs"]
#[allow(dead_code)]
mod fingerprint;
#[path = "../../../host/cli/sources.rs"]
mod sources;

use sources::SOURCES;

/// Licences of crates, each reviewed and found compatible with the project's own. A new text needs a review first.
const LICENCES: [&str; 28] = [
    "(MIT OR Apache-2.0 OR Zlib) AND BSD-3-Clause",
    // JPEG encoder. The Independent JPEG Group requires a notice in the documentation: docs/viewer.md has it.
    "(MIT OR Apache-2.0) AND IJG",
    "(MIT OR Apache-2.0) AND Unicode-3.0",
    "0BSD OR MIT OR Apache-2.0",
    "Apache-2.0",
    "Apache-2.0 / MIT",
    "Apache-2.0 OR BSL-1.0",
    "Apache-2.0 OR MIT",
    "Apache-2.0 WITH LLVM-exception OR Apache-2.0 OR MIT",
    "Apache-2.0/MIT",
    "BSD-2-Clause OR Apache-2.0 OR MIT",
    "BSD-3-Clause",
    "BSD-3-Clause OR Apache-2.0",
    "CC0-1.0 OR Apache-2.0 OR Apache-2.0 WITH LLVM-exception",
    "CC0-1.0 OR MIT-0 OR Apache-2.0",
    "ISC",
    "MIT",
    "MIT / Apache-2.0",
    "MIT AND BSD-3-Clause",
    "MIT OR Apache-2.0",
    "MIT OR Apache-2.0 OR Zlib",
    "MIT OR Zlib OR Apache-2.0",
    "MIT/Apache-2.0",
    "MPL-2.0",
    "Unlicense OR MIT",
    "Unlicense/MIT",
    "Zlib",
    "Zlib OR Apache-2.0 OR MIT",
];

/// Crates of the Mozilla licence, which covers their own files. Tests alone use them, as parts of scraper.
const MOZILLA: [&str; 4] = ["cssparser", "cssparser-macros", "dtoa-short", "selectors"];

/// Crates in several versions, and their number. Update a number that falls, too.
const SEVERAL: [(&str, usize); 8] = [
    // WebSocket handshake; in tests, proptest.
    ("cpufeatures", 2),
    ("getrandom", 2),
    // Interfaces of other versions of glam, behind features of spirv-std.
    ("glam", 5),
    // The decoders of PNG and of EXR.
    ("miniz_oxide", 2),
    // WebP decoder; in tests, the crate by which proptest runs processes.
    ("quick-error", 2),
    // WebSockets; in tests, proptest and the HTML parser.
    ("rand", 3),
    ("rand_core", 3),
    // Crates of macros, in transition between versions.
    ("syn", 2),
];

const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// All packages of the lock file for this platform.
fn packages() -> Vec<Value> {
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let version = Command::new(&cargo).args(["version", "--verbose"]).output().unwrap();
    let version = String::from_utf8(version.stdout).unwrap();
    let host =
        version.lines().find_map(|line| line.strip_prefix("host: ")).expect("cargo names its platform");
    let arguments = ["metadata", "--offline", "--locked", "--format-version", "1", "--filter-platform", host];
    let output = Command::new(cargo).current_dir(root()).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

/// Adds the folders of the repository whose crates a package is built from, its own among them.
fn own_crates(packages: &[Value], name: &str, folders: &mut BTreeSet<PathBuf>) {
    let package = packages.iter().find(|package| package["name"] == name && package["source"].is_null());
    let Some(package) = package else { return };
    let root = root().canonicalize().unwrap();
    let manifest = PathBuf::from(package["manifest_path"].as_str().unwrap()).canonicalize().unwrap();
    if folders.insert(manifest.parent().unwrap().strip_prefix(root).unwrap().join("src")) {
        let dependencies = package["dependencies"].as_array().unwrap().iter();
        for dependency in dependencies.filter(|dependency| dependency["kind"].is_null()) {
            own_crates(packages, dependency["name"].as_str().unwrap(), folders);
        }
    }
}

#[test]
fn program_hash_changes_with_every_crate_of_the_program() {
    let mut folders = BTreeSet::new();
    own_crates(&packages(), "caustics-cli", &mut folders);
    assert_eq!(folders, SOURCES.map(PathBuf::from).into());

    let hash = |folder: &Path| fingerprint::fingerprint(folder, &SOURCES).unwrap();
    let copy = tempfile::tempdir().unwrap();
    for folder in SOURCES {
        let file = copy.path().join(folder).join("lib.rs");
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, "fn f() -> u32 { 1 }").unwrap();
    }
    let before = hash(copy.path());
    for folder in SOURCES {
        let file = copy.path().join(folder).join("lib.rs");
        std::fs::write(&file, "fn f() -> u32 { 2 }").unwrap();
        assert_ne!(hash(copy.path()), before, "{folder}");
        std::fs::write(&file, "fn f() -> u32 { 1 }").unwrap();
    }
    assert_eq!(hash(copy.path()), before);
}

#[test]
fn licences_sources_and_duplicate_versions_of_crates_are_listed() {
    let packages = packages();
    assert!(packages.len() > 100);
    let mut faults = Vec::new();
    let mut versions: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for package in &packages {
        let [name, version] = ["name", "version"].map(|key| package[key].as_str().unwrap());
        versions.entry(name).or_default().insert(version);
        let licence = package["license"].as_str().unwrap_or("none");
        if !LICENCES.contains(&licence) || (licence == "MPL-2.0") != MOZILLA.contains(&name) {
            faults.push(format!("{name} {version}: licence {licence}"));
        }
        let is_ours =
            package["source"].is_null() && (name.starts_with("caustics") || name == "cargo-kernels");
        if !is_ours && package["source"] != REGISTRY {
            faults.push(format!("{name} {version}: from {}", package["source"]));
        }
    }
    let several: Vec<(&str, usize)> = versions
        .iter()
        .map(|(name, versions)| (*name, versions.len()))
        .filter(|(_, count)| *count > 1)
        .collect();
    assert_eq!(faults, [""; 0]);
    assert_eq!(several, SEVERAL);
}

/// The builder of the kernels has a lock file of its own, and its crates need not be installed here.
#[test]
fn the_kernel_builder_takes_crates_from_the_registry_alone() {
    let lock = std::fs::read_to_string(root().join("kernels/builder/Cargo.lock")).unwrap();
    let sources: Vec<&str> = lock.lines().filter_map(|line| line.strip_prefix("source = ")).collect();
    assert!(sources.len() > 50);
    let other: Vec<_> = sources.iter().filter(|source| source.trim_matches('"') != REGISTRY).collect();
    assert!(other.is_empty(), "{other:?}");
}

/// Kernels have platform modules, `vulkan/` calls Vulkan, `oidn/` a library in C: no other module may be unsafe.
#[test]
fn crates_without_unsafe_code_forbid_it() {
    for (file, line) in [
        ("scenes/src/lib.rs", "#![forbid(unsafe_code)]"),
        ("tests/src/lib.rs", "#![forbid(unsafe_code)]"),
        ("kernels/builder/src/main.rs", "#![forbid(unsafe_code)]"),
        ("host/files/src/lib.rs", "#![forbid(unsafe_code)]"),
        ("host/scene/src/lib.rs", "#![forbid(unsafe_code)]"),
        ("host/bench/src/lib.rs", "#![forbid(unsafe_code)]"),
        ("host/cli/src/main.rs", "#![forbid(unsafe_code)]"),
        ("host/src/lib.rs", "#![deny(unsafe_code)]"),
    ] {
        let text = std::fs::read_to_string(root().join(file)).unwrap();
        assert!(text.lines().any(|found| found == line), "{file} lacks {line}");
    }
    let host = std::fs::read_to_string(root().join("host/src/lib.rs")).unwrap();
    let allowed: Vec<_> =
        host.split("#[allow(unsafe_code)]\n").skip(1).filter_map(|rest| rest.lines().next()).collect();
    assert_eq!(allowed, ["pub mod oidn;", "pub mod vulkan;"]);
    assert_eq!(host.matches("allow(unsafe_code)").count(), allowed.len());
}

/// Kernels are unsafe where they use GPU instructions that Rust lacks, where invocations write one buffer, and where a
/// CPU has optional instructions.
#[test]
fn kernels_use_unsafe_code_only_in_listed_modules() {
    let kernels = root().join("kernels/src");
    let is_unsafe = |file: &PathBuf| std::fs::read_to_string(file).unwrap().contains("unsafe {");
    let found = files(&kernels).into_iter().filter(is_unsafe);
    let found: Vec<String> =
        found.map(|file| file.strip_prefix(&kernels).unwrap().display().to_string()).collect();
    let unsafe_files = [
        "declare/on_cpu.rs",
        "gather/photons_rt.rs",
        "gather/points_rt.rs",
        "platform.rs",
        "trace/bvh8.rs",
        "trace/ray_query.rs",
    ];
    assert_eq!(found, unsafe_files);
}
