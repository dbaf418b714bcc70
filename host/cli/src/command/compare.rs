//! `caustics compare`.

use std::path::Path;
use std::process::ExitCode;

use anyhow::anyhow;
use caustics::image_file::{Channels, Encoding};
use caustics::memory;
use caustics::metric::comparison::{Metric, MetricValue, Viewing};
use caustics::metric::pixels::{Estimate, Region};
use caustics::metric::report::MetricReport;
use caustics::output::png;
use caustics::output::target::Target;
use serde_json::json;

use super::console::print;
use super::options::{check_ending, same_file};
use crate::cli::{Compare, Limit, Usage};

/// Memory of the metrics for each pixel (bytes). The measured growth of the peak is 236.
const PIXEL_BYTES: u64 = 240;
/// Memory of a pixel of each file (bytes): its mean and variance, in f64. The measured growth of the peak is 27.
const FILE_BYTES: u64 = 48;

/// Measures and reports. Returns exit code 3 if a metric is above its limit or has no value.
pub fn run(options: &Compare) -> anyhow::Result<ExitCode> {
    let map = check(options)?;
    let (reference, images) = options.files.split_last().ok_or_else(|| Usage("no files".into()))?;
    let image = Channels::read(reference)?;
    let frame = Frame::new(options, reference, &image)?;
    let Region { width, height, .. } = frame.region;
    let bytes = (width * height) as u64 * (PIXEL_BYTES + FILE_BYTES * options.files.len() as u64);
    memory::check(bytes)
        .map_err(|short| anyhow!("{width}x{height} px would take {short}; compare a --region of them"))?;
    let mut estimates = vec![frame.layer(reference, &image)?];
    drop(image);
    // Read one file at a time, since there may be many.
    for (index, path) in images.iter().enumerate() {
        estimates.insert(index, frame.layer(path, &Channels::read(path)?)?);
    }
    let (encoding, region) = (frame.encoding, frame.region);
    let non_finite: Vec<usize> = estimates.iter().map(|image| image.mean.non_finite_count()).collect();
    for (path, count) in options.files.iter().zip(&non_finite).filter(|(_, count)| **count > 0) {
        message!("warning: {}: {count} pixels are NaN or infinite", path.display());
    }
    let of_reference = estimates.pop().ok_or_else(|| Usage("no files".into()))?;
    let exposure = options.exposure.stops(of_reference.mean.values.iter().copied());
    let viewing = Viewing { encoding, exposure, pixels_per_degree: options.pixels_per_degree };
    let report = MetricReport::new(&estimates, &of_reference, &viewing);

    match (map, &report.map) {
        (Some(target), Some(map)) => {
            target.finish(&png::encode(map.width as u32, map.height as u32, &map.to_colors())?)?;
        }
        (Some(_), None) => message!("warning: --map: FLIP has no value here, and no map is written"),
        (None, _) => {}
    }
    let failed = failed(options, &report);
    for failure in &failed {
        message!("failed: {failure}");
    }
    if options.json {
        let region = json!({ "x": region.x, "y": region.y, "width": region.width, "height": region.height });
        let (of_reference, of_images) = non_finite.split_last().unwrap_or((&0, &[]));
        let out = json!({
            "images": images, "reference": reference, "layer": options.layer, "region": region,
            "runs": images.len(), "metrics": report.by_name(), "unavailable": report.unavailable(),
            "non_finite_px": { "images": of_images, "reference": of_reference },
            "z_blocks": report.z_blocks,
            "exposure": exposure, "pixels_per_degree": options.pixels_per_degree, "failed": failed,
        });
        print(serde_json::to_string_pretty(&out)?)?;
    } else {
        print(table(&report).trim_end())?;
    }
    Ok(ExitCode::from(if failed.is_empty() { 0 } else { 3 }))
}

/// Checks the options, and claims the map's file.
fn check(options: &Compare) -> anyhow::Result<Option<Target>> {
    if !(1.0..=1000.0).contains(&options.pixels_per_degree) {
        let value = options.pixels_per_degree;
        return Err(Usage(format!("--pixels-per-degree {value}: it must be 1 to 1000")).into());
    }
    let Some(map) = &options.map else { return Ok(None) };
    if map.is_dir() {
        return Err(Usage(format!("--map: {} is a folder; name a file in it", map.display())).into());
    }
    if options.files.iter().any(|file| same_file(file, map)) {
        return Err(
            Usage(format!("--map {} would overwrite an image that is compared", map.display())).into()
        );
    }
    check_ending("--map", map, "png")?;
    Ok(Some(Target::claim(map, options.force)?))
}

/// Properties that all images share with the reference, and the compared part of them.
struct Frame<'a> {
    reference: &'a Path,
    size: (usize, usize),
    encoding: Encoding,
    layer: &'a str,
    region: Region,
}

impl<'a> Frame<'a> {
    fn new(options: &'a Compare, reference: &'a Path, image: &Channels) -> Result<Frame<'a>, Usage> {
        let (size, encoding) = ((image.width, image.height), image.encoding);
        let region = options.region.unwrap_or(Region::whole(image));
        if !region.is_within(size.0, size.1) {
            let Region { x, y, width, height } = region;
            let path = reference.display();
            return Err(Usage(format!(
                "--region {x},{y},{width},{height} is not within the {}x{} px of {path}",
                size.0, size.1
            )));
        }
        Ok(Frame { reference, size, encoding, layer: &options.layer, region })
    }

    /// Returns the layer of a file, with its variance if it has one.
    fn layer(&self, path: &Path, image: &Channels) -> Result<Estimate, Usage> {
        let (file, reference) = (path.display(), self.reference.display());
        let (width, height) = (image.width, image.height);
        if (width, height) != self.size {
            return Err(Usage(format!(
                "{file} has {width}x{height} px, {reference} {}x{}; render both in one size",
                self.size.0, self.size.1
            )));
        }
        if image.encoding != self.encoding {
            return Err(Usage(format!(
                "{file} and {reference}: one is EXR, the other PNG; give two of a kind"
            )));
        }
        let name = self.layer;
        let inner = if name == "beauty" && image.layer(name).is_none() { "" } else { name };
        Estimate::from_layer(image, inner, self.region).ok_or_else(|| {
            let known = image.layer_names().join(", ");
            Usage(format!("--layer {name}: {file} has no such layer; it has {known}"))
        })
    }
}

/// Messages on the metrics that are above their limit or have no value.
fn failed(options: &Compare, report: &MetricReport) -> Vec<String> {
    let check = |limit: &Limit| match report.get(limit.metric.name) {
        Ok(value) => above(limit.metric.name, limit.metric.limited(value), limit.value),
        Err(why) => Some(format!("{} has no value: {why}", limit.metric.name)),
    };
    options.fail_above.iter().filter_map(check).collect()
}

fn above(metric: &str, value: f64, limit: f64) -> Option<String> {
    (value > limit).then(|| format!("{metric} is {value:.6}, above {limit}"))
}

/// Table of the metrics for the user.
fn table(report: &MetricReport) -> String {
    let line = |(Metric { name, unit, .. }, value): &(&'static Metric, MetricValue)| match value {
        Ok(value) if (1e-4..1e7).contains(&value.abs()) || *value == 0.0 => {
            format!("{name:22} {value:>14.6}  {unit}\n")
        }
        Ok(value) => format!("{name:22} {value:>14.6e}  {unit}\n"),
        Err(why) => format!("{name:22} {:>14}  {why}\n", "-"),
    };
    report.values.iter().map(line).collect()
}
