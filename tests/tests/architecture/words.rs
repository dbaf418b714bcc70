//! Words that docs/glossary.md replaces do not return: neither in declared names, nor in the prose of doc comments and
//! documents.

use std::collections::BTreeSet;
use std::path::Path;

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

use crate::ci::documents;
use crate::layers::all_files;
use crate::{name, root};

/// A banned word.
struct Banned {
    /// Forms of the word, in lower case.
    forms: &'static [&'static str],
    /// The term to use.
    instead: &'static str,
    /// Folders and files in whose declared names the word is banned.
    names: &'static [&'static str],
    /// Folders and files in whose doc comments and text the word is banned.
    prose: &'static [&'static str],
}

/// All code, and all documents.
const CODE: &[&str] = &["kernels", "host", "scenes", "tests", "fuzz"];
const KERNELS: &[&str] = &["kernels"];
const EVERYWHERE: &[&str] = &[""];
const NOWHERE: &[&str] = &[];
/// Code in which a connection is no socket and a lane no SIMD lane.
const NOT_THE_VIEWER: &[&str] =
    &["kernels", "scenes", "tests", "fuzz", "host/bench/src", "host/src/inspect", "host/scene/src"];
/// Code of sweeps, in which a cell is no cell of a grid or a table.
const SWEEPS: &[&str] = &[
    "host/bench/src/matrix.rs",
    "host/bench/src/measure.rs",
    "host/bench/src/parameter.rs",
    "host/bench/src/result.rs",
    "host/bench/src/sweep",
    "host/cli/src/command/sweep.rs",
    "host/cli/src/command/view",
];

/// A banned word.
const fn banned(
    forms: &'static [&'static str],
    instead: &'static str,
    names: &'static [&'static str],
    prose: &'static [&'static str],
) -> Banned {
    Banned { forms, instead, names, prose }
}

/// The words, by groups of docs/glossary.md.
const BANNED: &[Banned] = &[
    // BVH
    banned(
        &["tree", "trees"],
        "BVH, pyramid or CDF",
        &["kernels", "host/scene/src/bvh", "host/scene/src/bvh.rs"],
        NOWHERE,
    ),
    // Light sampling and emission
    banned(
        &["connection", "connections", "connect", "connects"],
        "light sampling, light sample",
        NOT_THE_VIEWER,
        KERNELS,
    ),
    banned(
        &["leave", "leaving", "towards"],
        "sample_emission, eval_emission",
        &["kernels/src/light"],
        NOWHERE,
    ),
    banned(&["aim", "lamp", "lamps"], "emission direction, emission cone, light", KERNELS, NOWHERE),
    // Sampling and probability
    banned(&["chance", "chances"], "probability", CODE, KERNELS),
    banned(&["draw", "draws", "drawn"], "sample, sampled", KERNELS, KERNELS),
    // Reuse and history
    banned(
        &["lend", "lends", "lent", "lender", "borrower"],
        "reuse, reprojected, history sample",
        CODE,
        KERNELS,
    ),
    // Images
    banned(&["picture", "pictures"], "image", CODE, &["kernels", "host", "tests"]),
    // Minima, maxima, constructors, variants
    banned(&["most", "least"], "max, min", CODE, NOWHERE),
    banned(&["usual", "useless"], "default, not applicable", CODE, NOWHERE),
    // Media, surfaces, platform
    banned(&["sheet", "sheets"], "open surface", KERNELS, NOWHERE),
    banned(
        &["fold", "folded"],
        "flip to the geometric hemisphere",
        &["kernels/src/surface"],
        &["kernels/src/surface"],
    ),
    banned(&["glass"], "dielectric", &["kernels/src/surface"], NOWHERE),
    banned(&["bend", "bends", "bent"], "deform, refract", KERNELS, KERNELS),
    banned(
        &["unblocked", "enclosing", "seam"],
        "shadow transmittance, initial media, platform",
        CODE,
        EVERYWHERE,
    ),
    banned(&["truth"], "reference", CODE, &["kernels", "host", "tests", "README.md"]),
    // Positions and photons
    banned(&["place", "places"], "position, index, slot", KERNELS, NOWHERE),
    banned(&["deposit", "deposits"], "photon; deposit is the verb", CODE, NOWHERE),
    // Tests
    banned(
        &["toy", "toys", "twin", "house"],
        "example variant, parity, architecture test",
        CODE,
        &["kernels", "host", "tests", "docs"],
    ),
    // Viewer and console
    banned(&["wish", "keeper"], "view request, checkpoint writer", CODE, EVERYWHERE),
    banned(
        &["lane", "lanes"],
        "render job, channel",
        &["host/cli/src/command", "host/files/src/image_file", "host/files/src/output"],
        NOWHERE,
    ),
    banned(&["told", "said"], "message, printed", CODE, NOWHERE),
    // Sweeps
    banned(&["cell", "cells"], "run configuration", SWEEPS, SWEEPS),
    // Records
    banned(
        &["row", "rows"],
        "record, light_id",
        &[
            "kernels/src/light.rs",
            "kernels/src/light/mixture.rs",
            "kernels/src/light/guided.rs",
            "kernels/src/light/light_sampling.rs",
            "host/src/upload.rs",
            "host/scene/src/instanced.rs",
            "host/scene/src/mesh.rs",
        ],
        NOWHERE,
    ),
];

