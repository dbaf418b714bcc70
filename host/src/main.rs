//! The command line of caustics.

#![forbid(unsafe_code)]

use std::process::ExitCode;

use caustics::checkpoint::CheckpointError;
use caustics::output::target::TargetError;
use caustics::scene::SceneError;
use caustics::vulkan::VulkanError;
use clap::Parser;

mod cli;
mod command;

fn main() -> ExitCode {
    let result = match cli::Cli::parse().command {
        cli::Command::Render(options) => command::render::run(*options),
        cli::Command::Animate(options) => command::animate::run(&options),
        cli::Command::Reference(options) => command::reference::run(*options),
        cli::Command::Merge(options) => command::merge::run(&options),
        cli::Command::Compare(options) => command::compare::run(&options),
        cli::Command::Bench(options) => command::bench::run(&options),
        cli::Command::Sweep(options) => command::sweep::run(&options),
        cli::Command::Report(options) => command::report_page::run(&options),
        cli::Command::Device(options) => command::device::run(&options),
        cli::Command::Scene(command) => command::scene::run(command),
    };
    match result {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(exit_code(&error))
        }
    }
}

/// 2 for what the command line got wrong, 4 for a device that is not there, else 1.
fn exit_code(error: &anyhow::Error) -> u8 {
    let usage = error.is::<cli::Usage>()
        || error.downcast_ref().is_some_and(TargetError::is_usage)
        || matches!(error.downcast_ref(), Some(SceneError::Unknown { .. } | SceneError::NotMade { .. }))
        || error.is::<CheckpointError>();
    if usage {
        2
    } else if error.downcast_ref().is_some_and(VulkanError::is_no_device) {
        4
    } else {
        1
    }
}
