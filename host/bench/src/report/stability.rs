//! Table of known failure modes, each with its test and its verdicts: `tests/stability.toml`.

use maud::{Markup, html};
use serde::Deserialize;

/// All failure modes.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stability {
    /// Failure modes, in order of their numbers.
    pub mode: Vec<Mode>,
}

/// A failure mode.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mode {
    /// Its position in the list, from 1.
    pub number: u32,
    /// Its name.
    pub name: String,
    /// `path/of/file.rs::name_of_the_test`.
    pub test: String,
    /// Requirement of the test.
    pub what: String,
    /// Verdicts of the methods.
    #[serde(default)]
    pub verdict: Vec<MethodVerdict>,
}

/// Verdict on a method.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MethodVerdict {
    /// Its name.
    pub method: String,
    /// The verdict.
    pub verdict: Verdict,
    /// Reason or extent.
    #[serde(default)]
    pub note: String,
    /// Test of the verdict, where it is not the mode's.
    pub test: Option<String>,
}

/// Verdict on a method in a failure mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The method does not fail.
    Holds,
    /// The method fails.
    Fails,
    /// The method fails, within the bound of the test.
    Bounded,
}

impl Verdict {
    fn word(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::Fails => "fails",
            Verdict::Bounded => "bounded",
        }
    }

    /// Sign that tells verdicts apart without colour.
    fn sign(self) -> &'static str {
        match self {
            Verdict::Holds => "✓",
            Verdict::Fails => "✗",
            Verdict::Bounded => "≤",
        }
    }
}

/// Returns the table that this program was built with.
pub fn stability() -> anyhow::Result<Stability> {
    toml::from_str(include_str!("../../../../tests/stability.toml"))
        .map_err(|error| anyhow::anyhow!("tests/stability.toml: {error}"))
}

impl Stability {
    /// The table for the page.
    pub fn inline(&self) -> Markup {
        html! {
            div .table tabindex="0" role="region" aria-label="Stability" {
                table .stability {
                    thead { tr { th scope="col" .number { "No." } th scope="col" { "mode" } th scope="col" { "verdict" } th scope="col" { "test" } } }
                    tbody {
                        @for mode in &self.mode {
                            tr {
                                td .number { (mode.number) }
                                td .what { b { (mode.name) } span .dim { (mode.what) } }
                                td .verdicts { @for verdict in &mode.verdict { (row(verdict)) } }
                                td { code { (mode.test.rsplit("::").next().unwrap_or_default().replace('_', "_\u{200b}")) } }
                            }
                        }
                    }
                }
            }
        }
    }

    /// Its data; the first row has the headings.
    pub fn rows(&self) -> Vec<Vec<String>> {
        let mut rows =
            vec![["number", "mode", "test", "method", "verdict", "note"].map(String::from).to_vec()];
        for mode in &self.mode {
            for verdict in &mode.verdict {
                let number = mode.number.to_string();
                let test = verdict.test.as_ref().unwrap_or(&mode.test);
                let words =
                    [&number, &mode.name, test, &verdict.method, verdict.verdict.word(), &verdict.note];
                rows.push(words.map(String::from).to_vec());
            }
        }
        rows
    }
}

fn row(verdict: &MethodVerdict) -> Markup {
    html! {
        div {
            span class={ "verdict " (verdict.verdict.word()) } {
                (verdict.verdict.sign()) " " (verdict.verdict.word())
            }
            " " b { (verdict.method) } @if !verdict.note.is_empty() { " " span .dim { (verdict.note) } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Checks that a test of this name is in the file; the error describes what is missing.
    fn find(test: &str) -> Result<(), String> {
        let (file, name) = test.rsplit_once("::").ok_or(format!("{test}: it must be FILE::TEST"))?;
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let text = std::fs::read_to_string(root.join(file)).map_err(|error| format!("{file}: {error}"))?;
        // The attribute comes first, perhaps others, then the function; tests of proptest have arguments.
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        let head = format!("fn {name}(");
        let at = lines
            .iter()
            .position(|line| line.starts_with(&head))
            .ok_or(format!("{test}: no such function"))?;
        let attributes =
            lines[..at].iter().rev().take_while(|line| line.starts_with("#[") || line.starts_with("//"));
        if attributes.clone().any(|line| *line == "#[test]") {
            Ok(())
        } else {
            Err(format!("{test}: it is no test"))
        }
    }

    #[test]
    fn every_mode_names_a_test_that_exists() {
        let table = stability().unwrap();
        let own =
            |mode: &Mode| mode.verdict.iter().filter_map(|verdict| verdict.test.clone()).collect::<Vec<_>>();
        let tests = table.mode.iter().flat_map(|mode| own(mode).into_iter().chain([mode.test.clone()]));
        let wrong: Vec<String> = tests.filter_map(|test| find(&test).err()).collect();
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }

    #[test]
    fn tests_that_do_not_exist_are_found() {
        for test in [
            "tests/tests/methods/stability.rs::a_test_that_nobody_wrote",
            "tests/tests/nowhere.rs::caustic_history_is_unused_in_the_frame_after_a_cut",
            "caustic_history_is_unused_in_the_frame_after_a_cut",
            // A function that is not a test.
            "tests/tests/methods/stability.rs::config",
        ] {
            assert!(find(test).is_err(), "{test} was found");
        }
    }

    #[test]
    fn modes_have_unique_numbers_and_one_verdict_per_method() {
        let table = stability().unwrap();
        assert!(table.mode.windows(2).all(|pair| pair[0].number < pair[1].number));
        for mode in &table.mode {
            assert!((1..=24).contains(&mode.number) && !mode.verdict.is_empty(), "mode {}", mode.number);
            for (index, verdict) in mode.verdict.iter().enumerate() {
                let again = mode.verdict[..index].iter().any(|other| other.method == verdict.method);
                assert!(!again, "mode {}: {} twice", mode.number, verdict.method);
            }
        }
    }
}
