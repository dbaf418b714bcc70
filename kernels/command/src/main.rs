//! `cargo kernels`: starts `kernels/builder` with the nightly toolchain that rustc_codegen_spirv is built against. Nothing else
//! of the project needs that toolchain. rustup fetches it (1.6 GB, with rustc's own libraries) where it is missing.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, exit};

use anyhow::{Context, bail};

fn main() -> anyhow::Result<ExitCode> {
    // Read at run time: checkouts may share a target directory, so a path compiled in may be another checkout's.
    let own = std::env::var_os("CARGO_MANIFEST_DIR").context("run it by `cargo kernels`")?;
    let builder = Path::new(&own).join("../builder");
    let toolchain = channel(&builder)?;
    if !installed(&toolchain) {
        eprintln!(
            "the kernels' compiler needs the toolchain {toolchain} with rustc-dev: rustup fetches it, 1.6 GB"
        );
        let done = clean("rustup", &builder).args(["toolchain", "install"]).status();
        if !done.context("rustup is needed to fetch a toolchain")?.success() {
            bail!("{toolchain} could not be fetched; --runner cpu works without the compiled kernels");
        }
    }
    let mut cargo = clean("cargo", &builder);
    // Jump threading sends finished paths past the code behind them. A shader's structured control flow can only follow that by a
    // value kept for each path: more registers, and more code.
    cargo.env("RUSTGPU_RUSTFLAGS", "-Zmir-enable-passes=-JumpThreading");
    cargo.args(["run", "--locked", "--release", "--"]).args(arguments()?);
    exit(cargo.status().context("cargo cannot be started")?.code().unwrap_or(1));
}

/// Arguments of the command line. A folder of `--panics` or `--out` is made absolute, from the caller's working directory.
fn arguments() -> anyhow::Result<Vec<std::ffi::OsString>> {
    let mut arguments: Vec<std::ffi::OsString> = std::env::args_os().skip(1).collect();
    if let [.., option, folder] = &mut arguments[..]
        && (option == "--panics" || option == "--out")
    {
        *folder = std::path::absolute(PathBuf::from(&*folder))?.into();
    }
    Ok(arguments)
}

/// Toolchain channel in the builder's `rust-toolchain.toml`.
fn channel(builder: &Path) -> anyhow::Result<String> {
    let file = builder.join("rust-toolchain.toml");
    let text = std::fs::read_to_string(&file).with_context(|| format!("reading {}", file.display()))?;
    let line = text.lines().find_map(|line| line.strip_prefix("channel = "));
    Ok(line.with_context(|| format!("{} names no channel", file.display()))?.trim_matches('"').to_string())
}

/// Whether rustup has a toolchain; true without rustup, as another tool may manage toolchains.
fn installed(toolchain: &str) -> bool {
    let Ok(list) = Command::new("rustup").args(["toolchain", "list"]).output() else { return true };
    String::from_utf8_lossy(&list.stdout).lines().any(|line| line.starts_with(toolchain))
}

/// A command in the builder's folder, without the environment variables of this toolchain.
fn clean(program: &str, folder: &Path) -> Command {
    let mut command = Command::new(program);
    command.current_dir(folder);
    for (name, _) in std::env::vars_os() {
        let text = name.to_string_lossy();
        if text.starts_with("RUSTUP_TOOLCHAIN")
            || text.starts_with("CARGO_PKG")
            || text == "RUSTC"
            || text == "CARGO"
        {
            command.env_remove(&name);
        }
    }
    command
}
