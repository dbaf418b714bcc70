//! Runs steps on a Vulkan device: one command buffer for all of them.

use std::collections::HashMap;
use std::sync::Arc;

use caustics_kernels::interface::instance::Transform;
use caustics_kernels::interface::needs::Needs;

use super::{Runner, StepTime};
use crate::method::{BufferSpec, Step};
use crate::scene::motion::Placement;
use crate::vulkan::buffer::Buffer;
use crate::vulkan::context::Context;
use crate::vulkan::error::VulkanError;
use crate::vulkan::frame::Frame;
use crate::vulkan::memory::{Memory, Purpose};
use crate::vulkan::passes::{Module, Passes};
use crate::vulkan::pipeline::{Pipeline, Resources};
use crate::vulkan::primitives::Primitives;
use crate::vulkan::recorder::Recorder;
use crate::vulkan::structure::{Hierarchy, Part, Placed};

const SCENE_STRUCTURE: &str = "scene_structure";
const POINTS_STRUCTURE: &str = "points_structure";
const BUILD_POINTS: &str = "build.points";

/// How to open a device, and the kernels.
#[derive(Clone, Debug, Default)]
pub struct GpuOptions {
    /// Index of the device or a part of its name; none: the best one there is.
    pub device: Option<String>,
    /// Whether to trace by ray queries. Without, the device is opened without the feature.
    pub hardware: bool,
    /// Whether the validation layer watches and its messages make calls fail.
    pub validation: bool,
    /// SPIR-V that needs no ray queries.
    pub base: Vec<u32>,
    /// SPIR-V that does; its entry points win over those of `base` if `hardware` is set.
    pub rayquery: Option<Vec<u32>>,
}

/// A Vulkan device with a scene's tables and a plan's buffers.
pub struct GpuRunner {
    // Fields drop in order: what uses a thing comes before the thing.
    frame: Frame,
    passes: Passes,
    resources: Resources,
    context: Arc<Context>,
    // Meshes that move, as the structure has them.
    placements: Vec<Placement>,
}

