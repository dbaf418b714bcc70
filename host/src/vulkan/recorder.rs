//! Recording of steps into a command buffer.

use ash::vk;

use super::bound::BoundPipeline;
use super::buffer::Buffer;
use super::context::Context;
use super::pipeline::INVOCATIONS_PER_ROW;
use super::structure::Hierarchy;

/// Command buffer that [`super::frame::FrameCommands::execute`] records.
pub struct Recorder<'a> {
    pub(super) context: &'a Context,
    pub(super) commands: vk::CommandBuffer,
}

impl Recorder<'_> {
    /// Runs a pass for each index below `count`, and for the further indices of the last workgroup.
    pub fn dispatch(&self, bound: &BoundPipeline, count: u32, push_constants: &[u8]) {
        let pipeline = &bound.pipeline;
        let groups = count.div_ceil(pipeline.entry.workgroup_size);
        let row = INVOCATIONS_PER_ROW / pipeline.entry.workgroup_size;
        let push_constants = &push_constants[..pipeline.entry.push_constant_bytes as usize];
        if groups == 0 {
            return;
        }
        let (device, commands) = (&self.context.raw, self.commands);
        let (point, stage) = (vk::PipelineBindPoint::COMPUTE, vk::ShaderStageFlags::COMPUTE);
        // SAFETY: the commands are being recorded; all objects are of this device and outlive the submission.
        unsafe {
            device.cmd_bind_pipeline(commands, point, pipeline.raw);
            device.cmd_bind_descriptor_sets(commands, point, pipeline.layout, 0, &[bound.set], &[]);
            if !push_constants.is_empty() {
                device.cmd_push_constants(commands, pipeline.layout, stage, 0, push_constants);
            }
            device.cmd_dispatch(commands, groups.min(row), groups.div_ceil(row), 1);
        }
    }

    /// Writes a few bytes to the beginning of a buffer, for all commands that follow.
    pub fn update(&self, buffer: &Buffer, bytes: &[u8]) {
        // SAFETY: the commands are being recorded; the bytes fit the buffer, and their number is a multiple of four.
        unsafe { self.context.raw.cmd_update_buffer(self.commands, buffer.raw, 0, bytes) };
        self.barrier();
    }

    /// Fills a buffer with zeros.
    pub fn clear(&self, buffer: &Buffer) {
        // SAFETY: the commands are being recorded; the size is a multiple of four.
        unsafe { self.context.raw.cmd_fill_buffer(self.commands, buffer.raw, 0, buffer.size, 0) };
    }

    /// Builds an acceleration structure over the first `count` primitives of its buffer.
    pub fn build(&self, hierarchy: &Hierarchy, count: u32) {
        hierarchy.record(self.commands, count, || self.barrier());
    }

    /// Updates a structure's instances to their new transforms, and rebuilds the bottom levels with changed triangles.
    pub fn build_again(&self, hierarchy: &Hierarchy, changed: &[usize]) {
        hierarchy.record_again(self.commands, changed, || self.barrier());
    }

    /// Copies bytes between buffers, each with an offset (bytes).
    pub(super) fn copy(&self, from: (&Buffer, u64), to: (&Buffer, u64), bytes: u64) {
        let region = vk::BufferCopy::default().src_offset(from.1).dst_offset(to.1).size(bytes);
        // SAFETY: the commands are being recorded; callers keep within both buffers.
        unsafe { self.context.raw.cmd_copy_buffer(self.commands, from.0.raw, to.0.raw, &[region]) };
    }

    /// Makes all writes visible to all following commands.
    pub(super) fn barrier(&self) {
        self.memory_barrier(
            vk::PipelineStageFlags::ALL_COMMANDS,
            vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE,
        );
    }

    /// Makes all writes visible to the host.
    pub(super) fn barrier_to_host(&self) {
        self.memory_barrier(vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ);
    }

    fn memory_barrier(&self, stage: vk::PipelineStageFlags, access: vk::AccessFlags) {
        let barrier = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
            .dst_access_mask(access)];
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        let none = vk::DependencyFlags::empty();
        // SAFETY: the commands are being recorded.
        unsafe {
            self.context.raw.cmd_pipeline_barrier(self.commands, all, stage, none, &barrier, &[], &[]);
        }
    }
}
