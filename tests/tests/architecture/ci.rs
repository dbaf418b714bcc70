//! Names of tests in `.ci/` and in the documents exist, and a script of `.ci/` runs every ignored test.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

use proc_macro2::{TokenStream, TokenTree};

use crate::layers::all_files;
use crate::root;

/// Ignored tests that no script runs: a developer compares two builds by one; the test beside the other starts it as a
/// process.
const NOT_BY_SCRIPTS: [&str; 2] = ["images::every_image_has_the_recorded_hash", "caught::tests::child"];

/// Roots of the targets that have tests.
const TARGETS: [(&str, &str); 18] = [
    ("caustics-kernels", "kernels/src/lib.rs"),
    ("caustics-kernel-macros", "kernels/macros/src/lib.rs"),
    ("cargo-kernels", "kernels/command/src/main.rs"),
    ("kernel-builder", "kernels/builder/src/main.rs"),
    ("caustics", "host/src/lib.rs"),
    ("caustics-files", "host/files/src/lib.rs"),
    ("caustics-scene", "host/scene/src/lib.rs"),
    ("caustics-bench", "host/bench/src/lib.rs"),
    ("caustics-cli", "host/cli/src/main.rs"),
    ("caustics-scenes", "scenes/src/lib.rs"),
    ("caustics-tests", "tests/src/lib.rs"),
    ("program", "host/cli/tests/program/main.rs"),
    ("measure", "host/cli/tests/measure/main.rs"),
    ("gpu", "tests/tests/gpu/main.rs"),
    ("architecture", "tests/tests/architecture/main.rs"),
    ("kernels", "tests/tests/kernels/main.rs"),
    ("light", "tests/tests/light/main.rs"),
    ("methods", "tests/tests/methods/main.rs"),
];

/// A test by its path in libtest.
#[derive(Clone, Debug, PartialEq)]
struct Test {
    /// Package of a unit test, or target of an integration test.
    target: &'static str,
    /// Modules and name.
    path: String,
    is_ignored: bool,
}

/// All tests of the repository, read from the tokens of its sources.
fn tests() -> &'static [Test] {
    static TESTS: LazyLock<Vec<Test>> = LazyLock::new(read_tests);
    &TESTS
}

fn read_tests() -> Vec<Test> {
    let mut tests = Vec::new();
    for (target, main) in TARGETS {
        let folder = root().join(main).parent().unwrap().to_path_buf();
        for file in all_files(&folder) {
            let module = file.strip_prefix(&folder).unwrap().with_extension("");
            let mut module: Vec<_> =
                module.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
            module.retain(|name| name != "main" && name != "lib");
            let tokens = std::fs::read_to_string(&file).unwrap().parse().expect("a source parses");
            collect(target, tokens, &module, &mut tests);
        }
    }
    tests
}

/// Adds the tests among the tokens of a module.
fn collect(target: &'static str, tokens: TokenStream, module: &[String], tests: &mut Vec<Test>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let (mut is_test, mut is_ignored) = (false, false);
    for (at, token) in tokens.iter().enumerate() {
        match token {
            TokenTree::Group(group) => {
                let is_attribute = at > 0 && tokens[at - 1].to_string() == "#";
                let name = group.stream().into_iter().next().map(|name| name.to_string());
                match name.as_deref() {
                    Some("test") if is_attribute => is_test = true,
                    Some("ignore") if is_attribute => is_ignored = true,
                    _ if is_attribute => {}
                    _ => {
                        let is_module = at > 1 && tokens[at - 2].to_string() == "mod";
                        let inner = is_module.then(|| [module, &[tokens[at - 1].to_string()]].concat());
                        collect(target, group.stream(), inner.as_deref().unwrap_or(module), tests);
                    }
                }
            }
            TokenTree::Ident(ident) if *ident == "fn" => {
                if let (true, Some(name)) = (is_test, tokens.get(at + 1)) {
                    let path = [module, &[name.to_string()]].concat().join("::");
                    tests.push(Test { target, path, is_ignored });
                }
                (is_test, is_ignored) = (false, false);
            }
            _ => {}
        }
    }
}

/// Words of `.ci/` that name tests: words with `::`, or of three parts and more, outside of comments.
fn words_of_ci(text: &str) -> BTreeSet<String> {
    let code = text.lines().filter(|line| !line.trim_start().starts_with('#'));
    let words = code.flat_map(|line| {
        line.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':')
            .map(str::to_string)
            .collect::<Vec<_>>()
    });
    words.filter(|word| names_tests(word)).collect()
}

