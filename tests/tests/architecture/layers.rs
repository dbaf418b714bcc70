//! Imports point one way: each folder of a crate imports only folders that stand before it. Paths are read from the
//! sources' tokens, inline paths included; tests are not read.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, TokenStream, TokenTree};

use crate::root;

/// Layers of the kernels, innermost first; modules of one layer do not import each other.
const KERNELS: &[&[&str]] = &[
    &["interface", "memory", "platform"],
    &["math"],
    &["texture"],
    &["surface", "light"],
    &["trace"],
    &["declare"],
    &["gather", "path"],
    &["pass"],
    &["history", "denoiser", "emission"],
    &["method"],
    &["shared_entry"],
];

/// A crate of the host.
pub struct HostCrate {
    /// Folder of sources, from the root of the repository.
    pub src: &'static str,
    /// Name in paths.
    name: &'static str,
    layers: &'static [&'static [&'static str]],
}

/// Crates of the host; each depends only on those before it.
pub const HOST_CRATES: [HostCrate; 5] = [
    HostCrate { src: "host/files/src", name: "caustics_files", layers: FILES },
    HostCrate { src: "host/scene/src", name: "caustics_scene", layers: SCENE },
    HostCrate { src: "host/src", name: "caustics", layers: LIBRARY },
    HostCrate { src: "host/bench/src", name: "caustics_bench", layers: BENCH },
    HostCrate { src: "host/cli/src", name: "caustics_cli", layers: CLI },
];

/// Layers of files.
const FILES: &[&[&str]] = &[
    &["caught", "exact", "hash", "memory", "program", "rendered_image", "shell", "text"],
    &["file", "sealed"],
    &["output"],
    &["image_file"],
];

/// Layers of scenes.
const SCENE: &[&[&str]] = &[
    &[
        "animation",
        "borders",
        "buffers",
        "bvh",
        "camera",
        "corner",
        "environment",
        "error",
        "features",
        "find",
    ],
    &["geometry", "motion", "priorities", "radiance", "staging"],
    &[
        "casters",
        "deformation",
        "light",
        "open_surfaces",
        "punctual",
        "recorded",
        "solids",
        "texture",
        "viewpoint",
    ],
    &["default_light", "floor", "mesh"],
    &["instanced", "pose"],
    &["file_nodes", "fingerprint", "media"],
    &["edits", "gltf", "parts"],
];

/// Layers of the library.
const LIBRARY: &[&[&str]] = &[
    &["counters", "energy", "machine", "named", "oidn", "shard", "threads", "vulkan"],
    &["kernels"],
    &["render_config", "accumulation"],
    &["metric", "exposure"],
    &["runner", "checkpoint"],
    &["upload", "frame_memory"],
    &["session"],
    &["inspect"],
    &["trace_rate"],
    &["builder", "fuzzing"],
];

/// Layers of the experiments.
const BENCH: &[&[&str]] = &[
    &["gain", "identity", "plan", "record", "renamed", "run_config"],
    &["error", "limits", "memory", "parameter", "reference"],
    &["cost", "measure"],
    &["result"],
    &["run_parameters", "store", "table", "timing"],
    &["matrix", "report"],
    &["sweep"],
    &["fuzzing"],
];

/// Layers of the program.
const CLI: &[&[&str]] = &[&["cli"], &["commands_page"], &["command"]];

/// Imports between the top-level modules of a crate, each with the first file that has it.
type Imports = BTreeMap<(String, String), PathBuf>;

/// Reads the imports between a crate's top-level modules from its sources.
fn imports(src: &Path, own_name: &str) -> Imports {
    let mut imports = Imports::new();
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
        // Items of the crate's root are in no layer.
        found.retain(|name| *name != module[0] && src.join(name).with_extension("rs").is_file());
        for top_module in found {
            imports.entry((module[0].clone(), top_module)).or_insert_with(|| file.clone());
        }
    }
    imports
}

/// Sources below a folder, without tests in files of their own, sorted.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let is_test = |path: &Path| {
        path.components().any(|part| part.as_os_str() == "tests" || part.as_os_str() == "tests.rs")
    };
    let mut files = all_files(folder);
    files.retain(|file| !is_test(file.strip_prefix(folder).expect("below")));
    files
}

