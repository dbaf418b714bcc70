//! Experiments of the project: their files parse, and documents quote the measured results.

use std::path::{Path, PathBuf};

use caustics_bench::sweep::config::SweepConfig;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments")
}

/// Text of a file of the project.
fn text(file: &str) -> String {
    std::fs::read_to_string(folder().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

#[test]
fn the_files_of_the_experiments_parse() {
    let mut count = 0;
    for entry in folder().read_dir().unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_some_and(|extension| extension == "toml") {
            let config = SweepConfig::parse(&std::fs::read_to_string(&file).unwrap());
            assert!(config.is_ok(), "{}: {}", file.display(), config.unwrap_err());
            count += 1;
        }
    }
    assert!(count >= 4, "{count} files");
}

/// A row of the talk's table: name, then ratio, FLIP, FLIP of the caustics and relMSE of each scene.
fn quoted(row: &str) -> (String, Vec<String>) {
    let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
    (cells[0].to_string(), cells[2..].iter().map(|cell| cell.to_string()).collect())
}

/// Whether a quoted number is the measured one, rounded to its digits.
fn holds(quoted: &str, measured: &str) -> bool {
    if quoted == "-" {
        return measured.is_empty();
    }
    let digits = quoted.split_once('.').map_or(0, |(_, digits)| digits.len());
    let measured: f64 = measured.parse().expect("a number");
    format!("{measured:.digits$}") == quoted
}

#[test]
fn the_table_of_the_talk_quotes_the_measured_numbers() {
    let readme = text("results/README.md");
    let mut table = csv::Reader::from_path(folder().join("results/talk/cells.csv")).unwrap();
    let heads = table.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let column = |name: &str| heads.iter().position(|head| head == name).expect("a column");
    let million = (1024 * 1024).to_string();
    let (two, ten) = ((2 * 1024 * 1024).to_string(), (10 * 1024 * 1024).to_string());
    let known = [
        ("| Kim's method | 2 N ", "kim2019", "none", &two),
        ("| Kim's method | 10 N ", "kim2019", "none", &ten),
        ("| OurBasic | N ", "basic", "none", &million),
        ("| OurTemporal as published | N ", "basic", "paper", &million),
        ("| OurTemporal, validated | N ", "basic", "validated", &million),
        ("| path tracing | - ", "path", "none", &"0".to_string()),
    ];
    for (head, method, history, paths) in known {
        let line = readme.lines().find(|line| line.starts_with(head)).unwrap_or_else(|| panic!("no {head}"));
        let (name, numbers) = quoted(line);
        for (scene, numbers) in ["animated-light", "animated-camera"].iter().zip(numbers.chunks(4)) {
            let is = |row: &&csv::StringRecord| {
                let get = |name| &row[column(name)];
                (get("scene"), get("method"), get("history"), get("light_paths"))
                    == (*scene, method, history, paths.as_str())
            };
            let row = rows.iter().find(is).unwrap_or_else(|| panic!("{scene} {name} was not measured"));
            for (measure, number) in ["ratio_to_first", "flip", "flip_caustics", "relmse"].iter().zip(numbers)
            {
                let measured = &row[column(measure)];
                assert!(
                    holds(number, measured),
                    "{name}, {scene}, {measure}: {number} is quoted of {measured}"
                );
            }
        }
    }
}

/// Detects a number that was not measured.
#[test]
fn detects_another_number() {
    assert!(holds("1.03", "1.0318200698475306") && holds("-", "") && holds("184", "183.68"));
    assert!(!holds("1.04", "1.0318200698475306") && !holds("-", "1") && !holds("1.032", "1.031"));
}

/// Costs of histories on the page on rendering are those of the talk's table.
#[test]
fn the_page_of_histories_quotes_the_same_ratios() {
    let page = text("../docs/rendering.md");
    let row = page.lines().find(|line| line.starts_with("| frame at 1920x1080, CPU, ratio |"));
    assert_eq!(row, Some("| frame at 1920x1080, CPU, ratio | 1 | 1.01 to 1.05 | 1.09 to 1.10 |"));
    let table = text("results/README.md");
    for (head, light, camera) in [
        ("| OurTemporal as published | N ", "1.01", "1.05"),
        ("| OurTemporal, validated | N ", "1.09", "1.10"),
    ] {
        let (_, numbers) = quoted(table.lines().find(|line| line.starts_with(head)).unwrap());
        assert_eq!((numbers[0].as_str(), numbers[4].as_str()), (light, camera));
    }
}
