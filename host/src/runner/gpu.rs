//! GPU runner: records steps into one command buffer and runs them on a Vulkan device.

use std::collections::HashMap;
use std::sync::Arc;

use caustics_kernels::gather::variant::Side;
use caustics_kernels::interface::counters::PhotonState;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::instance::Transform;
use caustics_kernels::texture::cut_out::SOME_ARE_NOT_THERE;

use super::{RunError, Runner, StepTime};
use crate::vulkan::bound::{BoundPipeline, Resources};
use crate::vulkan::buffer::{Buffer, Purpose};
use crate::vulkan::context::Context;
use crate::vulkan::error::VulkanError;
use crate::vulkan::frame::FrameCommands;
use crate::vulkan::memory::DeviceAllocator;
use crate::vulkan::passes::{DeviceOptions, Kernels, Passes};
use crate::vulkan::primitives::Primitives;
use crate::vulkan::recorder::Recorder;
use crate::vulkan::structure::{BlasGeometry, Hierarchy, TlasInstance};
use caustics_kernels::declare::{BufferSpec, Step};
use caustics_scene::instanced::{InstanceTransform, Instanced};

const SCENE_STRUCTURE: &str = "scene_structure";
const NEIGHBOUR_STRUCTURE: &str = "neighbour_structure";
/// Name of the uniform buffer of the frame's parameters.
const PARAMS: &str = "params";

/// GPU runner with the tables of a scene and the buffers of a plan.
pub struct GpuRunner {
    // Fields drop in order: users of a resource stand before it.
    frame: FrameCommands,
    passes: Passes,
    resources: Resources,
    memory: Arc<DeviceAllocator>,
    context: Arc<Context>,
    // Transforms of the instances in the acceleration structure.
    instance_transforms: Vec<InstanceTransform>,
}