/// All sources below a folder, sorted.
pub fn all_files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            all.extend(all_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            all.push(path);
        }
    }
    all.sort();
    all
}

/// Adds the top-level modules that tokens of a module name.
fn read(tokens: TokenStream, module: &[String], own_name: &str, found: &mut BTreeSet<String>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut at = 0;
    while at < tokens.len() {
        if is_test(&tokens[at..]) {
            // Read up to the item's braces or semicolon.
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
                modules_behind(&tokens, at + 1, found);
            } else if name == "super" {
                let supers = tokens[at..].chunks(3).take_while(|path| path[0].to_string() == "super").count();
                // As many `super`s as modules lead to the crate's root.
                if supers >= module.len() {
                    modules_behind(&tokens, at + 3 * supers - 2, found);
                }
                at += 3 * supers - 3;
            }
        } else if let TokenTree::Group(group) = &tokens[at] {
            read(group.stream(), module, own_name, found);
        }
        at += 1;
    }
}

/// The names behind `::` at an index: one, or those of a group.
fn modules_behind(tokens: &[TokenTree], at: usize, found: &mut BTreeSet<String>) {
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

/// Imports of outer layers, and modules without a layer.
fn violations(imports: &Imports, layers: &[&[&str]]) -> Vec<String> {
    let layer = |top_module: &str| layers.iter().position(|modules| modules.contains(&top_module));
    let violation = |((from, to), file): (&(String, String), &PathBuf)| {
        let message = match (layer(from), layer(to)) {
            (Some(from), Some(to)) if to < from => return None,
            (None, _) => format!("no layer has {from}"),
            // A macro or a constant of the crate's root.
            (_, None) => return None,
            _ => format!("{from} knows {to}"),
        };
        Some(format!("{message} ({})", file.display()))
    };
    imports.iter().filter_map(violation).collect()
}

/// Path of a module, from its file.
type Module = Vec<String>;

/// Import graph of the modules of a crate.
struct ImportGraph {
    known: BTreeMap<Module, BTreeSet<Module>>,
    /// Path that a re-exported name leads to, by module and name.
    reexports: BTreeMap<(Module, String), Module>,
}

impl ImportGraph {
    /// Builds the graph from the sources of the modules.
    fn from_sources(sources: &BTreeMap<Module, String>, own_name: &str) -> ImportGraph {
        let mut graph = ImportGraph { known: BTreeMap::new(), reexports: BTreeMap::new() };
        let mut named = Vec::new();
        for (module, text) in sources {
            let mut paths = Vec::new();
            collect(text.parse().expect("a source parses"), module, own_name, &mut paths);
            named.extend(paths.into_iter().map(|path| (module.clone(), path)));
        }
        for (module, NamedPath { path, is_reexport }) in &named {
            if let (true, Some(name)) = (is_reexport, path.last()) {
                graph.reexports.insert((module.clone(), name.clone()), path.clone());
            }
        }
        for (module, NamedPath { path, is_reexport }) in &named {
            let resolved = graph.resolved(path, sources, 8);
            if !is_reexport && resolved != *module && sources.contains_key(&resolved) {
                graph.known.entry(module.clone()).or_default().insert(resolved);
            }
        }
        graph
    }

    /// Returns the module that a path leads to, following re-exports.
    fn resolved(&self, path: &[String], sources: &BTreeMap<Module, String>, steps: usize) -> Module {
        let mut module = Vec::new();
        for name in path {
            let inner = [&module[..], std::slice::from_ref(name)].concat();
            if sources.contains_key(&inner) {
                module = inner;
                continue;
            }
            return match self.reexports.get(&(module.clone(), name.clone())) {
                Some(path) if steps > 0 => self.resolved(path, sources, steps - 1),
                _ => module,
            };
        }
        module
    }

    /// Returns an import cycle, if there is one.
    fn cycle(&self) -> Option<Vec<Module>> {
        // Remove modules that import none of the rest, until none is left or every one imports another.
        let mut rest: BTreeSet<&Module> = self.known.keys().collect();
        let next = |module: &Module, rest: &BTreeSet<&Module>| {
            self.known.get(module)?.iter().find(|known| rest.contains(known)).cloned()
        };
        while let Some(&module) = rest.iter().find(|module| next(module, &rest).is_none()) {
            rest.remove(module);
        }
        let mut walk = vec![(*rest.first()?).clone()];
        loop {
            let module = next(walk.last()?, &rest)?;
            if let Some(start) = walk.iter().position(|known| *known == module) {
                return Some(walk.split_off(start));
            }
            walk.push(module);
        }
    }
}

/// A path from the crate's root that a module names.
struct NamedPath {
    path: Vec<String>,
    /// Whether it is a `pub use`.
    is_reexport: bool,
}

/// Adds the paths that tokens of a module name. A path that starts with a name starts at a child module, if there is
/// one.
fn collect(tokens: TokenStream, module: &[String], own_name: &str, found: &mut Vec<NamedPath>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let (mut at, mut is_reexport) = (0, false);
    while at < tokens.len() {
        if is_test(&tokens[at..]) {
            while at < tokens.len() && !ends_item(&tokens[at]) {
                at += 1;
            }
            at += 1;
            continue;
        }
        let is_behind = at > 0 && is_colon(&tokens[at - 1]);
        match tokens.get(at) {
            // The group behind a `use` was read with the path before it.
            Some(TokenTree::Group(group)) if !is_behind => collect(group.stream(), module, own_name, found),
            Some(TokenTree::Ident(ident)) if *ident == "use" => {
                let before: Vec<_> =
                    tokens[at.saturating_sub(2)..at].iter().map(ToString::to_string).collect();
                is_reexport = before.contains(&"pub".to_string());
            }
            Some(TokenTree::Ident(ident)) if !is_behind => {
                let name = ident.to_string();
                let (base, start) = match name.as_str() {
                    "crate" => (&[][..], at + 1),
                    _ if name == own_name => (&[][..], at + 1),
                    "self" => (module, at + 1),
                    _ => (module, at),
                };
                if tokens.get(at + 1).is_some_and(is_colon) && tokens.get(at + 2).is_some_and(is_colon) {
                    paths_behind(&tokens[start..], base, is_reexport, found);
                }
            }
            Some(TokenTree::Punct(punct)) if punct.as_char() == ';' => is_reexport = false,
            _ => {}
        }
        at += 1;
    }
}

fn is_colon(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == ':')
}

