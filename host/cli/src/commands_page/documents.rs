//! Checks that commands in the documents' shell blocks are valid, with options and values.

use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, CommandFactory};

use crate::cli::Cli;

/// Names of variants that documents tell the reader to write.
const EXAMPLES: [&str; 2] = ["mine", "same-pixel"];

/// Arguments of the commands `caustics` and `cargo run --release --` in the shell blocks of a document.
fn commands(text: &str) -> Vec<Vec<String>> {
    let mut commands = Vec::new();
    let mut is_shell = false;
    for line in text.replace("\\\n", " ").lines() {
        let line = line.trim();
        if let Some(info) = line.strip_prefix("```") {
            is_shell = info == "sh";
        } else if is_shell {
            commands.extend(arguments(line));
        }
    }
    commands
}

/// Words after the program in a line of shell, up to a comment or another command.
fn arguments(line: &str) -> Option<Vec<String>> {
    let line = line.split(" #").next().unwrap_or_default();
    let words: Vec<&str> = line.split_whitespace().collect();
    let is_program = |at: usize| {
        let name = words[at].trim_start_matches('"');
        name == "caustics" && !words[..at].ends_with(&["--bin"])
            || name.ends_with("/caustics")
            || words[..at].ends_with(&["cargo", "run", "--release"]) && name == "--"
    };
    let program = (0..words.len()).find(|at| is_program(*at))?;
    if words[0].starts_with('#') {
        return None;
    }
    let ends = |word: &&str| ["|", "&&", ";", "&", ">", "2>", ":::"].contains(word);
    let words = words[program + 1..].iter().take_while(|word| !ends(word));
    // A pattern stands for at least two files.
    let words = words.flat_map(|word| std::iter::repeat_n(word, 1 + usize::from(word.contains('*'))));
    Some(words.map(|word| word.trim_matches('"').to_string()).collect())
}

/// Returns the program's error for these arguments, if any. Accepts any value that the shell fills in.
fn objection(command: Command, arguments: &[String]) -> Option<String> {
    let error = command.try_get_matches_from([&["caustics".to_string()], arguments].concat()).err()?;
    let value = match error.get(ContextKind::InvalidValue) {
        Some(ContextValue::String(value)) => value.as_str(),
        _ => "",
    };
    let is_open = value.contains(['$', '{']) || EXAMPLES.contains(&value);
    let is_value = matches!(error.kind(), ErrorKind::InvalidValue | ErrorKind::ValueValidation);
    (!(is_value && is_open)).then(|| format!("caustics {}: {error}", arguments.join(" ")))
}

#[test]
fn commands_of_the_documents_are_accepted_by_the_program() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut count = 0;
    for folder in [".", "docs", "docs/decisions", "experiments", "experiments/peers", "experiments/results"] {
        for entry in root.join(folder).read_dir().unwrap() {
            let page = entry.unwrap().path();
            if page.extension().is_some_and(|extension| extension == "md") {
                for arguments in commands(&std::fs::read_to_string(&page).unwrap()) {
                    let objection = objection(Cli::command(), &arguments);
                    assert_eq!(objection, None, "{}", page.display());
                    count += 1;
                }
            }
        }
    }
    assert!(count > 60, "only {count} commands are found");
}

#[test]
fn detects_options_and_values_that_the_program_does_not_have() {
    let objections = |line: &str| {
        let commands = commands(&format!("text\n\n```sh\n{line}\n```\n"));
        assert!(!commands.is_empty(), "{line}");
        commands.iter().filter(|arguments| objection(Cli::command(), arguments).is_some()).count()
    };
    for line in [
        "caustics view still-life",
        "for scene in a b; do\n  cargo run --release -- bench $scene --history none,paper -o out/$scene\ndone",
        "CAUSTICS_KERNELS=DIR ~/lvp-run target/release/caustics animate still-life \\\n  -o a.exr --history same-pixel # --no",
        "parallel caustics reference room -o a.exr --shard {}/8 ::: $(seq 8)",
        "caustics compare a.exr b.exr --json > a.json",
        "caustics merge a-*.sums -o a.exr",
    ] {
        assert_eq!(objections(line), 0, "{line}");
    }
    for line in [
        "caustics render still-life -o a.exr --no-such-option",
        "caustics renders still-life -o a.exr",
        "A=1 cargo run --release -- animate still-life \\\n  --history no-such-history -o a.exr",
        "caustics view still-life\ncaustics view",
    ] {
        assert_eq!(objections(line), 1, "{line}");
    }
    assert!(commands("caustics render\n\n```toml\ncaustics render\n```\n").is_empty());
}
