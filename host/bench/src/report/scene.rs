//! Run configurations of one scene seen through one camera, and a selection that represents them.

use super::load::Measured;
use super::name::Names;
use crate::parameter::{FEATURES, PATHS_PER_PIXEL};

/// A scene of the report.
#[derive(Debug)]
pub struct ReportScene<'a> {
    /// Heading: the scene's name, and the camera's where the scene has several.
    pub title: String,
    /// Stem of its file names: letters, digits and dashes, unique in the report.
    pub slug: String,
    /// Its run configurations.
    pub runs: Vec<&'a Measured>,
}

/// Groups sorted run configurations by scene and camera.
pub fn scenes(runs: &[Measured]) -> Vec<ReportScene<'_>> {
    let key = |run: &Measured| (run.result.config.scene.clone(), run.result.config.camera.clone());
    let mut scenes: Vec<ReportScene> = Vec::new();
    let chunks: Vec<&[Measured]> = runs.chunk_by(|a, b| key(a) == key(b)).collect();
    for chunk in &chunks {
        let (name, camera) = key(&chunk[0]);
        let alone = chunks.iter().filter(|other| key(&other[0]).0 == name).count() == 1;
        let title = if alone { name } else { format!("{name}, camera {camera}") };
        let stem = slug(&title);
        let numbered = (scenes.len() + 1..).map(|number| format!("{stem}-{number}"));
        let mut names = [stem.clone()].into_iter().chain(numbered);
        let slug = names.find(|name| scenes.iter().all(|scene| scene.slug != *name)).unwrap_or(stem);
        scenes.push(ReportScene { title, slug, runs: chunk.iter().collect() });
    }
    scenes
}

/// Maximum number of letters of a slug: file systems allow 255 bytes for a whole file name.
const MAX_LETTERS: usize = 120;

/// Name for files: lower-case letters, digits and single dashes.
fn slug(name: &str) -> String {
    let kept = |letter: char| if letter.is_ascii_alphanumeric() { letter.to_ascii_lowercase() } else { '-' };
    let text: String = name.chars().map(kept).take(MAX_LETTERS).collect();
    let parts: Vec<&str> = text.split('-').filter(|part| !part.is_empty()).collect();
    if parts.is_empty() { "scene".into() } else { parts.join("-") }
}

impl<'a> ReportScene<'a> {
    /// Returns at most `count` configurations that satisfy `has`: one of each series, all at the number of paths that most
    /// series have.
    pub fn chosen(&self, names: &Names, count: usize, has: impl Fn(&Measured) -> bool) -> Vec<&'a Measured> {
        let able: Vec<&'a Measured> = self.runs.iter().copied().filter(|run| has(run)).collect();
        let common = common_paths(&able, names);
        let rank = |run: &Measured| {
            let config = &run.result.config;
            (config.text(&FEATURES) == "all", (config.number(&PATHS_PER_PIXEL).max(1e-9) / common).ln().abs())
        };
        let mut chosen: Vec<&'a Measured> = Vec::new();
        for run in able {
            let kind = |run: &Measured| (names.series(&run.result.config), names.origin(run));
            match chosen.iter_mut().find(|other| kind(other) == kind(run)) {
                Some(other) if rank(run) < rank(other) => *other = run,
                Some(_) => {}
                None => chosen.push(run),
            }
        }
        chosen.truncate(count);
        chosen
    }
}

/// Paths a pixel that most series have; among equally common numbers, the one nearest to 1.
fn common_paths(runs: &[&Measured], names: &Names) -> f64 {
    let mut counts: Vec<(f64, Vec<usize>)> = Vec::new();
    for config in
        runs.iter().map(|run| &run.result.config).filter(|config| config.number(&PATHS_PER_PIXEL) > 0.0)
    {
        let series = names.series(config);
        match counts.iter_mut().find(|(paths, _)| *paths == config.number(&PATHS_PER_PIXEL)) {
            Some((_, known)) if known.contains(&series) => {}
            Some((_, known)) => known.push(series),
            None => counts.push((config.number(&PATHS_PER_PIXEL), vec![series])),
        }
    }
    let from_one = |paths: f64| paths.ln().abs();
    counts.sort_by(|a, b| a.1.len().cmp(&b.1.len()).then(from_one(b.0).total_cmp(&from_one(a.0))));
    counts.last().map_or(1.0, |(paths, _)| *paths)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::METHOD;
    use crate::result::{ConfigValues, RunResult};

    fn run(scene: &str, method: &str, paths: f64, features: &str) -> Measured {
        let config = ConfigValues::new(scene, "main")
            .with(&METHOD, method)
            .with(&PATHS_PER_PIXEL, &paths.to_string())
            .with(&FEATURES, features);
        Measured { result: RunResult { config, ..RunResult::default() }, folder: "".into() }
    }

    #[test]
    fn files_of_scenes_have_plain_and_different_names() {
        let mut runs = [
            run("a <b> & \"c\"", "path", 0.0, ""),
            run("A b c", "path", 0.0, ""),
            run("日本", "path", 0.0, ""),
        ];
        runs[2].result.config.camera = "other".into();
        let slugs: Vec<String> = scenes(&runs).into_iter().map(|scene| scene.slug).collect();
        assert_eq!(slugs, ["a-b-c", "a-b-c-2", "scene"]);
        runs[0].result.config.scene = "A b c 2".into();
        runs[2].result.config.scene = "a b  c".into();
        let slugs: Vec<String> = scenes(&runs).into_iter().map(|scene| scene.slug).collect();
        assert_eq!(slugs, ["a-b-c-2", "a-b-c", "a-b-c-3"]);
        assert_eq!(slug(&"long ".repeat(99)).len(), MAX_LETTERS - 1);
        runs[2].result.config.scene = "日本".into();
        runs[1].result.config.scene = "日本".into();
        let titles: Vec<String> = scenes(&runs).into_iter().map(|scene| scene.title).collect();
        assert_eq!(titles[1..], ["日本, camera main", "日本, camera other"]);
    }

    #[test]
    fn a_configuration_of_each_series_is_chosen_at_equal_paths() {
        let runs = [
            run("a", "basic", 0.5, "scene"),
            run("a", "basic", 2.0, "all"),
            run("a", "basic", 2.0, "scene"),
            run("a", "kim2019", 2.0, "scene"),
            run("a", "kim2019", 8.0, "scene"),
            run("a", "path", 0.0, "scene"),
        ];
        let names = Names::new(&runs);
        let scenes = scenes(&runs);
        let chosen = |count| -> Vec<usize> {
            let chosen = scenes[0].chosen(&names, count, |_| true);
            chosen.iter().map(|one| runs.iter().position(|run| std::ptr::eq(run, *one)).unwrap()).collect()
        };
        assert_eq!(chosen(9), [2, 3, 5]);
        assert_eq!(chosen(2), [2, 3]);
    }
}