impl GpuRunner {
    /// Opens a device, allocates the buffers with zeros in them, uploads the tables (buffers like the others), and
    /// with `hardware` builds `scene_structure` over the first `triangle_count` rows of `triangles` and over the meshes that
    /// move, whose own triangles are the rows of `object_triangles`.
    pub fn new(
        options: GpuOptions,
        needs: Needs,
        buffers: &[BufferSpec],
        tables: &[(&'static str, &[u8])],
        triangle_count: u32,
        placements: &[Placement],
    ) -> Result<GpuRunner, VulkanError> {
        let context =
            Arc::new(Context::new(options.device.as_deref(), options.hardware, options.validation)?);
        let memory = Memory::new(Arc::clone(&context))?;
        let frame = Frame::new(&context)?;

        // Modules in the order in which they are searched.
        let mut modules = Vec::new();
        if let (true, Some(words)) = (options.hardware, &options.rayquery) {
            modules.push(Module::new(&context, "rayquery.spv", words)?);
        }
        modules.push(Module::new(&context, "base.spv", &options.base)?);
        let passes = Passes::new(&context, modules, needs)?;

        let resources =
            Resources { buffers: allocate(&memory, buffers, tables)?, structures: HashMap::new() };
        let mut runner = GpuRunner { frame, passes, resources, context, placements: Vec::new() };
        runner.clear_all()?;
        for (name, bytes) in tables {
            runner.upload(name, 0, bytes)?;
        }
        if options.hardware {
            // Kernels that look for holes confirm every hit.
            let kind = if needs.has(Needs::CUT_OUTS) {
                Primitives::TrianglesWithHoles
            } else {
                Primitives::Triangles
            };
            runner.build_structures(&memory, kind, triangle_count, placements)?;
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

    fn build_structures(
        &mut self,
        memory: &Arc<Memory>,
        kind: Primitives,
        triangle_count: u32,
        placements: &[Placement],
    ) -> Result<(), VulkanError> {
        let Resources { buffers, structures } = &mut self.resources;
        let triangles = buffers.get("triangles").ok_or_else(|| unknown("triangles"))?;
        let mut parts = vec![Part { buffer: triangles, first: 0, capacity: u64::from(triangle_count) }];
        for placement in placements {
            let buffer = buffers.get("object_triangles").ok_or_else(|| unknown("object_triangles"))?;
            let first = u64::from(placement.first - triangle_count);
            parts.push(Part { buffer, first, capacity: u64::from(placement.count) });
        }
        let mut scene = Hierarchy::of_parts(memory, SCENE_STRUCTURE, kind, &parts)?;
        scene.place(&placed(placements))?;
        self.placements = placements.to_vec();
        self.frame.execute(&["build.scene".into()], |recorder, _| recorder.build(&scene, triangle_count))?;
        structures.insert(SCENE_STRUCTURE, scene);

        // Until the first step builds it, the other structure is empty.
        if let Some(boxes) = buffers.get("point_boxes") {
            let (kind, count) = (Primitives::Boxes, boxes.bytes() / Primitives::Boxes.stride());
            let points = Hierarchy::new(memory, POINTS_STRUCTURE, kind, boxes, count)?;
            self.frame.execute(&[BUILD_POINTS.into()], |recorder, _| recorder.build(&points, 0))?;
            structures.insert(POINTS_STRUCTURE, points);
        }
        Ok(())
    }

    fn upload(&mut self, name: &str, offset: usize, bytes: &[u8]) -> Result<(), VulkanError> {
        let GpuRunner { frame, resources, .. } = self;
        resources.buffers.get_mut(name).ok_or_else(|| unknown(name))?.write(frame, offset as u64, bytes)
    }
}

impl Runner for GpuRunner {
    fn device(&self) -> String {
        let info = self.context.info();
        format!("{} ({}, Vulkan {})", info.name, info.driver, info.api_version)
    }

    fn write_at(&mut self, buffer: &str, offset: usize, bytes: &[u8]) -> anyhow::Result<()> {
        Ok(self.upload(buffer, offset, bytes)?)
    }

    fn place(&mut self, placements: &[Placement]) -> anyhow::Result<()> {
        let Some(scene) = self.resources.structures.get_mut(SCENE_STRUCTURE) else { return Ok(()) };
        if *placements == *self.placements {
            return Ok(());
        }
        let pairs = placements.iter().zip(&self.placements).enumerate();
        let changed: Vec<usize> = pairs
            .filter(|(_, (now, before))| now.mirrored != before.mirrored)
            .map(|(id, _)| id + 1)
            .collect();
        scene.place(&placed(placements))?;
        let scene = &*scene;
        self.frame.execute(&["build.scene".into()], |recorder, _| recorder.build_again(scene, &changed))?;
        self.placements = placements.to_vec();
        Ok(())
    }

    fn read(&mut self, buffer: &str) -> anyhow::Result<Vec<u8>> {
        let GpuRunner { frame, resources, .. } = self;
        let buffer = resources.buffers.get_mut(buffer).ok_or_else(|| unknown(buffer))?;
        Ok(buffer.read(frame)?)
    }

    fn run(&mut self, steps: &[Step]) -> anyhow::Result<Vec<StepTime>> {
        let names = steps.iter().filter_map(|step| match step {
            Step::Dispatch { pass, .. } => Some(*pass),
            _ => None,
        });
        self.passes.prepare(names, &self.resources)?;
        let GpuRunner { frame, passes, resources, .. } = self;
        let actions =
            steps.iter().map(|step| resolve(passes, resources, step)).collect::<Result<Vec<_>, _>>()?;
        let labels: Vec<_> = steps.iter().map(label).collect();
        let times = frame.execute(&labels, |recorder, index| actions[index].record(recorder))?;
        Ok(times.into_iter().map(|(pass, time)| StepTime { pass, time }).collect())
    }
}

/// Instances of the scene's structure: what stands still, and the meshes that move and can be seen.
fn placed(placements: &[Placement]) -> Vec<Placed> {
    let still = Placed { part: 0, to_world: Transform::IDENTITY, custom_index: 0 };
    let moving = placements.iter().enumerate().filter_map(|(id, placement)| {
        let to_world = placement.to_world?;
        Some(Placed { part: id + 1, to_world, custom_index: placement.first })
    });
    std::iter::once(still).chain(moving).collect()
}

/// A step with what it names looked up.
enum Action<'a> {
    Dispatch(&'a Pipeline, u32, &'a [u8]),
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
) -> Result<Action<'a>, VulkanError> {
    match step {
        Step::Dispatch { pass, count, params } => {
            Ok(Action::Dispatch(passes.get(pass)?, *count, bytemuck::bytes_of(params)))
        }
        Step::Clear { buffer } => {
            resources.buffers.get(buffer).map(Action::Clear).ok_or_else(|| unknown(buffer))
        }
        Step::BuildPoints { count } => {
            let points = resources.structures.get(POINTS_STRUCTURE);
            let points = points.ok_or(VulkanError::NotHardware { step: BUILD_POINTS })?;
            points.check(*count)?;
            Ok(Action::Build(points, *count))
        }
    }
}

fn label(step: &Step) -> String {
    match step {
        Step::Dispatch { pass, .. } => (*pass).into(),
        Step::Clear { buffer } => format!("clear.{buffer}"),
        Step::BuildPoints { .. } => BUILD_POINTS.into(),
    }
}

/// Every named buffer: those of the plan, and one a table.
fn allocate(
    memory: &Arc<Memory>,
    buffers: &[BufferSpec],
    tables: &[(&'static str, &[u8])],
) -> Result<HashMap<&'static str, Buffer>, VulkanError> {
    let tables = tables.iter().map(|&(name, bytes)| BufferSpec { name, bytes: bytes.len() });
    let mut named = HashMap::new();
    for BufferSpec { name, bytes } in buffers.iter().copied().chain(tables) {
        let buffer = memory.buffer(name, bytes as u64, Purpose::Data)?;
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
