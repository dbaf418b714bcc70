//! `cargo kernels`: compiles `kernels/` to `base.spv` and `rayquery.spv` and writes `kernels.lock`.
//!
//! Modules in which loops or branches carry pointers are refused (`pointers`). `--check` compares instead of writing and
//! fails on any difference; `--lint` runs clippy over the code that only a GPU sees; `--panics FOLDER` writes modules there that report panics through debug printf.

#![forbid(unsafe_code)]

mod fingerprint;
mod pointers;

use anyhow::{Context, bail};
use spirv_builder::{Capability, ShaderPanicStrategy, SpirvBuilder, SpirvBuilderError, SpirvMetadata};
use std::path::{Path, PathBuf};

/// The modules: name, whether it has ray queries.
const MODULES: [(&str, bool); 2] = [("base.spv", false), ("rayquery.spv", true)];

fn main() -> anyhow::Result<()> {
    // Asked at run time: with a target directory that checkouts share, a path compiled in may be another checkout's.
    let builder = std::env::var_os("CARGO_MANIFEST_DIR").context("run it by `cargo kernels`")?;
    let kernels = Path::new(&builder).parent().context("the builder lies in kernels/")?;
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => write(kernels, &compile(kernels, ShaderPanicStrategy::SilentExit)?),
        ["--check"] => check(kernels, &compile(kernels, ShaderPanicStrategy::SilentExit)?),
        ["--lint"] => lint(kernels),
        ["--panics", folder] => {
            let report =
                ShaderPanicStrategy::DebugPrintfThenExit { print_inputs: true, print_backtrace: true };
            for (name, bytes) in compile(kernels, report)? {
                std::fs::write(Path::new(folder).join(name), bytes)?;
            }
            Ok(())
        }
        _ => bail!("usage: cargo kernels [--check | --lint | --panics FOLDER]"),
    }
}

fn builder(kernels: &Path, ray_queries: bool) -> SpirvBuilder {
    let mut builder = SpirvBuilder::new(kernels, "spirv-unknown-vulkan1.2")
        .deny_warnings(true)
        .spirv_metadata(SpirvMetadata::NameVariables)
        .capability(Capability::VulkanMemoryModelDeviceScope)
        .scalar_block_layout(true);
    // Of the two toolchains of the project, that of this program.
    builder.toolchain_overwrite = std::env::var("RUSTUP_TOOLCHAIN").ok();
    if ray_queries {
        builder
            .capability(Capability::RayQueryKHR)
            .extension("SPV_KHR_ray_query")
            .shader_crate_features(["ray-query".to_string()])
    } else {
        builder
    }
}

fn compile(kernels: &Path, panics: ShaderPanicStrategy) -> anyhow::Result<Vec<(&'static str, Vec<u8>)>> {
    MODULES
        .iter()
        .map(|&(name, ray_queries)| {
            let compiled = builder(kernels, ray_queries).shader_panic_strategy(panics).build()?;
            let bytes = std::fs::read(compiled.module.unwrap_single())?;
            pointers::refuse_carried(&bytes).with_context(|| format!("{name} would crash drivers"))?;
            Ok((name, bytes))
        })
        .collect()
}

fn lint(kernels: &Path) -> anyhow::Result<()> {
    for (name, ray_queries) in MODULES {
        match builder(kernels, ray_queries).clippy() {
            // Clippy leaves no module behind, which spirv-builder takes for a failure.
            Ok(_) | Err(SpirvBuilderError::NoArtifactProduced { .. }) => {}
            Err(error) => return Err(error).with_context(|| format!("clippy of {name}")),
        }
    }
    Ok(())
}

/// The lock: what was compiled, by what, to what.
fn lock(kernels: &Path, modules: &[(&'static str, Vec<u8>)]) -> anyhow::Result<String> {
    let mut lock =
        String::from("# Written by `cargo kernels`; the host refuses a GPU when the sources differ.\n");
    lock += &format!("sources = \"{}\"\n", fingerprint::fingerprint(kernels, &fingerprint::KERNELS)?);
    lock += "compiler = \"rustc_codegen_spirv 0.11.0\"\n";
    for (name, bytes) in modules {
        lock += &format!("\"{name}\" = \"{}\"\n", fingerprint::hash(bytes));
    }
    Ok(lock)
}

/// Everything that is committed: modules and lock.
fn committed(kernels: &Path, modules: &[(&'static str, Vec<u8>)]) -> anyhow::Result<Vec<(PathBuf, Vec<u8>)>> {
    let lock = lock(kernels, modules)?.into_bytes();
    let modules = modules.iter().map(|(name, bytes)| (kernels.join(name), bytes.clone()));
    Ok(modules.chain([(kernels.join("kernels.lock"), lock)]).collect())
}

fn write(kernels: &Path, modules: &[(&'static str, Vec<u8>)]) -> anyhow::Result<()> {
    for (path, bytes) in committed(kernels, modules)? {
        std::fs::write(&path, &bytes)?;
        println!("{} ({} bytes)", path.display(), bytes.len());
    }
    Ok(())
}

fn check(kernels: &Path, modules: &[(&'static str, Vec<u8>)]) -> anyhow::Result<()> {
    for (path, bytes) in committed(kernels, modules)? {
        if std::fs::read(&path).with_context(|| format!("reading {}", path.display()))? != bytes {
            bail!("{} is not what the sources compile to: run `cargo kernels` and commit it", path.display());
        }
    }
    println!("the committed kernels are what the sources compile to");
    Ok(())
}