fn names_tests(word: &str) -> bool {
    let is_name = word.starts_with(|c: char| c.is_ascii_lowercase());
    is_name && (word.contains("::") || word.matches('_').count() > 1)
}

/// Scripts of `.ci/`.
fn scripts() -> Vec<(PathBuf, String)> {
    let mut paths: Vec<_> =
        root().join(".ci").read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), std::fs::read_to_string(path).unwrap())).collect()
}

/// Ignored tests whose path contains none of the words.
fn never_run<'a>(tests: &'a [Test], words: &BTreeSet<String>) -> Vec<&'a str> {
    let ignored = tests.iter().filter(|test| test.is_ignored).map(|test| test.path.as_str());
    ignored.filter(|path| !words.iter().any(|word| path.contains(word.as_str()))).collect()
}

#[test]
fn every_ignored_test_is_run_by_a_script_of_ci() {
    let tests = tests();
    assert!(tests.len() > 1000, "only {} tests are found", tests.len());
    let words = scripts().iter().flat_map(|(_, text)| words_of_ci(text)).collect();
    let mut never_run = never_run(tests, &words);
    never_run.retain(|path| !NOT_BY_SCRIPTS.contains(path));
    assert_eq!(never_run, [""; 0]);
}

#[test]
fn every_path_of_a_test_that_ci_names_exists() {
    let tests = tests();
    for (script, text) in scripts() {
        for word in words_of_ci(&text).iter().filter(|word| word.contains("::")) {
            let is_known = tests.iter().any(|test| test.path.contains(word.as_str()));
            assert!(is_known, "{}: no test is called {word}", script.display());
        }
    }
}

/// Commands of a script or a document that run `cargo test` with arguments, joined to one line each.
fn test_commands(text: &str) -> Vec<String> {
    let joined = text.replace("\\\n", " ");
    let lines = joined.lines().filter(|line| line.contains("cargo test"));
    lines.map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect()
}

/// Commands that choose tests by name without a check by `tested` or `all_ran`.
fn unchecked(text: &str) -> Vec<String> {
    let is_unchecked = |line: &String| {
        let arguments = line.split_once("cargo test").map_or("", |(_, arguments)| arguments);
        let is_checked = ["tested ", "--list"].iter().any(|word| line.contains(word));
        !line.starts_with('#') && arguments.contains(" -- ") && !is_checked
    };
    let commands = test_commands(text);
    commands.into_iter().filter(is_unchecked).collect()
}

#[test]
fn every_filtered_run_of_tests_in_ci_fails_if_a_filter_matches_nothing() {
    let mut count = 0;
    for (script, text) in scripts() {
        count += text.matches("tested ").count();
        let mut unchecked = unchecked(&text);
        // Its command writes a log, which the script passes to `all_ran`.
        unchecked.retain(|line| !(script.ends_with("mutate") && line.contains("> \"$WORK/log\"")));
        assert_eq!(unchecked, [""; 0], "{}", script.display());
    }
    assert!(count > 5, "{count} runs");
    assert!(
        scripts()
            .iter()
            .any(|(path, text)| path.ends_with("mutate") && text.contains("all_ran \"$WORK/log\""))
    );
}

/// Runs a Bash script after sourcing `.ci/tested`.
fn bash(script: &str) -> Output {
    let script = format!("set -euo pipefail\n. .ci/tested\n{script}");
    Command::new("bash").current_dir(root()).args(["-c", &script]).output().unwrap()
}

