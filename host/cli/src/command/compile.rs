//! `caustics device --compile`: compiles every entry point for a device, each in its own process. A compiler that crashes
//! names its entry point, and the others are still compiled.

mod figures;
mod one;
mod report;

use std::path::Path;
use std::process::{Command, ExitCode, ExitStatus};

use anyhow::Context;
use caustics::hash::fnv1a;
use caustics::kernels::{Modules, Source};
use caustics::scene::{self, Scene};
use caustics::vulkan::reflection::Reflection;
use caustics::vulkan::{self, DeviceInfo};
use caustics_kernels::interface::features::Features;
use rayon::prelude::*;

use super::console::print;
use crate::cli::{self, Usage};
use figures::Figures;
use one::Compiled;
use report::{CompileJob, CompileReport, EntryPointRecord};

/// Maximum roughness of a specular reflection, the default of `render`.
const SPECULAR_ROUGHNESS: f32 = 0.25;

/// Compiles and prints. Returns exit code 1 if anything failed.
pub fn run(options: &cli::Device) -> anyhow::Result<ExitCode> {
    let modules = Source::from_environment().unchecked()?;
    if let Some(one) = &options.one {
        return one::run(one, options.device.as_deref(), &modules);
    }
    let device = vulkan::best(options.device.as_deref())?;
    let modules = suitable(&device, &modules);
    let jobs = jobs(&modules, &features(&options.features)?, &options.pass)?;
    let program = std::env::current_exe().context("finding the program itself, to start it anew")?;
    let entry_points: Vec<EntryPointRecord> =
        jobs.into_par_iter().map(|job| compile(&program, device.index, job)).collect();
    let failed = entry_points.iter().filter(|record| record.error.is_some()).count();
    let modules = modules.iter().map(|&(name, words)| (name, hash(words))).collect();
    let report = CompileReport { device, modules, entry_points };
    if options.json {
        print(serde_json::to_string_pretty(&report)?)?;
    } else {
        print(report::text(&report).trim_end())?;
    }
    Ok(ExitCode::from(u8::from(failed > 0)))
}

/// Returns the modules that the device supports.
fn suitable<'a>(device: &DeviceInfo, modules: &'a Modules) -> Vec<(&'static str, &'a [u32])> {
    let mut suitable = vec![("base.spv", &modules.base[..])];
    if device.ray_queries {
        suitable.push(("rayquery.spv", &modules.rayquery[..]));
    }
    suitable
}

fn hash(words: &[u32]) -> String {
    // `kernels.lock` appends a byte 0xff to the module before hashing.
    fnv1a(words.iter().flat_map(|word| word.to_le_bytes()).chain([0xff]))
}

/// Names and bits of the features to compile in.
fn features(names: &[String]) -> anyhow::Result<Vec<(String, Features)>> {
    let one = |name: &String| {
        let features = match name.as_str() {
            "all" => Features::ALL,
            "none" => Features(0),
            scene => Scene::load(&scene::resolve(scene)?)?.features(SPECULAR_ROUGHNESS),
        };
        Ok((name.clone(), features))
    };
    names.iter().map(one).collect()
}

