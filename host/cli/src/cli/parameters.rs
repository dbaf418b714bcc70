//! Options of the parameters of an experiment, generated from their entries.

use std::marker::PhantomData;

use caustics::oidn::OIDN;
use caustics_bench::parameter::{
    self, AUTO, DENOISER, FEATURES, MAX_BOUNCES, NotApplicable, PARAMETERS, PATHS_PER_PIXEL, Parameter,
    RUNNER, Values, spelled,
};
use caustics_bench::run_config::RunConfig;
use caustics_bench::sweep::matrix_table::MatrixTable;
use caustics_kernels::method::basic::BASIC;
use clap::builder::{PossibleValue, PossibleValuesParser, ValueParser};
use clap::{Arg, ArgAction, ArgMatches, Command};

use super::Usage;

/// A command with options of parameters.
pub trait CommandParameters {
    /// Whether its options take comma-separated lists.
    const LISTS: bool;
    /// Whether the command has an option for a key.
    fn has(key: &str) -> bool;
}

/// A command that renders one configuration.
#[derive(Debug)]
pub enum OneConfiguration {}
/// A command that averages frames of one configuration, for which histories do not help.
#[derive(Debug)]
pub enum Averaged {}
/// A command that path traces.
#[derive(Debug)]
pub enum PathTraced {}
/// A command that renders many configurations.
#[derive(Debug)]
pub enum ManyConfigurations {}

impl CommandParameters for OneConfiguration {
    const LISTS: bool = false;
    fn has(key: &str) -> bool {
        key != "equal_time_ms"
    }
}

impl CommandParameters for Averaged {
    const LISTS: bool = false;
    fn has(key: &str) -> bool {
        !["equal_time_ms", "history", "path_history"].contains(&key)
    }
}

impl CommandParameters for PathTraced {
    const LISTS: bool = false;
    fn has(key: &str) -> bool {
        ["runner", "features", "max_bounces"].contains(&key)
    }
}

impl CommandParameters for ManyConfigurations {
    const LISTS: bool = true;
    fn has(_: &str) -> bool {
        true
    }
}

/// Values given on the command line, by key.
#[derive(Clone, Debug)]
pub struct ParameterOptions<C> {
    given: Vec<(&'static str, &'static Parameter, Vec<String>)>,
    command: PhantomData<C>,
}

/// Keys of the command's options, with descriptions.
fn keys<C: CommandParameters>() -> impl Iterator<Item = (&'static str, &'static str, &'static Parameter)> {
    parameter::keys().filter(|(key, ..)| C::has(key))
}