/// Names that match nothing in the output of libtest are found: one name or several, in part or exact.
#[test]
fn detects_a_filter_that_matches_no_test_that_ran() {
    let log = "\
running 5 tests
test a::long::one ... ok
test a::two ... ignored, takes a minute
50 %test b::three ... ok
test b::four - should panic ... ok
test b::five ... on lavapipe (Mesa), validation true
test result: ok. 4 passed; 0 failed; 1 ignored; 0 measured; 20 filtered out
";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    let ran = |log: &str, names: &str| {
        std::fs::write(&path, log).unwrap();
        bash(&format!("all_ran '{}' {names}", path.display()))
    };
    for names in [
        "",
        "long::",
        "long:: three",
        "--ignored --nocapture five four",
        "--exact b::three",
        "--test-threads 1 one",
    ] {
        let output = ran(log, names);
        assert!(output.status.success(), "{names}: {}", String::from_utf8_lossy(&output.stderr));
    }
    for (names, missing) in [
        ("release::", "release::"),
        ("long:: release::", "release::"),
        ("two", "two"),
        ("--exact three", "three"),
        ("--skip long:: no_such_test", "no_such_test"),
        ("passed", "passed"),
    ] {
        let output = ran(log, names);
        let message = format!("no test ran that is called '{missing}'\n");
        assert_eq!(String::from_utf8_lossy(&output.stderr), message, "{names}");
        assert!(!output.status.success(), "{names}");
    }
    assert!(!ran("running 0 tests\n\ntest result: ok. 0 passed\n", "").status.success());
}

/// `tested` fails with its command, and with a name that no test has.
#[test]
fn detects_a_command_whose_name_matches_no_test() {
    let libtest = "cargo() { echo 'test a::one ... ok'; echo 'test a::two ... ok' >&2; }\n";
    for (command, succeeds) in [
        ("tested cargo test --test x -- --nocapture a:: one two", true),
        ("tested cargo test --test x -- --nocapture a:: one three", false),
        ("tested cargo test --test x -- three", false),
        ("tested false -- one", false),
    ] {
        assert_eq!(bash(&format!("{libtest}{command}")).status.success(), succeeds, "{command}");
    }
    assert_eq!(unchecked("vulkan cargo test --workspace \\\n    --test gpu -- --ignored vulkan::").len(), 1);
    assert_eq!(unchecked("tested cargo test -- one\ncargo test --workspace\n# cargo test -- one"), [""; 0]);
}

/// Names in a command of a document that match nothing, behind "--test", "-p" or as a filter.
fn unknown_names(command: &str, tests: &[Test]) -> Vec<String> {
    let mut unknown = Vec::new();
    let (_, arguments) = command.split_once("cargo test").expect("a command");
    // Stop at a comment, or at the end of code in a line of text.
    let arguments = arguments.split(['`', '#', ')', '"']).next().unwrap();
    let mut words = arguments.split_whitespace();
    while let Some(word) = words.next() {
        let is_known = match word {
            "--test" | "-p" | "--package" => {
                let name = words.next().unwrap_or_default();
                TARGETS.iter().any(|(target, _)| *target == name)
            }
            "--bin" => words.next() == Some("caustics"),
            _ if word.starts_with('-') => true,
            _ => tests.iter().any(|test| test.path.contains(word)),
        };
        if !is_known {
            unknown.push(format!("{word} in {command}"));
        }
    }
    unknown
}

/// The documents of the project.
pub fn documents() -> Vec<PathBuf> {
    let mut documents = Vec::new();
    for folder in [
        ".",
        ".github",
        "docs",
        "docs/decisions",
        "experiments",
        "experiments/peers",
        "experiments/results",
        "fuzz",
        "tests/corpus",
        "tests/browser",
        "scenes",
    ] {
        let Ok(entries) = root().join(folder).read_dir() else {
            continue;
        };
        let files = entries.map(|entry| entry.unwrap().path());
        documents.extend(files.filter(|path| path.extension().is_some_and(|extension| extension == "md")));
    }
    documents.sort();
    documents
}

#[test]
fn every_test_that_a_document_names_exists() {
    let tests = tests();
    let mut command_count = 0;
    let sources =
        [Path::new("host/cli/src/commands_page.rs"), Path::new("tests/tests/architecture/images.rs")];
    for path in documents().into_iter().chain(sources.map(|path| root().join(path))) {
        for command in test_commands(&std::fs::read_to_string(&path).unwrap()) {
            assert_eq!(unknown_names(&command, tests), [""; 0], "{}", path.display());
            command_count += 1;
        }
    }
    assert!(command_count > 8, "only {command_count} commands are found");
}

#[test]
fn detects_a_document_that_names_no_test() {
    let test = |path: &str| Test { target: "architecture", path: path.into(), is_ignored: false };
    let tests = [test("gathers::every_gather_is_brute_force")];
    let unknown = |command| unknown_names(command, &tests).len();
    assert_eq!(unknown("A=1 cargo test --workspace --test kernels gathers # all"), 0);
    assert_eq!(unknown("text (`cargo test -p caustics-tests -- --ignored gathers::`) and more"), 0);
    assert_eq!(unknown("cargo test --workspace gatherers"), 1);
    assert_eq!(unknown("cargo test --test nothing -- --ignored long:: gathers::"), 2);
}

