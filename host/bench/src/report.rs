//! A report: results of several folders as one page that needs no network, and SVG and CSV of each figure.
//!
//! `load` reads the results of run configurations, `scene` groups them and `name` names them. Every figure, table and block
//! has its own file; `page` assembles them.

use std::path::PathBuf;

use maud::{Markup, html};

mod axis;
mod baseline;
mod features;
mod figure;
mod frames;
mod growth;
mod images;
mod load;
mod name;
mod number;
mod overview;
mod page;
mod pareto;
mod passes;
mod plot;
mod provenance;
mod ratio;
mod run_table;
mod scene;
mod speed;
mod stability;
mod strip;
mod table;
mod tip;

use crate::error::MEASURES;
use crate::result::RunResult;

use figure::Figure;
use images::ReportImages;
use load::Measured;
use name::Names;
pub use page::STYLE;
use page::Section;
use scene::ReportScene;
use table::{Table, csv};

/// Input of a report.
#[derive(Clone, Debug)]
pub struct Request {
    /// Folders of results.
    pub folders: Vec<PathBuf>,
    /// Folders of results to compare with; each run configuration is compared with the same one there.
    pub baseline: Vec<PathBuf>,
    /// Title of the page.
    pub title: String,
    /// Maximum number of images of a scene.
    pub images: usize,
    /// File of the page, named in the command that repeats the report.
    pub output: PathBuf,
}

/// A report that can be written.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// HTML of the page.
    pub html: String,
    /// Files beside it: names and contents.
    pub files: Vec<(String, Vec<u8>)>,
    /// Messages for the user that are not on the page.
    pub warnings: Vec<String>,
    /// Number of run configurations in the report.
    pub runs: usize,
}

impl Report {
    fn add_figure(&mut self, figure: &Figure) -> anyhow::Result<()> {
        self.files.push((format!("{}.svg", figure.name), figure.file().into_bytes()));
        self.add_rows(&figure.name, &figure.rows)
    }

    fn add_rows(&mut self, name: &str, rows: &[Vec<String>]) -> anyhow::Result<()> {
        self.files.push((format!("{name}.csv"), csv(rows)?));
        Ok(())
    }

    fn table(&mut self, table: &Table, head: &str, note: &str) -> anyhow::Result<Markup> {
        self.add_rows(&table.name, &table.rows())?;
        Ok(page::table(table, head, note))
    }

    fn figure(&mut self, figure: &Figure, head: &str, note: &str) -> anyhow::Result<Markup> {
        self.add_figure(figure)?;
        Ok(page::figure(figure, head, note))
    }
}

/// Reads the results and makes the report.
pub fn report(request: &Request) -> anyhow::Result<Report> {
    let (runs, warnings) = load::load(&request.folders)?;
    let (before, of_before) = match &request.baseline[..] {
        [] => Default::default(),
        folders => load::load(folders)?,
    };
    let report = from_runs(&runs, &before, request)?;
    Ok(Report { warnings: [warnings, of_before, report.warnings].concat(), ..report })
}

/// Makes the report of results that are in memory.
pub(crate) fn from_results(results: Vec<RunResult>, request: &Request) -> anyhow::Result<Report> {
    let measured = |result| Measured { result, folder: "/no folder".into() };
    from_runs(&results.into_iter().map(measured).collect::<Vec<_>>(), &[], request)
}

