//! Rust code in the documents, and in examples of doc comments that are not compiled, quotes a compiled file.

use std::path::Path;

use crate::ci::documents;
use crate::layers::all_files;
use crate::root;

/// Line of a block that stands for omitted lines.
const LEFT_OUT: &str = "// ...";

/// A fenced block of a document.
#[derive(Debug, PartialEq)]
struct Block {
    /// Line of the fence (from 1).
    line: usize,
    /// Text behind the fence.
    info: String,
    /// The last source file that the text before it names.
    file: Option<String>,
    lines: Vec<String>,
}

/// Returns the fenced blocks of Markdown, and its indented lines of code as blocks without a language.
fn blocks(text: &str) -> Vec<Block> {
    let (mut blocks, mut open, mut file): (Vec<Block>, Option<(String, Block)>, _) = (Vec::new(), None, None);
    for (at, line) in text.lines().enumerate() {
        let trimmed = line.trim_start();
        let marks: String = trimmed.chars().take_while(|mark| ['`', '~'].contains(mark)).collect();
        match &mut open {
            Some((fence, _)) if trimmed.trim_end() == fence => {
                blocks.extend(open.take().map(|(_, block)| block));
            }
            Some((_, block)) => block.lines.push(line.to_string()),
            None => {
                let info = trimmed[marks.len()..].trim().to_string();
                let block = Block { line: at + 1, info, file: file.clone(), lines: Vec::new() };
                if marks.len() > 2 {
                    open = Some((marks, block));
                } else if line.starts_with("    ") && is_rust(trimmed) {
                    blocks.push(Block { info: String::new(), lines: vec![line.to_string()], ..block });
                } else {
                    let is_part = |c: char| c.is_alphanumeric() || "_./-".contains(c);
                    let mut names = line.split(|c| !is_part(c)).filter(|name| name.ends_with(".rs"));
                    file = names.next_back().map(str::to_string).or(file);
                }
            }
        }
    }
    assert_eq!(open, None, "a block without an end");
    blocks
}

/// Returns the doc comments of a source; all other lines are empty, so that line numbers stay.
fn doc_comments(source: &str) -> String {
    let line = |line: &str| {
        let line = line.trim_start();
        let text = line.strip_prefix("//!").or(line.strip_prefix("///")).unwrap_or_default();
        format!("{}\n", text.strip_prefix(' ').unwrap_or(text))
    };
    source.lines().map(line).collect()
}

/// Whether a line of a block without a language is Rust.
fn is_rust(line: &str) -> bool {
    let line = line.trim();
    let starts =
        ["use ", "pub ", "fn ", "impl ", "let ", "mod ", "struct ", "enum ", "static ", "const ", "#["];
    starts.iter().any(|start| line.starts_with(start)) && line.ends_with([';', '{', '}', ']', ','])
}

/// Whether a block holds Rust, by its language or, without one, by its lines.
fn holds_rust(block: &Block) -> bool {
    let language = block.info.split([',', ' ', '{']).next().unwrap_or_default();
    match language {
        "rust" | "rs" => true,
        "" | "text" | "ignore" => block.lines.iter().any(|line| is_rust(line)),
        _ => false,
    }
}

/// Whether lines are runs of a file's lines, in the order of the file; each run may have another indentation.
fn is_quote(lines: &[String], file: &str) -> bool {
    let indent = |line: &str| line.len() - line.trim_start().len();
    let min_indent =
        lines.iter().filter(|line| !line.trim().is_empty()).map(|line| indent(line)).min().unwrap_or(0);
    let lines: Vec<&str> = lines.iter().map(|line| line.get(min_indent..).unwrap_or_default()).collect();
    let file: Vec<&str> = file.lines().collect();
    let mut start = 0;
    let runs = lines.split(|line| line.trim() == LEFT_OUT).map(|run| {
        let first = run.iter().position(|line| !line.trim().is_empty()).unwrap_or(run.len());
        let last = run.iter().rposition(|line| !line.trim().is_empty()).map_or(first, |last| last + 1);
        &run[first..last]
    });
    let mut count = 0;
    for run in runs.filter(|run| !run.is_empty()) {
        let matches = |at: usize| {
            let shift = indent(file[at]).checked_sub(indent(run[0]))?;
            let same = |(line, quoted): (&&str, &&str)| line.get(shift..).unwrap_or_default() == *quoted;
            let there = file.get(at..at + run.len())?;
            there.iter().zip(run).all(same).then_some(at + run.len())
        };
        let Some(next) = (start..file.len()).find_map(matches) else { return false };
        start = next;
        count += 1;
    }
    count > 0
}

/// Describes the fault of a block that holds Rust.
fn fault(block: &Block, read: impl Fn(&str) -> Option<String>) -> Option<String> {
    let Some(name) = &block.file else {
        return Some(format!("line {}: no file is named that this code is of", block.line));
    };
    match read(name) {
        None => Some(format!("line {}: no source file {name}", block.line)),
        Some(file) if !is_quote(&block.lines, &file) => {
            Some(format!("line {}: not a quote of {name}", block.line))
        }
        Some(_) => None,
    }
}

