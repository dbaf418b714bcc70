//! Check of modules against the program's passes. Each pass needs an entry point, which may only bind buffers of the passes
//! that share it.

use caustics_kernels::declare::{Pass, Step};
use caustics_kernels::gather::variant;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::guide::LightGroups;
use caustics_kernels::method::frame::look_back;
use caustics_kernels::method::{self, Parts, Stages};
use caustics_kernels::pass::step::{STEP_EMIT, STEP_HIT, STEP_SAMPLE, STEP_SCATTER};
use caustics_kernels::{denoiser, emission, history};

use super::error::KernelsError;
use super::lock::{BASE, RAYQUERY};
use crate::vulkan::reflection::{Binding, BindingKind, EntryPoint, Reflection};

/// Checks the modules: base first, then ray queries.
pub fn modules([base, rayquery]: [&[u32]; 2]) -> Result<(), KernelsError> {
    let passes = passes();
    let in_base = passes.iter().copied().filter(|pass| is_in_base(pass));
    module(BASE, base, in_base)?;
    let in_rayquery = passes.iter().copied().filter(|pass| is_in_rayquery(pass));
    module(RAYQUERY, rayquery, in_rayquery)
}

/// Whether a pass is in the base module. Passes that need ray queries have no CPU version.
fn is_in_base(pass: &Pass) -> bool {
    pass.cpu.is_some()
}

fn is_in_rayquery(pass: &Pass) -> bool {
    pass.traces || pass.cpu.is_none()
}

fn module(
    name: &'static str,
    words: &[u32],
    passes: impl Iterator<Item = &'static Pass>,
) -> Result<(), KernelsError> {
    let Reflection { entry_points, .. } = Reflection::new(name, words)?;
    let find = |pass: &Pass| {
        entry_points.get(pass.name).ok_or(KernelsError::NoEntry { module: name, entry: pass.name })
    };
    let found = passes.map(|pass| Ok((find(pass)?, pass))).collect::<Result<Vec<_>, KernelsError>>()?;
    for &(entry, pass) in &found {
        let sharing = found.iter().filter(|(other, _)| other.symbol == entry.symbol);
        entry_point(name, entry, pass, &sharing.map(|&(_, pass)| pass).collect::<Vec<_>>())?;
    }
    Ok(())
}

/// Checks the entry point of a pass. It binds the buffers of all passes that share it.
fn entry_point(
    module: &'static str,
    found: &EntryPoint,
    pass: &'static Pass,
    sharing: &[&'static Pass],
) -> Result<(), KernelsError> {
    let entry = pass.name;
    for Binding { name, kind, stride, .. } in &found.bindings {
        let bound = sharing.iter().flat_map(|pass| pass.buffers).find(|bound| bound.name == name);
        let is_known = match kind {
            BindingKind::Buffer => bound.is_some(),
            BindingKind::Uniform => name == "params",
            BindingKind::Structure => match name.as_str() {
                "scene_structure" => pass.traces,
                "neighbour_structure" => pass.cpu.is_none(),
                _ => false,
            },
        };
        if !is_known {
            return Err(KernelsError::Unbound { module, entry, buffer: name.clone() });
        }
        if let Some(bound) = bound.filter(|bound| bound.stride != *stride as usize) {
            let (found, expected) = (*stride, bound.stride);
            return Err(KernelsError::Elements { module, entry, buffer: name.clone(), found, expected });
        }
    }
    Ok(())
}

/// Returns every pass that a session or a test can run.
pub(crate) fn passes() -> Vec<&'static Pass> {
    let params = FrameParams {
        width: 1,
        height: 1,
        light_path_count: 1,
        light_path_batch: 1,
        photon_capacity: 1,
        light_count: 1,
        // So many lights that some share their maps.
        light_groups: LightGroups::new(LightGroups::max_count(0) + 1, 0),
        moved: 1,
        share_radius_px: 2.0,
        cache_share: 1.0,
        ..FrameParams::default()
    };
    let mut passes = vec![&STEP_SAMPLE, &STEP_HIT, &STEP_SCATTER, &STEP_EMIT];
    for method in method::ALL {
        let params = (method.frame)(params, 0);
        for parts in parts() {
            let frame = method.frame_steps(parts, &params);
            passes.extend(look_back(parts, &params).into_iter().chain(frame).filter_map(|step| match step {
                Step::Dispatch { pass, .. } => Some(pass),
                _ => None,
            }));
        }
    }
    passes.sort_unstable_by_key(|pass| pass.name);
    passes.dedup();
    passes
}

/// Returns frame parts that together contain every pass. All stages are on, and each variant occurs once.
fn parts() -> impl Iterator<Item = Parts> {
    let all = Parts { stages: Stages::ALL, ..Parts::from(&variant::PHOTONS_GRID) };
    let gathers = variant::ALL.iter().map(move |gather| Parts { gather, ..all });
    let histories = history::ALL.iter().map(move |&history| Parts { history, ..all });
    let denoisers = denoiser::ALL.iter().map(move |&denoiser| Parts { denoiser, ..all });
    let emissions = emission::ALL.iter().map(move |&emission| Parts { emission, ..all });
    gathers.chain(histories).chain(denoisers).chain(emissions)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use caustics_kernels::declare::Access;

    use super::*;

    fn assert_has(name: &str, bytes: &[u8], is_in: fn(&Pass) -> bool) {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
        let mut found: BTreeSet<String> =
            Reflection::new(name, &words).unwrap().entry_points.into_keys().collect();
        // No stage runs this entry point.
        found.remove("index.brute");
        let known = passes().into_iter().filter(|pass| is_in(pass)).map(|pass| pass.name.to_string());
        assert_eq!(found, known.collect(), "{name}");
    }

    /// Without a buffer of one of its passes, a shared entry point would skip writes silently.
    #[test]
    fn shared_entry_points_bind_the_buffers_of_each_of_their_passes() {
        for (name, bytes, is_in) in [
            (BASE, &include_bytes!("../../../kernels/base.spv")[..], is_in_base as fn(&Pass) -> bool),
            (RAYQUERY, include_bytes!("../../../kernels/rayquery.spv"), is_in_rayquery),
        ] {
            let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
            let Reflection { entry_points, .. } = Reflection::new(name, &words).unwrap();
            let mut shared = 0;
            for pass in passes().into_iter().filter(|pass| is_in(pass)) {
                let entry = &entry_points[pass.name];
                if !entry.is_joint() {
                    continue;
                }
                shared += 1;
                for bound in pass.buffers.iter().filter(|bound| bound.access != Access::Table) {
                    let is_bound = entry.bindings.iter().any(|binding| binding.name == bound.name);
                    assert!(is_bound, "{name}: {} has no {}", pass.name, bound.name);
                }
            }
            assert_eq!(shared, 9, "{name}");
        }
    }

    /// A pass outside of the modules would not be checked.
    #[test]
    fn the_passes_are_those_of_the_modules() {
        assert_has(BASE, include_bytes!("../../../kernels/base.spv"), is_in_base);
        assert_has(RAYQUERY, include_bytes!("../../../kernels/rayquery.spv"), is_in_rayquery);
    }
}
