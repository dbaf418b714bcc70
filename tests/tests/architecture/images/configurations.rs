//! Run configurations of the compared images: every value of every parameter once, beside a method's defaults, and
//! beside a configuration with everything on.
//! Parameters and values come from the program's lists.

use std::collections::BTreeSet;

use caustics::render_config::RenderConfig;
use caustics_bench::parameter::{
    AUTO, COLLECTION_POINTS, GATHER, MAX_BOUNCES, METHOD, PARAMETERS, PATHS_PER_PIXEL, Parameter, RADIUS_PX,
    RUNNER, Values,
};
use caustics_bench::run_config::RunConfig;
use caustics_kernels::gather::variant::{self, Variant};
use caustics_kernels::interface::choice::{PixelFilter, TextureFilter};
use caustics_kernels::interface::named::Named;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::{self, Method};

/// Size of most images (px).
const SIZE: [u32; 2] = [48, 27];
/// Width over height of all images.
pub const ASPECT: f64 = SIZE[0] as f64 / SIZE[1] as f64;

/// Settings of an image, and its name.
#[derive(Clone, Debug)]
pub struct Configuration {
    pub name: String,
    pub run: RunConfig,
}

impl Configuration {
    fn new(name: String, run: RunConfig) -> Configuration {
        let [width, height] = SIZE;
        let common = RenderConfig { width, height, seed: 7, ..RenderConfig::default() };
        let config = run.config.with_image_of(&common);
        Configuration { name, run: RunConfig { config, ..run } }
    }

    /// Returns the configuration with another value of a parameter, under a name that tells it.
    fn with(&self, what: &str, config: RenderConfig) -> Configuration {
        Configuration { name: format!("{} {what}", self.name), run: RunConfig { config, ..self.run.clone() } }
    }
}

/// Values of a parameter to compare images in.
fn values(parameter: &'static Parameter) -> Vec<String> {
    let texts = |values: &[&str]| values.iter().map(|value| value.to_string()).collect();
    match parameter.values {
        // All images are those of one runner.
        Values::Names(_) if *parameter == RUNNER => Vec::new(),
        Values::Names(names) => {
            // The CPU has no ray queries.
            let is_software = |name: &str| <&Variant>::find(name).map_or(true, |gather| !gather.hardware);
            let names = names().into_iter().map(|(name, _)| name);
            names.filter(|name| *parameter != GATHER || is_software(name)).map(str::to_string).collect()
        }
        Values::Numbers(_) if *parameter == PATHS_PER_PIXEL => texts(&["p2", "p0.1", AUTO]),
        Values::Numbers(_) if *parameter == RADIUS_PX => texts(&["1", "2.5", AUTO]),
        Values::Numbers(_) if *parameter == COLLECTION_POINTS => texts(&["1", "16"]),
        Values::Numbers(_) if *parameter == MAX_BOUNCES => texts(&["5", "1", "2", "9"]),
        Values::Numbers(_) => {
            panic!("{parameter:?} is new: choose numbers of it to compare images in")
        }
    }
}

fn set(run: &mut RunConfig, parameter: &'static Parameter, value: &str) {
    parameter.set(run, value).unwrap_or_else(|error| panic!("{parameter:?} {value}: {error}"));
}

/// Defaults of a method.
fn plain(method: &'static Method) -> Configuration {
    let mut run = RunConfig::new(method);
    set(&mut run, &PATHS_PER_PIXEL, "p2");
    Configuration::new(method.name.into(), run.effective())
}

/// The last value of every parameter: lists end with the value that does most.
fn full(method: &'static Method) -> Configuration {
    let mut run = RunConfig::new(method);
    for parameter in PARAMETERS.into_iter().filter(|parameter| ![&METHOD, &MAX_BOUNCES].contains(parameter)) {
        if let Some(value) = values(parameter).last() {
            set(&mut run, parameter, value);
        }
    }
    let run = run.effective().with(|config| {
        config.pixel_filter = PixelFilter::Box;
        config.auxiliary = true;
    });
    Configuration::new(format!("{} full", method.name), run)
}

/// Variations of a configuration by every other value of every parameter, one at a time.
fn one_at_a_time(base: &Configuration) -> Vec<Configuration> {
    let mut found = Vec::new();
    let mut keys = BTreeSet::from([base.run.key()]);
    for parameter in PARAMETERS.into_iter().filter(|parameter| **parameter != METHOD) {
        for value in values(parameter) {
            let mut run = base.run.clone();
            set(&mut run, parameter, &value);
            let run = run.effective();
            // Skip values without an effect in the method.
            if keys.insert(run.key()) {
                found.push(Configuration { name: format!("{} {}={value}", base.name, parameter.key), run });
            }
        }
    }
    found
}

