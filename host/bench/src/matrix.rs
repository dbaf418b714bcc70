//! A matrix: lists of parameter values, all combinations of which are run configurations.

use std::collections::{BTreeMap, BTreeSet};

use super::parameter::{PARAMETERS, Parameter, RUNNER};
use super::run_config::{RunConfig, runner_name};
use super::run_parameters::name_all;
use caustics::session::RunnerChoice;

/// Values of the parameters; a parameter without any has its default.
#[derive(Clone, Debug, Default)]
pub struct Matrix {
    lists: BTreeMap<&'static str, Vec<String>>,
}

/// Run configurations of a matrix.
#[derive(Clone, Debug, Default)]
pub struct RunConfigs {
    /// Run configurations without duplicates, named.
    pub runs: Vec<RunConfig>,
    /// Combinations that are not possible, one line each.
    pub skipped: Vec<String>,
}

impl Matrix {
    /// Adds a value of a parameter.
    ///
    /// # Errors
    /// If the parameter does not accept the value; the message says what it must be.
    pub fn add(&mut self, parameter: &Parameter, value: &str) -> Result<(), String> {
        parameter.check(value)?;
        self.lists.entry(parameter.key).or_default().push(value.into());
        Ok(())
    }

    /// Returns the values of a parameter.
    pub fn values(&self, parameter: &Parameter) -> Vec<&str> {
        let given = self.lists.get(parameter.key);
        given.map_or(vec![parameter.default], |list| list.iter().map(String::as_str).collect())
    }

    /// Whether a parameter was given values.
    pub fn has(&self, parameter: &Parameter) -> bool {
        self.lists.contains_key(parameter.key)
    }

    /// Number of combinations.
    pub fn count(&self) -> u64 {
        self.lists.values().fold(1, |count: u64, list| count.saturating_mul(list.len() as u64))
    }

    /// Returns the run configurations; `runner` finds the runner of a name. Runners vary slowest, since the configurations
    /// of a runner take turns. Methods vary fastest.
    ///
    /// # Errors
    /// If a runner is missing; the message says why.
    pub fn runs(
        &self,
        runner: &mut dyn FnMut(&str) -> anyhow::Result<RunnerChoice>,
    ) -> anyhow::Result<RunConfigs> {
        let mut runs = vec![RunConfig::new(&caustics_kernels::method::basic::BASIC)];
        let others = PARAMETERS.into_iter().rev().filter(|parameter| **parameter != RUNNER);
        for parameter in std::iter::once(&RUNNER).chain(others) {
            let mut more = Vec::new();
            let mut seen = BTreeSet::new();
            let mut values = self.values(parameter);
            values.retain(|value| seen.insert(*value));
            for run in &runs {
                for value in &values {
                    let mut run = run.clone();
                    parameter.set(&mut run, value).map_err(anyhow::Error::msg)?;
                    more.push(run);
                }
            }
            runs = more;
        }
        let mut all = RunConfigs::default();
        for run in runs {
            let runner = runner(run.asked_runner)?;
            let gather = run.config.gather.unwrap_or_else(|| runner.default_gather());
            let run = RunConfig { runner, ..run }.with(|config| config.gather = Some(gather)).effective();
            if let Some(gather) = run.config.gather.filter(|gather| gather.hardware)
                && !run.runner.has_ray_queries()
            {
                let (gather, runner) = (gather.name, runner_name(&run.runner));
                let line = format!("gather {gather} needs ray queries, and {runner} has none: skipped");
                if !all.skipped.contains(&line) {
                    all.skipped.push(line);
                }
                continue;
            }
            all.runs.push(run);
        }
        keep_one_of_each(&mut all.runs);
        name_all(&mut all.runs);
        Ok(all)
    }
}

/// Keeps the first of the run configurations that render equal frames.
pub fn keep_one_of_each(runs: &mut Vec<RunConfig>) {
    let mut seen = BTreeSet::new();
    runs.retain(|run| seen.insert(run.key()));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::{DENOISER, FEATURES, GATHER, HISTORY, METHOD, PATHS_PER_PIXEL, RADIUS_PX};
    use caustics_kernels::gather::variant;
    use caustics_kernels::{denoiser, history};

    fn matrix(gathers: &[&str]) -> Matrix {
        let mut matrix = Matrix::default();
        let names = |all: Vec<&'static str>| all;
        for (parameter, values) in [
            (&METHOD, vec!["basic", "path"]),
            (&GATHER, gathers.to_vec()),
            (&HISTORY, names(history::ALL.iter().map(|history| history.name).collect())),
            (&DENOISER, names(denoiser::ALL.iter().map(|denoiser| denoiser.name).collect())),
            (&PATHS_PER_PIXEL, vec!["0.5", "1"]),
            (&RADIUS_PX, vec!["1", "2"]),
            (&FEATURES, vec!["scene", "all"]),
            (&RUNNER, vec!["cpu"]),
        ] {
            for value in values {
                matrix.add(parameter, value).unwrap();
            }
        }
        matrix
    }

    fn runs(matrix: &Matrix) -> RunConfigs {
        matrix.runs(&mut |_| Ok(RunnerChoice::Cpu { threads: 0 })).unwrap()
    }

    #[test]
    fn every_combination_occurs_once() {
        let gathers: Vec<_> = variant::ALL.iter().map(|gather| gather.name).collect();
        let RunConfigs { runs, skipped } = runs(&matrix(&gathers));
        let software = variant::ALL.iter().filter(|gather| !gather.hardware).count();
        let basic = software * history::ALL.len() * denoiser::ALL.len() * 2 * 2 * 2;
        // The path tracer depends on the features only.
        assert_eq!(runs.len(), basic + 2);
        assert_eq!(skipped.len(), variant::ALL.len() - software);
        let mut names: Vec<&str> = runs.iter().map(|run| run.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), runs.len(), "names are told apart");
    }

    #[test]
    fn methods_without_a_gather_remain_if_no_runner_has_the_gather() {
        let hardware: Vec<_> =
            variant::ALL.iter().filter(|gather| gather.hardware).map(|gather| gather.name).collect();
        let RunConfigs { runs: left, skipped } = runs(&matrix(&hardware));
        assert!(left.iter().all(|run| run.config.method.name == "path"), "{left:?}");
        assert!(!skipped.is_empty());
        let mut alone = Matrix::default();
        alone.add(&METHOD, "path").unwrap();
        alone.add(&GATHER, "points-rt").unwrap();
        assert!(runs(&alone).skipped.is_empty(), "nothing was asked for that is not there");
    }

    #[test]
    fn a_wrong_value_is_refused() {
        assert!(Matrix::default().add(&METHOD, "basik").unwrap_err().contains("yang2021"));
        assert!(Matrix::default().add(&RADIUS_PX, "0").is_err());
    }
}
