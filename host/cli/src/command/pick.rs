//! Picks runner, tracer and gather from the options and the machine, and states the reason.

use caustics::session::RunnerChoice;
use caustics::vulkan::{DeviceInfo, devices};
use caustics_kernels::gather::variant::{self, Variant};

use crate::cli::{Debug, Machine, Tracer, Usage};

/// Maximum number of threads, above any machine's number of cores.
const MAX_THREADS: usize = 1024;

/// Returns the runner and gather, and the reason in one line. `runner` is a name of the parameter `runner`.
pub fn pick(
    runner: &str,
    machine: &Machine,
    gather: Option<&'static Variant>,
) -> anyhow::Result<(RunnerChoice, &'static Variant, String)> {
    let tracer = match runner {
        "gpu-hardware" => Tracer::Hardware,
        "gpu-software" => Tracer::Software,
        _ => machine.tracer,
    };
    let options = &Machine { tracer, ..machine.clone() };
    let (choice, reason) = match runner {
        "cpu" => (cpu(options)?, "--runner cpu".to_string()),
        "auto" => auto(options)?,
        _ => {
            options.source().modules()?;
            let devices = devices()?;
            let device = find(options, &devices, |_| true);
            let hardware = hardware(options, device);
            (gpu(options, hardware), format!("--runner {runner}"))
        }
    };
    let variant = gather.unwrap_or_else(|| choice.default_gather());
    if variant.hardware && !choice.has_ray_queries() {
        let usable: Vec<_> = variant::ALL.iter().filter(|v| !v.hardware).map(|v| v.name).collect();
        let name = variant.name;
        return Err(Usage(format!(
            "--gather {name} needs ray queries, and {reason} has none here; use --runner gpu on a device that has \
             them, or --gather {}",
            usable.join(" or ")
        ))
        .into());
    }
    Ok((choice, variant, reason))
}

fn cpu(options: &Machine) -> Result<RunnerChoice, Usage> {
    if options.tracer == Tracer::Hardware {
        return Err(Usage("--tracer hardware needs --runner gpu: a CPU has no ray queries".into()));
    }
    if options.debug.is_some() {
        return Err(Usage("--debug validation watches Vulkan: it needs --runner gpu".into()));
    }
    if let Some(device) = &options.device {
        return Err(Usage(format!("--device {device:?} is a Vulkan device: it needs --runner gpu")));
    }
    if options.threads > MAX_THREADS {
        return Err(Usage(format!("--threads {}: give at most {MAX_THREADS}", options.threads)));
    }
    Ok(RunnerChoice::Cpu { threads: options.threads })
}

fn gpu(options: &Machine, hardware: bool) -> RunnerChoice {
    RunnerChoice::Gpu {
        device: options.device.clone(),
        hardware,
        validation: options.debug == Some(Debug::Validation),
        kernels: options.source(),
    }
}

/// Returns the device that would be opened, as far as it is known beforehand.
fn find<'a>(
    options: &Machine,
    devices: &'a [DeviceInfo],
    fits: impl Fn(&DeviceInfo) -> bool,
) -> Option<&'a DeviceInfo> {
    let named = |device: &&DeviceInfo| match &options.device {
        None => true,
        Some(name) => {
            device.index.to_string() == *name || device.name.to_lowercase().contains(&name.to_lowercase())
        }
    };
    let mut usable: Vec<_> = devices.iter().filter(|d| d.usable && fits(d)).filter(named).collect();
    usable.sort_by_key(|device| device.is_cpu());
    usable.first().copied()
}

fn hardware(options: &Machine, device: Option<&DeviceInfo>) -> bool {
    match options.tracer {
        Tracer::Hardware => true,
        Tracer::Software => false,
        Tracer::Auto => device.is_some_and(|device| device.ray_queries),
    }
}

/// Picks a real GPU if there is one that can run the kernels, else the CPU.
fn auto(options: &Machine) -> anyhow::Result<(RunnerChoice, String)> {
    let wants_gpu = options.tracer == Tracer::Hardware || options.device.is_some() || options.debug.is_some();
    let found = devices();
    let why_not = match &found {
        Err(error) => error.to_string(),
        Ok(devices) => match find(options, devices, |device| wants_gpu || !device.is_cpu()) {
            Some(device) => match options.source().modules() {
                Ok(_) => {
                    let tracer = hardware(options, Some(device));
                    let reason = format!("{} is there", device.name);
                    return Ok((gpu(options, tracer), reason));
                }
                Err(error) => error.to_string(),
            },
            None if devices.is_empty() => "there is no Vulkan device".into(),
            None => "there is no Vulkan device that is a real GPU".into(),
        },
    };
    if wants_gpu {
        found?;
        return Err(Usage(format!("no device fits the options: {why_not}")).into());
    }
    Ok((cpu(options)?, why_not))
}
