//! Run configurations by their parameters: relevant values, identity, names, and values of a result.

use caustics_kernels::emission;
use caustics_kernels::interface::choice::Sampler;
use caustics_kernels::method::Method;

use super::parameter::{HISTORY, METHOD, PARAMETERS, PATHS_PER_PIXEL, VisualEncoding};
use super::result::ConfigValues;
use super::run_config::RunConfig;
use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::session::RunnerChoice;

impl RunConfig {
    /// Returns a method by itself: no history, no filter, one light path a pixel, on all cores of the CPU.
    pub fn new(method: &'static Method) -> RunConfig {
        let runner = RunnerChoice::Cpu { threads: 0 };
        let run = RunConfig {
            name: String::new(),
            config: RenderConfig {
                method,
                gather: Some(runner.default_gather()),
                emission: &emission::GUIDED,
                sampler: Sampler::Sobol,
                light_paths: Paths::PerPixel(1.0),
                ..RenderConfig::default()
            },
            runner,
            asked_runner: "cpu",
        };
        let run = run.effective();
        RunConfig { name: run.short_name(), ..run }
    }

    /// Sets every parameter that does not apply to its neutral value, and those that the method decides to its choice. Configurations
    /// that render the same become equal.
    pub fn effective(mut self) -> RunConfig {
        for parameter in PARAMETERS {
            if (parameter.not_applicable)(&self).is_some() {
                // A parameter's neutral value is always valid.
                let _ = parameter.set(&mut self, parameter.neutral);
            }
        }
        let RenderConfig { indirect_share, indirect_end, .. } = self.config.clone().with_defaults_of_method();
        (self.config.indirect_share, self.config.indirect_end) = (indirect_share, indirect_end);
        self
    }

    /// Text of everything except the name.
    pub fn key(&self) -> String {
        let values = PARAMETERS.iter().map(|parameter| format!("{} {}", parameter.key, parameter.get(self)));
        // A runner's name does not include its device.
        format!("{} on {:?}", values.collect::<Vec<_>>().join(" "), self.runner)
    }

    /// Method, history, and every other colour-coded parameter that is not at its default: `basic-paper`,
    /// `basic-paper-atrous`.
    fn short_name(&self) -> String {
        let colored =
            PARAMETERS.into_iter().filter(|parameter| matches!(parameter.shown, VisualEncoding::Color));
        let colored =
            colored.filter(|parameter| **parameter == HISTORY || (parameter.not_applicable)(self).is_none());
        let named = colored.filter(|parameter| {
            [&METHOD, &HISTORY].contains(parameter) || parameter.get(self) != parameter.default
        });
        named.map(|parameter| parameter.get(self)).collect::<Vec<_>>().join("-")
    }

    /// Values of a result; paths a pixel are those of a frame of this size.
    pub fn values(&self, scene: &Scene, camera: &str, image: &RenderConfig) -> ConfigValues {
        let RenderConfig { width, height, texture_filter, .. } = *image;
        let paths = match self.config.light_paths {
            Paths::PerPixel(paths) => paths.to_string(),
            Paths::Auto => self.config.light_paths.to_string(),
            _ => {
                let pixels = f64::from(width) * f64::from(height);
                (f64::from(self.config.light_paths.count(width, height)) / pixels).to_string()
            }
        };
        let mut values = ConfigValues::new(&scene.name, camera);
        for parameter in PARAMETERS {
            values.set(parameter, &parameter.get(self));
        }
        values.set(&PATHS_PER_PIXEL, &paths);
        values.texture_filter = texture_filter.unwrap_or(self.config.method.texture_filter).name().into();
        values
    }
}

