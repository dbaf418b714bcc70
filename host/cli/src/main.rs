//! The command line of caustics.

#![cfg_attr(not(test), deny(clippy::print_stderr, clippy::print_stdout))]
#![forbid(unsafe_code)]

use std::process::ExitCode;

use caustics::checkpoint::CheckpointError;
use caustics::output::target::TargetError;
use caustics::program::Program;
use caustics::scene::SceneError;
use caustics::vulkan::VulkanError;

/// Writes a message for the user to stderr: cut to a few lines and harmless to a terminal. Ignores a closed stderr.
macro_rules! message {
    ($($message:tt)*) => { $crate::command::console::print_message(format_args!($($message)*)) };
}

mod cli;
mod command;
#[cfg(test)]
mod commands_page;

fn main() -> ExitCode {
    caustics::program::declare(Program {
        version: env!("CARGO_PKG_VERSION").into(),
        commit: env!("CAUSTICS_COMMIT").into(),
        sources: env!("CAUSTICS_SOURCES_HASH").into(),
    });
    outlive_file_limit();
    end_by_code();
    let command = cli::Cli::read().command;
    if let Err(few) = caustics::threads::prepare() {
        message!("warning: {few}; this takes longer");
    }
    let result = cli::check_variables().map_err(Into::into).and_then(|()| run(command));
    match result {
        Ok(code) => code,
        Err(error) => {
            message!("error: {}", command::console::error_chain(&error));
            ExitCode::from(exit_code(&error))
        }
    }
}

fn run(command: cli::Command) -> anyhow::Result<ExitCode> {
    match command {
        cli::Command::Render(options) => command::render::run(*options),
        cli::Command::View(options) => command::view::run(&options),
        cli::Command::Animate(options) => command::animate::run(&options),
        cli::Command::Reference(options) => command::render::run_reference(*options),
        cli::Command::Merge(options) => command::merge::run(&options),
        cli::Command::Compare(options) => command::compare::run(&options),
        cli::Command::Bench(options) => command::bench::run(&options),
        cli::Command::Sweep(options) => command::sweep::run(&options),
        cli::Command::Inspect(options) => command::inspect::run(&options),
        cli::Command::Report(options) => command::report_page::run(&options),
        cli::Command::Device(options) => command::device::run(&options),
        cli::Command::Scene(command) => command::scene::run(command),
        cli::Command::Completions(options) => command::pages::completions(&options),
        cli::Command::Man(options) => command::pages::man(&options),
    }
}

/// Makes writes beyond the limit of file sizes (`ulimit -f`) fail as on a full drive. Otherwise the signal SIGXFSZ would
/// end the program and leave partial files.
fn outlive_file_limit() {
    #[cfg(unix)]
    {
        // If registering fails, the signal keeps its default action.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Default::default());
    }
}

/// Makes a process that aborts for lack of memory, where no budget foresaw it, end with 1 instead of a signal. Its last
/// line gives the reason. `device` is excluded: there the signal reports a crash of the driver's compiler.
fn end_by_code() {
    #[cfg(unix)]
    if std::env::args_os().nth(1).is_none_or(|command| command != "device") {
        use signal_hook::{consts::SIGABRT, flag::register_conditional_shutdown};
        // If registering fails, the signal keeps its default action.
        let _ = register_conditional_shutdown(SIGABRT, 1, std::sync::Arc::new(true.into()));
    }
}

/// Returns exit code 2 for errors of the command line, 4 for a missing device, else 1.
fn exit_code(error: &anyhow::Error) -> u8 {
    let usage = error.is::<cli::Usage>()
        || error.downcast_ref().is_some_and(TargetError::is_usage)
        || error.downcast_ref().is_some_and(SceneError::is_usage)
        || error.is::<CheckpointError>();
    if usage {
        2
    } else if error.chain().filter_map(|cause| cause.downcast_ref()).any(VulkanError::is_no_device) {
        4
    } else {
        1
    }
}
