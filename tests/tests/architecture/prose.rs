//! Prose of comments and documents: openings that say nothing, and sentences that are too long. The style is CONTRIBUTING's.
//!
//! `tests/golden/prose.txt` holds the number of each per folder. The numbers may only fall:
//! `CAUSTICS_BLESS=1 cargo test --test architecture prose` writes the table, and refuses a number that rose.

use std::collections::BTreeMap;
use std::path::Path;

use crate::ci::documents;
use crate::layers::all_files;
use crate::root;

/// Words that no doc comment begins with: they leave out the noun.
const BANNED_OPENINGS: [&str; 12] = [
    "What", "Which", "Who", "Whose", "Those", "That", "Of", "As", "The same", "So many", "How many",
    "How much",
];
/// Maximum number of words in a sentence of a comment.
const MAX_WORDS_OF_CODE: usize = 25;
/// Maximum number of words in a sentence of a document.
const MAX_WORDS_OF_DOCUMENTS: usize = 35;
/// Maximum number of words in any sentence of a document.
const NEVER_ABOVE: usize = 50;
/// Depth of the folders that are counted.
const FOLDER_DEPTH: usize = 3;
/// Documents that a program writes.
const GENERATED: [&str; 1] = ["docs/commands.md"];

/// Faults in the prose of a folder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Faults {
    /// Doc comments that open with a banned word.
    openings: usize,
    /// Sentences that are too long.
    long: usize,
}

/// Text of a paragraph, and whether it opens a doc comment.
#[derive(Debug, Default, PartialEq)]
struct Paragraph {
    text: String,
    opens_doc: bool,
}

/// Removes code in backticks, targets of links and formulas from a text, so that words remain.
fn words_alone(text: &str) -> String {
    let mut plain = String::new();
    for (at, part) in text.split('`').enumerate() {
        plain.push_str(if at % 2 == 0 { part } else { "X" });
    }
    let mut rest = plain.as_str();
    let mut found = String::new();
    while let Some((before, behind)) = rest.split_once("](") {
        found.push_str(before);
        rest = behind.split_once(')').map_or("", |(_, behind)| behind);
    }
    found + rest
}

/// Sentences of a text, as numbers of words. One of `.?!` before a space or the end ends a sentence.
fn sentences(text: &str) -> Vec<usize> {
    let mut counts = vec![0];
    for word in words_alone(text).split_whitespace() {
        let is_word = word.contains(|c: char| c.is_alphanumeric());
        *counts.last_mut().expect("a sentence") += usize::from(is_word);
        if word.ends_with(['.', '?', '!']) {
            counts.push(0);
        }
    }
    counts.retain(|&count| count > 0);
    counts
}

/// Whether a line of Markdown is no prose: a heading, a row of a table, an image, HTML.
fn is_no_prose(line: &str) -> bool {
    line.is_empty() || line.starts_with(['#', '|', '<', '!'])
}

/// A line without its mark of a list, and whether it had one.
fn item(line: &str) -> (&str, bool) {
    let behind = line.strip_prefix("- ").or_else(|| line.strip_prefix("* "));
    let number = line.split_once(". ").filter(|(number, _)| number.parse::<u32>().is_ok());
    let behind = behind.or(number.map(|(_, behind)| behind));
    (behind.unwrap_or(line), behind.is_some())
}

/// Paragraphs of lines: `None` ends one, code between fences does not count.
fn paragraphs<'a>(lines: impl Iterator<Item = Option<(&'a str, bool)>>) -> Vec<Paragraph> {
    let (mut found, mut open, mut is_code) = (Vec::new(), Paragraph::default(), false);
    for line in lines {
        let (line, opens_doc) = line.map_or(("", false), |(line, opens_doc)| (line.trim(), opens_doc));
        let is_fence = line.starts_with("```");
        is_code ^= is_fence;
        let (line, is_item) = item(line);
        let ends = is_fence || is_code || is_no_prose(line);
        if ends || is_item || opens_doc {
            found.push(std::mem::take(&mut open));
        }
        if !ends {
            open.opens_doc |= opens_doc;
            open.text += " ";
            open.text += line;
        }
    }
    found.push(open);
    found.retain(|paragraph| !paragraph.text.is_empty());
    found
}

/// Paragraphs of the comments of a source.
fn comments(source: &str) -> Vec<Paragraph> {
    let mut last = "";
    let lines = source.lines().map(move |line| {
        let line = line.trim_start();
        let mark = ["///", "//!", "//"].into_iter().find(|mark| line.starts_with(mark)).unwrap_or("");
        let opens_doc = mark.len() == 3 && mark != last;
        last = mark;
        (!mark.is_empty()).then(|| (&line[mark.len()..], opens_doc))
    });
    paragraphs(lines)
}

/// Counts the faults of some paragraphs.
fn faults(paragraphs: &[Paragraph], max_words: usize) -> Faults {
    let opens_badly = |paragraph: &&Paragraph| {
        let is_opening = |banned: &&str| {
            let behind = paragraph.text.trim_start().strip_prefix(*banned);
            behind.is_some_and(|behind| !behind.starts_with(|c: char| c.is_alphanumeric()))
        };
        paragraph.opens_doc && BANNED_OPENINGS.iter().any(is_opening)
    };
    let lengths = paragraphs.iter().flat_map(|paragraph| sentences(&paragraph.text));
    Faults {
        openings: paragraphs.iter().filter(opens_badly).count(),
        long: lengths.filter(|&length| length > max_words).count(),
    }
}

