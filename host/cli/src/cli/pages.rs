//! Options of `completions` and `man`.

use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

/// Options of `completions`.
#[derive(Args, Debug)]
#[command(before_help = "Examples:
  caustics completions bash > ~/.local/share/bash-completion/completions/caustics
  caustics completions zsh > ~/.zfunc/_caustics
  caustics completions fish > ~/.config/fish/completions/caustics.fish")]
pub struct Completions {
    /// Shell
    pub shell: Shell,
}

/// Options of `man`.
#[derive(Args, Debug)]
#[command(before_help = "Example:
  caustics man ~/.local/share/man/man1")]
pub struct Man {
    /// Folder to write: caustics.1, caustics-render.1 and so on
    pub folder: PathBuf,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}
