//! Command buffer that is recorded again for every frame, run to its end and timed step by step.

use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use ash::vk;

use super::context::Context;
use super::error::VulkanError;
use super::recorder::Recorder;

/// Timeout of a single wait (ns). The host waits again, since a frame may take minutes.
const WAIT_NS: u64 = 10_000_000_000;

/// Command buffer with its fence and its timestamp queries.
pub struct FrameCommands {
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    queries: vk::QueryPool,
    query_capacity: u32,
    context: Arc<Context>,
}

impl FrameCommands {
    /// Creates an empty command buffer of a device.
    pub fn new(context: &Arc<Context>) -> Result<FrameCommands, VulkanError> {
        let device = &context.raw;
        // On an error below, drop destroys the objects created so far.
        let mut frame = FrameCommands {
            pool: vk::CommandPool::null(),
            commands: vk::CommandBuffer::null(),
            fence: vk::Fence::null(),
            queries: vk::QueryPool::null(),
            query_capacity: 0,
            context: Arc::clone(context),
        };
        let info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(context.candidate.family);
        // SAFETY: the device is alive and the family the one of its queue.
        unsafe {
            frame.pool =
                device.create_command_pool(&info, None).map_err(VulkanError::call("vkCreateCommandPool"))?;
            let info =
                vk::CommandBufferAllocateInfo::default().command_pool(frame.pool).command_buffer_count(1);
            frame.commands = device
                .allocate_command_buffers(&info)
                .map_err(VulkanError::call("vkAllocateCommandBuffers"))?[0];
            frame.fence = device
                .create_fence(&vk::FenceCreateInfo::default(), None)
                .map_err(VulkanError::call("vkCreateFence"))?;
        }
        Ok(frame)
    }

    /// Records `record(recorder, i)` for each step with a full barrier behind it, runs the steps and waits for the end.
    ///
    /// Returns each step's name and its time between device timestamps. Without timestamps it returns one entry `frame`
    /// with the wall time. Fails if the validation layer reports any message.
    pub fn execute(
        &mut self,
        steps: &[String],
        record: impl Fn(&Recorder<'_>, usize),
    ) -> Result<Vec<(String, Duration)>, VulkanError> {
        if self.context.info().timestamps {
            self.grow_queries(steps.len() as u32 + 1)?;
        }
        self.record(steps, record)?;
        let start = Instant::now();
        self.submit().map_err(|error| {
            let error = lost(error, steps);
            if matches!(error, VulkanError::DeviceLost { .. }) {
                self.context.lose();
            }
            error
        })?;
        let wall = start.elapsed();
        self.context.messages().check()?;
        let times = if self.context.info().timestamps {
            steps.iter().cloned().zip(self.times(steps.len())?).collect()
        } else {
            vec![("frame".into(), wall)]
        };
        Ok(times)
    }

    fn record(&self, steps: &[String], record: impl Fn(&Recorder<'_>, usize)) -> Result<(), VulkanError> {
        let (device, commands) = (&self.context.raw, self.commands);
        let recorder = Recorder { context: &self.context, commands };
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the last submission has ended; beginning resets the command buffer.
        unsafe { device.begin_command_buffer(commands, &info) }
            .map_err(VulkanError::call("vkBeginCommandBuffer"))?;
        if self.query_capacity > 0 {
            // SAFETY: the commands are being recorded, outside a render pass.
            unsafe { device.cmd_reset_query_pool(commands, self.queries, 0, steps.len() as u32 + 1) };
        }
        self.timestamp(0);
        for (index, step) in steps.iter().enumerate() {
            self.context.labels.begin(commands, step);
            record(&recorder, index);
            recorder.barrier();
            self.timestamp(index as u32 + 1);
            self.context.labels.end(commands);
        }
        recorder.barrier_to_host();
        // SAFETY: the commands are being recorded.
        unsafe { device.end_command_buffer(commands) }.map_err(VulkanError::call("vkEndCommandBuffer"))
    }

    fn timestamp(&self, query: u32) {
        if self.query_capacity > 0 {
            let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
            // SAFETY: the commands are being recorded; the pool has this query, reset in the same commands.
            unsafe { self.context.raw.cmd_write_timestamp(self.commands, stage, self.queries, query) };
        }
    }

    fn submit(&self) -> Result<(), VulkanError> {
        let device = &self.context.raw;
        let (fences, commands) = ([self.fence], [self.commands]);
        let submit = vk::SubmitInfo::default().command_buffers(&commands);
        // SAFETY: the fence is not in use and the commands are recorded; `&mut self` above keeps others away.
        unsafe {
            device.reset_fences(&fences).map_err(VulkanError::call("vkResetFences"))?;
            let queue = self.context.queue.lock().unwrap_or_else(PoisonError::into_inner);
            device.queue_submit(*queue, &[submit], self.fence).map_err(VulkanError::call("vkQueueSubmit"))?;
            drop(queue);
            loop {
                match device.wait_for_fences(&fences, true, WAIT_NS) {
                    Err(vk::Result::TIMEOUT) => {}
                    ended => return ended.map_err(VulkanError::call("vkWaitForFences")),
                }
            }
        }
    }

    fn times(&self, steps: usize) -> Result<Vec<Duration>, VulkanError> {
        let mut stamps = vec![0u64; steps + 1];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: the queries were written by the submission that has ended.
        unsafe { self.context.raw.get_query_pool_results(self.queries, 0, &mut stamps, flags) }
            .map_err(VulkanError::call("vkGetQueryPoolResults"))?;
        let candidate = &self.context.candidate;
        let mask = u64::MAX >> (64 - candidate.timestamp_bits.clamp(1, 64));
        let period = f64::from(candidate.properties.limits.timestamp_period);
        let time = |pair: &[u64]| (pair[1].wrapping_sub(pair[0]) & mask) as f64 * period;
        Ok(stamps.windows(2).map(|pair| Duration::from_nanos(time(pair) as u64)).collect())
    }

    fn grow_queries(&mut self, count: u32) -> Result<(), VulkanError> {
        if count <= self.query_capacity {
            return Ok(());
        }
        let count = count.next_power_of_two();
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(count);
        // SAFETY: nothing is submitted, so the old pool is not in use; a null pool is ignored.
        unsafe {
            self.context.raw.destroy_query_pool(self.queries, None);
            (self.queries, self.query_capacity) = (vk::QueryPool::null(), 0);
            self.queries = self
                .context
                .raw
                .create_query_pool(&info, None)
                .map_err(VulkanError::call("vkCreateQueryPool"))?;
        }
        self.query_capacity = count;
        Ok(())
    }
}

impl Drop for FrameCommands {
    fn drop(&mut self) {
        let device = &self.context.raw;
        // SAFETY: `execute` waits for what it submits; null handles are ignored.
        unsafe {
            device.destroy_query_pool(self.queries, None);
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
        }
    }
}

/// Adds the names of the submitted steps to the error of a lost device.
fn lost(error: VulkanError, steps: &[String]) -> VulkanError {
    match error {
        VulkanError::Call { result: vk::Result::ERROR_DEVICE_LOST, .. } => VulkanError::DeviceLost {
            last: steps.last().cloned().unwrap_or_default(),
            submitted: steps.join(", "),
        },
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_device_names_the_passes() {
        let error = VulkanError::call("vkWaitForFences")(vk::Result::ERROR_DEVICE_LOST);
        let message = lost(error, &["collect".into(), "shoot".into()]).to_string();
        assert!(message.contains("`collect, shoot`, last pass `shoot`"), "{message}");
    }
}