/// Path below the root, with slashes.
fn name(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).to_string_lossy().replace('\\', "/")
}

/// Faults of each folder of sources, and of each document.
fn counted() -> BTreeMap<String, Faults> {
    let mut counted: BTreeMap<String, Faults> = BTreeMap::new();
    for folder in ["kernels", "host", "scenes", "tests", "fuzz"] {
        for file in all_files(&root().join(folder)).iter().filter(|file| !name(file).contains("/target/")) {
            let name = name(file);
            let parts: Vec<_> = name.split('/').collect();
            let key = parts[..FOLDER_DEPTH.min(parts.len() - 1)].join("/");
            let found =
                faults(&comments(&std::fs::read_to_string(file).expect("a source")), MAX_WORDS_OF_CODE);
            let sum = counted.entry(key).or_default();
            *sum = Faults { openings: sum.openings + found.openings, long: sum.long + found.long };
        }
    }
    for file in documents() {
        let text = std::fs::read_to_string(&file).expect("a document");
        let found = paragraphs(text.lines().map(|line| Some((line, false))));
        counted.insert(name(&file), faults(&found, MAX_WORDS_OF_DOCUMENTS));
    }
    counted.retain(|name, faults| *faults != Faults::default() && !GENERATED.contains(&name.as_str()));
    counted
}

/// The table that is committed.
fn baseline() -> BTreeMap<String, Faults> {
    let text = std::fs::read_to_string(root().join("tests/golden/prose.txt")).expect("a table");
    let record = |line: &str| {
        let mut parts = line.split(' ');
        let name = parts.next().expect("a folder").to_string();
        let mut number = || parts.next().and_then(|number| number.parse().ok()).expect("a number");
        (name, Faults { openings: number(), long: number() })
    };
    text.lines().map(record).collect()
}

#[test]
fn prose_has_no_more_faults_than_before() {
    let (before, now) = (baseline(), counted());
    let rose = |(name, now): (&String, &Faults)| {
        let before = before.get(name).copied().unwrap_or_default();
        (now.openings > before.openings || now.long > before.long)
            .then(|| format!("{name}: {now:?}, before {before:?}"))
    };
    let rose: Vec<_> = now.iter().filter_map(rose).collect();
    assert!(rose.is_empty(), "doc comments with a banned opening, or long sentences\n{}", rose.join("\n"));
    if std::env::var_os("CAUSTICS_BLESS").is_some() {
        let line =
            |(name, faults): (&String, &Faults)| format!("{name} {} {}\n", faults.openings, faults.long);
        let text: String = now.iter().map(line).collect();
        std::fs::write(root().join("tests/golden/prose.txt"), text).expect("a table");
    }
    assert_eq!(before, now, "fewer faults than before: write tests/golden/prose.txt anew");
}

#[test]
fn no_sentence_of_a_document_has_more_than_50_words() {
    for file in documents().iter().filter(|file| !GENERATED.contains(&name(file).as_str())) {
        let text = std::fs::read_to_string(file).expect("a document");
        let found = paragraphs(text.lines().map(|line| Some((line, false))));
        assert_eq!(faults(&found, NEVER_ABOVE).long, 0, "{}", name(file));
    }
}

#[test]
fn detects_a_banned_opening_and_a_long_sentence() {
    let long = "word ".repeat(MAX_WORDS_OF_CODE + 1);
    let fits = "word ".repeat(MAX_WORDS_OF_CODE);
    for (source, openings, count) in [
        ("/// What a light gives.\nfn a() {}".to_string(), 1, 0),
        ("/// Radiance.\n///\n/// What a light gives.".to_string(), 0, 0),
        ("/// Whatever.".to_string(), 0, 0),
        ("// What a light gives.".to_string(), 0, 0),
        ("//! The same.\n\n/// Of a light.".to_string(), 2, 0),
        (format!("/// {long}."), 0, 1),
        (format!("/// {fits}. {fits}."), 0, 0),
        (format!("/// {fits}\n/// word."), 0, 1),
        (format!("/// {fits}.\n/// - {fits}"), 0, 0),
        (format!("/// ```\n/// {long}\n/// ```"), 0, 0),
        (format!("fn a() {{\n    // {long}\n}}"), 0, 1),
    ] {
        assert_eq!(
            faults(&comments(&source), MAX_WORDS_OF_CODE),
            Faults { openings, long: count },
            "{source}"
        );
    }
    let page = format!("# {long}\n\n| {long} |\n\n{fits}\n[word](a file) `x y z`");
    let found = paragraphs(page.lines().map(|line| Some((line, false))));
    assert_eq!(faults(&found, MAX_WORDS_OF_CODE + 1).long, 1);
    assert_eq!(faults(&found, MAX_WORDS_OF_CODE + 2).long, 0);
}
