//! Parameters: all settings that can vary between the run configurations of an experiment, one entry each.
//!
//! An entry defines the option of `render`, `animate` and `bench` with its help, and the key of a sweep's `[[matrix]]`. It
//! also defines the key of a result, a column of CSV and the words of a report. The product, the identity and the names of
//! run configurations follow from it. To add a parameter, write a field of [`RenderConfig`](caustics::RenderConfig) and an
//! entry of [`PARAMETERS`]. The code compiles only once two decisions are made: whether another value gives another
//! expected image, and whether run configurations differ in it.

use std::fmt::{self, Display, Formatter};

use caustics_kernels::denoiser::Denoiser;
use caustics_kernels::emission::Emission;
use caustics_kernels::gather::variant::Variant;
use caustics_kernels::history::History;
use caustics_kernels::interface::choice::{
    Caustics, Fireflies, IndirectEnd, IndirectShare, LightSampler, PathHistory, Sampler, ThinWalls,
};
use caustics_kernels::method::Method;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::pass::more_points::MAX_POINTS;

use super::run_config::{RunConfig, runner_name};
use caustics::named::Named;
pub use caustics::render_config::AUTO;
use caustics::render_config::{FeatureChoice, Radius};

/// A setting that can vary between run configurations.
pub struct Parameter {
    /// Key of a sweep's `[[matrix]]`, of results and of CSV; the option of a command has dashes for underscores.
    pub key: &'static str,
    /// Heading of its column in a report.
    pub head: &'static str,
    /// Description, as the help of an option prints it.
    pub description: &'static str,
    /// Values that it accepts.
    pub values: Values,
    /// Default value; empty where the machine or the method decides.
    pub default: &'static str,
    /// Neutral value, for run configurations to which the parameter does not apply.
    pub neutral: &'static str,
    /// Visual encoding of its values in a report.
    pub shown: VisualEncoding,
    /// Returns why the parameter does not apply to a run configuration; none where it does.
    pub not_applicable: fn(&RunConfig) -> Option<NotApplicable>,
    get: fn(&RunConfig) -> String,
    set: fn(&mut RunConfig, &str) -> Result<(), String>,
}

/// Why a parameter does not apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotApplicable {
    /// The method does this.
    Method(&'static str),
    /// Another option does this; the text says which value to give.
    Options(&'static str),
}

impl NotApplicable {
    /// Returns this reason if the method does so.
    fn method(does_so: bool, does: &'static str) -> Option<NotApplicable> {
        does_so.then_some(NotApplicable::Method(does))
    }

    /// Returns this reason if other options do so.
    fn options(do_so: bool, does: &'static str) -> Option<NotApplicable> {
        do_so.then_some(NotApplicable::Options(does))
    }
}

impl Display for NotApplicable {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            NotApplicable::Method(does) => write!(f, "the method {does}"),
            NotApplicable::Options(does) => f.write_str(does),
        }
    }
}

/// The values of a parameter.
#[derive(Clone, Copy, Debug)]
pub enum Values {
    /// Names, each with a description.
    Names(fn() -> Vec<(&'static str, &'static str)>),
    /// Numbers; the text says which are allowed.
    Numbers(&'static str),
}

/// Visual encoding of values in a report.
#[derive(Clone, Copy, Debug)]
pub enum VisualEncoding {
    /// By the colour of a mark.
    Color,
    /// By its shape.
    Shape,
    /// In words, where configurations differ; the letters precede the value in a configuration's name.
    Words(&'static str, fn(&str) -> String),
}

impl std::fmt::Debug for Parameter {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.key)
    }
}

impl PartialEq for Parameter {
    fn eq(&self, other: &Parameter) -> bool {
        self.key == other.key
    }
}

impl Parameter {
    /// Returns the value of a run configuration.
    pub fn get(&self, run: &RunConfig) -> String {
        (self.get)(run)
    }

    /// Sets the value of a run configuration.
    ///
    /// # Errors
    /// If the value is not allowed; the message says what it must be.
    pub fn set(&self, run: &mut RunConfig, value: &str) -> Result<(), String> {
        (self.set)(run, value).map_err(|wrong| match self.values {
            Values::Names(names) => {
                let names: Vec<_> = names().iter().map(|(name, _)| *name).collect();
                format!("no {} is called {value}; known are {}", self.head, names.join(", "))
            }
            Values::Numbers(_) => wrong,
        })
    }

