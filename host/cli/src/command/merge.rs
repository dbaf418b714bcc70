//! `caustics merge`.

use std::collections::BTreeMap;
use std::process::ExitCode;

use caustics::image_file::Channels;
use caustics::output::target::Target;
use caustics::output::{attributes, exr};
use caustics::rendered_image::RenderedImage;
use caustics_kernels::method::path::PATH;
use glam::Vec3;

use super::options::{check_ending, same_file};
use super::shard::SUMS;
use crate::cli::{Merge, Usage};

mod shards;

/// Attributes in which references of one view may differ.
const OWN: [&str; 8] =
    ["seed", "runner", "device", "frames", "seconds", "commit", "scene_file", attributes::CHECKSUM];

/// Merges shards or references, whichever the inputs are.
pub fn run(options: &Merge) -> anyhow::Result<ExitCode> {
    if let Some(input) = options.inputs.iter().find(|input| same_file(input, &options.output)) {
        let (out, input) = (options.output.display(), input.display());
        return Err(Usage(format!("-o {out} is the input {input}; give another name")).into());
    }
    check_ending("-o", &options.output, "exr")?;
    let target = Target::claim(&options.output, options.force)?;
    let sums = options.inputs.iter().filter(|path| path.extension().is_some_and(|ending| ending == SUMS));
    match sums.count() {
        0 => references(options, target)?,
        count if count == options.inputs.len() => shards::join(options, target)?,
        _ => return Err(Usage(format!("give shards alone (.{SUMS}), or references alone (.exr)")).into()),
    }
    Ok(ExitCode::SUCCESS)
}

/// Merges references: weights means by their share of the samples, variances by the square of that share.
fn references(options: &Merge, target: Target) -> anyhow::Result<()> {
    let mut parts = Vec::new();
    for path in &options.inputs {
        parts.push(Part::read(path.display().to_string(), Channels::read(path)?)?);
    }
    check(&parts)?;

    let samples: f64 = parts.iter().map(|part| part.samples).sum();
    let pixels = parts[0].mean.len();
    let (mut mean, mut variance) = (vec![[0.0; 3]; pixels], vec![[0.0; 3]; pixels]);
    for part in &parts {
        let share = part.samples / samples;
        for pixel in 0..pixels {
            for channel in 0..3 {
                mean[pixel][channel] += share * f64::from(part.mean[pixel][channel]);
                variance[pixel][channel] += share * share * f64::from(part.variance[pixel][channel]);
            }
        }
    }
    let colors = |values: Vec<[f64; 3]>| values.into_iter().map(|value| Vec3::from(value.map(|v| v as f32)));
    let (width, height) = parts[0].size;
    let image = RenderedImage { width, height, path: colors(mean).collect(), ..RenderedImage::default() };
    let mut attributes = parts[0].attributes.clone();
    for name in OWN {
        let values: Vec<&str> =
            parts.iter().filter_map(|part| part.attributes.get(name)).map(String::as_str).collect();
        attributes.insert(name.into(), values.join(", "));
    }
    attributes.insert("frames".into(), samples.to_string());
    // Remove attributes of layers that the merged file lacks.
    attributes.retain(|name, _| !["aov", "materials"].contains(&name.as_str()));
    let bytes = exr::encode(&image, Some((colors(variance).collect(), samples as u32)), &attributes)?;
    target.finish(&bytes)?;
    message!("{}: {} samples a pixel from {} files", options.output.display(), samples, parts.len());
    Ok(())
}

/// A reference to merge.
struct Part {
    file: String,
    size: (usize, usize),
    mean: Vec<Vec3>,
    variance: Vec<Vec3>,
    samples: f64,
    attributes: BTreeMap<String, String>,
}

impl Part {
    fn read(file: String, image: Channels) -> Result<Part, Usage> {
        let colors = |layer: &str| -> Option<Vec<Vec3>> {
            let [r, g, b] = image.layer(layer)?;
            Some(r.iter().zip(g).zip(b).map(|((&r, &g), &b)| Vec3::new(r, g, b)).collect())
        };
        // Only path tracing gives independent samples: the radii of `progressive` shrink over a run.
        let is_reference = image.attributes.get("method").is_some_and(|method| method == PATH.name);
        let samples = image.channels.get("samples.count").and_then(|samples| samples.first());
        let (true, Some(mean), Some(variance), Some(&samples)) =
            (is_reference, colors(""), colors("variance"), samples)
        else {
            return Err(Usage(format!(
                "{file} has no mean, variance and number of samples of path tracing; give files of `caustics reference`"
            )));
        };
        if !(samples.is_finite() && samples >= 1.0) {
            return Err(Usage(format!("{file}: its number of samples is {samples}")));
        }
        if !mean.iter().chain(&variance).all(|color| color.is_finite()) {
            return Err(Usage(format!("{file}: its mean or its variance is not finite; render it again")));
        }
        let size = (image.width, image.height);
        Ok(Part { file, size, mean, variance, samples: f64::from(samples), attributes: image.attributes })
    }
}

/// Refuses references of different views, and samples that would be counted twice.
fn check(parts: &[Part]) -> Result<(), Usage> {
    let first = &parts[0];
    for (index, part) in parts.iter().enumerate().skip(1) {
        if part.size != first.size {
            let ((w, h), (width, height)) = (first.size, part.size);
            return Err(Usage(format!("{} is {w}x{h}, {} is {width}x{height}", first.file, part.file)));
        }
        let names = first.attributes.keys().chain(part.attributes.keys());
        let differs = |name: &&String| {
            !OWN.contains(&name.as_str()) && first.attributes.get(*name) != part.attributes.get(*name)
        };
        if let Some(name) = names.into_iter().find(differs) {
            return Err(Usage(format!(
                "{} and {} differ in {name:?}: they are of two views",
                first.file, part.file
            )));
        }
        // A merged file lists the seeds of its parts.
        let seeds = |part: &Part| -> Vec<String> {
            let seeds = part.attributes.get("seed").map(String::as_str).unwrap_or_default();
            seeds.split(", ").map(str::to_string).collect()
        };
        for other in &parts[..index] {
            if let Some(seed) = seeds(part).iter().find(|seed| seeds(other).contains(seed)) {
                return Err(Usage(format!(
                    "{} and {} share seed {seed}: they hold the same samples; give each run its own --seed",
                    other.file, part.file
                )));
            }
        }
    }
    Ok(())
}