/// Adds the continuations of a module's path: names behind `::`, groups of them, and `super`.
fn paths_behind(tokens: &[TokenTree], base: &[String], is_reexport: bool, found: &mut Vec<NamedPath>) {
    let mut path = base.to_vec();
    for (at, token) in tokens.iter().enumerate() {
        let is_behind = at == 0 || is_colon(&tokens[at - 1]);
        match token {
            _ if is_colon(token) => {}
            TokenTree::Ident(ident) if *ident == "super" => _ = path.pop(),
            TokenTree::Ident(ident) if *ident == "self" => {}
            TokenTree::Ident(ident) if is_behind => path.push(ident.to_string()),
            TokenTree::Group(group) if is_behind && group.delimiter() == Delimiter::Brace => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                let is_comma = |token: &TokenTree| token.to_string() == ",";
                for part in inner.split(is_comma).filter(|part| !part.is_empty()) {
                    paths_behind(part, &path, is_reexport, found);
                }
                return;
            }
            _ => break,
        }
    }
    found.push(NamedPath { path, is_reexport });
}

/// Sources of a crate by module, except tests.
fn sources(src: &Path) -> BTreeMap<Module, String> {
    let source = |file: PathBuf| {
        let path = file.strip_prefix(src).expect("below").with_extension("");
        let module = path.components().map(|part| part.as_os_str().to_string_lossy().into_owned());
        (module.collect(), std::fs::read_to_string(&file).expect("a source"))
    };
    files(src).into_iter().map(source).collect()
}

/// Returns the number of imports between modules.
fn assert_layers(src: &str, own_name: &str, layers: &[&[&str]]) -> usize {
    let imports = imports(&root().join(src), own_name);
    let violations = violations(&imports, layers);
    assert!(violations.is_empty(), "{src}:\n{}", violations.join("\n"));
    imports.len()
}