    /// Checks a value.
    ///
    /// # Errors
    /// If the value is not allowed; the message says what it must be.
    pub fn check(&self, value: &str) -> Result<(), String> {
        self.set(&mut RunConfig::new(&BASIC), value)
    }

    /// Its option, without the leading dashes.
    pub fn option(&self) -> String {
        self.key.replace('_', "-")
    }

    /// Returns the parameter of a key.
    pub fn find(key: &str) -> Option<&'static Parameter> {
        PARAMETERS.iter().copied().find(|parameter| parameter.key == key)
    }
}

/// Names of values, each with a description.
fn names<T: Named>() -> Vec<(&'static str, &'static str)> {
    T::all().into_iter().map(|value| (value.name(), value.description())).collect()
}

/// Common part of parameters whose values have names: a field of [`RenderConfig`](caustics::RenderConfig) and its type.
macro_rules! named {
    ($field:ident: $type:ty) => {
        Parameter {
            key: stringify!($field),
            head: stringify!($field),
            description: "",
            values: Values::Names(names::<$type>),
            default: "",
            neutral: "",
            shown: VisualEncoding::Color,
            not_applicable: |_| None,
            get: |run| run.config.$field.name().into(),
            set: |run, name| {
                run.config.$field = Named::find(name)?;
                Ok(())
            },
        }
    };
}

/// All parameters, in the order of tables.
pub static PARAMETERS: [&Parameter; 19] = [
    &METHOD,
    &GATHER,
    &CAUSTICS,
    &THIN_WALLS,
    &EMISSION,
    &LIGHT_SAMPLER,
    &SAMPLER,
    &HISTORY,
    &PATH_HISTORY,
    &INDIRECT_SHARE,
    &INDIRECT_END,
    &FIREFLIES,
    &DENOISER,
    &RUNNER,
    &FEATURES,
    &PATHS_PER_PIXEL,
    &RADIUS_PX,
    &COLLECTION_POINTS,
    &MAX_BOUNCES,
];

/// Rendering method.
pub static METHOD: Parameter =
    Parameter { description: "Render method", default: "basic", neutral: "basic", ..named!(method: &Method) };

/// Gather: how photons and collection points are brought together.
pub static GATHER: Parameter = Parameter {
    key: "gather",
    head: "gather",
    description: "Gather: how collection points find photons [default: points-rt with ray queries, points-bvh on other GPUs, photons-grid on a CPU]",
    values: Values::Names(names::<&Variant>),
    default: "",
    neutral: "",
    shown: VisualEncoding::Shape,
    not_applicable: |run| {
        NotApplicable::method(
            !run.config.method.chooses_gather,
            "brings photons and points together in its own way",
        )
    },
    get: |run| run.config.gather.map_or("", |gather| gather.name).into(),
    set: |run, name| {
        run.config.gather = if name.is_empty() { None } else { Some(Named::find(name)?) };
        Ok(())
    },
};

/// Definition of a caustic: the light that light paths carry.
pub static CAUSTICS: Parameter = Parameter {
    description: "Light that counts as a caustic, which light paths carry",
    default: "first",
    neutral: "first",
    not_applicable: |run| NotApplicable::method(!run.config.method.gathers, "shoots no light paths"),
    ..named!(caustics: Caustics)
};

/// Treatment of thin walls.
pub static THIN_WALLS: Parameter = Parameter {
    description: "Thin smooth walls of glass, such as windows",
    default: "passed",
    neutral: "passed",
    not_applicable: |run| {
        let passes = run.config.method.passes_thin_walls;
        NotApplicable::method(!passes, "counts passing a wall as a specular event").or(
            NotApplicable::options(
                !run.config.can_pass_thin_walls(),
                "--caustics any counts passing a wall as a specular event; give --caustics first",
            ),
        )
    },
    ..named!(thin_walls: ThinWalls)
};

/// Emission: how light paths start.
pub static EMISSION: Parameter = Parameter {
    description: "Emission: how light paths start",
    default: "guided",
    neutral: "power",
    not_applicable: |run| {
        let chooses = run.config.method.chooses_emission;
        NotApplicable::method(!chooses, "starts light paths in its own way, or has none")
    },
    ..named!(emission: &Emission)
};