/// Every entry point for all needs, or those that the options name.
fn jobs(
    modules: &[(&'static str, &[u32])],
    features: &[(String, Features)],
    wanted: &[String],
) -> anyhow::Result<Vec<CompileJob>> {
    let mut found = Vec::new();
    for &(module, words) in modules {
        found.extend(Reflection::new(module, words)?.entry_points.into_keys().map(|entry| (module, entry)));
    }
    if let Some(unknown) = wanted.iter().find(|&name| found.iter().all(|(_, entry)| entry != name)) {
        let mut known: Vec<_> = found.into_iter().map(|(_, entry)| entry).collect();
        known.sort_unstable();
        known.dedup();
        return Err(
            Usage(format!("no entry point is called `{unknown}`; there are: {}", known.join(", "))).into()
        );
    }
    let all = features.iter().flat_map(|(name, bits)| {
        let wanted = found.iter().filter(|(_, entry)| wanted.is_empty() || wanted.contains(entry));
        wanted.map(move |&(module, ref entry)| CompileJob {
            module,
            entry: entry.clone(),
            features: name.clone(),
            feature_bits: bits.0,
        })
    });
    Ok(all.collect())
}

/// Compiles an entry point in a process of `program`, which is this program or a substitute of the tests.
fn compile(program: &Path, device: usize, job: CompileJob) -> EntryPointRecord {
    let one = format!("{}/{}/{}", job.module, job.entry, job.feature_bits);
    let output = Command::new(program)
        .args(["device", "--compile", "--device", &device.to_string(), "--one", &one])
        // Disable the disk caches of Mesa and NVIDIA.
        .env("MESA_SHADER_CACHE_DISABLE", "true")
        .env("__GL_SHADER_DISK_CACHE", "0")
        .output();
    let compiled = match output {
        Err(error) => Err(format!("{}: {error}", program.display())),
        Ok(output) => outcome(output.status, &output.stdout, &output.stderr),
    };
    let figures = Figures::from_executables(compiled.as_ref().map_or(&[], |compiled| &compiled.executables));
    let (compiled, error) = match compiled {
        Ok(compiled) => (Some(compiled), None),
        Err(error) => (None, Some(error)),
    };
    EntryPointRecord { job, figures, compiled, error }
}

/// Returns the result of a process from its last line of output, or the reason why there is none.
fn outcome(status: ExitStatus, stdout: &[u8], stderr: &[u8]) -> Result<Compiled, String> {
    let stderr = String::from_utf8_lossy(stderr);
    let last = stderr.lines().rfind(|line| !line.trim().is_empty()).unwrap_or_default();
    if status.code().is_none() {
        // Only the driver ends a process that only compiles.
        let last_line = if last.is_empty() { String::new() } else { format!("; it said: {last}") };
        return Err(format!("the driver's compiler crashed ({status}){last_line}"));
    }
    if !status.success() {
        return Err(last.strip_prefix("error: ").unwrap_or(last).to_string());
    }
    let stdout = String::from_utf8_lossy(stdout);
    let line = stdout.lines().last().unwrap_or_default();
    serde_json::from_str(line).map_err(|error| format!("its process printed no result ({error})"))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    /// A script that replaces this program; it gets the arguments of `--one`.
    fn script(folder: &Path, body: &str) -> std::path::PathBuf {
        let path = folder.join("fake");
        std::fs::write(&path, format!("#!/bin/sh\none=$6\n{body}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        path
    }

    fn job(entry: &str) -> CompileJob {
        CompileJob {
            module: "base.spv",
            entry: entry.into(),
            features: "all".into(),
            feature_bits: Features::ALL.0,
        }
    }

    #[test]
    fn a_compiler_that_crashes_names_its_entry_point_and_the_others_are_compiled() {
        let folder = tempfile::tempdir().unwrap();
        let program = script(
            folder.path(),
            r#"echo talk; case $one in
                base.spv/dies/*) echo 'in nir_lower' >&2; kill -SEGV $$;;
                base.spv/fails/*) echo 'error: no such thing' >&2; exit 1;;
                base.spv/silent/*) exit 0;;
                *) echo '{"compile_ms": 2.5, "executables": []}';;
            esac"#,
        );
        let records: Vec<_> = ["before", "dies", "fails", "silent", "behind"]
            .map(|entry| compile(&program, 0, job(entry)))
            .into();
        let errors: Vec<_> = records.iter().map(|record| record.error.as_deref().unwrap_or("")).collect();
        assert!(errors[0].is_empty() && errors[4].is_empty(), "{errors:?}");
        assert_eq!(records[4].compiled.as_ref().unwrap().compile_ms, 2.5);
        assert!(errors[1].contains("crashed") && errors[1].contains("SEGV"), "{errors:?}");
        assert!(errors[1].contains("in nir_lower"), "{errors:?}");
        assert_eq!(errors[2], "no such thing");
        assert!(errors[3].contains("no result"), "{errors:?}");
        let report = CompileReport {
            device: report::test_device(),
            modules: vec![("base.spv", "0123".into())],
            entry_points: records,
        };
        let text = report::text(&report);
        assert!(text.contains("base.spv dies, features all: the driver's compiler crashed"), "{text}");
        assert!(text.contains("3 of 5 entry points failed"), "{text}");
    }

    #[test]
    fn a_program_that_is_not_there_is_named() {
        let record = compile(Path::new("/no/such/program"), 0, job("any"));
        assert!(record.error.unwrap().contains("/no/such/program"));
    }

    #[test]
    fn jobs_are_all_entry_points_or_those_named() {
        let modules = Modules {
            base: bytemuck::pod_collect_to_vec(include_bytes!("../../../../kernels/base.spv")),
            rayquery: bytemuck::pod_collect_to_vec(include_bytes!("../../../../kernels/rayquery.spv")),
        };
        let modules = [("base.spv", &modules.base[..]), ("rayquery.spv", &modules.rayquery[..])];
        let two = [("all".to_string(), Features::ALL), ("none".to_string(), Features(0))];
        let all = jobs(&modules, &two, &[]).unwrap();
        let one = jobs(&modules, &two[..1], &[]).unwrap();
        assert!(one.len() >= 30 && all.len() == 2 * one.len(), "{} and {}", one.len(), all.len());
        let collect = jobs(&modules, &two[1..], &["collect".into()]).unwrap();
        let found: Vec<_> = collect.iter().map(|job| (job.module, job.feature_bits)).collect();
        assert_eq!(found, [("base.spv", 0), ("rayquery.spv", 0)]);
        let error = jobs(&modules, &two, &["colect".into()]).unwrap_err();
        assert!(error.is::<Usage>() && error.to_string().contains("collect"), "{error}");
    }

    #[test]
    fn needs_are_those_of_a_scene_or_of_none_or_of_all() {
        let found = features(&["all".into(), "none".into(), "mirror-room".into()]).unwrap();
        assert_eq!((found[0].1, found[1].1), (Features::ALL, Features(0)));
        let room = found[2].1;
        assert!(
            room.has(Features::MIRROR) && room.has(Features::DIELECTRIC) && !room.has(Features::INSTANCES)
        );
        let error = features(&["no-such-room".into()]).unwrap_err().to_string();
        assert!(error.contains("no-such-room"), "{error}");
    }

    #[test]
    fn hashes_are_those_of_the_lock() {
        let lock = include_str!("../../../../kernels/kernels.lock");
        let words = bytemuck::pod_collect_to_vec::<u8, u32>(include_bytes!("../../../../kernels/base.spv"));
        assert!(lock.contains(&format!("\"base.spv\" = \"{}\"", hash(&words))), "{lock}");
    }
}
