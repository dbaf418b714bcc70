//! Report on features: time saved by leaving out the code that a scene does not need. Compares pairs of run configurations
//! that differ only in `features`.

use caustics_kernels::interface::features::Features;
use maud::{Markup, html};

use super::load::Measured;
use super::name::Names;
use super::scene::ReportScene;
use super::table::{Column, Table, TableValue};
use crate::parameter::FEATURES;
use caustics::scene;

/// Default of `--specular-roughness`, which decides whether a surface is a caster.
const SPECULAR_ROUGHNESS: f32 = 0.25;

/// A run configuration with only the code that the scene needs, and the same one with all code compiled in.
type Pair<'a> = (&'a Measured, &'a Measured);

/// Table over all scenes; none without a pair. Its last column lists the features that each scene does without.
pub fn features(scenes: &[ReportScene], names: &Names) -> Option<Table> {
    let mut rows: Vec<(String, String, Pair)> = Vec::new();
    for scene in scenes {
        let pairs = pairs(&scene.runs);
        let unneeded =
            if pairs.is_empty() { String::new() } else { unneeded(&pairs[0].0.result.config.scene) };
        rows.extend(pairs.into_iter().map(|pair| (scene.title.clone(), unneeded.clone(), pair)));
    }
    if rows.is_empty() {
        return None;
    }
    let word =
        |text: &String| if text.is_empty() { TableValue::None } else { TableValue::Text(text.clone()) };
    let ms = |run: &Measured| run.result.time.as_ref().map(|time| time.total_ms.median);
    let gain = |pair: &Pair| Some(100.0 * (1.0 - ratio(pair)?));
    let percent = |value: Option<f64>| {
        value.map_or(TableValue::None, |value| TableValue::Number(value, format!("{value:.1} %")))
    };
    let column = |head, key: &str, values| Column { head, key: key.into(), values };
    let columns = vec![
        column("scene", "scene", rows.iter().map(|(scene, ..)| TableValue::Text(scene.clone())).collect()),
        column(
            "configuration",
            "cell",
            rows.iter().map(|(.., (run, _))| TableValue::Text(names.label(run))).collect(),
        ),
        column(
            "as needed [ms]",
            "scene_ms",
            rows.iter().map(|(.., pair)| TableValue::number(ms(pair.0))).collect(),
        ),
        column("all [ms]", "all_ms", rows.iter().map(|(.., pair)| TableValue::number(ms(pair.1))).collect()),
        column("time saved", "saved_percent", rows.iter().map(|(.., pair)| percent(gain(pair))).collect()),
        column("not needed", "not_needed", rows.iter().map(|(_, names, _)| word(names)).collect()),
    ];
    let title = "What a scene does not need, and what leaving it out gains".into();
    Some(Table { name: "features".into(), title, columns }.without_empty())
}

/// Table for the page. It lists what a scene does without once, not in each of its rows.
pub fn inline(table: &Table) -> Markup {
    let column = |key: &str| table.columns.iter().position(|column| column.key == key);
    let rows = table.rows();
    let mut notes: Vec<(&String, &String)> = match (column("scene"), column("not_needed")) {
        (Some(scene), Some(names)) => rows[1..].iter().map(|row| (&row[scene], &row[names])).collect(),
        _ => vec![],
    };
    // Every row has a scene, but not every scene can be loaded.
    notes.retain(|(_, names)| !names.is_empty());
    notes.dedup();
    let mut short = table.clone();
    short.columns.retain(|column| column.key != "not_needed");
    html! {
        p .note { "The same frame with the code that the scene needs alone, and with all code compiled in." }
        (short.inline())
        @for (scene, names) in notes { p .note { b { (scene) } " does without " (names) "." } }
    }
}