impl GpuRunner {
    /// Opens a device, allocates zeroed buffers and uploads the tables. With `hardware` it also builds `scene_structure`
    /// over the world's elements of `triangles`, and over every mesh for its instances.
    pub fn new(
        options: &DeviceOptions,
        features: Features,
        buffers: &[BufferSpec],
        tables: &[(&'static str, &[u8])],
        instanced: &Instanced,
    ) -> Result<GpuRunner, VulkanError> {
        let kernels = Kernels::open(options)?;
        let context = Arc::clone(kernels.context());
        let memory = DeviceAllocator::new(Arc::clone(&context))?;
        let frame = FrameCommands::new(&context)?;
        let passes = Passes::new(kernels, features);
        let resources = Resources {
            nothing: Buffer::new(&memory, "nothing", 0, Purpose::Data)?,
            buffers: allocate(&memory, buffers, tables)?,
            structures: HashMap::new(),
        };
        let mut runner =
            GpuRunner { frame, passes, resources, memory, context, instance_transforms: Vec::new() };
        runner.clear_all()?;
        for (name, bytes) in tables {
            runner.upload(name, 0, bytes)?;
        }
        if options.hardware {
            // With holes, kernels confirm every hit.
            let kind = if features.has(SOME_ARE_NOT_THERE) {
                Primitives::TrianglesWithHoles
            } else {
                Primitives::Triangles
            };
            runner.build_structures(kind, instanced)?;
        }
        Ok(runner)
    }

    fn clear_all(&mut self) -> Result<(), VulkanError> {
        let buffers: Vec<_> = self.resources.buffers.values().collect();
        self.frame.execute(&["clear".into()], |recorder, _| {
            for buffer in &buffers {
                recorder.clear(buffer);
            }
        })?;
        Ok(())
    }

    fn build_structures(&mut self, kind: Primitives, instanced: &Instanced) -> Result<(), VulkanError> {
        let Resources { buffers, structures, .. } = &mut self.resources;
        let memory = &self.memory;
        let buffer = buffers.get("triangles").ok_or_else(|| unknown("triangles"))?;
        let world = BlasGeometry { buffer, first: 0, capacity: instanced.still as u64 };
        let meshes = instanced.meshes.iter();
        let meshes =
            meshes.map(|mesh| BlasGeometry { buffer, first: mesh.first.into(), capacity: mesh.count.into() });
        let parts: Vec<BlasGeometry<'_>> = std::iter::once(world).chain(meshes).collect();
        let instance_transforms = instanced.instance_transforms();
        let mut scene = Hierarchy::from_parts(
            memory,
            SCENE_STRUCTURE,
            kind,
            &parts,
            instance_transforms.len() as u32 + 1,
        )?;
        scene.set_instances(&tlas_instances(instance_transforms))?;
        self.instance_transforms = instance_transforms.to_vec();
        let count = instanced.still as u32;
        self.frame.execute(&["build.scene".into()], |recorder, _| recorder.build(&scene, count))?;
        structures.insert(SCENE_STRUCTURE, scene);

        Ok(())
    }

    /// Allocates an empty structure over the boxes in `index_0`, the gather's first buffer, unless it exists.
    fn make_neighbour_structure(&mut self, step: &Step) -> Result<(), VulkanError> {
        let GpuRunner { frame, resources, memory, context, .. } = self;
        if !context.is_hardware() {
            return Err(VulkanError::NotHardware { step: step.label() });
        }
        if resources.structures.contains_key(NEIGHBOUR_STRUCTURE) {
            return Ok(());
        }
        let boxes = resources.buffers.get("index_0").ok_or_else(|| unknown("index_0"))?;
        let (kind, count) = (Primitives::Boxes, boxes.bytes() / Primitives::Boxes.stride());
        let neighbours = Hierarchy::new(memory, NEIGHBOUR_STRUCTURE, kind, boxes, count)?;
        frame.execute(&["build.neighbours".into()], |recorder, _| recorder.build(&neighbours, 0))?;
        resources.structures.insert(NEIGHBOUR_STRUCTURE, neighbours);
        Ok(())
    }

    /// Runs steps in one submission. Only the first step may depend on the number of photons.
    fn submit(&mut self, params: &FrameParams, steps: &[Step]) -> Result<Vec<StepTime>, RunError> {
        let photons = match steps.first() {
            Some(Step::Structure { side: Side::Photons, count }) => {
                let state: Vec<u32> = bytemuck::pod_collect_to_vec(&self.read("photon_state")?);
                state[PhotonState::Stored as usize].min(*count)
            }
            _ => 0,
        };
        let GpuRunner { frame, passes, resources, .. } = self;
        let actions = steps
            .iter()
            .map(|step| resolve(passes, resources, step, photons))
            .collect::<Result<Vec<_>, _>>()?;
        let labels: Vec<_> = steps.iter().map(Step::label).collect();
        let uniform = resources.buffers.get(PARAMS).ok_or_else(|| unknown(PARAMS))?;
        let times = frame.execute(&labels, |recorder, index| {
            if index == 0 {
                recorder.update(uniform, bytemuck::bytes_of(params));
            }
            actions[index].record(recorder);
        })?;
        Ok(times.into_iter().map(|(pass, time)| StepTime { pass, time }).collect())
    }

    fn upload(&mut self, name: &str, offset: usize, bytes: &[u8]) -> Result<(), VulkanError> {
        let GpuRunner { frame, resources, .. } = self;
        let buffer = resources.buffers.get_mut(name).ok_or_else(|| unknown(name))?;
        frame.upload(buffer, offset as u64, bytes)
    }
}

impl Runner for GpuRunner {
    fn device(&self) -> String {
        let info = self.context.info();
        format!("{} ({}, Vulkan {})", info.name, info.driver, info.api_version)
    }

    fn write_at(&mut self, buffer: &str, offset: usize, bytes: &[u8]) -> Result<(), RunError> {
        Ok(self.upload(buffer, offset, bytes)?)
    }

    fn set_instances(
        &mut self,
        instance_transforms: &[InstanceTransform],
        deformed: &[usize],
    ) -> Result<(), RunError> {
        let Some(scene) = self.resources.structures.get_mut(SCENE_STRUCTURE) else { return Ok(()) };
        if deformed.is_empty() && *instance_transforms == *self.instance_transforms {
            return Ok(());
        }
        scene.set_instances(&tlas_instances(instance_transforms))?;
        let scene = &*scene;
        // Part 0 is the world.
        let parts: Vec<usize> = deformed.iter().map(|mesh| mesh + 1).collect();
        self.frame.execute(&["build.scene".into()], |recorder, _| recorder.build_again(scene, &parts))?;
        self.instance_transforms = instance_transforms.to_vec();
        Ok(())
    }

    fn read(&mut self, buffer: &str) -> Result<Vec<u8>, RunError> {
        let GpuRunner { frame, resources, .. } = self;
        let buffer = resources.buffers.get_mut(buffer).ok_or_else(|| unknown(buffer))?;
        Ok(frame.download(buffer)?)
    }

    fn run(&mut self, params: &FrameParams, steps: &[Step]) -> Result<Vec<StepTime>, RunError> {
        let names = steps.iter().filter_map(|step| match step {
            Step::Dispatch { pass, .. } => Some(pass.name),
            Step::Clear { .. } | Step::Structure { .. } => None,
        });
        if let Some(step) = steps.iter().find(|step| matches!(step, Step::Structure { .. })) {
            self.make_neighbour_structure(step)?;
        }
        self.passes.prepare(names, &self.resources)?;
        // The number of boxes over photons is known only after the photons exist. Such a build starts a new submission.
        let waits = |step: &Step| matches!(step, Step::Structure { side: Side::Photons, .. });
        let mut times = Vec::with_capacity(steps.len());
        let mut rest = steps;
        while !rest.is_empty() {
            let count = rest.iter().skip(1).position(waits).map_or(rest.len(), |index| index + 1);
            let (now, later) = rest.split_at(count);
            times.extend(self.submit(params, now)?);
            rest = later;
        }
        Ok(times)
    }
}

/// Returns the instances of the scene's structure: the world, and all visible instances.
fn tlas_instances(instance_transforms: &[InstanceTransform]) -> Vec<TlasInstance> {
    let world = TlasInstance { part: 0, to_world: Transform::IDENTITY, custom_index: 0 };
    let shown = (1..).zip(instance_transforms).filter_map(|(custom_index, instance)| {
        Some(TlasInstance { part: instance.mesh + 1, to_world: instance.to_world?, custom_index })
    });
    std::iter::once(world).chain(shown).collect()
}

/// Step with resolved names.
enum Action<'a> {
    Dispatch(&'a BoundPipeline, u32, &'a [u8]),
    Clear(&'a Buffer),
    Build(&'a Hierarchy, u32),
}

impl Action<'_> {
    fn record(&self, recorder: &Recorder<'_>) {
        match *self {
            Action::Dispatch(pipeline, count, params) => recorder.dispatch(pipeline, count, params),
            Action::Clear(buffer) => recorder.clear(buffer),
            Action::Build(structure, count) => recorder.build(structure, count),
        }
    }
}

fn resolve<'a>(
    passes: &'a Passes,
    resources: &'a Resources,
    step: &'a Step,
    photons: u32,
) -> Result<Action<'a>, VulkanError> {
    match step {
        Step::Dispatch { pass, dispatch, .. } => {
            Ok(Action::Dispatch(passes.get(pass.name)?, dispatch.count, bytemuck::bytes_of(dispatch)))
        }
        Step::Clear { buffer } => {
            resources.buffers.get(buffer).map(Action::Clear).ok_or_else(|| unknown(buffer))
        }
        Step::Structure { side, count } => {
            let neighbours = resources.structures.get(NEIGHBOUR_STRUCTURE);
            let neighbours = neighbours.ok_or_else(|| VulkanError::NotHardware { step: step.label() })?;
            let count = if *side == Side::Photons { photons } else { *count };
            neighbours.check(count)?;
            Ok(Action::Build(neighbours, count))
        }
    }
}

/// Allocates every named buffer: the frame's parameters, the plan's buffers, and one for each table.
fn allocate(
    memory: &Arc<DeviceAllocator>,
    buffers: &[BufferSpec],
    tables: &[(&'static str, &[u8])],
) -> Result<HashMap<&'static str, Buffer>, VulkanError> {
    let tables = tables.iter().map(|&(name, bytes)| BufferSpec { name, bytes: bytes.len() });
    let params = Buffer::new(memory, PARAMS, size_of::<FrameParams>() as u64, Purpose::Uniform)?;
    let mut named = HashMap::from([(PARAMS, params)]);
    for BufferSpec { name, bytes } in buffers.iter().copied().chain(tables) {
        let buffer = Buffer::new(memory, name, bytes as u64, Purpose::Data)?;
        if named.insert(name, buffer).is_some() {
            return Err(VulkanError::DuplicateBuffer { buffer: name.into() });
        }
    }
    Ok(named)
}

fn unknown(buffer: &str) -> VulkanError {
    VulkanError::UnknownBuffer { buffer: buffer.into() }
}

#[cfg(test)]
mod tests;