/// Light sampler: how camera paths find lights.
pub static LIGHT_SAMPLER: Parameter = Parameter {
    description: "Choice of lights at the vertices of camera paths, up to the collection point",
    default: "resampled",
    neutral: "resampled",
    shown: VisualEncoding::Words("nee-", |value| format!("light sampler {value}")),
    head: "light sampler",
    ..named!(light_sampler: LightSampler)
};

/// Sampler: source of the random numbers of camera paths.
pub static SAMPLER: Parameter = Parameter {
    description: "Random numbers of camera paths",
    default: "sobol",
    neutral: "sobol",
    shown: VisualEncoding::Words("", |value| format!("{value} samples")),
    ..named!(sampler: Sampler)
};

/// History: light of the previous frame that collection points reuse.
pub static HISTORY: Parameter = Parameter {
    description: "Light of the previous frame that collection points reuse",
    default: "none",
    neutral: "none",
    not_applicable: |run| {
        NotApplicable::method(!run.config.method.supports_history, "takes no light from the frame before")
    },
    ..named!(history: &History)
};

/// Path history: path-traced light of the previous frame that is reused.
pub static PATH_HISTORY: Parameter = Parameter {
    head: "path history",
    description: "Path-traced light of the previous frame that collection points reuse",
    default: "none",
    neutral: "none",
    shown: VisualEncoding::Color,
    not_applicable: |run| {
        let method = run.config.method;
        NotApplicable::method(method.converges, "converges: its frames are averaged").or(
            NotApplicable::method(!method.gathers, "makes no collection points, which a history looks for"),
        )
    },
    ..named!(path_history: PathHistory)
};

/// Sharing of indirect light between collection points.
pub static INDIRECT_SHARE: Parameter = Parameter {
    key: "indirect_share",
    head: "indirect share",
    description: "Indirect light that collection points share [default: points with --method progressive, else none]",
    values: Values::Names(names::<IndirectShare>),
    default: "",
    neutral: "none",
    shown: VisualEncoding::Words("share-", |value| format!("shared {value}")),
    not_applicable: |run| {
        let discs = run.config.method.chooses_gather;
        NotApplicable::method(!discs, "makes no discs around which points share").or(NotApplicable::options(
            !run.config.can_share_indirect(),
            "a denoiser, bounded fireflies or a path history changes the light before; give --denoiser none \
             --fireflies kept --path-history none",
        ))
    },
    get: |run| run.config.indirect_share.map_or("", |share| share.name()).into(),
    set: |run, name| {
        run.config.indirect_share = if name.is_empty() { None } else { Some(Named::find(name)?) };
        Ok(())
    },
};

/// Ends of camera paths behind the collection point.
pub static INDIRECT_END: Parameter = Parameter {
    key: "indirect_end",
    head: "indirect end",
    description: "Ends of camera paths at the second non-specular vertex [default: cache with --method progressive, else path]",
    values: Values::Names(names::<IndirectEnd>),
    default: "",
    neutral: "path",
    shown: VisualEncoding::Words("end-", |value| format!("ends in {value}")),
    not_applicable: |run| {
        let discs = run.config.method.chooses_gather;
        NotApplicable::method(!discs, "does not end camera paths in a cache").or(NotApplicable::options(
            !run.config.can_use_cache(),
            "a path history traces camera paths again; give --path-history none",
        ))
    },
    get: |run| run.config.indirect_end.map_or("", |end| end.name()).into(),
    set: |run, name| {
        run.config.indirect_end = if name.is_empty() { None } else { Some(Named::find(name)?) };
        Ok(())
    },
};

/// Treatment of fireflies, rare bright samples of camera paths.
pub static FIREFLIES: Parameter = Parameter {
    description: "Treatment of fireflies, rare bright samples of camera paths",
    default: "kept",
    neutral: "kept",
    not_applicable: |run| {
        NotApplicable::method(run.config.method.converges, "converges, and must lose no light")
    },
    ..named!(fireflies: Fireflies)
};

/// Denoiser of the path-traced part.
pub static DENOISER: Parameter = Parameter {
    description: "Denoiser of the path-traced light; caustics stay as they are",
    default: "none",
    neutral: "none",
    not_applicable: |run| {
        let gathers = run.config.method.gathers;
        NotApplicable::method(!gathers, "makes no collection points, which a denoiser looks at")
    },
    ..named!(denoiser: &Denoiser)
};

