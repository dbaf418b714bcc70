//! Imports point one way: each folder of a crate knows only those that stand before it. Paths are read from the sources' tokens,
//! inline ones too, tests aside.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// The rings of the kernels, from the inside; rooms of one ring do not know each other.
const KERNELS: &[&[&str]] = &[
    &["interface", "seam"],
    &["math"],
    &["texture", "declare"],
    &["surface", "light"],
    &["trace", "gather"],
    &["pass"],
    &["history", "denoiser", "emission"],
    &["method"],
];

/// Those of the host's library, then of its program.
const HOST: &[&[&str]] = &[
    &["hash", "kernels", "memory", "text"],
    &["file", "vulkan", "counters", "energy", "picture"],
    &["scene", "output", "sealed"],
    &["settings", "accumulation", "image"],
    &["metric"],
    &["runner", "checkpoint"],
    &["upload", "frame_memory"],
    &["session"],
    &["trace_rate"],
    &["experiment"],
    &["builder"],
    &["report"],
    &["fuzzing"],
    &["cli"],
    &["commands_page"],
    &["command"],
];

/// Which rooms a room's files name, and the first file that does.
type Doors = BTreeMap<(String, String), PathBuf>;

/// The doors of a crate's rooms, from its sources.
fn doors(src: &Path, own_name: &str) -> Doors {
    let mut doors = Doors::new();
    for file in files(src) {
        let path = file.strip_prefix(src).expect("below").with_extension("");
        let module: Vec<String> =
            path.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
        if module == ["lib"] || module == ["main"] {
            continue;
        }
        let text = std::fs::read_to_string(&file).expect("a source");
        let tokens: TokenStream = text.parse().expect("a source parses");
        let mut found = BTreeSet::new();
        read(tokens, &module, own_name, &mut found);
        for room in found.into_iter().filter(|room| *room != module[0]) {
            doors.entry((module[0].clone(), room)).or_insert_with(|| file.clone());
        }
    }
    doors
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.is_dir() && name != "tests" {
            all.extend(files(&path));
        } else if name.ends_with(".rs") && name != "tests.rs" {
            all.push(path);
        }
    }
    all.sort();
    all
}

/// Adds the rooms that tokens of a module name.
fn read(tokens: TokenStream, module: &[String], own_name: &str, found: &mut BTreeSet<String>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut at = 0;
    while at < tokens.len() {
        if is_test(&tokens[at..]) {
            // Up to the item's braces or semicolon.
            while at < tokens.len() && !ends_item(&tokens[at]) {
                at += 1;
            }
        } else if let TokenTree::Ident(ident) = &tokens[at] {
            let name = ident.to_string();
            let inline = matches!(tokens.get(at + 2), Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace);
            if name == "mod" && inline {
                let inner = [module, &[tokens[at + 1].to_string()]].concat();
                if let TokenTree::Group(group) = &tokens[at + 2] {
                    read(group.stream(), &inner, own_name, found);
                }
                at += 2;
            } else if name == "crate" || name == own_name {
                rooms_behind(&tokens, at + 1, found);
            } else if name == "super" {
                let supers = tokens[at..].chunks(3).take_while(|path| path[0].to_string() == "super").count();
                // The modules above this one: none is the crate.
                if supers >= module.len() {
                    rooms_behind(&tokens, at + 3 * supers - 2, found);
                }
                at += 3 * supers - 3;
            }
        } else if let TokenTree::Group(group) = &tokens[at] {
            read(group.stream(), module, own_name, found);
        }
        at += 1;
    }
}

/// The names behind `::` at a place: one, or those of a group.
fn rooms_behind(tokens: &[TokenTree], at: usize, found: &mut BTreeSet<String>) {
    let is_colon =
        |token: Option<&TokenTree>| matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == ':');
    if !is_colon(tokens.get(at)) || !is_colon(tokens.get(at + 1)) {
        return;
    }
    match tokens.get(at + 2) {
        Some(TokenTree::Ident(ident)) => {
            found.insert(ident.to_string());
        }
        Some(TokenTree::Group(group)) => {
            let mut first = true;
            for token in group.stream() {
                match token {
                    TokenTree::Ident(ident) if first => {
                        found.insert(ident.to_string());
                        first = false;
                    }
                    TokenTree::Punct(punct) if punct.as_char() == ',' => first = true,
                    _ => {}
                }
            }
        }
        _ => {}
    }
}

fn is_test(tokens: &[TokenTree]) -> bool {
    let [TokenTree::Punct(punct), TokenTree::Group(group), ..] = tokens else { return false };
    punct.as_char() == '#' && group.stream().to_string().replace(' ', "") == "cfg(test)"
}

fn ends_item(token: &TokenTree) -> bool {
    match token {
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        TokenTree::Punct(punct) => punct.as_char() == ';',
        _ => false,
    }
}

/// The doors that open outwards, and rooms that no ring has.
fn breaches(doors: &Doors, rings: &[&[&str]]) -> Vec<String> {
    let ring = |room: &str| rings.iter().position(|rooms| rooms.contains(&room));
    let breach = |((from, to), file): (&(String, String), &PathBuf)| {
        let message = match (ring(from), ring(to)) {
            (Some(from), Some(to)) if to < from => return None,
            (None, _) => format!("no ring has {from}"),
            // A macro or a constant of the crate's root.
            (_, None) => return None,
            _ => format!("{from} knows {to}"),
        };
        Some(format!("{message} ({})", file.display()))
    };
    doors.iter().filter_map(breach).collect()
}

fn assert_rings(src: &str, own_name: &str, rings: &[&[&str]]) {
    let doors = doors(&Path::new(env!("CARGO_MANIFEST_DIR")).join(src), own_name);
    assert!(doors.len() > 20, "only {} doors are found", doors.len());
    let breaches = breaches(&doors, rings);
    assert!(breaches.is_empty(), "{src}:\n{}", breaches.join("\n"));
}

#[test]
fn the_kernels_keep_their_rings() {
    assert_rings("../kernels/src", "caustics_kernels", KERNELS);
}

#[test]
fn the_host_keeps_its_rings() {
    assert_rings("../host/src", "caustics", HOST);
}

/// A path in a ring further out, however it is written, is found; a test's is not.
#[test]
fn detects_what_points_outwards() {
    let outwards = [
        "use crate::pass::resolve;",
        "use crate::{interface::NONE, pass};",
        "fn f() { crate::pass::f(); }",
        "use super::super::pass::resolve;",
        "mod inner { use super::super::super::pass::f; }",
        "use caustics_kernels::pass::f;",
    ];
    let module = ["math", "rng"].map(String::from);
    let rooms = |text: &str| {
        let mut found = BTreeSet::new();
        read(text.parse().expect("tokens"), &module, "caustics_kernels", &mut found);
        found
    };
    for text in outwards {
        assert!(rooms(text).contains("pass"), "{text}");
        let doors = Doors::from([(("math".to_string(), "pass".to_string()), PathBuf::from("a file"))]);
        assert_eq!(breaches(&doors, KERNELS).len(), 1);
    }
    for text in ["#[cfg(test)] mod tests { use crate::pass::f; }", "use super::pass::f;", "mod pass {}"] {
        assert!(!rooms(text).contains("pass"), "{text}");
    }
}