/// Names run configurations by their colour-coded parameters, then by all others in which they differ.
pub fn name_all(runs: &mut [RunConfig]) {
    let mut names: Vec<String> = runs.iter().map(RunConfig::short_name).collect();
    for parameter in
        PARAMETERS.into_iter().filter(|parameter| !matches!(parameter.shown, VisualEncoding::Color))
    {
        let letters = if let VisualEncoding::Words(letters, _) = parameter.shown { letters } else { "" };
        let text = |run: &RunConfig| match (parameter.not_applicable)(run) {
            Some(_) => String::new(),
            None => format!("{letters}{}", parameter.get(run)),
        };
        let texts: Vec<String> = runs.iter().map(text).collect();
        let mut given: Vec<&String> = texts.iter().filter(|text| !text.is_empty()).collect();
        given.sort();
        given.dedup();
        if given.len() > 1 {
            for (name, text) in names.iter_mut().zip(&texts).filter(|(_, text)| !text.is_empty()) {
                *name += &format!("-{text}");
            }
        }
    }
    for (run, name) in runs.iter_mut().zip(names) {
        run.name = name;
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameter::{INDIRECT_END, INDIRECT_SHARE, Values};
    use super::*;
    use caustics::render_config::Radius;
    use caustics_kernels::gather::variant;
    use caustics_kernels::interface::choice::{Fireflies, IndirectShare};
    use caustics_kernels::method::basic::BASIC;
    use caustics_kernels::method::path::PATH;
    use caustics_kernels::method::progressive::PROGRESSIVE;
    use caustics_kernels::{denoiser, history, method};

    #[test]
    fn parameters_that_do_not_apply_make_no_other_configuration() {
        let fancy = |method| {
            RunConfig::new(method).with(|config| {
                config.gather = Some(&variant::BRUTE);
                config.history = history::ALL[1];
                config.denoiser = denoiser::ALL[1];
                config.light_paths = Paths::Count(7);
                config.radius = Radius::Px(3.0);
            })
        };
        assert_eq!(fancy(&PATH).effective().key(), RunConfig::new(&PATH).key());
        assert_eq!(fancy(&BASIC).effective().key(), fancy(&BASIC).key());
        assert_ne!(fancy(&BASIC).key(), RunConfig::new(&BASIC).key());
    }

    #[test]
    fn a_method_decides_how_indirect_light_is_found_unless_it_is_said() {
        for (parameter, on, off) in [(&INDIRECT_SHARE, "points", "none"), (&INDIRECT_END, "cache", "path")] {
            let with = |method, value| {
                let mut run = RunConfig::new(method);
                parameter.set(&mut run, value).unwrap();
                run
            };
            let effective = |run: RunConfig| parameter.get(&run.effective());
            assert_eq!(effective(with(&PROGRESSIVE, "")), on);
            assert_eq!(effective(with(&PROGRESSIVE, off)), off);
            assert_eq!(effective(with(&BASIC, "")), off);
            assert_eq!(effective(with(&BASIC, on)), on);
            assert_eq!(effective(with(&PATH, "")), off);
        }
        let denoised = RunConfig::new(&PROGRESSIVE).with(|config| config.denoiser = denoiser::ALL[1]);
        assert_eq!(INDIRECT_SHARE.get(&denoised.effective()), "none");
        // Sharing would add light that was bounded.
        for (fireflies, shared) in [(Fireflies::Kept, "points"), (Fireflies::Bounded, "none")] {
            let run = RunConfig::new(&BASIC).with(|config| {
                config.fireflies = fireflies;
                config.indirect_share = Some(IndirectShare::Points);
            });
            assert_eq!(INDIRECT_SHARE.get(&run.effective()), shared);
        }
    }

    /// A field of the viewer that vanished by its own value could not be set back.
    #[test]
    fn whether_a_parameter_applies_does_not_depend_on_its_own_value() {
        for &method in method::ALL {
            for &denoiser in denoiser::ALL {
                let run = RunConfig::new(method).with(|config| config.denoiser = denoiser);
                for parameter in PARAMETERS.into_iter().filter(|parameter| **parameter != METHOD) {
                    let Values::Names(names) = parameter.values else { continue };
                    let reason = |value: &str| {
                        let mut run = run.clone();
                        parameter.set(&mut run, value).map(|()| (parameter.not_applicable)(&run))
                    };
                    let expected = reason(parameter.neutral);
                    // A combination that cannot be set has no reason.
                    for (value, _) in names().into_iter().filter(|(value, _)| reason(value).is_ok()) {
                        let key = parameter.key;
                        assert_eq!(reason(value), expected, "{key} {value} with {}", method.name);
                    }
                }
            }
        }
    }

    /// Results on disk are found by this text.
    #[test]
    fn the_key_of_a_run_configuration_is_as_it_was() {
        let run = RunConfig::new(&BASIC).with(|config| config.light_paths = Paths::PerPixel(0.5));
        let text = "method basic gather photons-grid caustics first thin_walls passed emission guided light_sampler resampled sampler sobol \
                    history none path_history none indirect_share none indirect_end path fireflies kept denoiser none runner cpu features scene \
                    paths_per_pixel p0.5 radius_px 1 collection_points 1 max_bounces 5 on Cpu { threads: 0 }";
        assert_eq!(run.key(), text);
    }

    #[test]
    fn names_contain_the_differing_values() {
        let mut runs = [
            RunConfig::new(&BASIC),
            RunConfig::new(&BASIC).with(|config| {
                config.gather = Some(&variant::BRUTE);
                config.light_paths = Paths::PerPixel(0.5);
            }),
            RunConfig::new(&BASIC).with(|config| config.denoiser = &denoiser::ATROUS),
            RunConfig::new(&PATH),
        ];
        name_all(&mut runs);
        let names = runs.each_ref().map(|run| run.name.as_str());
        let expected = ["basic-none-photons-grid-p1", "basic-none-brute-p0.5"];
        assert_eq!(names[..2], expected);
        assert_eq!(names[2..], ["basic-none-atrous-photons-grid-p1", "path-none"]);
    }
}
