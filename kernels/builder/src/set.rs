//! A set of compiled kernels in a folder: the modules, and the lock that holds their fingerprints.

use crate::fingerprint::{self, INTERFACE, KERNELS};
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};

/// Name of the lock.
const LOCK: &str = "kernels.lock";

/// Fingerprints of sources.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sources {
    all: String,
    interface: String,
}

impl Sources {
    /// Computes the fingerprints of the present sources below `kernels`.
    pub fn now(kernels: &Path) -> std::io::Result<Sources> {
        let hash = |sources: &[&str]| fingerprint::fingerprint(kernels, sources);
        Ok(Sources { all: hash(&KERNELS)?, interface: hash(&INTERFACE)? })
    }
}

/// Compiled modules by name, and the fingerprints of their sources.
pub struct Set {
    pub sources: Sources,
    pub modules: Vec<(&'static str, Vec<u8>)>,
}

impl Set {
    /// Text of the lock: fingerprints of the sources, the compiler, and hashes of the modules.
    fn lock(&self) -> String {
        let mut lock =
            String::from("# Written by `cargo kernels`; the host refuses a GPU when the sources differ.\n");
        lock += &format!("sources = \"{}\"\n", self.sources.all);
        lock += "# Of the types that kernels and host share.\n";
        lock += &format!("interface = \"{}\"\n", self.sources.interface);
        lock += "compiler = \"rustc_codegen_spirv 0.11.0\"\n";
        for (name, bytes) in &self.modules {
            lock += &format!("\"{name}\" = \"{}\"\n", fingerprint::hash(bytes));
        }
        lock
    }

    /// Paths and contents of the files, the lock last.
    fn files(&self, folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
        let modules = self.modules.iter().map(|(name, bytes)| (folder.join(name), bytes.clone()));
        modules.chain([(folder.join(LOCK), self.lock().into_bytes())]).collect()
    }

    /// Writes the set. Each file appears whole, and the lock after the modules, so that a program can read the folder meanwhile.
    pub fn write(&self, folder: &Path) -> anyhow::Result<()> {
        std::fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
        for (path, bytes) in self.files(folder) {
            let mut new = path.clone().into_os_string();
            new.push(".new");
            let written = std::fs::write(&new, &bytes).and_then(|()| std::fs::rename(&new, &path));
            written.with_context(|| format!("writing {}", path.display()))?;
            println!("{} ({} bytes)", path.display(), bytes.len());
        }
        Ok(())
    }

    /// Fails if the set in the folder differs.
    pub fn compare(&self, folder: &Path) -> anyhow::Result<()> {
        for (path, bytes) in self.files(folder) {
            if std::fs::read(&path).with_context(|| format!("reading {}", path.display()))? != bytes {
                bail!(
                    "{} is not what the sources compile to: run `cargo kernels` and commit it",
                    path.display()
                );
            }
        }
        println!("the committed kernels are what the sources compile to");
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(bytes: &[u8]) -> Set {
        let sources = Sources { all: "0123".into(), interface: "4567".into() };
        Set { sources, modules: vec![("base.spv", bytes.to_vec()), ("rayquery.spv", b"rays".to_vec())] }
    }

    #[test]
    fn compare_finds_other_modules_and_other_interfaces() {
        let folder = std::env::temp_dir().join(format!("caustics-set-{}", std::process::id()));
        set(b"old").write(&folder).expect("it can be written");
        set(b"old").compare(&folder).expect("it is the same");
        let error = set(b"new").compare(&folder).expect_err("another module").to_string();
        assert!(error.contains("base.spv"), "{error}");
        set(b"new").write(&folder).expect("it replaces the old one");
        set(b"new").compare(&folder).expect("it is the same");
        let other = Set { sources: Sources { interface: "89ab".into(), ..set(b"").sources }, ..set(b"new") };
        let error = other.compare(&folder).expect_err("another interface").to_string();
        assert!(error.contains("kernels.lock"), "{error}");
        let names = std::fs::read_dir(&folder).expect("a folder").count();
        assert_eq!(names, 3, "nothing is left beside the set");
        std::fs::remove_dir_all(&folder).expect("the folder can be removed");
    }

    /// A program that sees the lock also sees the modules that it names.
    #[test]
    fn the_lock_is_written_last() {
        let files = set(b"some").files(Path::new("there"));
        assert_eq!(files.last().map(|(path, _)| path.clone()), Some(Path::new("there").join(LOCK)));
    }
}
