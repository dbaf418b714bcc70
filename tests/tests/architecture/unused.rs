//! Every dependency of a manifest is named by the code that it is declared for.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use serde_json::Value;

use crate::layers::all_files;
use crate::root;

/// Manifests of the repository: the workspace, and the packages outside of it.
const MANIFESTS: [&str; 3] = ["Cargo.toml", "fuzz/Cargo.toml", "kernels/builder/Cargo.toml"];

/// Packages of a manifest. Cargo resolves nothing here: it needs neither a lock file nor a network.
fn packages(manifest: &Path) -> Vec<Value> {
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let arguments = ["metadata", "--offline", "--no-deps", "--format-version", "1", "--manifest-path"];
    let output = Command::new(cargo).args(arguments).arg(manifest).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

/// Names of crates in a package's code.
#[derive(Default)]
struct Named {
    /// Code of libraries and programs, except tests.
    program: BTreeSet<String>,
    tests: BTreeSet<String>,
    build: BTreeSet<String>,
}

impl Named {
    /// Reads the sources of all targets of a package.
    fn new(package: &Value) -> Named {
        let mut named = Named::default();
        for target in package["targets"].as_array().unwrap() {
            let path = PathBuf::from(target["src_path"].as_str().unwrap());
            let is_kind = |kinds: &[&str]| kinds.iter().any(|kind| target["kind"][0] == **kind);
            for file in sources(&path) {
                let is_test_file = file.strip_prefix(path.parent().unwrap()).is_ok_and(|below| {
                    below
                        .components()
                        .any(|part| ["tests", "tests.rs"].iter().any(|name| part.as_os_str() == *name))
                });
                let Crates { mut program, tests } = Crates::new(&std::fs::read_to_string(&file).unwrap());
                if is_kind(&["custom-build"]) {
                    named.build.append(&mut program);
                } else if is_kind(&["test", "bench", "example"]) || is_test_file {
                    named.tests.append(&mut program);
                } else {
                    named.program.append(&mut program);
                }
                named.tests.extend(tests);
            }
        }
        named
    }

    /// Whether code for a kind of dependency (`null` for a normal one) names a crate.
    fn has(&self, kind: &Value, name: &str) -> bool {
        match kind.as_str() {
            None => self.program.contains(name),
            Some("build") => self.build.contains(name),
            Some(_) => self.program.contains(name) || self.tests.contains(name),
        }
    }
}

/// Source files of a target: the root's folder where the root is its main file, and files that `#[path]` names.
fn sources(root: &Path) -> BTreeSet<PathBuf> {
    let is_main = ["lib.rs", "main.rs"].iter().any(|name| root.ends_with(name));
    let mut open = if is_main { all_files(root.parent().unwrap()) } else { vec![root.to_path_buf()] };
    let mut sources = BTreeSet::new();
    while let Some(file) = open.pop() {
        let text = std::fs::read_to_string(&file).unwrap();
        let paths =
            text.lines().filter_map(|line| line.trim().strip_prefix("#[path = \"")?.strip_suffix("\"]"));
        open.extend(paths.map(|path| file.parent().unwrap().join(path)));
        sources.insert(file);
    }
    sources
}

/// First names of the paths in a source file; they may be crates.
#[derive(Default)]
struct Crates {
    program: BTreeSet<String>,
    /// First names in items with `#[cfg(test)]`.
    tests: BTreeSet<String>,
}

impl Crates {
    fn new(text: &str) -> Crates {
        let tokens: TokenStream = text.parse().expect("a source parses");
        let mut local = BTreeSet::new();
        collect_local(tokens.clone(), &mut local);
        let mut crates = Crates::default();
        crates.collect(tokens, false, &local);
        crates
    }

    /// Adds the first names of the paths of tokens. `name::` is no crate where the file itself declares or imports
    /// `name`.
    fn collect(&mut self, tokens: TokenStream, in_test: bool, local: &BTreeSet<String>) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut test_end = 0;
        for at in 0..tokens.len() {
            if is_test(&tokens[at..]) {
                let length =
                    tokens[at + 2..].iter().position(ends_item).map_or(tokens.len(), |length| length + 3);
                test_end = test_end.max(at + length);
            }
            let in_test = in_test || at < test_end;
            let found = if in_test { &mut self.tests } else { &mut self.program };
            match &tokens[at] {
                TokenTree::Group(group) => {
                    if at > 0 && is(&tokens[at - 1], "use") {
                        let parts: Vec<TokenTree> = group.stream().into_iter().collect();
                        let first = parts.split(|token| is(token, ",")).filter_map(|part| part.first());
                        found.extend(first.map(ToString::to_string));
                    }
                    self.collect(group.stream(), in_test, local);
                }
                TokenTree::Ident(ident) => {
                    let name = ident.to_string();
                    let is_inner = at > 1 && is_separator(&tokens[at - 2..]);
                    // A path `::name` starts at a crate even where `name` is local.
                    let is_absolute = is_inner
                        && (at < 3
                            || !matches!(&tokens[at - 3], TokenTree::Ident(_)) && !is(&tokens[at - 3], ">"));
                    let is_imported = at > 0 && (is(&tokens[at - 1], "use") || is(&tokens[at - 1], "crate"));
                    let starts_path = !is_inner && is_separator(&tokens[at + 1..]);
                    if is_absolute
                        || is_imported && !is_separator(&tokens[at + 1..])
                        || starts_path && !local.contains(&name)
                    {
                        found.insert(name);
                    }
                }
                _ => {}
            }
        }
    }
}