/// Returns a source file that is compiled, by its path from the root of the repository.
fn compiled(name: &str) -> Option<String> {
    let is_compiled =
        ["kernels", "host", "scenes", "tests"].iter().any(|folder| Path::new(name).starts_with(folder));
    is_compiled.then(|| std::fs::read_to_string(root().join(name)).ok()).flatten()
}

#[test]
fn rust_in_the_documents_is_a_quote_of_a_compiled_file() {
    let mut count = 0;
    for page in documents() {
        let text = std::fs::read_to_string(&page).unwrap();
        for block in blocks(&text).iter().filter(|block| holds_rust(block)) {
            assert_eq!(fault(block, compiled), None, "{}", page.display());
            count += 1;
        }
    }
    assert!(count > 2, "only {count} blocks are found");
}

/// Checks examples that rustdoc does not compile; the others are tests of their own.
#[test]
fn ignored_examples_of_doc_comments_are_quotes_of_compiled_files() {
    let mut count = 0;
    for file in
        ["kernels", "host", "scenes", "tests"].iter().flat_map(|folder| all_files(&root().join(folder)))
    {
        let text = doc_comments(&std::fs::read_to_string(&file).unwrap());
        for block in blocks(&text).iter().filter(|block| is_ignored(block)) {
            assert_eq!(fault(block, compiled), None, "{}", file.display());
            count += 1;
        }
    }
    assert!(count > 0, "no example is found");
}

/// Whether rustdoc skips a block although it holds Rust.
fn is_ignored(block: &Block) -> bool {
    block.info.contains("ignore") || block.info.starts_with("text") && holds_rust(block)
}

/// A test compiles every example variant, or the script that copies the others into the kernels does.
#[test]
fn every_example_variant_is_compiled() {
    let script = std::fs::read_to_string(root().join(".ci/new-variant")).unwrap();
    let tests: Vec<String> = all_files(&root().join("tests/tests"))
        .iter()
        .map(|file| std::fs::read_to_string(file).unwrap())
        .collect();
    let variants = all_files(&root().join("tests/example_variants"));
    let mut by_tests = 0;
    for variant in &variants {
        let name = variant.file_name().unwrap().to_string_lossy();
        let is_tested =
            tests.iter().any(|text| text.contains(&format!("#[path = \"../../example_variants/{name}\"]")));
        assert!(
            is_tested || script.contains(&format!("cp tests/example_variants/{name} ")),
            "no build compiles it: {name}"
        );
        by_tests += usize::from(is_tested);
    }
    assert!(by_tests >= 6 && by_tests < variants.len(), "{by_tests} of {} by tests", variants.len());
}

#[test]
fn detects_rust_that_quotes_no_compiled_file() {
    let file = "use a;\n\nimpl A {\n    fn b() {\n        c();\n    }\n}\n";
    let faults = |page: &str| {
        let read = |name: &str| (name == "tests/a.rs").then(|| file.to_string());
        let blocks = blocks(page);
        blocks.iter().filter(|block| holds_rust(block)).filter_map(|block| fault(block, read)).count()
    };
    for page in [
        "[a](tests/a.rs):\n\n```rust\nuse a;\n\nimpl A {\n```\n",
        "`tests/a.rs`\n```rust\nuse a;\n// ...\n    fn b() {\n        c();\n```\n",
        "1. tests/a.rs\n   ```rust\n   fn b() {\n       c();\n   }\n   ```\n",
        "```sh\nuse a;\n```\n```\nuse the door\n```\n",
    ] {
        assert_eq!(faults(page), 0, "{page}");
    }
    for page in [
        "```rust\nuse a;\n```\n",
        "tests/b.rs\n```rust\nuse a;\n```\n",
        "tests/a.rs\n```rust\nuse b;\n```\n",
        "tests/a.rs\n```rust\n```\n",
        "tests/a.rs\n```rust,ignore\nuse b;\n```\n",
        "tests/a.rs\n```rs\nimpl A {\n    fn b() {\n    c();\n```\n",
        "tests/a.rs\n~~~ rust\nfn b() {\n// ...\nuse a;\n~~~\n",
        "tests/a.rs\n```\npub fn b() {\n```\n",
        "tests/a.rs\n\n    pub fn b() {\n",
        "tests/a.rs and then tests/c.rs\n```rust\nuse a;\n```\n",
    ] {
        assert_eq!(faults(page), 1, "{page}");
    }
    let source = "//! `tests/a.rs`:\n//! ```ignore\n//! use b;\n//! ```\n/// ```no_run\n/// use c;\n/// ```\nfn d() {}\n";
    let doc = doc_comments(source);
    let ignored: Vec<Block> = blocks(&doc).into_iter().filter(is_ignored).collect();
    assert_eq!(
        ignored.iter().map(|block| (block.line, &block.lines[..])).collect::<Vec<_>>(),
        [(2, &["use b;".to_string()][..])]
    );
}
