//! The host reads files of others in one module, which refuses files that may never end.

use crate::layers::{HOST_CRATES, files};
use crate::root;

/// Calls that read any file.
const CALLS: [&str; 4] = ["fs::read(", "fs::read_to_string(", "File::open(", "OpenOptions::new()"];
/// The module itself, two files that read the system's own paths, locks and outputs, and tests of pages.
const ALLOWED: [&str; 5] = ["commands_page", "file.rs", "machine.rs", "memory.rs", "output/folder.rs"];

/// The first of the calls in a source, except tests and comments.
fn call(source: &str) -> Option<&'static str> {
    let code = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = || code.lines().filter(|line| !line.trim_start().starts_with("//"));
    CALLS.into_iter().find(|call| lines().any(|line| line.contains(call)))
}

#[test]
fn host_reads_files_only_through_the_file_module() {
    let sources = HOST_CRATES.iter().map(|host| root().join(host.src));
    let mut found = Vec::new();
    for (src, file) in sources.flat_map(|src| files(&src).into_iter().map(move |file| (src.clone(), file))) {
        let name = file.strip_prefix(src).unwrap().to_string_lossy().replace('\\', "/");
        let text = std::fs::read_to_string(&file).unwrap();
        if let Some(call) = call(&text).filter(|_| !ALLOWED.iter().any(|allowed| name.starts_with(allowed))) {
            found.push(format!("{name}: {call}"));
        }
    }
    assert_eq!(found, [""; 0], "use caustics::file");
}

#[test]
fn detects_a_direct_read_of_a_file() {
    assert_eq!(call("fn a() {\n    std::fs::read(path)\n}"), Some("fs::read("));
    assert_eq!(call("let file = File::open(path)?;"), Some("File::open("));
    assert_eq!(
        call("/// See `File::open(path)`.\n#[cfg(test)]\nmod tests {\n    std::fs::read(path)\n}"),
        None
    );
}
