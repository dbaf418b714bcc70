//! `caustics completions` and `caustics man`: the options for shells and for man.

use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;
use caustics::output::target::Target;
use clap::{Command, CommandFactory};
use clap_mangen::Man;

use super::console::print;
use crate::cli::{self, Cli};

/// Prints a completion script for a shell.
pub fn completions(options: &cli::Completions) -> anyhow::Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(options.shell, &mut Cli::command(), "caustics", &mut script);
    print(String::from_utf8(script)?.trim_end())?;
    Ok(ExitCode::SUCCESS)
}

/// Writes a man page for each command.
pub fn man(options: &cli::Man) -> anyhow::Result<ExitCode> {
    let folder = &options.folder;
    std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    let mut pages = Vec::new();
    claim(command, folder, options.force, &mut pages)?;
    for (target, page) in pages {
        target.finish(&page)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Claims the page of a command and those of its subcommands, each with its file.
fn claim(
    command: Command,
    folder: &Path,
    force: bool,
    pages: &mut Vec<(Target, Vec<u8>)>,
) -> anyhow::Result<()> {
    for below in command.get_subcommands().filter(|below| !below.is_hide_set()) {
        claim(below.clone(), folder, force, pages)?;
    }
    let man = Man::new(command);
    let mut page = Vec::new();
    man.render(&mut page)?;
    pages.push((Target::claim(&folder.join(man.get_filename()), force)?, page));
    Ok(())
}