#[test]
fn kernel_modules_import_only_inner_layers() {
    let count = assert_layers("kernels/src", "caustics_kernels", KERNELS);
    assert!(count > 20, "only {count} imports are found");
}

#[test]
fn host_modules_import_only_inner_layers() {
    let count: usize = HOST_CRATES.iter().map(|host| assert_layers(host.src, host.name, host.layers)).sum();
    assert!(count > 20, "only {count} imports are found");
}

/// A module and its children form no cycle either. A module does not import what it declares and re-exports (`pub
/// use`).
#[test]
fn host_modules_have_no_import_cycle() {
    let mut count = 0;
    for host in &HOST_CRATES {
        let mut sources = sources(&root().join(host.src));
        sources.retain(|module, _| !["lib", "main"].contains(&module[0].as_str()));
        let graph = ImportGraph::from_sources(&sources, host.name);
        count += graph.known.values().map(BTreeSet::len).sum::<usize>();
        let cycle =
            graph.cycle().map(|cycle| cycle.iter().map(|module| module.join("::")).collect::<Vec<_>>());
        assert_eq!(cycle, None, "{}", host.src);
    }
    assert!(count > 200, "only {count} imports are found");
}

/// A cycle is found however its paths are written; a path to a parent's re-export leads on to the definition.
#[test]
fn detects_an_import_cycle() {
    let cycle = |texts: &[(&str, &str)]| {
        let module = |path: &str| path.split("::").map(String::from).collect::<Module>();
        let sources = texts.iter().map(|(path, text)| (module(path), (*text).to_string())).collect();
        ImportGraph::from_sources(&sources, "caustics").cycle().map(|cycle| cycle.len())
    };
    let to_b = [
        "use super::b::B;",
        "use crate::a::{b::B, NONE};",
        "fn f() { super::b::f(); }",
        "use caustics::a::b;",
        "use super::{B as Other};",
    ];
    for text in to_b {
        let parent = "mod b; mod c; mod d; pub use self::b::B;";
        let files =
            [("a", parent), ("a::b", "use super::c::C;"), ("a::c", "use super::d::D;"), ("a::d", text)];
        assert_eq!(cycle(&files), Some(3), "{text}");
        let files = [("a", parent), ("a::b", ""), ("a::c", "use super::d::D;"), ("a::d", text)];
        assert_eq!(cycle(&files), None, "{text}");
    }
    for parent in ["mod b; struct A(b::B);", "mod b; use self::b::B;", "mod b; fn f() { b::f(); }"] {
        assert_eq!(cycle(&[("a", parent), ("a::b", "use super::A;")]), Some(2), "{parent}");
    }
    let test = "#[cfg(test)] mod tests { use crate::a::c::C; }";
    let files = [("a", "mod b; mod c;"), ("a::b", test), ("a::c", "use crate::a::b::B;")];
    assert_eq!(cycle(&files), None);
}

/// An import from an outer layer is found however it is written; an import of a test is not.
#[test]
fn detects_an_import_from_an_outer_layer() {
    let outwards = [
        "use crate::pass::resolve;",
        "use crate::{interface::NONE, pass};",
        "fn f() { crate::pass::f(); }",
        "use super::super::pass::resolve;",
        "mod inner { use super::super::super::pass::f; }",
        "use caustics_kernels::pass::f;",
    ];
    let module = ["math", "rng"].map(String::from);
    let modules = |text: &str| {
        let mut found = BTreeSet::new();
        read(text.parse().expect("tokens"), &module, "caustics_kernels", &mut found);
        found
    };
    for text in outwards {
        assert!(modules(text).contains("pass"), "{text}");
        let imports = Imports::from([(("math".to_string(), "pass".to_string()), PathBuf::from("a file"))]);
        assert_eq!(violations(&imports, KERNELS).len(), 1);
    }
    for text in ["#[cfg(test)] mod tests { use crate::pass::f; }", "use super::pass::f;", "mod pass {}"] {
        assert!(!modules(text).contains("pass"), "{text}");
    }
}