/// Runner: where kernels run.
pub static RUNNER: Parameter = Parameter {
    key: "runner",
    head: "runner",
    description: "Runner: CPU or Vulkan device",
    values: Values::Names(|| RUNNERS.to_vec()),
    default: "auto",
    neutral: "auto",
    shown: VisualEncoding::Words("", str::to_string),
    not_applicable: |_| None,
    get: |run| runner_name(&run.runner).into(),
    set: |run, name| {
        let known = RUNNERS.iter().find(|(known, _)| *known == name);
        (run.asked_runner, _) = *known.ok_or_else(String::new)?;
        Ok(())
    },
};

/// Features: kernel code that is compiled in.
pub static FEATURES: Parameter = Parameter {
    description: "Features: kernel code that is compiled in",
    default: "scene",
    neutral: "scene",
    shown: VisualEncoding::Words("", |value| format!("{value} features")),
    ..named!(features: FeatureChoice)
};

/// Light paths a pixel and frame; `PATHS_SPELLINGS` has other keys for them.
pub static PATHS_PER_PIXEL: Parameter = Parameter {
    key: "paths_per_pixel",
    head: "paths/px",
    description: "Light paths a pixel and frame",
    values: Values::Numbers("more than 0, at most 4096"),
    default: "auto",
    neutral: "",
    shown: VisualEncoding::Words("", |value| {
        let unit = if value == "1" { "path/px" } else { "paths/px" };
        format!("{value} {unit}")
    }),
    not_applicable: |run| NotApplicable::method(!run.config.method.gathers, "shoots no light paths"),
    get: |run| run.config.light_paths.to_string(),
    set: |run, text| {
        run.config.light_paths = text.parse()?;
        Ok(())
    },
};

/// Radius of collection points.
pub static RADIUS_PX: Parameter = Parameter {
    key: "radius_px",
    head: "radius [px]",
    description: "Radius of collection points; 1 gives a disc the area of its pixel's footprint, auto that and up to three times the \
            radius where the last frame's photons were few",
    values: Values::Numbers("auto or a positive number"),
    default: "1",
    neutral: "1",
    shown: VisualEncoding::Words("r", |value| format!("radius {value} px")),
    not_applicable: |run| match run.config.radius {
        _ if !run.config.method.gathers => Some(NotApplicable::Method("makes no collection points")),
        Radius::Auto if !run.config.method.chooses_gather => {
            Some(NotApplicable::Method("has no discs that could widen"))
        }
        _ => None,
    },
    get: |run| run.config.radius.to_string(),
    set: |run, text| {
        run.config.radius = text.parse()?;
        Ok(())
    },
};

/// Maximum number of collection points of a pixel.
pub static COLLECTION_POINTS: Parameter = Parameter {
    key: "collection_points",
    head: "points/px",
    description: "Collection points of a pixel, at most: more than one where the choice of the prefix is most of the noise, as in \
            rough mirrors",
    values: Values::Numbers("1 to 16"),
    default: "1",
    neutral: "1",
    shown: VisualEncoding::Words("k", |value| format!("{value} points/px")),
    not_applicable: |run| match run.config.collection_points {
        1 => None,
        _ if !run.config.method.chooses_gather => {
            Some(NotApplicable::Method("makes no discs for further points"))
        }
        _ => NotApplicable::options(
            !run.config.can_add_points(),
            "a history reuses the light of single points; give --history none",
        ),
    },
    get: |run| run.config.collection_points.to_string(),
    set: |run, text| {
        let points = text.parse().ok().filter(|points| (1..=MAX_POINTS).contains(points));
        run.config.collection_points = points.ok_or("it must be 1 to 16")?;
        Ok(())
    },
};

/// Maximum length of paths.
pub static MAX_BOUNCES: Parameter = Parameter {
    key: "max_bounces",
    head: "bounces",
    description: "Scattering vertices between eye and light, at most",
    values: Values::Numbers("1 to 64"),
    default: "5",
    neutral: "5",
    shown: VisualEncoding::Words("b", |value| format!("{value} bounces")),
    not_applicable: |_| None,
    get: |run| run.config.max_bounces.to_string(),
    set: |run, text| {
        let bounces = text.parse().ok().filter(|bounces| (1..=64).contains(bounces));
        run.config.max_bounces = bounces.ok_or("it must be 1 to 64")?;
        Ok(())
    },
};

