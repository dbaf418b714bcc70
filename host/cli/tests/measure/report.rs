//! `caustics report` from outside: the page, its files, and refusals.

mod fixture;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use caustics_bench::error::{FLIP, FLIP_CAUSTICS, RELMSE};
use caustics_bench::parameter::METHOD;
use caustics_bench::result::RunResult;
use scraper::{Html, Selector};

use crate::test_dir::{BINARY, Run, TestDir};

/// Runs `caustics report`, which must print nothing to stdout.
fn report(dir: &TestDir, arguments: &[&str]) -> Run {
    let run = dir.run(&[&["report"], arguments].concat());
    assert!(run.stdout.is_empty());
    run
}

/// Writes the page `report.html`. Returns its text and its document. The run must succeed.
#[track_caller]
fn write_page(dir: &TestDir, arguments: &[&str]) -> (String, Html) {
    report(dir, &[arguments, &["-o", "report.html"]].concat()).expect_success(arguments);
    let text = std::fs::read_to_string(dir.path("report.html")).unwrap();
    let page = Html::parse_document(&text);
    (text, page)
}

fn select<'a>(page: &'a Html, selector: &str) -> Vec<scraper::ElementRef<'a>> {
    page.select(&Selector::parse(selector).unwrap()).collect()
}

fn text_of(page: &Html, selector: &str) -> String {
    select(page, selector).iter().flat_map(|node| node.text()).collect()
}

fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().map(|row| row.unwrap()).collect()
}

/// The page loads nothing from elsewhere, and holds every image once.
#[test]
fn the_page_loads_nothing_from_elsewhere() {
    let dir = TestDir::new();
    fixture::write(&dir.path("results"));
    let (text, page) = write_page(&dir, &["results"]);
    assert!(
        !text.contains("http:") && !text.contains("https:") && !text.contains("url("),
        "the page loads something from elsewhere"
    );
    assert!(!text.contains("@import") && select(&page, "[src], iframe, object, embed").is_empty());
    let links: Vec<&str> = select(&page, "link").iter().filter_map(|link| link.attr("href")).collect();
    assert_eq!(links, ["data:,"]);
    let images: Vec<&str> =
        select(&page, "image, img").iter().map(|node| node.attr("href").unwrap()).collect();
    assert!(images.len() > 20 && images.iter().all(|address| address.starts_with("data:image/png;base64,")));
    assert_eq!(images.iter().collect::<BTreeSet<_>>().len(), images.len(), "an image is in the page twice");
    assert_eq!(text.matches("data:image/png").count(), images.len());
    for target in select(&page, "use, a").iter().map(|node| node.attr("href").unwrap()) {
        assert!(target.starts_with('#'), "{target}");
        assert_eq!(select(&page, &format!("[id=\"{}\"]", &target[1..])).len(), 1, "{target}");
    }
}

#[test]
fn every_configuration_is_in_its_charts_and_files() {
    let dir = TestDir::new();
    let runs = fixture::write(&dir.path("results"));
    let (_, page) = write_page(&dir, &["results"]);
    for (slug, scene) in [("mirror-room", "mirror-room"), ("moving-b-glass", fixture::ROUGH)] {
        for (measure, value) in [
            ("flip", (|run| run.error.as_ref()?.get(&FLIP)) as fn(&RunResult) -> Option<f64>),
            ("relmse", |run| run.error.as_ref()?.get(&RELMSE)),
            ("flip-caustics", |run| run.error.as_ref()?.get(&FLIP_CAUSTICS)),
        ] {
            let expected: BTreeSet<&str> = runs
                .iter()
                .filter(|run| run.config.scene == scene && value(run).is_some())
                .map(|run| run.identity.as_str())
                .collect();
            assert!(expected.len() > 30);
            for size in ["wide", "narrow"] {
                let marks = select(&page, &format!("#scene-{slug} [data-chart={measure}] .{size} .point"));
                let drawn: Vec<&str> = marks.iter().map(|mark| mark.attr("data-cell").unwrap()).collect();
                assert_eq!(drawn.len(), expected.len());
                assert_eq!(drawn.into_iter().collect::<BTreeSet<_>>(), expected, "{slug} {measure} {size}");
            }
            let rows = rows(&dir.path(&format!("report_files/{slug}-{measure}.csv")));
            let known: BTreeSet<&str> = rows.iter().map(|row| row["identity"].as_str()).collect();
            assert_eq!(known, expected);
        }
        assert!(select(&page, &format!("#scene-{slug} [data-chart=relmse-caustics]")).is_empty());
    }
    // Only the scene that moves has charts over frames.
    assert!(dir.path("report_files/moving-b-glass-frame-flip.svg").exists());
    assert!(!dir.path("report_files/mirror-room-frame-flip.svg").exists());
    let all = rows(&dir.path("report_files/cells.csv"));
    assert_eq!(all.len(), runs.len());
    for run in &runs {
        let row = all.iter().find(|row| row["identity"] == run.identity).unwrap();
        let time = run.time.as_ref().unwrap();
        assert_eq!(row["median_ms"].parse::<f64>().unwrap(), time.total_ms.median);
        assert_eq!(row["pass.collect_ms"].parse::<f64>().unwrap(), time.pass_ms["collect"].median);
        assert_eq!(row["scene"], run.config.scene);
    }
}

