//! Fingerprint of the kernels' sources: the same for builder and host, blind to comments, layout and tests.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Folders of what the modules are made of, below `kernels/`: the kernels, and the macro that makes their entry points.
pub const KERNELS: [&str; 2] = ["src", "macros/src"];

/// What kernels and the host that runs them must agree on, below `kernels/`: the types that both read and write, the entry
/// points' own code around a pass, and the words of a sum. What each pass binds is reflected instead.
pub const INTERFACE: [&str; 4] =
    ["src/interface.rs", "src/interface", "src/gather/accumulator.rs", "macros/src"];

/// FNV-1a hash, 64 bits, of the token streams of these `.rs` files, and all in these folders, below `folder`, in the order
/// of their paths.
pub fn fingerprint(folder: &Path, sources: &[&str]) -> std::io::Result<String> {
    let mut hash = Fnv::default();
    for file in files(folder, sources)? {
        let source = std::fs::read_to_string(&file)?;
        let tokens = TokenStream::from_str(&source)
            .map_err(|error| std::io::Error::other(format!("{}: {error}", file.display())))?;
        let name = file.strip_prefix(folder).unwrap_or(&file).to_string_lossy().replace('\\', "/");
        hash.add(name.as_bytes());
        add(tokens, &mut hash);
    }
    Ok(hash.hex())
}

/// The hash of some bytes, for the compiled modules.
pub fn hash(bytes: &[u8]) -> String {
    let mut hash = Fnv::default();
    hash.add(bytes);
    hash.hex()
}

/// These `.rs` files, and all in these folders, below `folder`, sorted.
pub fn files(folder: &Path, sources: &[&str]) -> std::io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for below in sources {
        list(folder.join(below), &mut files)?;
    }
    files.sort();
    Ok(files)
}

fn list(path: PathBuf, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    if std::fs::metadata(&path)?.is_dir() {
        for entry in std::fs::read_dir(path)? {
            list(entry?.path(), files)?;
        }
    } else if path.extension().is_some_and(|extension| extension == "rs") {
        files.push(path);
    }
    Ok(())
}

/// Adds tokens, without documentation and without items marked `#[cfg(test)]`.
fn add(tokens: TokenStream, hash: &mut Fnv) {
    let mut tokens = tokens.into_iter().peekable();
    while let Some(token) = tokens.next() {
        if matches!(&token, TokenTree::Punct(punct) if punct.as_char() == '#') {
            let inner = matches!(tokens.peek(), Some(TokenTree::Punct(punct)) if punct.as_char() == '!');
            if inner {
                tokens.next();
            }
            if let Some(TokenTree::Group(group)) = tokens.next() {
                let attribute = group.stream().to_string().replace(' ', "");
                if attribute == "cfg(test)" {
                    // Skip the item: up to its braces or its semicolon.
                    for token in tokens.by_ref() {
                        match token {
                            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => break,
                            TokenTree::Punct(punct) if punct.as_char() == ';' => break,
                            _ => {}
                        }
                    }
                } else if !attribute.starts_with("doc=") {
                    hash.add(attribute.as_bytes());
                }
            }
            continue;
        }
        match token {
            TokenTree::Group(group) => {
                hash.add(format!("{:?}", group.delimiter()).as_bytes());
                add(group.stream(), hash);
                hash.add(b"end");
            }
            other => hash.add(other.to_string().as_bytes()),
        }
    }
}

struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Fnv(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    /// Adds bytes and a separator.
    fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes.iter().chain([&0xff]) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn hex(&self) -> String {
        format!("{:016x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

    /// The fingerprints, of all and of the interface, of a copy of the kernels' folders in which a file has other text.
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
        let found =
            [&KERNELS[..], &INTERFACE].map(|sources| fingerprint(&copy, sources).expect("sources parse"));
        std::fs::remove_dir_all(&copy).expect("the copy can be removed");
        found
    }

    /// The host compares this with `kernels.lock`: what changes an entry point makes it refuse the compiled kernels.
    #[test]
    fn changes_of_kernels_and_of_the_macro_change_it_and_comments_do_not() {
        for file in ["src/pass/resolve.rs", "macros/src/expand.rs"] {
            let same = with(file, str::to_string);
            assert_eq!(with(file, |text| format!("// A remark.\n{text}")), same, "{file}");
            assert_eq!(
                with(file, |text| format!("{text}\n#[cfg(test)]\nmod more {{ fn f() {{}} }}\n")),
                same
            );
            assert_ne!(with(file, |text| format!("{text}\nfn more() {{}}\n"))[0], same[0], "{file}");
        }
    }

    /// A running program takes kernels with other passes, but none with other types.
    #[test]
    fn a_pass_is_no_interface_and_a_type_is() {
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
}