impl<C: CommandParameters> clap::Args for ParameterOptions<C> {
    fn augment_args(command: Command) -> Command {
        keys::<C>().fold(command, |command, (key, description, parameter)| {
            command.arg(option::<C>(key, description, parameter))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

fn option<C: CommandParameters>(key: &'static str, description: &str, parameter: &'static Parameter) -> Arg {
    let mut help = description.to_string();
    if C::LISTS {
        help += "; several with commas between";
    }
    let default = parameter.default;
    if !default.is_empty() && (*parameter != PATHS_PER_PIXEL || key == "light_paths") {
        help += &format!(" [default: {default}]");
    }
    let parser: ValueParser = match parameter.values {
        Values::Names(names) => names_parser(names()),
        Values::Numbers(_) => ValueParser::new(move |text: &str| match spelled(key, text) {
            Some((parameter, value)) => parameter.check(&value).map(|()| text.to_string()),
            None => Err(format!("there is no key {key}")),
        }),
    };
    let arg =
        Arg::new(key).long(key.replace('_', "-")).help(help).value_parser(parser).action(ArgAction::Append);
    let arg = if C::LISTS { arg.value_delimiter(',') } else { arg.action(ArgAction::Set) };
    // Keys of one parameter exclude each other.
    let others =
        keys::<C>().filter(|(other, _, other_parameter)| *other_parameter == parameter && *other != key);
    arg.conflicts_with_all(others.map(|(other, ..)| other).collect::<Vec<_>>())
}

/// Parses names, and describes them in the help.
fn names_parser(names: Vec<(&'static str, &'static str)>) -> ValueParser {
    let value = |(name, description)| PossibleValue::new(name).help(description);
    PossibleValuesParser::new(names.into_iter().map(value)).into()
}

/// Adds the denoiser of finished images to the values of an option for [`DENOISER`].
pub fn with_image_denoiser(option: Arg) -> Arg {
    let Values::Names(names) = DENOISER.values else { return option };
    option.value_parser(names_parser([names(), vec![(OIDN.name, OIDN.description)]].concat()))
}

impl<C: CommandParameters> clap::FromArgMatches for ParameterOptions<C> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let value = |key| Some(matches.get_many::<String>(key)?.cloned().collect());
        let given =
            keys::<C>().filter_map(|(key, _, parameter)| Some((key, parameter, value(key)?))).collect();
        Ok(ParameterOptions { given, command: PhantomData })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<C: CommandParameters> ParameterOptions<C> {
    /// Whether a parameter was given a value.
    pub fn has(&self, parameter: &Parameter) -> bool {
        self.given.iter().any(|(_, given, _)| *given == parameter)
    }

    /// Whether an option sets how to render; runner, features and bounces do not count.
    pub fn has_render_options(&self) -> bool {
        self.given.iter().any(|(_, parameter, _)| ![&RUNNER, &FEATURES, &MAX_BOUNCES].contains(parameter))
    }

    /// Returns the checked run configuration; its runner is still a name.
    pub fn run_config(&self) -> Result<RunConfig, Usage> {
        self.checked(self.unchecked(&[])?)
    }

    /// Returns the run configuration, with other defaults for some parameters. Values that do not apply are not refused yet.
    pub fn unchecked(&self, default: &[(&Parameter, &str)]) -> Result<RunConfig, Usage> {
        let mut run_config = RunConfig::new(&BASIC);
        let values = PARAMETERS
            .into_iter()
            .map(|parameter| (parameter, parameter.default))
            .chain(default.iter().copied());
        for (parameter, value) in values {
            parameter.set(&mut run_config, value).map_err(Usage)?;
        }
        for (key, _, values) in &self.given {
            let Some((parameter, value)) = values.last().and_then(|value| spelled(key, value)) else {
                continue;
            };
            // Only an option `with_image_denoiser` takes this name.
            if (parameter, &*value) == (&DENOISER, OIDN.name) {
                run_config.config.denoiser = &OIDN;
            } else {
                parameter.set(&mut run_config, &value).map_err(Usage)?;
            }
        }
        Ok(run_config)
    }

    /// Returns a run configuration without what does not apply to it. Refuses given values that do not apply, unless they are neutral,
    /// or numbers that the method has no use for.
    pub fn checked(&self, run_config: RunConfig) -> Result<RunConfig, Usage> {
        for parameter in PARAMETERS.into_iter().filter(|parameter| self.has(parameter)) {
            let Some(why) = (parameter.not_applicable)(&run_config) else { continue };
            let (option, value) = (parameter.option(), parameter.get(&run_config));
            let is_harmless = match (parameter.values, why) {
                (Values::Names(_), _) => value == parameter.neutral,
                (Values::Numbers(_), NotApplicable::Options(_)) => false,
                (Values::Numbers(_), NotApplicable::Method(_)) => value != AUTO || parameter.default == AUTO,
            };
            let method = run_config.config.method.name;
            match why {
                _ if is_harmless => {}
                NotApplicable::Options(why) => return Err(Usage(format!("--{option} {value}: {why}"))),
                NotApplicable::Method(why) => {
                    return Err(Usage(format!(
                        "--{option} {value}: --method {method} {why}; use --method basic"
                    )));
                }
            }
        }
        Ok(run_config.effective())
    }

    /// Returns all configurations, as the `[[matrix]]` of a sweep.
    pub fn table(&self) -> Result<MatrixTable, Usage> {
        let mut table = MatrixTable::default();
        for (key, _, values) in &self.given {
            for value in values {
                table.add(key, value).map_err(Usage)?;
            }
        }
        Ok(table)
    }
}