#[test]
fn figures_are_files_of_their_own_with_their_data() {
    let dir = TestDir::new();
    fixture::write(&dir.path("results"));
    write_page(&dir, &["results"]);
    let files: Vec<PathBuf> =
        dir.path("report_files").read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    let figures: Vec<&PathBuf> = files.iter().filter(|path| path.extension().unwrap() == "svg").collect();
    assert_eq!(
        figures.len(),
        2 * 4 + 2 + 2,
        "three charts and the passes of two scenes, frames of one, growth"
    );
    for path in figures {
        let text = std::fs::read_to_string(path).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        let root = document.root_element();
        assert_eq!(root.tag_name().namespace(), Some("http://www.w3.org/2000/svg"), "{}", path.display());
        let has =
            |tag: &str| root.descendants().any(|node| node.has_tag_name(("http://www.w3.org/2000/svg", tag)));
        assert!(has("style") && has("text"), "{}", path.display());
        let data = path.with_extension("csv");
        assert!(rows(&data).len() > 1, "{}", data.display());
    }
    let svg = std::fs::read_to_string(dir.path("report_files/mirror-room-flip.svg")).unwrap();
    let legend = ["kim2019 · photons-grid", "basic + validated · points-grid", "path"];
    assert!(legend.iter().all(|name| svg.contains(&format!("<text x=\"24\" y=\"13\">{name}</text>"))));
}

#[test]
fn names_are_text_and_never_markup() {
    let dir = TestDir::new();
    fixture::write(&dir.path("results"));
    let title = "</title><script>alert(1)</script>";
    let (text, page) = write_page(&dir, &["results", "--title", title]);
    assert_eq!(text_of(&page, "head > title"), title);
    assert_eq!(select(&page, "script").len(), 1, "a name became a script");
    assert_eq!(text_of(&page, "#scene-moving-b-glass > h2"), fixture::ROUGH);
    assert!(select(&page, "h2 b, nav b").is_empty());
    assert!(!text.contains("<b> & \"glass\""));
}

#[test]
fn a_hostile_commit_is_shown_as_text_and_in_no_command() {
    let dir = TestDir::new();
    let mut runs = fixture::write(&dir.path("all"));
    let run = &mut runs[0];
    for (commit, is_hash) in [("main; touch OWNED #\u{3}\u{1b}[201~", false), ("0123abc-dirty", true)] {
        run.provenance.commit = commit.into();
        fixture::save(&dir.path("-f $(touch OWNED)"), run);
        let (_, page) = write_page(&dir, &["./-f $(touch OWNED)", "--force"]);
        let commands = text_of(&page, "#provenance pre");
        assert_eq!(commands.contains("git checkout 0123abc\n"), is_hash, "{commands}");
        assert!(commands.ends_with("caustics report './-f $(touch OWNED)' -o report.html"), "{commands}");
        assert_eq!(commands.lines().count(), 1 + usize::from(is_hash), "{commands}");
        let values = text_of(&page, "#provenance dl");
        assert!(values.contains(commit.split('\u{3}').next().unwrap()), "{values}");
        assert!(!values.chars().any(|character| character.is_control()), "{values:?}");
    }
}

