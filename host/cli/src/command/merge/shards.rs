//! Merges the shards of a run: their sums, in f64, add up to the run's.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use caustics::accumulation::Shape;
use caustics::checkpoint::{self, Difference, Head, difference};
use caustics::output::exr;
use caustics::output::target::Target;
use caustics::shard::Shard;

use crate::cli::{Merge, Usage};
use crate::command::identity::end;
use crate::command::options::layers_named;
use crate::command::shard::{ALL_FRAMES, SHARD};

/// Attributes in which shards of one run may differ: they depend on the machine.
const OF_MACHINES: [&str; 3] = ["runner", "device", "scene_file"];
/// Maximum number of missing shards that a message names.
const MAX_NAMED: usize = 200;

/// A shard, read up to its head.
struct Part<'a> {
    path: &'a Path,
    head: Head,
    shard: Shard,
}

impl Part<'_> {
    fn read(path: &Path) -> anyhow::Result<Part<'_>> {
        let head = checkpoint::head(path)?;
        let shard = head.identity.get(SHARD).and_then(|text| Shard::parse(text));
        let shard = shard.ok_or_else(|| Usage(format!("{} is no shard of a run", path.display())))?;
        Ok(Part { path, head, shard })
    }

    /// Identity and attributes of the run, without those of the part and the machine.
    fn run(&self) -> BTreeMap<String, String> {
        let Head { identity, about, .. } = &self.head;
        let of_run = |(name, _): &(String, String)| name != SHARD && !OF_MACHINES.contains(&name.as_str());
        let mut run: BTreeMap<_, _> =
            identity.clone().into_iter().chain(about.clone()).filter(of_run).collect();
        run.insert("shards".into(), self.shard.count.to_string());
        run
    }

    /// Whether the shard holds all of its frames; `all` is the number of frames of all shards.
    fn is_whole(&self, all: u32) -> bool {
        let shape = self.head.shape;
        self.shard.frames(0..all).is_ok_and(|frames| (frames.start, frames.end) == (shape.first, shape.end()))
    }
}

/// Writes the mean of all shards, none of which may be missing.
pub fn join(options: &Merge, target: Target) -> anyhow::Result<()> {
    let mut parts = options.inputs.iter().map(|path| Part::read(path)).collect::<Result<Vec<_>, _>>()?;
    parts.sort_by_key(|part| part.shard.index);
    check(&parts)?;
    let mut sums = None;
    for Part { path, head, .. } in &parts {
        let part = checkpoint::load(path, &head.identity, head.shape)?.sums;
        if part.shape != head.shape {
            return Err(Usage(format!("{} was written while it was read", path.display())).into());
        }
        match &mut sums {
            None => sums = Some(part),
            Some(sums) => sums.append(&part),
        }
    }
    let sums = sums.unwrap_or_default();
    let mut attributes = parts[0].head.about.clone();
    for name in OF_MACHINES {
        let values: BTreeSet<_> =
            parts.iter().filter_map(|part| part.head.about.get(name)).map(String::as_str).collect();
        attributes.insert(name.into(), values.into_iter().collect::<Vec<_>>().join(", "));
    }
    end(&mut attributes, sums.frames(), parts.iter().map(|part| part.head.seconds).sum());
    let mut image = sums.mean();
    image.auxiliary.keep(&layers_named(attributes.get("aov").map_or("", String::as_str)));
    let variance = sums.variance().map(|variance| (variance, sums.frames()));
    target.finish(&exr::encode(&image, variance, &attributes)?)?;
    let (out, frames, count) = (options.output.display(), sums.frames(), parts.len());
    message!("{out}: the mean of {frames} frames from {count} shards");
    Ok(())
}

/// Refuses shards of different runs, and an incomplete run.
fn check(parts: &[Part]) -> Result<(), Usage> {
    let first = &parts[0];
    for pair in parts.windows(2) {
        let [part, next] = pair else { continue };
        if let Some(Difference { name, theirs, ours }) = difference(&next.run(), &part.run()) {
            let (a, b) = (part.path.display(), next.path.display());
            return Err(Usage(format!("{a} and {b} are of two runs: {name} is {theirs:?}, and {ours:?}")));
        }
        let of_run = |head: &Head| Shape { first: 0, frames: 0, ..head.shape };
        if of_run(&part.head) != of_run(&next.head) {
            let (a, b) = (part.path.display(), next.path.display());
            return Err(Usage(format!("{a} and {b} are of two runs: their sums differ in size")));
        }
        if part.shard == next.shard {
            let (a, b) = (part.path.display(), next.path.display());
            return Err(Usage(format!("{a} and {b} are both shard {}; leave one out", part.shard)));
        }
    }
    let all = first.head.identity.get(ALL_FRAMES).and_then(|all| all.parse().ok()).unwrap_or(0);
    let whole: BTreeSet<u32> =
        parts.iter().filter(|part| part.is_whole(all)).map(|part| part.shard.index + 1).collect();
    let count = first.shard.count;
    let missing = (1..=count).filter(|number| !whole.contains(number)).take(MAX_NAMED);
    let missing: Vec<String> = missing.map(|number| number.to_string()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let missing = missing.join(",");
    Err(Usage(format!(
        "shards {missing} of {count} are missing or not done; start them again, then merge all"
    )))
}
