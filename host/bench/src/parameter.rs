//! Parameters: all that can vary between the cells of an experiment, a row each.
//!
//! From a row come the option of `render`, `animate` and `bench` with its help, the key of a sweep's `[[matrix]]` and of a
//! result, a column of CSV, its part in the product of cells and in their identity and names, and the words of a report. To
//! add a parameter: a field of [`Settings`](caustics::Settings) and a row of [`PARAMETERS`]. Where a decision is missing, whether
//! another value gives another expected image, or whether cells differ in it, the code does not compile.

use caustics_kernels::gather::variant;
use caustics_kernels::interface::choice::{Caustics, Fireflies, LightSampler, PathHistory, Sampler};
use caustics_kernels::{denoiser, emission, history, method};

use super::cell::{Cell, FeatureChoice, runner_name};
pub use caustics::settings::AUTO;
use caustics::settings::Radius;

/// Something that can vary between cells.
pub struct Parameter {
    /// Key of a sweep's `[[matrix]]`, of results and of CSV; the option of a command has dashes for underscores.
    pub key: &'static str,
    /// Head of its column in a report.
    pub head: &'static str,
    /// Description, as the help of an option prints it.
    pub description: &'static str,
    /// The values that it may have.
    pub values: Values,
    /// Default value; empty where the machine decides.
    pub default: &'static str,
    /// Neutral value: that of cells to which it does not apply.
    pub neutral: &'static str,
    /// How a report tells its values apart.
    pub shown: VisualEncoding,
    /// Why it does not apply to a cell; none where it does.
    pub not_applicable: fn(&Cell) -> Option<&'static str>,
    get: fn(&Cell) -> String,
    set: fn(&mut Cell, &str) -> Result<(), String>,
}

/// The values of a parameter.
#[derive(Clone, Copy, Debug)]
pub enum Values {
    /// These names, each with what it is.
    Names(fn() -> Vec<(&'static str, &'static str)>),
    /// Numbers; in words, which.
    Numbers(&'static str),
}

/// How a report tells values apart.
#[derive(Clone, Copy, Debug)]
pub enum VisualEncoding {
    /// By the colour of a mark.
    Color,
    /// By its shape.
    Shape,
    /// In words, where cells differ; the letters lead the value in the name of a cell.
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
    /// The value of a cell.
    pub fn get(&self, cell: &Cell) -> String {
        (self.get)(cell)
    }