/// Runners by name.
const RUNNERS: [(&str, &str); 5] = [
    ("auto", "A real GPU if there is one, else the CPU"),
    ("cpu", "The kernels as CPU code"),
    ("gpu", "Any Vulkan device, software ones too; by ray queries if it has them"),
    ("gpu-hardware", "Any Vulkan device, by its ray queries"),
    ("gpu-software", "Any Vulkan device, by the project's own BVH"),
];

/// Other keys for the light paths of a frame: key, description, and the letters that mark it around the number in a value
/// of [`PATHS_PER_PIXEL`].
const PATHS_SPELLINGS: [(&str, &str, [&str; 2]); 2] = [
    (
        "light_paths",
        "Light paths a frame, or auto: as many as serve the image best, by what earlier frames cost and left to noise",
        ["n", ""],
    ),
    (
        "equal_time_ms",
        "As many light paths as a frame of this time has (ms); they are searched for",
        ["t", "ms"],
    ),
];

/// Keys that set parameters, each with a description: one for each parameter, several for light paths.
pub fn keys() -> impl Iterator<Item = (&'static str, &'static str, &'static Parameter)> {
    let of_parameter = |parameter: &'static Parameter| {
        let others = PATHS_SPELLINGS.into_iter().filter(move |_| *parameter == PATHS_PER_PIXEL);
        std::iter::once((parameter.key, parameter.description, parameter))
            .chain(others.map(move |(key, description, _)| (key, description, parameter)))
    };
    PARAMETERS.into_iter().flat_map(of_parameter)
}

/// Returns the parameter of a key, and its value for a text under that key.
pub fn spelled(key: &str, text: &str) -> Option<(&'static Parameter, String)> {
    let (_, _, parameter) = keys().find(|(known, ..)| *known == key)?;
    if (key, text) == ("light_paths", AUTO) {
        return Some((parameter, text.into()));
    }
    let others = PATHS_SPELLINGS.into_iter().find(|(known, ..)| *known == key);
    let [before, after] = match others {
        Some((_, _, letters)) => letters,
        None if *parameter == PATHS_PER_PIXEL => ["p", ""],
        None => ["", ""],
    };
    Some((parameter, format!("{before}{text}{after}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_accepts_only_its_own_values() {
        for parameter in PARAMETERS {
            parameter.check(parameter.default).unwrap();
            parameter.check(parameter.neutral).unwrap();
            if let Values::Names(names) = parameter.values {
                for (name, description) in names() {
                    parameter.check(name).unwrap();
                    assert!(description.len() > 3, "{name} of {parameter:?} says what it is");
                }
            }
            let wrong = parameter.check("sieve").unwrap_err();
            assert!(wrong.contains("it must be") || wrong.contains("known are"), "{wrong}");
            assert_eq!(Parameter::find(parameter.key), Some(parameter));
        }
    }

    #[test]
    fn set_values_are_returned() {
        for (parameter, value) in [
            (&METHOD, "path"),
            (&GATHER, "brute"),
            (&HISTORY, "paper"),
            (&DENOISER, "atrous"),
            (&FEATURES, "all"),
            (&PATHS_PER_PIXEL, "p0.25"),
            (&PATHS_PER_PIXEL, "n7"),
            (&PATHS_PER_PIXEL, "t33.3ms"),
            (&PATHS_PER_PIXEL, "auto"),
            (&RADIUS_PX, "0.5"),
            (&RADIUS_PX, "auto"),
            (&MAX_BOUNCES, "9"),
        ] {
            let mut run = RunConfig::new(&BASIC);
            parameter.set(&mut run, value).unwrap();
            assert_eq!(parameter.get(&run), value);
        }
    }

    #[test]
    fn light_paths_are_spelled_in_three_ways() {
        assert_eq!(spelled("light_paths", "auto"), Some((&PATHS_PER_PIXEL, "auto".into())));
        assert_eq!(spelled("paths_per_pixel", "auto"), Some((&PATHS_PER_PIXEL, "pauto".into())));
        assert_eq!(spelled("light_paths", "9"), Some((&PATHS_PER_PIXEL, "n9".into())));
        assert_eq!(spelled("paths_per_pixel", "9"), Some((&PATHS_PER_PIXEL, "p9".into())));
        assert_eq!(spelled("equal_time_ms", "9"), Some((&PATHS_PER_PIXEL, "t9ms".into())));
        assert_eq!(spelled("radius_px", "9"), Some((&RADIUS_PX, "9".into())));
        assert_eq!(spelled("radius", "9"), None);
    }
}
