//! Entry points that trace in software.

use crate::entry::tracing::tracing_entries;
use crate::interface::tree::{TreeNode, TriangleBlock};
use crate::trace::bvh::BvhTracer;

tracing_entries!(
    [
        #[spirv(storage_buffer, descriptor_set = 0, binding = 16)] nodes: &[TreeNode],
        #[spirv(storage_buffer, descriptor_set = 0, binding = 17)] blocks: &[TriangleBlock],
        #[spirv(storage_buffer, descriptor_set = 0, binding = 18)] instances: &[Instance],
    ],
    |cut_outs| BvhTracer { nodes, blocks, instances, cut_outs }
);