#[test]
fn missing_measures_are_left_out_and_missing_path_tracing_is_noted() {
    let dir = TestDir::new();
    let mut runs = fixture::write(&dir.path("whole"));
    runs.retain(|run| run.config.scene == "mirror-room" && run.config.text(&METHOD) != "path");
    let mut timed = runs[0].clone();
    timed.error = None;
    fixture::save(&dir.path("timed"), &mut timed);
    let (_, page) = write_page(&dir, &["timed"]);
    assert!(select(&page, "[data-chart], .strip, .wipe, #features").is_empty());
    assert_eq!(select(&page, ".bar").len(), 2, "a bar for each width of window");
    assert!(!text_of(&page, "#scene-mirror-room th").contains("FLIP"));

    let mut seen = runs[3].clone();
    seen.time = None;
    fixture::save(&dir.path("seen"), &mut seen);
    let (_, page) = write_page(&dir, &["seen", "--force"]);
    assert!(select(&page, ".chart, #features").is_empty());
    assert_eq!(select(&page, ".tile").len(), 2, "reference and image");
    assert_eq!(select(&page, ".wipe-box option").len(), 1);

    let mut both = runs[3].clone();
    fixture::save(&dir.path("both"), &mut both);
    let (_, page) = write_page(&dir, &["both", "--force"]);
    assert!(text_of(&page, "[data-chart=flip] .note").contains("no run configuration of method path"));
    let (_, page) = write_page(&dir, &["whole", "--force"]);
    assert!(!text_of(&page, "[data-chart=flip] .note").contains("no run configuration of method path"));
}

#[test]
fn parts_hold_the_data_they_are_about() {
    let dir = TestDir::new();
    let runs = fixture::write(&dir.path("results"));
    let (_, page) = write_page(&dir, &["results"]);
    let features = rows(&dir.path("report_files/features.csv"));
    assert_eq!(features.len(), 4, "two pairs of two scenes");
    for row in &features {
        let [scene, all]: [f64; 2] = [&row["scene_ms"], &row["all_ms"]].map(|value| value.parse().unwrap());
        assert!((row["saved_percent"].parse::<f64>().unwrap() - 100.0 * (1.0 - scene / all)).abs() < 1e-9);
    }
    let note = text_of(&page, "#features .note");
    assert!(note.contains("mirror-room does without ") && note.contains("metal"), "{note}");
    let ratios = rows(&dir.path("report_files/mirror-room-ratios.csv"));
    assert!(ratios.iter().any(|row| row["cell"].starts_with("kim2019") && row["time_ratio"] == "1"));
    let provenance = text_of(&page, "#provenance");
    for words in [
        "0123abc",
        "8f3c5b7a90d1e2f4",
        "CPU, 2 threads",
        "caustics report results -o report.html",
        "git checkout 0123abc",
    ] {
        assert!(provenance.contains(words), "{words}: {provenance}");
    }
    let seconds = 12.5 * runs.len() as f64;
    assert!(provenance.contains(&format!("{}m", (seconds / 60.0) as u32)), "{provenance}");
    assert!(select(&page, "#stability tbody tr").len() > 10);
}

#[test]
fn unreadable_and_unwritable_files_are_named() {
    let dir = TestDir::new();
    let runs = fixture::write(&dir.path("results"));
    #[track_caller]
    fn refuses(dir: &TestDir, arguments: &[&str], code: i32, words: &str) {
        let before = dir.folder().read_dir().unwrap().count();
        let run = report(dir, arguments);
        run.expect_refusal(arguments, code, &[words]);
        assert!(run.stderr.starts_with("error: "), "{}", run.stderr);
        assert_eq!(dir.folder().read_dir().unwrap().count(), before, "a refused run left a file");
    }
    refuses(&dir, &["nowhere", "-o", "a.html"], 1, "nowhere");
    refuses(&dir, &["results", "-o", "results"], 2, "name a file");
    refuses(&dir, &["results", "-o", "nowhere/a.html"], 1, "nowhere");

    write_page(&dir, &["results"]);
    let first = std::fs::read(dir.path("report.html")).unwrap();
    refuses(&dir, &["results", "-o", "report.html"], 2, "--force");
    std::fs::remove_file(dir.path("report.html")).unwrap();
    refuses(&dir, &["results", "-o", "report.html"], 2, ".csv exists");
    write_page(&dir, &["results", "--force"]);
    assert_eq!(std::fs::read(dir.path("report.html")).unwrap(), first, "the same results give the same page");

    let image = runs[7].error.as_ref().unwrap().image.clone().unwrap();
    let missing = dir.path("results/cells").join(image);
    let bytes = std::fs::read(&missing).unwrap();
    std::fs::write(&missing, &bytes[..bytes.len() / 2]).unwrap();
    refuses(&dir, &["results", "-o", "b.html"], 1, missing.file_name().unwrap().to_str().unwrap());
    std::fs::remove_file(&missing).unwrap();
    let Run { code, stderr, .. } = report(&dir, &["results", "-o", "b.html"]);
    assert!(code == Some(0) && stderr.contains("is missing"), "{stderr}");

    dir.write("results/cells/damaged.json", "{\"identity\": 3}");
    refuses(&dir, &["results", "-o", "c.html"], 1, "damaged.json");
}