    /// Gives a cell a value.
    ///
    /// # Errors
    /// What the value must be, where it is something else.
    pub fn set(&self, cell: &mut Cell, value: &str) -> Result<(), String> {
        (self.set)(cell, value).map_err(|wrong| match self.values {
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
    /// What it must be.
    pub fn check(&self, value: &str) -> Result<(), String> {
        self.set(&mut Cell::new(&method::basic::BASIC), value)
    }

    /// Its option without the leading dashes.
    pub fn option(&self) -> String {
        self.key.replace('_', "-")
    }

    /// The row of a key.
    pub fn find(key: &str) -> Option<&'static Parameter> {
        PARAMETERS.iter().copied().find(|parameter| parameter.key == key)
    }
}

/// What is common to the rows of choices: the values of a field of [`Cell`] that is an enum with `ALL`, `name`, `description` and `find`.
macro_rules! chosen {
    ($field:ident $(in $owner:ident)?: $choice:ident) => {
        Parameter {
            key: stringify!($field),
            head: stringify!($field),
            description: "",
            values: Values::Names(|| {
                $choice::ALL.iter().map(|choice| (choice.name(), choice.description())).collect()
            }),
            default: "",
            neutral: "",
            shown: VisualEncoding::Color,
            not_applicable: |_| None,
            get: |cell| cell$(.$owner)?.$field.name().into(),
            set: |cell, name| found($choice::find(name), &mut cell$(.$owner)?.$field),
        }
    };
}

/// All parameters, in the order of tables.
pub static PARAMETERS: [&Parameter; 15] = [
    &METHOD,
    &GATHER,
    &CAUSTICS,
    &EMISSION,
    &LIGHT_SAMPLER,
    &SAMPLER,
    &HISTORY,
    &PATH_HISTORY,
    &FIREFLIES,
    &DENOISER,
    &RUNNER,
    &FEATURES,
    &PATHS_PER_PIXEL,
    &RADIUS_PX,
    &MAX_BOUNCES,
];

/// How a frame is rendered.
pub static METHOD: Parameter = Parameter {
    key: "method",
    head: "method",
    description: "How to render",
    values: Values::Names(|| method::ALL.iter().map(|method| (method.name, method.description)).collect()),
    default: "basic",
    neutral: "basic",
    shown: VisualEncoding::Color,
    not_applicable: |_| None,
    get: |cell| cell.method.name.into(),
    set: |cell, name| found(method::find(name), &mut cell.method),
};

/// How photons and collection points meet.
pub static GATHER: Parameter = Parameter {
    key: "gather",
    head: "gather",
    description: "How photons and collection points meet [default: points-rt with ray queries, points-bvh on other GPUs, photons-grid on a CPU]",
    values: Values::Names(|| variant::ALL.iter().map(|gather| (gather.name, gather.description)).collect()),
    default: "",
    neutral: "",
    shown: VisualEncoding::Shape,
    not_applicable: |cell| {
        (!cell.method.chooses_gather).then_some("brings photons and points together in its own way")
    },
    get: |cell| cell.gather_name().into(),
    set: |cell, name| match (name, variant::find(name)) {
        ("", _) => {
            cell.gather = None;
            Ok(())
        }
        (_, found @ Some(_)) => {
            cell.gather = found;
            Ok(())
        }
        (_, None) => Err(String::new()),
    },
};

/// Which light is the light paths'.
pub static CAUSTICS: Parameter = Parameter {
    description: "Which light is a caustic, found by light paths",
    default: "first",
    neutral: "first",
    not_applicable: |cell| (!cell.method.gathers).then_some("shoots no light paths"),
    ..chosen!(caustics in settings: Caustics)
};

/// How light paths start.
pub static EMISSION: Parameter = Parameter {
    key: "emission",
    head: "emission",
    description: "How light paths start",
    values: Values::Names(|| {
        emission::ALL.iter().map(|emission| (emission.name, emission.description)).collect()
    }),
    default: "guided",
    neutral: "power",
    shown: VisualEncoding::Color,
    not_applicable: |cell| {
        (!cell.method.chooses_emission).then_some("starts light paths in its own way, or has none")
    },
    get: |cell| cell.settings.emission.name.into(),
    set: |cell, name| found(emission::find(name), &mut cell.settings.emission),
};

/// How camera paths find lights.
pub static LIGHT_SAMPLER: Parameter = Parameter {
    description: "How camera paths find lights, up to the collection point",
    default: "resampled",
    neutral: "resampled",
    shown: VisualEncoding::Words("nee-", |value| format!("light sampler {value}")),
    head: "light sampler",
    ..chosen!(light_sampler in settings: LightSampler)
};

/// Where the numbers of camera paths come from.
pub static SAMPLER: Parameter = Parameter {
    description: "Where the random numbers of camera paths come from",
    default: "sobol",
    neutral: "sobol",
    shown: VisualEncoding::Words("", |value| format!("{value} samples")),
    ..chosen!(sampler in settings: Sampler)
};

/// Light of the previous frame that is reused.
pub static HISTORY: Parameter = Parameter {
    key: "history",
    head: "history",
    description: "Light of the previous frame that collection points reuse",
    values: Values::Names(|| {
        history::ALL.iter().map(|history| (history.name, history.description)).collect()
    }),
    default: "none",
    neutral: "none",
    shown: VisualEncoding::Color,
    not_applicable: |cell| (!cell.method.supports_history).then_some("takes no light from the frame before"),
    get: |cell| cell.settings.history.name.into(),
    set: |cell, name| found(history::find(name), &mut cell.settings.history),
};

/// Path-traced light of the previous frame that is reused.
pub static PATH_HISTORY: Parameter = Parameter {
    head: "path history",
    description: "Path-traced light of the previous frame that collection points reuse",
    default: "none",
    neutral: "none",
    shown: VisualEncoding::Color,
    not_applicable: |cell| {
        let converges = cell.method.converges.then_some("converges: its frames are averaged");
        converges
            .or((!cell.method.gathers).then_some("makes no collection points, which a history looks for"))
    },
    ..chosen!(path_history in settings: PathHistory)
};

/// What is done about rare bright samples of camera paths.
pub static FIREFLIES: Parameter = Parameter {
    description: "What is done about rare bright samples of camera paths",
    default: "kept",
    neutral: "kept",
    not_applicable: |cell| cell.method.converges.then_some("converges, and must lose no light"),
    ..chosen!(fireflies in settings: Fireflies)
};

/// What smooths the path-traced part.
pub static DENOISER: Parameter = Parameter {
    key: "denoiser",
    head: "denoiser",
    description: "What smooths the path-traced part, caustics excepted",
    values: Values::Names(|| {
        denoiser::ALL.iter().map(|denoiser| (denoiser.name, denoiser.description)).collect()
    }),
    default: "none",
    neutral: "none",
    shown: VisualEncoding::Color,
    not_applicable: |cell| {
        (!cell.method.gathers).then_some("makes no collection points, which a denoiser looks at")
    },
    get: |cell| cell.settings.denoiser.name.into(),
    set: |cell, name| found(denoiser::find(name), &mut cell.settings.denoiser),
};

/// Where a cell runs.
pub static RUNNER: Parameter = Parameter {
    key: "runner",
    head: "runner",
    description: "Where to run",
    values: Values::Names(|| RUNNERS.to_vec()),
    default: "auto",
    neutral: "auto",
    shown: VisualEncoding::Words("", str::to_string),
    not_applicable: |_| None,
    get: |cell| runner_name(&cell.runner).into(),
    set: |cell, name| {
        found(RUNNERS.iter().map(|(known, _)| *known).find(|known| *known == name), &mut cell.asked_runner)
    },
};

/// Kernel code that is compiled in.
pub static FEATURES: Parameter = Parameter {
    description: "Kernel code that is compiled in",
    default: "scene",
    neutral: "scene",
    shown: VisualEncoding::Words("", |value| format!("{value} features")),
    ..chosen!(features: FeatureChoice)
};

/// Light paths of a frame; other keys for them: `PATHS_SPELLINGS`.
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
    not_applicable: |cell| (!cell.method.gathers).then_some("shoots no light paths"),
    get: |cell| cell.settings.light_paths.to_string(),
    set: |cell, text| {
        cell.settings.light_paths = text.parse()?;
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
    not_applicable: |cell| match cell.settings.radius {
        _ if !cell.method.gathers => Some("makes no collection points"),
        Radius::Auto if !cell.method.chooses_gather => Some("has no discs that could widen"),
        _ => None,
    },
    get: |cell| cell.settings.radius.to_string(),
    set: |cell, text| {
        cell.settings.radius = text.parse()?;
        Ok(())
    },
};

/// Length of paths.
pub static MAX_BOUNCES: Parameter = Parameter {
    key: "max_bounces",
    head: "bounces",
    description: "Scattering vertices between eye and light, at most",
    values: Values::Numbers("1 to 64"),
    default: "5",
    neutral: "5",
    shown: VisualEncoding::Words("b", |value| format!("{value} bounces")),
    not_applicable: |_| None,
    get: |cell| cell.settings.max_bounces.to_string(),
    set: |cell, text| {
        let bounces = text.parse().ok().filter(|bounces| (1..=64).contains(bounces));
        cell.settings.max_bounces = bounces.ok_or("it must be 1 to 64")?;
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

/// Other keys for the light paths of a frame: key, what it is, and the letters around the number that say so in a value of
/// [`PATHS_PER_PIXEL`].
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

/// The keys by which parameters are given values, each with what it is: one for each parameter, of light paths several.
pub fn keys() -> impl Iterator<Item = (&'static str, &'static str, &'static Parameter)> {
    let of_parameter = |parameter: &'static Parameter| {
        let others = PATHS_SPELLINGS.into_iter().filter(move |_| *parameter == PATHS_PER_PIXEL);
        std::iter::once((parameter.key, parameter.description, parameter))
            .chain(others.map(move |(key, description, _)| (key, description, parameter)))
    };
    PARAMETERS.into_iter().flat_map(of_parameter)
}

/// The parameter of a key, and the value of a text under that key.
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

fn found<T>(found: Option<T>, target: &mut T) -> Result<(), String> {
    *target = found.ok_or_else(String::new)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_takes_its_own_values_and_no_others() {
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
    fn what_was_set_is_got() {
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
            let mut cell = Cell::new(&method::basic::BASIC);
            parameter.set(&mut cell, value).unwrap();
            assert_eq!(parameter.get(&cell), value);
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