/// Names that say nothing alone.
const EMPTY: &[&str] = &["of", "Of"];

/// Names that may hold a banned word: the name, the word, and the reason.
const EXEMPT: &[(&str, &str, &str)] = &[("SEAM", "seam", "the seam of the frames of a sphere of directions")];

/// Largest number of exemptions.
const MAX_EXEMPT: usize = 15;

/// Keywords before a declared name.
const DECLARING: [&str; 11] =
    ["struct", "enum", "union", "trait", "fn", "const", "static", "type", "mod", "let", "for"];

/// Splits an identifier into words in lower case: `max_treeNodes` into max, tree and nodes.
fn words(identifier: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    for letter in identifier.trim_start_matches("r#").chars() {
        if letter == '_' || was_lower && letter.is_uppercase() {
            words.push(String::new());
        }
        was_lower = letter.is_lowercase() || letter.is_ascii_digit();
        if letter != '_' {
            words.last_mut().expect("a word").extend(letter.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Names and prose of a source.
#[derive(Default)]
struct Text {
    /// Identifiers behind a declaring keyword, and names of fields, parameters and variants.
    names: BTreeSet<String>,
    /// Doc comments.
    prose: Vec<String>,
}

impl Text {
    fn new(source: &str) -> Text {
        let mut text = Text::default();
        text.read(source.parse().expect("a source parses"), false);
        text
    }

    /// Adds the names that tokens declare; in an enum, names at the beginning of a list are variants.
    fn read(&mut self, tokens: TokenStream, in_enum: bool) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let ident = |at: usize| match tokens.get(at) {
            Some(TokenTree::Ident(ident)) => Some(ident.to_string()),
            _ => None,
        };
        let is_sign = |at: usize, sign: char| matches!(tokens.get(at), Some(TokenTree::Punct(punct)) if punct.as_char() == sign);
        // A colon that is not the first of two.
        let is_colon = |at: usize| matches!(tokens.get(at), Some(TokenTree::Punct(punct)) if punct.as_char() == ':' && punct.spacing() == Spacing::Alone);
        let (mut enum_follows, mut test_follows) = (false, false);
        let mut starts_variant = in_enum;
        for (at, token) in tokens.iter().enumerate() {
            match token {
                TokenTree::Ident(name) => {
                    let name = name.to_string();
                    let mut next = at + 1;
                    while ident(next).is_some_and(|word| word == "mut" || word == "ref") {
                        next += 1;
                    }
                    if DECLARING.contains(&name.as_str()) {
                        let is_path = is_sign(next + 1, ':') && !is_colon(next + 1);
                        // Names of tests are sentences.
                        let is_test = name == "fn" && std::mem::take(&mut test_follows);
                        self.names.extend(ident(next).filter(|_| !is_path && !is_test));
                        enum_follows = name == "enum";
                    }
                    let is_path = at > 0 && is_sign(at - 1, ':') && !is_colon(at - 1);
                    if starts_variant || is_colon(at + 1) && !is_path {
                        self.names.insert(name);
                    }
                    starts_variant = false;
                }
                TokenTree::Group(group) => {
                    let is_attribute = at > 0
                        && (is_sign(at - 1, '#') || at > 1 && is_sign(at - 1, '!') && is_sign(at - 2, '#'))
                        && group.delimiter() == Delimiter::Bracket;
                    if is_attribute {
                        test_follows |= group.stream().to_string() == "test";
                        self.prose.extend(doc(group.stream()));
                    } else {
                        let is_enum = enum_follows && group.delimiter() == Delimiter::Brace;
                        enum_follows &= !is_enum;
                        self.read(group.stream(), is_enum);
                    }
                }
                TokenTree::Punct(sign) => starts_variant |= in_enum && sign.as_char() == ',',
                TokenTree::Literal(_) => {}
            }
        }
    }
}

/// The text of `doc = "text"`.
fn doc(attribute: TokenStream) -> Option<String> {
    let mut tokens = attribute.into_iter();
    let is_doc = matches!(tokens.next(), Some(TokenTree::Ident(name)) if name == "doc");
    let text = tokens.nth(1).filter(|_| is_doc)?;
    matches!(text, TokenTree::Literal(_)).then(|| text.to_string())
}

/// Words of prose: code in backticks, blocks of code and links' targets aside.
fn words_of_prose(text: &str) -> Vec<String> {
    let mut outside = String::new();
    for (at, part) in text.split("```").enumerate() {
        if at % 2 == 0 {
            outside.extend(part.split('`').step_by(2));
        }
    }
    let is_part = |letter: char| letter.is_alphanumeric() || "_-./".contains(letter);
    let words = outside.split(|letter| !is_part(letter)).filter(|word| !word.contains(['/', '_']));
    words.flat_map(|word| word.split(['-', '.'])).map(str::to_lowercase).collect()
}

/// Banned words of a file, by its path from the root of the repository, each with the term to use.
fn faults(banned: &[Banned], path: &str, names: &BTreeSet<String>, prose: &[String]) -> Vec<String> {
    let is_below = |folders: &[&str]| folders.iter().any(|folder| Path::new(path).starts_with(folder));
    let mut faults: Vec<String> = (names.iter().filter(|name| EMPTY.contains(&name.as_str())))
        .map(|name| format!("{path}: the name {name}: write what it is"))
        .collect();
    for Banned { forms, instead, names: in_names, prose: in_prose } in banned {
        let is_banned = |word: &String| forms.contains(&word.as_str());
        for name in names.iter().filter(|_| is_below(in_names)) {
            let is_exempt = EXEMPT.iter().any(|(exempt, word, _)| exempt == name && forms.contains(word));
            if words(name).iter().any(is_banned) && !is_exempt {
                faults.push(format!("{path}: the name {name}: write {instead}"));
            }
        }
        for word in prose.iter().filter(|_| is_below(in_prose)).flat_map(|text| words_of_prose(text)) {
            if is_banned(&word) {
                faults.push(format!("{path}: the word {word:?}: write {instead}"));
            }
        }
    }
    faults
}

#[test]
fn names_and_prose_hold_no_word_that_the_glossary_replaces() {
    let root = root();
    let mut found = Vec::new();
    for file in CODE.iter().flat_map(|folder| all_files(&root.join(folder))) {
        let text = Text::new(&std::fs::read_to_string(&file).expect("a source"));
        found.extend(faults(BANNED, &name(&file), &text.names, &text.prose));
    }
    for page in documents() {
        let text = std::fs::read_to_string(&page).expect("a document");
        found.extend(faults(BANNED, &name(&page), &BTreeSet::new(), &[text]));
    }
    assert!(found.is_empty(), "see docs/glossary.md\n{}", found.join("\n"));
}

#[test]
fn exemptions_are_at_most_15_and_used() {
    assert!(EXEMPT.len() <= MAX_EXEMPT);
    let sources = CODE.iter().flat_map(|folder| all_files(&root().join(folder)));
    let names: BTreeSet<String> =
        sources.flat_map(|file| Text::new(&std::fs::read_to_string(file).expect("a source")).names).collect();
    for (name, word, _) in EXEMPT {
        assert!(words(name).iter().any(|found| found == word), "{name} does not hold {word}");
        assert!(names.contains(*name), "nothing is called {name}");
    }
}

#[test]
fn detects_banned_words_in_names_and_prose_of_their_folders_alone() {
    let banned = [Banned {
        forms: &["tree", "trees"],
        instead: "BVH",
        names: &["kernels"],
        prose: &["kernels", "docs"],
    }];
    let source = r#"
        //! Trees of boxes; `tree` in code is no prose.
        struct TreeNode { tree_size: u32 }
        enum Kind { BinaryTree, Street(BTreeMap) }
        #[test]
        fn trees_are_high() {}
        fn at(of_trees: u32, of: u32) -> u32 { let mut tree = Tree::tree; node::tree }
    "#;
    let Text { names, prose } = Text::new(source);
    let found = faults(&banned, "kernels/src/a.rs", &names, &prose);
    let expected = ["BinaryTree", "TreeNode", "of_trees", "tree", "tree_size"]
        .map(|name| format!("kernels/src/a.rs: the name {name}: write BVH"));
    assert_eq!(found[0], "kernels/src/a.rs: the name of: write what it is");
    assert_eq!(found[1..6], expected);
    assert_eq!(found[6..], [r#"kernels/src/a.rs: the word "trees": write BVH"#]);
    assert_eq!(
        faults(&banned, "host/src/a.rs", &names, &prose),
        ["host/src/a.rs: the name of: write what it is"]
    );
    let text = ["A street, a `tree` and docs/tree.md.".to_string(), "One tree-like thing".into()];
    assert_eq!(
        faults(&banned, "docs/a.md", &BTreeSet::new(), &text),
        [r#"docs/a.md: the word "tree": write BVH"#]
    );
}

#[test]
fn identifiers_are_split_into_words() {
    assert_eq!(words("max_tree_nodes"), ["max", "tree", "nodes"]);
    assert_eq!(words("BvhNode"), ["bvh", "node"]);
    assert_eq!(words("TREE_STACK"), ["tree", "stack"]);
    assert_eq!(words("BTreeMap"), ["btree", "map"]);
}
