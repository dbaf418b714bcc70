//! Generates `docs/commands.md` from the options as clap knows them and from the descriptions of variants, so that it
//! matches the program. `CAUSTICS_BLESS=1 cargo test --workspace --bin caustics commands_page` writes it.

use std::fmt::Write;
use std::path::Path;

use caustics::oidn::OIDN;
use caustics_kernels::{denoiser, emission, gather::variant, history, method};
use clap::{Arg, Command, CommandFactory};

mod documents;

/// Text before the commands.
const HEAD: &str = "\
# Commands

This page is generated from the program by a test (`host/cli/src/commands_page.rs`); do not edit it. The same text is in
`caustics help COMMAND`. [rendering.md](rendering.md) and [measuring.md](measuring.md) explain how the commands are used.

`caustics` is `target/release/caustics` after `cargo build --release`, or `cargo run --release --` instead. Results go to
stdout or to files, messages to stderr.

| exit code | meaning |
|---|---|
| 0 | done |
| 1 | failed: a file cannot be read or written, a scene is damaged, the device was lost |
| 2 | usage: an option, a name, or an existing file without `--force` |
| 3 | `compare`: a metric is above its limit, or has no value |
| 4 | no suitable Vulkan device |
| 130 | interrupted; what was done is written |
";

/// A variant's name, description, cost and limitations.
type VariantRecord = [&'static str; 4];

/// Kinds of variants, by the title of their section.
fn kinds() -> Vec<(&'static str, Vec<VariantRecord>)> {
    macro_rules! records {
        ($all:expr) => {
            $all.iter()
                .map(|variant| [variant.name, variant.description, variant.cost, variant.limitations])
                .collect()
        };
    }
    vec![
        ("Methods", records!(method::ALL)),
        ("Gathers", records!(variant::ALL)),
        ("Emissions", records!(emission::ALL)),
        ("Histories", records!(history::ALL)),
        ("Denoisers", records!(denoiser::ALL.iter().copied().chain([&OIDN]).collect::<Vec<_>>())),
    ]
}

/// Returns the whole page.
fn page(command: &Command) -> String {
    let kinds = kinds();
    let mut page = HEAD.to_string();
    for command in command.get_subcommands() {
        section(&mut page, "caustics", command, &kinds);
    }
    for (title, records) in &kinds {
        write!(page, "\n## {title}\n\n| name | description | cost | limitations |\n|---|---|---|---|\n")
            .unwrap();
        for record in records {
            let [description, cost, limitations] = [record[1], record[2], record[3]].map(cell);
            writeln!(page, "| `{}` | {description} | {cost} | {limitations} |", record[0]).unwrap();
        }
    }
    page
}

/// Adds a command with its options, or its subcommands.
fn section(page: &mut String, parent: &str, command: &Command, kinds: &[(&str, Vec<VariantRecord>)]) {
    if command.is_hide_set() {
        return;
    }
    let path = format!("{parent} {}", command.get_name());
    let shown: Vec<&Arg> = command.get_arguments().filter(|arg| !arg.is_hide_set()).collect();
    let positionals: Vec<String> =
        shown.iter().filter(|arg| arg.is_positional()).map(|arg| names(arg)).collect();
    write!(page, "\n## {}\n\n", [&path[..], &positionals.join(" ")].join(" ").trim_end()).unwrap();
    if let Some(description) = command.get_about() {
        writeln!(page, "{description}.").unwrap();
    }
    if let Some(examples) = command.get_before_help().map(ToString::to_string) {
        let lines: Vec<&str> = examples.lines().skip(1).map(str::trim).collect();
        write!(page, "\n```sh\n{}\n```\n", lines.join("\n")).unwrap();
    }
    if !shown.is_empty() {
        page.push_str("\n| option | default | what it does |\n|---|---|---|\n");
    }
    for arg in shown {
        let long = arg.get_long().map(|long| format!("`--{long}`"));
        let short = arg.get_short().map(|short| format!("`-{short}`"));
        let option: Vec<String> = short.into_iter().chain(long).collect();
        let option = if option.is_empty() { format!("`{}`", names(arg)) } else { option.join(", ") };
        let takes = if arg.is_positional() || !arg.get_action().takes_values() {
            String::new()
        } else {
            format!(" `{}`", names(arg))
        };
        let default: Vec<_> = arg.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
        let default = match arg.is_required_set() {
            true => "required".to_string(),
            false if arg.get_action().takes_values() => default.join(","),
            false => String::new(),
        };
        let help = cell(&arg.get_help().map(ToString::to_string).unwrap_or_default());
        writeln!(page, "| {option}{} | {default} | {help}{} |", cell(&takes), values(arg, kinds)).unwrap();
    }
    for command in command.get_subcommands() {
        section(page, &path, command, kinds);
    }
}

/// Names that stand for an argument's values.
fn names(arg: &Arg) -> String {
    match arg.get_value_names() {
        Some(names) => names.join(" "),
        None => arg.get_id().as_str().to_uppercase(),
    }
}

/// Values that an argument takes, if they can be listed: the first variants of a kind by its section, others one by one.
fn values(arg: &Arg, kinds: &[(&str, Vec<VariantRecord>)]) -> String {
    let values = if arg.get_action().takes_values() { arg.get_possible_values() } else { Vec::new() };
    let shown: Vec<_> = values.iter().filter(|value| !value.is_hide_set()).collect();
    if shown.is_empty() {
        return String::new();
    }
    let is_kind = |records: &[VariantRecord]| {
        let names = records.iter().map(|record| record[0]).take(shown.len());
        shown.iter().map(|value| value.get_name()).eq(names)
    };
    let list: Vec<String> = match kinds.iter().find(|(_, records)| is_kind(records)) {
        Some((title, _)) => {
            let names: Vec<_> = shown.iter().map(|value| format!("`{}`", value.get_name())).collect();
            return format!(": {} ([{title}](#{}))", names.join(", "), title.to_lowercase());
        }
        None => shown
            .iter()
            .map(|value| match value.get_help() {
                Some(help) => format!("`{}` ({})", value.get_name(), cell(&help.to_string())),
                None => format!("`{}`", value.get_name()),
            })
            .collect(),
    };
    format!(": {}", list.join(", "))
}

/// Text for a table cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('*', "\\*").replace('\n', " ")
}