fn from_runs(runs: &[Measured], before: &[Measured], request: &Request) -> anyhow::Result<Report> {
    let names = Names::new(runs);
    let scenes = scene::scenes(runs);
    let mut report = Report { runs: runs.len(), ..Report::default() };
    let mut images = ReportImages::default();
    let mut sections = Vec::new();
    if let Some(overview) = overview::overview(&scenes, &names) {
        let content = report.table(&overview.table, &overview.table.title, &overview.sentence)?;
        sections.push(Section { id: "overview".into(), title: "Over all scenes".into(), content });
    }
    if !request.baseline.is_empty() {
        let content = match baseline::changes(before, runs, &names) {
            Some(table) => {
                let note = "Standard errors are those between seeds, and of the medians of times. Times of two runs were not \
                            taken in turns: what else the machine did differs too.";
                report.table(&table, "Run configurations that both have", note)?
            }
            None => {
                html! { p .note { "No run configuration of these results has the same settings and size before." } }
            }
        };
        sections.push(Section { id: "baseline".into(), title: "Before and after".into(), content });
    }
    for scene in &scenes {
        let content =
            scene_section(scene, &names.among(&scene.runs), &mut images, request.images, &mut report)?;
        sections.push(Section { id: format!("scene-{}", scene.slug), title: scene.title.clone(), content });
    }
    if let Some((figures, table)) = growth::growth(runs) {
        let mut parts = Vec::new();
        for figure in &figures {
            parts.push(report.figure(figure, &figure.title, "")?);
        }
        let note = "Least squares of logarithms over run configurations that differ in one quantity, and the slope of the last \
                    step, where fixed costs hide least; n log n over the same values. What is above it by twice its standard error, \
                    over all values or in the last step, is not within.";
        parts.push(report.table(&table, "Exponents", note)?);
        let content = html! { @for part in &parts { (part) } };
        sections.push(Section { id: "growth".into(), title: "Cost against work".into(), content });
    }
    if let Some(table) = features::features(&scenes, &names) {
        report.add_rows(&table.name, &table.rows())?;
        let content = features::inline(&table);
        sections.push(Section { id: "features".into(), title: "Code that is not needed".into(), content });
    }
    let stability = stability::stability()?;
    if !stability.mode.is_empty() {
        report.add_rows("stability", &stability.rows())?;
        let content = html! {
            p .note { "Known ways in which such methods fail; each is a test that runs with every change of the program." }
            (stability.inline())
        };
        sections.push(Section { id: "stability".into(), title: "Stability".into(), content });
    }
    report.add_rows("cells", &run_table::all(runs, &names))?;
    let commands = provenance::commands(runs, &request.folders, &request.output);
    let content = provenance::inline(runs, &commands);
    sections.push(Section { id: "provenance".into(), title: "Provenance".into(), content });

    let count = |count: usize, one: &str| format!("{count} {one}{}", if count == 1 { "" } else { "s" });
    let lead = format!("{} of {}.", count(runs.len(), "run configuration"), count(scenes.len(), "scene"));
    report.html = page::page(&request.title, &lead, &sections, &images.store());
    for path in &images.missing {
        report
            .warnings
            .push(format!("{} is missing, and its run configuration is shown without it", path.display()));
    }
    Ok(report)
}

/// Section of a scene. It answers in order: which is best, how does it look, why does it take that long, what are the
/// numbers.
fn scene_section(
    scene: &ReportScene,
    names: &Names,
    images: &mut ReportImages,
    count: usize,
    report: &mut Report,
) -> anyhow::Result<Markup> {
    let charted = MEASURES.into_iter().filter(|measure| measure.charted);
    let charts: Vec<_> = charted.filter_map(|measure| speed::chart(scene, names, measure)).collect();
    for chart in &charts {
        report.add_figure(&chart.figure)?;
    }
    let mut parts = Vec::new();
    if !charts.is_empty() {
        parts.push(html! { h3 { "Speed against accuracy" } (page::charts(&charts)) });
    }
    if let Some(strip) = strip::strip(scene, names, images, count)? {
        parts.push(html! { h3 { "Images" } (strip) });
    }
    if let Some(figure) = passes::passes(scene, names) {
        let note = "Medians of the passes; the number at the end is the median of the whole frame.";
        parts.push(report.figure(&figure, "Time by pass", note)?);
    }
    for figure in frames::frames(scene, names) {
        let head = figure.title.rsplit(": ").next().unwrap_or_default();
        let (first, rest) = head.split_at(head.chars().next().map_or(0, char::len_utf8));
        let head = first.to_uppercase() + rest;
        parts.push(report.figure(&figure, &head, "")?);
    }
    if let Some(table) = ratio::ratios(scene, names) {
        let note = "Time is the median over turns of a configuration's time over that of the first one in the same turn.";
        parts.push(report.table(&table, "Ratios", note)?);
    }
    let (table, common) = run_table::table(scene);
    let common: Vec<String> = common.iter().map(|(head, text)| format!("{head} {text}")).collect();
    let note =
        if common.is_empty() { String::new() } else { format!("The same for all: {}.", common.join(", ")) };
    parts.push(report.table(&table, "All run configurations", &note)?);
    Ok(html! { @for part in &parts { (part) } })
}