/// Tests in modules and in macros are found, with their `ignore` attributes, and so is an ignored test that no script
/// names.
#[test]
fn detects_an_ignored_test_that_no_script_runs() {
    let text = "
        mod long { #[test] #[ignore = \"slow\"] fn a() {} mod b { #[ignore] #[test] fn c() {} fn d() {} } }
        proptest! { #![config] #[test] fn e(x in 0..2) { fn f() {} } }
        #[cfg(test)] mod tests { #[test] fn g() -> Result {} }";
    let mut tests = Vec::new();
    collect("architecture", text.parse().unwrap(), &["file".to_string()], &mut tests);
    let found: Vec<_> = tests.iter().map(|test| (test.path.as_str(), test.is_ignored)).collect();
    let expected =
        [("file::long::a", true), ("file::long::b::c", true), ("file::e", false), ("file::tests::g", false)];
    assert_eq!(found, expected);
    let words = words_of_ci("# slow::\ntested cargo test -- --ignored long::b:: leaves_a_report x_y");
    assert_eq!(words, ["leaves_a_report", "long::b::"].map(String::from).into());
    assert_eq!(never_run(&tests, &words), ["file::long::a"]);
}

/// Scripts of `.ci/` and the builder of the kernels as a text names them, each with the options behind it.
fn script_options(text: &str) -> Vec<(String, Vec<String>)> {
    let is_mark = |c: char| !c.is_alphanumeric();
    let trimmed = |word: &str| {
        let start = word.trim_end_matches(is_mark);
        start.trim_start_matches(|c: char| is_mark(c) && !"-.".contains(c)).to_string()
    };
    let words: Vec<String> = text.split_whitespace().map(trimmed).collect();
    let mut found = Vec::new();
    for (at, word) in words.iter().enumerate() {
        let name = match word.split_once(".ci/") {
            Some(("", name)) if !name.is_empty() => format!(".ci/{name}"),
            _ if word == "kernels" && at > 0 && words[at - 1] == "cargo" => "cargo kernels".into(),
            _ => continue,
        };
        let options = words[at + 1..].iter().take_while(|word| word.starts_with("--"));
        found.push((name, options.cloned().collect()));
    }
    found
}

/// Named scripts and options that do not exist.
fn unknown_options(text: &str, source: impl Fn(&str) -> Option<String>) -> Vec<String> {
    let is_unknown = |(name, options): &(String, Vec<String>)| {
        let source = source(name);
        source.is_none_or(|source| options.iter().any(|option| !source.contains(option.as_str())))
    };
    let named = script_options(text).into_iter().filter(is_unknown);
    named.map(|(name, options)| [&[name], &options[..]].concat().join(" ")).collect()
}

/// Source of a script, or the sources of the kernel builder.
fn source_of(name: &str) -> Option<String> {
    let builder = ["kernels/builder/src/main.rs", "kernels/command/src/main.rs"];
    let files = if name == "cargo kernels" { &builder[..] } else { &[name][..] };
    files.iter().map(|file| std::fs::read_to_string(root().join(file)).ok()).collect()
}

#[test]
fn every_script_and_option_that_a_document_names_exists() {
    let mut count = 0;
    for path in documents() {
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(unknown_options(&text, source_of), [""; 0], "{}", path.display());
        count += script_options(&text).len();
    }
    assert!(count > 20, "only {count} scripts are named");
}

#[test]
fn detects_a_script_or_an_option_that_is_not_there() {
    let source =
        |name: &str| [".ci/run", "cargo kernels"].contains(&name).then(|| "--long --check".to_string());
    let unknown = |text: &str| unknown_options(text, source);
    assert_eq!(
        unknown("`.ci/run --long`, or .ci/run.\n(`cargo kernels --check`) of .ci/ and cargo kernels:"),
        [""; 0]
    );
    assert_eq!(
        unknown("`.ci/runs`, .ci/run --short, cargo kernels --check --fix"),
        [".ci/runs", ".ci/run --short", "cargo kernels --check --fix"]
    );
}