#[test]
fn the_page_of_commands_matches_the_program() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/commands.md");
    let page = page(&crate::cli::Cli::command());
    if std::env::var_os("CAUSTICS_BLESS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    let line = page.lines().zip(committed.lines()).find(|(new, old)| new != old);
    assert!(
        page == committed,
        "docs/commands.md is not what the program says{}; run CAUSTICS_BLESS=1 cargo test --workspace --bin caustics \
         commands_page",
        line.map_or(String::new(), |(new, old)| format!(":\n- {old}\n+ {new}\n"))
    );
}

/// Detects an option that the page lacks.
#[test]
fn detects_another_option() {
    let page_of = |name: &'static str| {
        let option = Arg::new(name).long(name).help("Either | or");
        page(&Command::new("caustics").subcommand(Command::new("render").arg(option)))
    };
    assert_ne!(page_of("seed"), page_of("seeds"));
    assert!(page_of("seed").contains(r"| `--seed` `SEED` |  | Either \| or |"), "{}", page_of("seed"));
}

/// Links of the project's documents to missing files and headings.
fn dead_links(page: &Path, text: &str) -> Vec<String> {
    let folder = page.parent().expect("a folder");
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let is_dead = |target: &&str| {
        let (file, heading) = target.split_once('#').unwrap_or((target, ""));
        let file = if file.is_empty() { page.to_path_buf() } else { folder.join(file) };
        let anchors = |text: String| -> Vec<String> {
            let heads = text.lines().filter_map(|line| line.strip_prefix('#')).map(|line| {
                let kept = line.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
                kept.collect::<String>().trim().to_lowercase().replace(' ', "-")
            });
            heads.collect()
        };
        let has_heading = || {
            std::fs::read_to_string(&file)
                .is_ok_and(|text| anchors(text).iter().any(|known| known == heading))
        };
        !file.exists() || (!heading.is_empty() && !has_heading())
    };
    targets.filter(|target| !target.contains("://")).filter(is_dead).map(str::to_string).collect()
}

#[test]
fn links_of_the_documents_lead_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut count = 0;
    for folder in [".", "docs", "docs/decisions", "experiments/peers", "experiments/results"] {
        for entry in root.join(folder).read_dir().unwrap() {
            let page = entry.unwrap().path();
            if page.extension().is_some_and(|extension| extension == "md") {
                let dead = dead_links(&page, &std::fs::read_to_string(&page).unwrap());
                assert!(dead.is_empty(), "{}: {dead:?}", page.display());
                count += 1;
            }
        }
    }
    assert!(count > 10, "{count} pages");
}

/// Detects a link to a missing file or heading.
#[test]
fn detects_a_dead_link() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../README.md");
    let text = "[a](no-such-file.md) [b](CONTRIBUTING.md#no-such-heading) [c](CONTRIBUTING.md#the-kernels) [d](https://x.org)";
    assert_eq!(dead_links(&page, text), ["no-such-file.md", "CONTRIBUTING.md#no-such-heading"]);
}
