//! `cargo kernels`: compiles `kernels/` to `base.spv` and `rayquery.spv` and writes `kernels.lock`.
//!
//! Refuses modules in which loops or branches carry pointers (`pointers`). `--out FOLDER` writes the set there instead. `--watch`
//! writes it again whenever a source has changed. `--panics FOLDER` writes modules there that report panics through debug printf.
//! `--check` compares instead of writing and fails on any difference. `--lint` runs clippy over the code that only a GPU
//! compiles.

#![forbid(unsafe_code)]

mod fingerprint;
#[cfg(test)]
mod fingerprint_tests;
mod pointers;
mod rewrite;
mod set;
mod watch;

use anyhow::{Context, bail};
use set::{Set, Sources};
use spirv_builder::{Capability, ShaderPanicStrategy, SpirvBuilder, SpirvBuilderError, SpirvMetadata};
use std::path::Path;

/// Compiled modules: name, and whether they use ray queries.
const MODULES: [(&str, bool); 2] = [("base.spv", false), ("rayquery.spv", true)];

fn main() -> anyhow::Result<()> {
    // Read at run time: checkouts may share a target directory, so a path compiled in may be another checkout's.
    let builder = std::env::var_os("CARGO_MANIFEST_DIR").context("run it by `cargo kernels`")?;
    let kernels = Path::new(&builder).parent().context("the builder lies in kernels/")?;
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let silent = || compile(kernels, ShaderPanicStrategy::SilentExit);
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => silent()?.write(kernels),
        ["--out", folder] => silent()?.write(Path::new(folder)),
        ["--watch"] => match watch::watch(kernels, kernels, silent)? {},
        ["--watch", "--out", folder] => match watch::watch(kernels, Path::new(folder), silent)? {},
        ["--check"] => silent()?.compare(kernels),
        ["--lint"] => lint(kernels),
        ["--panics", folder] => {
            let report =
                ShaderPanicStrategy::DebugPrintfThenExit { print_inputs: true, print_backtrace: true };
            compile(kernels, report)?.write(Path::new(folder))
        }
        _ => bail!("usage: cargo kernels [[--watch] [--out FOLDER] | --panics FOLDER | --check | --lint]"),
    }
}

fn builder(kernels: &Path, ray_queries: bool) -> SpirvBuilder {
    let mut builder = SpirvBuilder::new(kernels, "spirv-unknown-vulkan1.2")
        .deny_warnings(true)
        .spirv_metadata(SpirvMetadata::NameVariables)
        .capability(Capability::VulkanMemoryModelDeviceScope)
        .scalar_block_layout(true);
    // Use the toolchain that runs this program, not the project's other one.
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

fn compile(kernels: &Path, panics: ShaderPanicStrategy) -> anyhow::Result<Set> {
    // Hash before the compiler reads: the set then never claims sources that changed during the build.
    let sources = Sources::now(kernels)?;
    let module = |&(name, ray_queries): &(&'static str, bool)| {
        let compiled = builder(kernels, ray_queries).shader_panic_strategy(panics).build()?;
        let bytes = rewrite::for_drivers(&std::fs::read(compiled.module.unwrap_single())?)
            .with_context(|| format!("{name} is no SPIR-V"))?;
        pointers::refuse_carried(&bytes).with_context(|| format!("{name} would crash drivers"))?;
        Ok((name, bytes))
    };
    Ok(Set { sources, modules: MODULES.iter().map(module).collect::<anyhow::Result<_>>()? })
}

fn lint(kernels: &Path) -> anyhow::Result<()> {
    for (name, ray_queries) in MODULES {
        match builder(kernels, ray_queries).clippy() {
            // Clippy writes no module, which spirv-builder takes for a failure.
            Ok(_) | Err(SpirvBuilderError::NoArtifactProduced { .. }) => {}
            Err(error) => return Err(error).with_context(|| format!("clippy of {name}")),
        }
    }
    Ok(())
}
