//! Build script: records whether the committed SPIR-V matches the kernels' sources, the hashes of these sources and of
//! their interface, and the compiler's version.

#[path = "../kernels/builder/src/fingerprint.rs"]
mod fingerprint;

use std::path::Path;

fn main() {
    let kernels = Path::new("../kernels");
    for watched in fingerprint::KERNELS.into_iter().chain(["base.spv", "rayquery.spv", "kernels.lock"]) {
        println!("cargo::rerun-if-changed={}", kernels.join(watched).display());
    }
    println!("cargo::rerun-if-changed=../kernels/builder/src/fingerprint.rs");
    let lock = std::fs::read_to_string(kernels.join("kernels.lock")).unwrap_or_default();
    let locked = |key: &str| {
        let line = lock.lines().find(|line| line.starts_with(&format!("{key} = ")));
        line.and_then(|line| line.split('"').rev().nth(1)).map(str::to_string)
    };
    let sources = fingerprint::fingerprint(kernels, &fingerprint::KERNELS).ok();
    let module = |name: &str| std::fs::read(kernels.join(name)).ok().map(|bytes| fingerprint::hash(&bytes));
    let fresh = sources.is_some()
        && locked("sources") == sources
        && ["base.spv", "rayquery.spv"]
            .iter()
            .all(|name| module(name).is_some() && locked(&format!("\"{name}\"")) == module(name));
    println!("cargo::rustc-env=CAUSTICS_KERNELS_FRESH={}", u8::from(fresh));
    println!("cargo::rustc-env=CAUSTICS_KERNELS_HASH={}", sources.unwrap_or_default());
    let interface = fingerprint::fingerprint(kernels, &fingerprint::INTERFACE).unwrap_or_default();
    println!("cargo::rustc-env=CAUSTICS_INTERFACE_HASH={interface}");
    let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let compiler = std::process::Command::new(compiler).arg("--version").output();
    // Leave out the compiler's date: "rustc 1.95.0".
    let compiler = compiler.map_or("unknown compiler".into(), |output| {
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        text.split_whitespace().take(2).collect::<Vec<_>>().join(" ")
    });
    println!("cargo::rustc-env=CAUSTICS_COMPILER={compiler}");
}
