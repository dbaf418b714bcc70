//! Fingerprint of the kernels' sources: equal for builder and host, independent of comments, layout and tests.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Folders below `kernels/` that the modules are compiled from: the kernels, and the macro that makes their entry points.
pub const KERNELS: [&str; 2] = ["src", "macros/src"];

/// Sources below `kernels/` on which kernels and host must agree. They hold the types that both read and write, the code around a
/// pass in its entry points, and the words of a sum. The host reflects the bindings of each pass instead.
pub const INTERFACE: [&str; 4] =
    ["src/interface.rs", "src/interface", "src/gather/accumulator.rs", "macros/src"];

/// FNV-1a hash (64 bits) of the token streams of `.rs` files below `folder`, in the order of their paths. A folder among the
/// sources stands for all `.rs` files in it.
///
/// Fails if a source cannot be read or does not parse.
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

/// FNV-1a hash of bytes, for the compiled modules.
pub fn hash(bytes: &[u8]) -> String {
    let mut hash = Fnv::default();
    hash.add(bytes);
    hash.hex()
}

/// Lists the `.rs` files below `folder` that `sources` names, and all in the folders that it names, sorted.
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
