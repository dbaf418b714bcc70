//! Compiles one entry point in this process, for `--one`.

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use caustics::kernels::Modules;
use caustics::vulkan::context::Context;
use caustics::vulkan::executable::{Executable, compile};
use caustics::vulkan::module::Module;
use caustics_kernels::interface::features::Features;
use serde::{Deserialize, Serialize};

use crate::cli::Usage;
use crate::command::console::print;

/// Output of a process that compiled an entry point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compiled {
    /// Time that the driver took (ms).
    pub compile_ms: f64,
    /// Programs of the driver; none where it reports none.
    pub executables: Vec<Executable>,
}

/// Compiles MODULE/ENTRY/BITS and prints one line of JSON.
pub fn run(one: &str, device: Option<&str>, modules: &Modules) -> anyhow::Result<ExitCode> {
    let malformed = || Usage(format!("--one takes MODULE/ENTRY/BITS, not {one:?}"));
    let mut parts = one.split('/');
    let (Some(name), Some(entry), Some(bits), None) =
        (parts.next(), parts.next(), parts.next(), parts.next())
    else {
        return Err(malformed().into());
    };
    let words = match name {
        "base.spv" => &modules.base,
        "rayquery.spv" => &modules.rayquery,
        _ => return Err(malformed().into()),
    };
    let features = Features(bits.parse().map_err(|_| malformed())?);
    let context = Arc::new(Context::to_compile(device)?);
    let module = Module::new(&context, name, words)?;
    let start = Instant::now();
    let executables = compile(&module, entry, features)?;
    let compile_ms = start.elapsed().as_secs_f64() * 1.0e3;
    print(serde_json::to_string(&Compiled { compile_ms, executables })?)?;
    Ok(ExitCode::SUCCESS)
}