/// The configuration with other values of the settings that are no parameters of experiments, one at a time.
fn other_settings(base: &Configuration) -> Vec<Configuration> {
    let own = &base.run.config;
    // A new field is either set by a parameter, which takes its values from the program's lists, or gets other values below.
    let RenderConfig {
        method: _,
        gather: _,
        features: _,
        light_paths: _,
        max_bounces: _,
        radius: _,
        collection_points: _,
        history: _,
        denoiser: _,
        emission: _,
        caustics: _,
        light_sampler: _,
        thin_walls: _,
        sampler: _,
        path_history: _,
        indirect_share: _,
        indirect_end: _,
        fireflies: _,
        width,
        height,
        tiles: _,
        specular_roughness: _,
        seed,
        pixel_filter,
        texture_filter: _,
        exposure: _,
        background: _,
        batches: _,
        auxiliary,
    } = *own;
    let other_filter =
        PixelFilter::ALL.iter().copied().find(|filter| *filter != pixel_filter).expect("two filters");
    let mut found = vec![
        base.with("size=odd", RenderConfig { width: width + 1, height: height + 4, ..own.clone() }),
        base.with("tiles=4", RenderConfig { tiles: Some(4), ..own.clone() }),
        base.with("specular_roughness=0", RenderConfig { specular_roughness: 0.0, ..own.clone() }),
        base.with("specular_roughness=0.6", RenderConfig { specular_roughness: 0.6, ..own.clone() }),
        base.with("seed=other", RenderConfig { seed: seed + 1, ..own.clone() }),
        base.with("pixel_filter=other", RenderConfig { pixel_filter: other_filter, ..own.clone() }),
        base.with("exposure=1.5", RenderConfig { exposure: 1.5, ..own.clone() }),
        base.with("background=sky", RenderConfig { background: Some([0.1, 0.2, 0.4]), ..own.clone() }),
        base.with("batches=2", RenderConfig { batches: 2, ..own.clone() }),
        base.with("auxiliary=other", RenderConfig { auxiliary: !auxiliary, ..own.clone() }),
    ];
    found.extend(TextureFilter::ALL.iter().map(|filter| {
        let config = RenderConfig { texture_filter: Some(*filter), ..own.clone() };
        base.with(&format!("texture_filter={}", filter.name()), config)
    }));
    found
}

/// Every method with its defaults, and with everything on.
pub fn for_methods() -> Vec<Configuration> {
    method::ALL.iter().flat_map(|&method| [plain(method), full(method)]).collect()
}

/// Every configuration.
pub fn all() -> Vec<Configuration> {
    let mut found = for_methods();
    for method in method::ALL.iter().copied() {
        let base = plain(method);
        found.extend(one_at_a_time(&base));
        found.extend(other_settings(&base));
    }
    let base = full(&BASIC);
    found.extend(one_at_a_time(&base));
    found.extend(other_settings(&base));
    found
}

#[test]
fn every_parameter_value_has_an_image_in_every_method_that_it_affects() {
    let all = all();
    for &method in method::ALL {
        let of_method: Vec<_> = all.iter().filter(|found| found.run.config.method == method).collect();
        assert!(!of_method.is_empty());
        for parameter in PARAMETERS.into_iter().filter(|parameter| **parameter != METHOD) {
            for value in values(parameter) {
                let mut run = RunConfig::new(method);
                set(&mut run, parameter, &value);
                let wanted = parameter.get(&run.effective());
                let is_there = of_method.iter().any(|found| parameter.get(&found.run) == wanted);
                assert!(is_there, "{} {parameter:?} {wanted}", method.name);
            }
        }
    }
    for gather in variant::ALL.iter().filter(|gather| !gather.hardware) {
        assert!(all.iter().any(|found| found.run.config.gather == Some(gather)), "{}", gather.name);
    }
    // Only the runner is left out.
    for parameter in PARAMETERS.into_iter().filter(|parameter| values(parameter).is_empty()) {
        assert_eq!(*parameter, RUNNER);
    }
    let mut names: Vec<_> = all.iter().map(|found| &found.name).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), all.len(), "two images have one name");
}