/// Adds the names of modules that tokens declare, and names that they import from elsewhere.
fn collect_local(tokens: TokenStream, local: &mut BTreeSet<String>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    for (at, token) in tokens.iter().enumerate() {
        match token {
            TokenTree::Ident(ident) if *ident == "mod" => {
                local.extend(tokens.get(at + 1).map(ToString::to_string));
            }
            TokenTree::Ident(ident) if *ident == "use" => {
                let end =
                    tokens[at..].iter().position(|token| is(token, ";")).map_or(tokens.len(), |end| at + end);
                collect_imported(&tokens[at + 1..end], true, local);
            }
            TokenTree::Group(group) => collect_local(group.stream(), local),
            _ => {}
        }
    }
}

/// Adds the last names of a `use`'s paths; a path of one name is the crate itself.
fn collect_imported(path: &[TokenTree], is_start: bool, local: &mut BTreeSet<String>) {
    match path {
        [.., TokenTree::Group(group)] if group.delimiter() == Delimiter::Brace => {
            let parts: Vec<TokenTree> = group.stream().into_iter().collect();
            for part in parts.split(|token| is(token, ",")).filter(|part| !part.is_empty()) {
                collect_imported(part, is_start && path.len() == 1, local);
            }
        }
        [.., last] if !is_start || path.len() > 1 => {
            local.insert(last.to_string());
        }
        _ => {}
    }
}

fn is(token: &TokenTree, text: &str) -> bool {
    !matches!(token, TokenTree::Group(_)) && token.to_string() == text
}

fn is_separator(tokens: &[TokenTree]) -> bool {
    matches!(tokens, [first, second, ..] if is(first, ":") && is(second, ":"))
}

fn is_test(tokens: &[TokenTree]) -> bool {
    let [hash, TokenTree::Group(group), ..] = tokens else { return false };
    is(hash, "#") && group.stream().to_string().replace(' ', "") == "cfg(test)"
}

fn ends_item(token: &TokenTree) -> bool {
    match token {
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        _ => is(token, ";"),
    }
}

/// Dependencies that the code they are declared for does not name: "PACKAGE: KIND NAME".
fn unused(packages: &[Value]) -> Vec<String> {
    let mut unused = Vec::new();
    for package in packages {
        let named = Named::new(package);
        for dependency in package["dependencies"].as_array().unwrap() {
            let name = dependency["rename"].as_str().or(dependency["name"].as_str()).unwrap();
            let kind = &dependency["kind"];
            if !named.has(kind, &name.replace('-', "_")) {
                let kind = kind.as_str().unwrap_or("normal");
                unused.push(format!("{}: {kind} {name}", package["name"].as_str().unwrap()));
            }
        }
    }
    unused
}

/// Entries of `[workspace.dependencies]` that no package uses.
fn unused_of_workspace(manifest: &str, packages: &[Value]) -> Vec<String> {
    let section = manifest.lines().skip_while(|line| *line != "[workspace.dependencies]").skip(1);
    let names = section.take_while(|line| !line.starts_with('[')).filter_map(|line| line.split_once(" = "));
    let is_used = |name: &str| {
        let dependencies = packages.iter().flat_map(|package| package["dependencies"].as_array().unwrap());
        dependencies.into_iter().any(|dependency| dependency["name"] == name || dependency["rename"] == name)
    };
    names.map(|(name, _)| name.to_string()).filter(|name| !is_used(name)).collect()
}

