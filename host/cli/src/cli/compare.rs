//! Options of `compare`.

use std::path::PathBuf;

use caustics::exposure::Exposure;
use caustics::metric::METRICS;
use caustics::metric::comparison::Metric;
use caustics::metric::flip::PIXELS_PER_DEGREE;
use caustics::metric::pixels::Region;
use caustics::metric::report::metric;
use clap::Args;

/// Options of `compare`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
#[command(before_help = "Examples:
  caustics compare room.exr reference.exr --map flip.png
  caustics compare a.exr b.exr c.exr reference.exr --layer caustics --json --fail-above relmse=0.01")]
pub struct Compare {
    /// EXR or PNG files: the image, or several runs of it with other seeds, and last the reference
    #[arg(required = true, num_args = 2.., value_name = "IMAGE REFERENCE")]
    pub files: Vec<PathBuf>,
    /// Layer to compare: beauty, path, caustics, or the name of any channel
    #[arg(long, default_value = "beauty")]
    pub layer: String,
    /// Compare this rectangle only: left, top, width, height (px)
    #[arg(long, value_name = "X,Y,W,H", value_parser = region)]
    pub region: Option<Region>,
    /// Write FLIP's error map as PNG: of the high dynamic range for EXR files, else of display colours
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Exit with 3 if a metric exceeds a value or has none; may be given several times
    #[arg(long, value_name = "METRIC=VALUE", value_parser = limit)]
    pub fail_above: Vec<Limit>,
    /// Exposure of EXR files for flip_ldr (stops, or auto, which fits the reference)
    #[arg(long, default_value = "auto")]
    pub exposure: Exposure,
    /// Pixels per degree of visual angle for FLIP
    #[arg(long, default_value_t = PIXELS_PER_DEGREE)]
    pub pixels_per_degree: f64,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Overwrite an existing map
    #[arg(long)]
    pub force: bool,
}

/// A metric and its maximum.
#[derive(Clone, Debug)]
pub struct Limit {
    /// One of [`METRICS`].
    pub metric: &'static Metric,
    /// Maximum, in the metric's unit.
    pub value: f64,
}

fn limit(text: &str) -> Result<Limit, String> {
    let (name, value) = text.split_once('=').ok_or("it must be METRIC=VALUE")?;
    let Some(metric) = metric(name) else {
        let known: Vec<_> = METRICS.iter().map(|metric| metric.name).collect();
        return Err(format!("no metric is called {name:?}; known are {}", known.join(", ")));
    };
    match value.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(Limit { metric, value }),
        _ => Err(format!("{value:?} is no finite number")),
    }
}

fn region(text: &str) -> Result<Region, String> {
    let numbers: Result<Vec<usize>, _> = text.split(',').map(str::trim).map(str::parse).collect();
    match numbers.as_deref() {
        Ok(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Region { x, y, width, height }),
        Ok([_, _, _, _]) => Err("it has no pixels".into()),
        _ => Err("it must be four whole numbers: left, top, width, height".into()),
    }
}
