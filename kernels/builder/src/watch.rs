//! Compiles again whenever a source of the kernels has changed.

use crate::fingerprint::{self, KERNELS};
use crate::set::{Set, Sources};
use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Time between two checks of the sources.
const PERIOD: Duration = Duration::from_millis(500);

/// Compiles the sources below `kernels` into `folder`, now and after each change, until the user interrupts it.
pub fn watch(
    kernels: &Path,
    folder: &Path,
    compile: impl Fn() -> anyhow::Result<Set>,
) -> anyhow::Result<Infallible> {
    let (mut seen, mut built) = (None, None);
    loop {
        // A file that an editor is just replacing is missing for a moment.
        let stamps = stamps(kernels).map_err(|error| error.to_string());
        if seen.as_ref() != Some(&stamps) {
            match build(kernels, folder, built.as_ref(), &compile) {
                Ok(Some(sources)) => {
                    built = Some(sources);
                    println!("waiting for changes of {}; Ctrl-C ends", kernels.display());
                }
                Ok(None) => {}
                // Report an error in a source and go on: the next change may mend it.
                Err(error) => eprintln!("error: {error:#}"),
            }
            // Keep the times from before the build, so that a change during it is noticed.
            seen = Some(stamps);
        }
        std::thread::sleep(PERIOD);
    }
}

/// Compiles and writes the set if the sources differ from those built. Returns the fingerprints of the set written, if any.
fn build(
    kernels: &Path,
    folder: &Path,
    built: Option<&Sources>,
    compile: impl Fn() -> anyhow::Result<Set>,
) -> anyhow::Result<Option<Sources>> {
    if built == Some(&Sources::now(kernels)?) {
        return Ok(None);
    }
    let set = compile()?;
    if Sources::now(kernels)? != set.sources {
        // Drop a set that mixes old and new sources: the next check compiles the new ones.
        return Ok(None);
    }
    set.write(folder)?;
    Ok(Some(set.sources))
}

/// Paths of the sources and times of their last changes.
fn stamps(kernels: &Path) -> std::io::Result<Vec<(PathBuf, SystemTime)>> {
    let stamp = |path: PathBuf| {
        let modified = std::fs::metadata(&path)?.modified()?;
        Ok((path, modified))
    };
    fingerprint::files(kernels, &KERNELS)?.into_iter().map(stamp).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::bail;
    use std::cell::Cell;

    #[test]
    fn changed_sources_are_compiled_once_and_written_if_stable() {
        let kernels = std::env::temp_dir().join(format!("caustics-watch-{}", std::process::id()));
        let write = |name: &str, text: &str| {
            let path = kernels.join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            std::fs::write(path, text).expect("a source");
        };
        for name in fingerprint::INTERFACE {
            let file = if name.ends_with(".rs") { name.to_string() } else { format!("{name}/lib.rs") };
            write(&file, "fn f() {}");
        }
        let (out, count) = (kernels.join("out"), Cell::new(0));
        let compile = || {
            count.set(count.get() + 1);
            let sources = Sources::now(&kernels)?;
            Ok(Set { sources, modules: vec![("base.spv", count.get().to_string().into_bytes())] })
        };
        let module = || std::fs::read_to_string(out.join("base.spv")).ok();

        let built = build(&kernels, &out, None, compile).expect("it compiles");
        assert_eq!((built.is_some(), module().as_deref()), (true, Some("1")));
        write("src/pass.rs", "// A remark.\nfn g() {}");
        let other = build(&kernels, &out, built.as_ref(), compile).expect("it compiles");
        assert_eq!((other.is_some(), module().as_deref()), (true, Some("2")));
        write("src/pass.rs", "// Another remark.\nfn g() {}");
        assert_eq!(build(&kernels, &out, other.as_ref(), compile).expect("nothing to do"), None);
        assert_eq!(count.get(), 2);

        let meanwhile = || {
            let set = compile();
            write("src/pass.rs", "fn h() {}");
            set
        };
        assert_eq!(build(&kernels, &out, None, meanwhile).expect("it compiles"), None);
        assert_eq!(module().as_deref(), Some("2"));
        let error = build(&kernels, &out, None, || bail!("a type is missing")).expect_err("it fails");
        assert_eq!((error.to_string().as_str(), module().as_deref()), ("a type is missing", Some("2")));
        std::fs::remove_dir_all(&kernels).expect("it can be removed");
    }
}
