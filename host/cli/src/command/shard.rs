//! Part of a run that a shard renders, and the reasons why parts may not add up to the run.

use std::ops::Range;
use std::path::PathBuf;

use caustics::checkpoint::Identity;
use caustics::render_config::RenderConfig;
use caustics::shard::Shard;
use caustics_kernels::history::path::PATH_HISTORY;
use caustics_kernels::pass::balance::BALANCE;
use caustics_kernels::pass::more_points::MORE_POINTS;
use caustics_kernels::pass::radiance_cache::RADIANCE_CACHE;
use caustics_kernels::pass::share::SHARE;
use caustics_kernels::pass::widen::WIDEN;

use super::stop::Stop;
use crate::cli::{Common, Usage};

/// Identity key of a part: the shard.
pub const SHARD: &str = "shard";
/// Identity key of a part: the number of frames of all parts.
pub const ALL_FRAMES: &str = "all_frames";
/// Extension of the file of its sums.
pub const SUMS: &str = "sums";

/// Part of a mean's frames that a shard renders.
pub struct ShardFrames {
    /// The shard.
    shard: Shard,
    /// Number of frames of all parts.
    all: u32,
    /// Its frames.
    pub frames: Range<u32>,
    /// File of their sums, which is also its checkpoint.
    pub file: PathBuf,
}

impl ShardFrames {
    /// Returns the part that the options select, if it is not the whole run; `stop` has the number of all frames.
    pub fn from_options(
        options: &Common,
        config: &RenderConfig,
        stop: &Stop,
    ) -> Result<Option<ShardFrames>, Usage> {
        let shard = options.sharding.asked()?;
        if !shard.is_part() {
            return Ok(None);
        }
        let Stop { frames: Some(all), time: None, relative_error: None } = *stop else {
            return Err(Usage(
                "--shard: a part knows neither time nor error of the whole; give a number, --frames of render or --spp of \
                 reference, and no --seconds or --target-relmse"
                    .into(),
            ));
        };
        if options.png.is_some() {
            return Err(Usage("--png: a shard writes sums and no image; `caustics merge` does".into()));
        }
        if config.denoises_image() {
            let name = config.denoiser.name;
            return Err(Usage(format!(
                "--denoiser {name}: a shard writes sums and no image, and `caustics merge` does not denoise; render without --shard"
            )));
        }
        let frames = shard.frames(0..all).map_err(Usage)?;
        let file = options.output.with_extension(format!("{}.{SUMS}", shard.name()));
        Ok(Some(ShardFrames { shard, all, frames, file }))
    }

    /// Identity of the part, from the identity of the run.
    pub fn identity(&self, run: &Identity) -> Identity {
        let own = [(SHARD, self.shard.to_string()), (ALL_FRAMES, self.all.to_string())];
        run.clone().into_iter().chain(own.map(|(name, value)| (name.into(), value))).collect()
    }
}

/// Warns where frames from `first` on differ from those of an unsplit run.
pub fn warn_of_reuse(config: &RenderConfig, first: u32) {
    if let Some((last, others)) = reusing_options(config).split_last() {
        let (others, reuse) = match others {
            [] => (String::new(), "reuses"),
            others => (others.join(", ") + " and ", "reuse"),
        };
        message!(
            "warning: {others}{last} {reuse} earlier frames: the shard is a run of its own from frame {first} on, and its \
             frames are not those of a run without --shard"
        );
    }
}

/// Options by which frames reuse earlier ones.
fn reusing_options(config: &RenderConfig) -> Vec<String> {
    let (method, parts) = (config.method, config.parts());
    let points = config.collection_points.to_string();
    let all = [
        (!method.keeps.is_empty(), "--method", method.name),
        (!parts.history.keeps.is_empty(), "--history", parts.history.name),
        (parts.stages.has(&PATH_HISTORY), "--path-history", config.path_history.name()),
        (!parts.emission.stage.keeps.is_empty(), "--emission", parts.emission.name),
        (parts.stages.has(&BALANCE), "--light-paths", "auto"),
        (parts.stages.has(&WIDEN), "--radius-px", "auto"),
        (parts.stages.has(&MORE_POINTS), "--collection-points", &points),
        (parts.stages.has(&SHARE), "--indirect-share", "points"),
        (parts.stages.has(&RADIANCE_CACHE), "--indirect-end", "cache"),
    ];
    let reuses = all.into_iter().filter(|(reuses, ..)| *reuses);
    reuses.map(|(_, option, value)| format!("{option} {value}")).collect()
}

#[cfg(test)]
mod tests {
    use caustics::render_config::{Paths, Radius};
    use caustics_kernels::interface::choice::{IndirectEnd, IndirectShare, PathHistory};
    use caustics_kernels::{emission, history, method};

    use super::*;
    use caustics_bench::run_config::RunConfig;

    #[test]
    fn options_whose_state_outlives_a_frame_are_named() {
        for method in method::ALL {
            for history in history::ALL {
                for emission in emission::ALL {
                    for path_history in PathHistory::ALL {
                        for (light_paths, radius) in [
                            (Paths::Count(1), Radius::Px(1.0)),
                            (Paths::Auto, Radius::Px(1.0)),
                            (Paths::Count(1), Radius::Auto),
                        ] {
                            let run_config = RunConfig::new(method).with(|config| {
                                config.history = history;
                                config.emission = emission;
                                config.path_history = *path_history;
                                config.light_paths = light_paths;
                                config.radius = radius;
                            });
                            let run_config = run_config.effective();
                            for (share, end) in [(false, false), (true, false), (false, true)] {
                                let indirect_share =
                                    if share { IndirectShare::Points } else { IndirectShare::None };
                                let indirect_end = if end { IndirectEnd::Cache } else { IndirectEnd::Path };
                                let config = RenderConfig {
                                    indirect_share: Some(indirect_share),
                                    indirect_end: Some(indirect_end),
                                    ..run_config.config.clone()
                                };
                                let reuses = method.kept(config.parts()).next().is_some();
                                assert_eq!(reuses, !reusing_options(&config).is_empty(), "{config:?}");
                            }
                        }
                    }
                }
            }
        }
    }
}