#[test]
fn every_dependency_is_named_by_the_code_it_is_declared_for() {
    let mut dependency_count = 0;
    for manifest in MANIFESTS {
        let packages = packages(&root().join(manifest));
        let dependencies = packages.iter().map(|package| package["dependencies"].as_array().unwrap().len());
        dependency_count += dependencies.sum::<usize>();
        assert_eq!(unused(&packages), [""; 0], "{manifest}");
        let text = std::fs::read_to_string(root().join(manifest)).unwrap();
        assert_eq!(unused_of_workspace(&text, &packages), [""; 0], "{manifest}");
    }
    assert!(dependency_count > 50, "only {dependency_count} dependencies are found");
}

/// Writes a package with these dependency sections, library and build script, and returns its unused dependencies.
fn unused_of(sections: &str, library: &str, build: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let write = |path: &str, text: &str| {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    write(
        "Cargo.toml",
        &format!("[package]\nname = \"planted\"\nedition = \"2024\"\n[workspace]\n{sections}"),
    );
    write("src/lib.rs", library);
    write("src/deep/file.rs", "fn f() { deep::f(); }");
    write("tests/suite/main.rs", "use in_suite::f;");
    write("build.rs", build);
    write("shared/included.rs", "fn f() { included::f(); }");
    unused(&packages(&folder.path().join("Cargo.toml")))
}

#[test]
fn detects_planted_unused_dependencies() {
    let sections = "[dependencies]\nname-d = \"1\"\n";
    let uses = [
        "use name_d;",
        "use name_d as other;",
        "use name_d::{self, a};",
        "use {std::mem, name_d::a};",
        "use {name_d};",
        "extern crate name_d;",
        "fn f() { let x = [name_d::f()]; }",
        "#[name_d::main] fn f() {}",
        "fn f() -> <A as name_d::B>::C {}",
        "use crate::name_d; fn f() { ::name_d::f(); }",
    ];
    for text in uses {
        assert_eq!(unused_of(sections, text, ""), [""; 0], "{text}");
    }
    let no_uses = [
        "// name_d::f",
        "/// `name_d::f`\nfn f() { \"name_d::f\"; }",
        "fn name_d() { let name_d = 1; }",
        "mod name_d; fn f() { name_d::f(); }",
        "use crate::name_d; fn f() { name_d::f(); }",
        "use other::{a, name_d}; fn f() { name_d::f(); }",
        "use crate::a as name_d; fn f() { name_d::f(); }",
        "fn f() { other::name_d::f(); A::<B>::name_d::f(); }",
        // Tests take a crate from [dev-dependencies].
        "#[cfg(test)] mod tests { use name_d::f; }",
    ];
    for text in no_uses {
        assert_eq!(unused_of(sections, text, ""), ["planted: normal name-d"], "{text}");
    }
}

/// Each kind of dependency serves code of its own; a renamed one is known by its new name.
#[test]
fn detects_dependencies_of_the_wrong_kind() {
    let sections = "[dependencies]\ndeep = \"1\"\nin_suite = \"1\"\nother = { version = \"1\", package = \"a\" }\n\
        [target.'cfg(unix)'.dependencies]\nbuilds = \"1\"\n\
        [dev-dependencies]\nin_tests = \"1\"\nnowhere = \"1\"\n[build-dependencies]\nbuilds = \"1\"\nincluded = \"1\"\ndeep = \"1\"\n";
    let library = "use other::f;\n#[cfg(test)]\nmod tests { use in_tests::f; }";
    let build = "#[path = \"shared/included.rs\"]\nmod included;\nfn main() { builds::f(); }";
    let found: BTreeSet<String> = unused_of(sections, library, build).into_iter().collect();
    let expected = ["build deep", "dev nowhere", "normal builds", "normal in_suite"];
    assert_eq!(found, expected.map(|entry| format!("planted: {entry}")).into());
    let packages = [serde_json::json!({ "dependencies": [{ "name": "a", "rename": null }] })];
    let manifest =
        "[workspace.dependencies]\na = \"1\"\nb = { version = \"1\" }\n[profile.dev]\nopt-level = 2\n";
    assert_eq!(unused_of_workspace(manifest, &packages), ["b"]);
}
