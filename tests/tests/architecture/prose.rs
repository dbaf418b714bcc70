//! Prose of comments and documents: no doc comment has an opening that leaves out the noun, and no sentence is too long.
//! CONTRIBUTING, "Style", has the rules.

use std::path::PathBuf;

use crate::ci::documents;
use crate::layers::all_files;
use crate::{name, root};

/// Words that no doc comment begins with: they leave out the noun.
const BANNED_OPENINGS: [&str; 12] = [
    "What", "Which", "Who", "Whose", "Those", "That", "Of", "As", "The same", "So many", "How many",
    "How much",
];
/// Maximum number of words in a sentence of a comment.
const MAX_WORDS_OF_CODE: usize = 25;
/// Maximum number of words in a sentence of a document.
const MAX_WORDS_OF_DOCUMENTS: usize = 35;
/// Documents that a program writes.
const GENERATED: [&str; 1] = ["docs/commands.md"];

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

/// Paragraphs of a document.
fn document_paragraphs(text: &str) -> Vec<Paragraph> {
    paragraphs(text.lines().map(|line| Some((line, false))))
}

/// Describes the faults of some paragraphs.
fn faults(paragraphs: &[Paragraph], max_words: usize) -> Vec<String> {
    let mut found = Vec::new();
    for Paragraph { text, opens_doc } in paragraphs {
        let text = text.trim_start();
        let is_opening = |banned: &&&str| {
            let behind = text.strip_prefix(**banned);
            behind.is_some_and(|behind| !behind.starts_with(|c: char| c.is_alphanumeric()))
        };
        if let Some(banned) = BANNED_OPENINGS.iter().find(is_opening).filter(|_| *opens_doc) {
            found.push(format!("begins with {banned:?}: {text}"));
        }
        let long = sentences(text).into_iter().filter(|&count| count > max_words);
        found.extend(long.map(|count| format!("{count} words in a sentence of: {text}")));
    }
    found
}

/// Describes the faults of the prose of some files.
fn faults_of_files(files: &[PathBuf], read: fn(&str) -> Vec<Paragraph>, max_words: usize) -> Vec<String> {
    let mut found = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(file).expect("a text");
        let faults = faults(&read(&text), max_words);
        found.extend(faults.into_iter().map(|fault| format!("{}: {fault}", name(file))));
    }
    found
}

#[test]
fn comments_have_no_banned_opening_and_no_sentence_above_25_words() {
    let folders = ["kernels", "host", "scenes", "tests", "fuzz"];
    let mut files: Vec<_> = folders.iter().flat_map(|folder| all_files(&root().join(folder))).collect();
    files.retain(|file| !name(file).contains("/target/"));
    let found = faults_of_files(&files, comments, MAX_WORDS_OF_CODE);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn documents_have_no_sentence_above_35_words() {
    let mut files = documents();
    files.retain(|file| !GENERATED.contains(&name(file).as_str()));
    let found = faults_of_files(&files, document_paragraphs, MAX_WORDS_OF_DOCUMENTS);
    assert!(found.is_empty(), "{}", found.join("\n"));
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
        let found = faults(&comments(&source), MAX_WORDS_OF_CODE);
        let found_openings = found.iter().filter(|fault| fault.starts_with("begins")).count();
        assert_eq!((found_openings, found.len() - found_openings), (openings, count), "{source}");
    }
    let page = format!("# {long}\n\n| {long} |\n\n{fits}\n[word](a file) `x y z`");
    let found = document_paragraphs(&page);
    assert_eq!(faults(&found, MAX_WORDS_OF_CODE + 1).len(), 1);
    assert_eq!(faults(&found, MAX_WORDS_OF_CODE + 2).len(), 0);
}
