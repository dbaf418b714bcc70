//! Tests of the fingerprint. They have a file of their own because other crates include `fingerprint.rs`.

use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use crate::fingerprint::{INTERFACE, KERNELS, files, fingerprint};

/// Fingerprints of all sources and of the interface, in a copy of the kernels' folders where `change` edits one file.
fn with(file: &str, change: impl Fn(&str) -> String) -> [String; 2] {
    let kernels = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    static COPIES: AtomicU32 = AtomicU32::new(0);
    let copy = format!("caustics-fingerprint-{}-{}", std::process::id(), COPIES.fetch_add(1, Relaxed));
    let copy = std::env::temp_dir().join(copy);
    for path in files(&kernels, &KERNELS).expect("the sources are there") {
        let to = copy.join(path.strip_prefix(&kernels).expect("it is below"));
        std::fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
        std::fs::copy(&path, to).expect("a copy");
    }
    let path = copy.join(file);
    let text = std::fs::read_to_string(&path).expect("the file is there");
    std::fs::write(&path, change(&text)).expect("a copy can be written");
    let found = [&KERNELS[..], &INTERFACE].map(|sources| fingerprint(&copy, sources).expect("sources parse"));
    std::fs::remove_dir_all(&copy).expect("the copy can be removed");
    found
}

/// The host compares the fingerprint with `kernels.lock` and refuses compiled kernels of other sources.
#[test]
fn fingerprint_changes_with_kernels_and_macro_but_not_with_comments() {
    for file in ["src/pass/resolve.rs", "macros/src/expand.rs"] {
        let same = with(file, str::to_string);
        assert_eq!(with(file, |text| format!("// A remark.\n{text}")), same, "{file}");
        assert_eq!(with(file, |text| format!("{text}\n#[cfg(test)]\nmod more {{ fn f() {{}} }}\n")), same);
        assert_ne!(with(file, |text| format!("{text}\nfn more() {{}}\n"))[0], same[0], "{file}");
    }
}

/// A running program accepts kernels with other passes, but none with other types.
#[test]
fn interface_fingerprint_covers_types_but_not_passes() {
    let more = |text: &str| format!("{text}\nfn more() {{}}\n");
    for (file, is_interface) in [
        ("src/pass/resolve.rs", false),
        ("src/interface.rs", true),
        ("src/interface/point.rs", true),
        ("src/gather/accumulator.rs", true),
        ("macros/src/expand.rs", true),
    ] {
        let [before, after] = [with(file, str::to_string), with(file, more)];
        assert_eq!(before[1] != after[1], is_interface, "{file}");
    }
}