fn pairs<'a>(runs: &[&'a Measured]) -> Vec<Pair<'a>> {
    let timed: Vec<&Measured> = runs.iter().copied().filter(|run| run.result.time.is_some()).collect();
    let device = |run: &Measured| run.result.provenance.device.clone();
    let size =
        |run: &Measured| run.result.time.as_ref().map(|time| (time.width, time.height, time.light_paths));
    let mut pairs = Vec::new();
    for run in timed.iter().filter(|run| run.result.config.text(&FEATURES) == "scene") {
        let wanted = run.result.config.clone().with(&FEATURES, "all");
        let other = timed.iter().find(|other| {
            // Times of other runs were not measured in the same turns.
            other.result.config == wanted
                && other.folder == run.folder
                && device(other) == device(run)
                && size(other) == size(run)
        });
        pairs.extend(other.map(|other| (*run, *other)));
    }
    pairs
}

/// Time of the first of a pair over the time of the second. Uses the ratios within turns if both refer to the same
/// configuration.
fn ratio((one, other): &Pair) -> Option<f64> {
    let (one, other) = (one.result.time.as_ref()?, other.result.time.as_ref()?);
    let turns = one.ratio_to_first.zip(other.ratio_to_first).filter(|_| one.first == other.first);
    let (one, other) = turns.unwrap_or((one.total_ms.median, other.total_ms.median));
    Some(one / other)
}

/// Names of the code that the scene does without; empty where the scene cannot be loaded.
fn unneeded(name: &str) -> String {
    let load = || scene::Scene::load(&scene::resolve(name).ok()?).ok();
    let Some(scene) = load() else { return String::new() };
    let features = scene.features(SPECULAR_ROUGHNESS);
    let names = Features::NAMES.iter().filter(|(bit, _)| !features.has(*bit)).map(|(_, name)| *name);
    names.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::{METHOD, PATHS_PER_PIXEL};
    use crate::report::scene::scenes;
    use crate::result::{ConfigValues, Quartiles, RunResult, TimeResult};

    fn run(features: &str, paths: f64, ms: f64) -> Measured {
        let config = ConfigValues::new("nowhere", "")
            .with(&METHOD, "basic")
            .with(&FEATURES, features)
            .with(&PATHS_PER_PIXEL, &paths.to_string());
        let total_ms = Quartiles { median: ms, ..Quartiles::default() };
        let time = Some(TimeResult { total_ms, ..TimeResult::default() });
        Measured { result: RunResult { config, time, ..RunResult::default() }, folder: "".into() }
    }

    #[test]
    fn only_configurations_that_differ_in_features_alone_are_pairs() {
        let mut runs = vec![
            run("all", 1.0, 10.0),
            run("scene", 1.0, 8.0),
            run("scene", 2.0, 20.0),
            run("all", 4.0, 40.0),
        ];
        let names = Names::new(&runs);
        let rows = features(&scenes(&runs), &names).unwrap().rows();
        assert_eq!(rows[0], ["scene", "cell", "scene_ms", "all_ms", "saved_percent"]);
        assert_eq!(rows[1][..4], ["nowhere", "basic · 1 path/px", "8", "10"]);
        assert!((rows[1][4].parse::<f64>().unwrap() - 20.0).abs() < 1e-9 && rows.len() == 2);
        // In its turns, the second configuration takes a quarter less time.
        for (run, ratio) in runs.iter_mut().zip([1.0, 0.75]) {
            let time = run.result.time.as_mut().unwrap();
            (time.ratio_to_first, time.first) = (Some(ratio), "first".into());
        }
        let rows = features(&scenes(&runs), &names).unwrap().rows();
        assert!((rows[1][4].parse::<f64>().unwrap() - 25.0).abs() < 1e-9);
        runs[0].result.provenance.device = "another".into();
        assert!(features(&scenes(&runs), &names).is_none());
    }

    #[test]
    fn plain_walls_need_no_code_for_glass() {
        let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/");
        let plain = unneeded(&format!("{scenes}plain-room"));
        assert!(plain.contains("glass"), "{plain}");
        assert!(!unneeded(&format!("{scenes}mirror-room")).split(", ").any(|name| name == "glass"));
    }
}
