//! `caustics device`; with `--compile` see [`super::compile`].

use std::process::ExitCode;

use caustics::vulkan::{DeviceInfo, VulkanError, devices};

use super::compile;
use super::console::print;
use crate::cli;

/// Lists devices. Without a device, says why and returns exit code 4.
pub fn run(options: &cli::Device) -> anyhow::Result<ExitCode> {
    if options.compile {
        return compile::run(options);
    }
    let devices = devices()?;
    if devices.is_empty() {
        return Err(VulkanError::NoDevice { wanted: "at all".into(), found: "none".into() }.into());
    }
    if options.json {
        print(serde_json::to_string_pretty(&devices)?)?;
        return Ok(ExitCode::SUCCESS);
    }
    for device in &devices {
        print(format_args!(
            "{}: {} ({}), Vulkan {}",
            device.index, device.name, device.driver, device.api_version
        ))?;
        print(format_args!("   kind: {:?}", device.kind))?;
        print(format_args!("   ray queries: {}", if device.ray_queries { "yes" } else { "no" }))?;
        print(format_args!("   largest buffer: {} MiB", device.max_storage_buffer_bytes >> 20))?;
        print(format_args!("   timestamps: {}", if device.timestamps { "yes" } else { "no" }))?;
        print(format_args!("   used: {}", verdict(device)))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn verdict(device: &DeviceInfo) -> String {
    if !device.usable {
        format!("no, it lacks {}", device.missing.join(", "))
    } else if device.is_cpu() {
        "with --runner gpu only: it is software, and --runner cpu is faster".into()
    } else if device.ray_queries {
        "yes, by --runner auto, with ray queries".into()
    } else {
        format!(
            "yes, by --runner auto, with the software tracer (no {})",
            device.missing_ray_queries.join(", ")
        )
    }
}