#[test]
fn an_image_outside_the_folder_is_not_shown() {
    let dir = TestDir::new();
    let runs = fixture::write(&dir.path("results"));
    let mut run = runs[3].clone();
    fixture::save(&dir.path("one"), &mut run);
    let image = run.error.as_mut().unwrap().image.as_mut().unwrap();
    *image = format!("../../results/cells/{image}");
    let file = dir.path("one/cells").join(format!("{}.json", run.identity));
    std::fs::write(file, serde_json::to_vec(&run).unwrap()).unwrap();
    let one = ["one", "-o", "a.html"];
    report(&dir, &one).expect_refusal(&one, 1, &[&run.identity, "image"]);
    assert!(!dir.path("a.html").exists());
}

#[test]
fn extreme_names_and_numbers_are_drawn() {
    let dir = TestDir::new();
    let runs = fixture::write(&dir.path("all"));
    let name = format!("{}\u{1}\u{7}", "long".repeat(100));
    for (run, relmse) in runs[3..6].iter().zip([1e-300, 5e-324, 1e300]) {
        let mut run = run.clone();
        run.config.scene.clone_from(&name);
        run.error.as_mut().unwrap().values.insert(RELMSE.key.into(), Some(relmse));
        fixture::save(&dir.path("results"), &mut run);
    }
    write_page(&dir, &["results"]);
    let mut count = 0;
    for entry in dir.path("report_files").read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "svg") {
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(roxmltree::Document::parse(&text).is_ok(), "{}", path.display());
            count += 1;
        }
    }
    assert!(count > 2);
}

#[test]
fn differences_to_a_baseline_have_a_table_and_all_scenes_an_overview() {
    let dir = TestDir::new();
    let mut runs = fixture::write(&dir.path("after"));
    fixture::write(&dir.path("before"));
    let changed = &mut runs[0];
    let flip = changed.error.as_ref().unwrap().get(&FLIP).unwrap();
    let error = changed.error.as_mut().unwrap();
    error.values.insert(FLIP.key.into(), Some(2.0 * flip));
    let identity = changed.identity.clone();
    fixture::save(&dir.path("after"), changed);
    let (_, page) = write_page(&dir, &["after", "--baseline", "before"]);
    let sections: Vec<&str> =
        select(&page, "main > section").iter().map(|node| node.attr("id").unwrap()).collect();
    assert_eq!(sections[..2], ["overview", "baseline"]);
    assert!(text_of(&page, "#overview .note").contains("held against"));
    let changes = rows(&dir.path("report_files/baseline.csv"));
    let differ: Vec<_> = changes.iter().filter(|row| row["verdict"] != "the same").collect();
    assert_eq!(differ.len(), 1, "{identity}: {differ:?}");
    assert!(differ[0]["measure"] == "FLIP" && differ[0]["ratio"] == "2", "{differ:?}");
    let nowhere = ["after", "--baseline", "nowhere", "-o", "other.html"];
    report(&dir, &nowhere).expect_refusal(&nowhere, 1, &["nowhere"]);
}

/// Leaves a report for `.ci/report-browser`, which opens it in a browser.
#[test]
#[ignore = "leaves files in the folder $CAUSTICS_REPORT: for .ci/report-browser"]
fn leaves_a_report() {
    let folder = PathBuf::from(std::env::var_os("CAUSTICS_REPORT").expect("set CAUSTICS_REPORT to a folder"));
    fixture::write(&folder.join("results"));
    let mut command = Command::new(BINARY);
    let arguments = ["report", "results", "-o", "report.html", "--force"];
    command.current_dir(folder).args(arguments).assert().success();
}
