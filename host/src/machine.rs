//! Description of the machine and of the compiler.

use std::path::Path;
use std::sync::OnceLock;

use caustics_files::memory::field;

/// Returns processor, its threads, memory, system and compiler, as far as the system reports them.
/// Example: "AMD EPYC, 2 threads, 15.6 GiB, Debian GNU/Linux 12, x86_64, rustc 1.95.0".
pub fn description() -> &'static str {
    static DESCRIPTION: OnceLock<String> = OnceLock::new();
    DESCRIPTION.get_or_init(|| description_in(Path::new("/")))
}

/// Returns the description from the system's files below `root`.
fn description_in(root: &Path) -> String {
    let read = |path: &str| std::fs::read_to_string(root.join(path)).unwrap_or_default();
    let value = |text: &str, key: &str, mark: char| {
        let line = text.lines().find(|line| line.starts_with(key))?;
        Some(line.split_once(mark)?.1.trim().trim_matches('"').to_string())
    };
    let processor = value(&read("proc/cpuinfo"), "model name", ':');
    let threads = std::thread::available_parallelism().ok().map(|threads| format!("{threads} threads"));
    let kib = field(&read("proc/meminfo"), "MemTotal:");
    let memory = kib.map(|kib| format!("{:.1} GiB", kib as f64 / f64::from(1 << 20)));
    let system = value(&read("etc/os-release"), "PRETTY_NAME", '=');
    let system = system.unwrap_or_else(|| std::env::consts::OS.into());
    let others = [system, std::env::consts::ARCH.into(), env!("CAUSTICS_COMPILER").into()];
    let all: Vec<String> = [processor, threads, memory].into_iter().flatten().chain(others).collect();
    all.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_description_holds_all_that_the_system_reports() {
        let root = tempfile::tempdir().unwrap();
        for (path, text) in [
            ("proc/cpuinfo", "processor\t: 0\nmodel name\t: Some CPU @ 3 GHz\n"),
            ("proc/meminfo", "MemTotal:       16384000 kB\nMemFree: 1 kB\n"),
            ("etc/os-release", "NAME=\"X\"\nPRETTY_NAME=\"Debian GNU/Linux 12 (bookworm)\"\n"),
        ] {
            let path = root.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let text = description_in(root.path());
        assert!(text.starts_with("Some CPU @ 3 GHz, "), "{text}");
        assert!(text.contains(", 15.6 GiB, Debian GNU/Linux 12 (bookworm), "), "{text}");
        assert!(text.contains("rustc 1."), "{text}");
        // Unknown values are left out.
        let bare = description_in(&root.path().join("none"));
        assert!(bare.contains(std::env::consts::OS) && !bare.contains("GiB"), "{bare}");
    }
}
