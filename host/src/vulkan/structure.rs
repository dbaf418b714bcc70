//! Acceleration structures: one bottom level over a buffer's primitives, one instance of it on top.
//!
//! Built on the device, into storage allocated once for the largest count. Not built by the host nor indirectly:
//! lavapipe can do neither.

use std::sync::Arc;

use ash::vk;

use super::buffer::Buffer;
use super::context::Context;
use super::error::VulkanError;
use super::memory::{Memory, Purpose};
use super::primitives::Primitives;

/// A top-level structure with one instance of a bottom-level structure over a buffer.
pub struct Hierarchy {
    name: &'static str,
    primitives: Primitives,
    primitive_address: u64,
    capacity: u32,
    bottom: Structure,
    top: Structure,
    instances: Buffer,
    scratch: Buffer,
    context: Arc<Context>,
}

impl Hierarchy {
    /// Allocates a structure over at most `capacity` primitives of a buffer that must outlive it. It is not built yet.
    pub fn new(
        memory: &Arc<Memory>,
        name: &'static str,
        primitives: Primitives,
        buffer: &Buffer,
        capacity: u64,
    ) -> Result<Hierarchy, VulkanError> {
        let context = Arc::clone(&memory.context);
        // Vertices are counted in 32 bits.
        let limit = context.candidate.max_primitives.min(u64::from(u32::MAX / 3));
        let limit = limit.min(buffer.bytes() / primitives.stride());
        if capacity > limit {
            return Err(VulkanError::TooManyPrimitives { structure: name, count: capacity, limit });
        }
        let capacity = capacity as u32;

        let primitive_address = buffer.address();
        let geometry = primitives.geometry(primitive_address, capacity);
        let (bottom, bottom_scratch) =
            Structure::new(memory, &format!("{name}.bottom"), Level::Bottom, primitives, geometry, capacity)?;
        let instances = instance(memory, name, bottom.address)?;
        let (top, top_scratch) =
            Structure::new(memory, name, Level::Top, primitives, instance_geometry(&instances), 1)?;
        // Both builds share the scratch; its address is rounded up when used.
        let bytes = bottom_scratch.max(top_scratch) + context.candidate.scratch_alignment;
        let scratch = memory.buffer(&format!("{name}.scratch"), bytes, Purpose::Scratch)?;
        Ok(Hierarchy {
            name,
            primitives,
            primitive_address,
            capacity,
            bottom,
            top,
            instances,
            scratch,
            context,
        })
    }

    /// Fails if `count` primitives are more than was allocated for.
    pub fn check(&self, count: u32) -> Result<(), VulkanError> {
        if count <= self.capacity {
            return Ok(());
        }
        let (count, limit) = (u64::from(count), u64::from(self.capacity));
        Err(VulkanError::TooManyPrimitives { structure: self.name, count, limit })
    }

    /// What kernels bind.
    pub(super) fn top(&self) -> vk::AccelerationStructureKHR {
        self.top.raw
    }

    /// Records the build over the buffer's first primitives; `barrier` orders the two levels.
    pub(super) fn record(&self, commands: vk::CommandBuffer, count: u32, barrier: impl FnOnce()) {
        let geometry = self.primitives.geometry(self.primitive_address, count);
        self.record_level(commands, &self.bottom, Level::Bottom, geometry, count.min(self.capacity));
        barrier();
        self.record_level(commands, &self.top, Level::Top, instance_geometry(&self.instances), 1);
    }

    fn record_level(
        &self,
        commands: vk::CommandBuffer,
        structure: &Structure,
        level: Level,
        geometry: vk::AccelerationStructureGeometryKHR<'_>,
        count: u32,
    ) {
        let Some(device) = &self.context.structures else { return };
        let scratch =
            self.scratch.address().next_multiple_of(self.context.candidate.scratch_alignment.max(1));
        let geometries = [geometry];
        let info = build_info(level, self.primitives, &geometries)
            .dst_acceleration_structure(structure.raw)
            .scratch_data(vk::DeviceOrHostAddressKHR { device_address: scratch });
        let range = [vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(count)];
        // SAFETY: the commands are being recorded; storage, scratch and input are alive and large enough.
        unsafe { device.cmd_build_acceleration_structures(commands, &[info], &[&range]) };
    }
}

/// The two levels of a hierarchy.
#[derive(Clone, Copy)]
enum Level {
    Bottom,
    Top,
}

/// An acceleration structure with its storage.
struct Structure {
    raw: vk::AccelerationStructureKHR,
    address: u64,
    context: Arc<Context>,
    // Freed after the structure itself, which `drop` destroys.
    _storage: Buffer,
}

impl Structure {
    /// Allocates a structure and says how much scratch its build needs [bytes].
    fn new(
        memory: &Arc<Memory>,
        name: &str,
        level: Level,
        primitives: Primitives,
        geometry: vk::AccelerationStructureGeometryKHR<'_>,
        count: u32,
    ) -> Result<(Structure, u64), VulkanError> {
        let context = &memory.context;
        let device = context.structures.as_ref().ok_or(VulkanError::NotHardware { step: "build" })?;
        let geometries = [geometry];
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        // SAFETY: one geometry, one count.
        unsafe {
            device.get_acceleration_structure_build_sizes(
                vk::AccelerationStructureBuildTypeKHR::DEVICE,
                &build_info(level, primitives, &geometries),
                &[count],
                &mut sizes,
            );
        }
        let storage = memory.buffer(name, sizes.acceleration_structure_size, Purpose::Structure)?;
        let info = vk::AccelerationStructureCreateInfoKHR::default()
            .buffer(storage.raw)
            .size(sizes.acceleration_structure_size)
            .ty(structure_type(level));
        // SAFETY: the storage is as large as the device asked for.
        let raw = unsafe { device.create_acceleration_structure(&info, None) }
            .map_err(VulkanError::call("vkCreateAccelerationStructureKHR"))?;
        context.labels.name(raw, name);
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(raw);
        // SAFETY: the structure is alive.
        let address = unsafe { device.get_acceleration_structure_device_address(&info) };
        let structure = Structure { raw, address, context: Arc::clone(context), _storage: storage };
        Ok((structure, sizes.build_scratch_size))
    }
}

impl Drop for Structure {
    fn drop(&mut self) {
        if let Some(device) = &self.context.structures {
            // SAFETY: the device does not use it.
            unsafe { device.destroy_acceleration_structure(self.raw, None) };
        }
    }
}

fn structure_type(level: Level) -> vk::AccelerationStructureTypeKHR {
    match level {
        Level::Bottom => vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL,
        Level::Top => vk::AccelerationStructureTypeKHR::TOP_LEVEL,
    }
}

fn build_info<'a>(
    level: Level,
    primitives: Primitives,
    geometries: &'a [vk::AccelerationStructureGeometryKHR<'a>],
) -> vk::AccelerationStructureBuildGeometryInfoKHR<'a> {
    vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(structure_type(level))
        .flags(primitives.flags())
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(geometries)
}

/// A buffer with one instance of a bottom-level structure, untransformed.
fn instance(memory: &Arc<Memory>, name: &str, bottom: u64) -> Result<Buffer, VulkanError> {
    let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let flags = vk::GeometryInstanceFlagsKHR::TRIANGLE_FACING_CULL_DISABLE;
    let instance = vk::AccelerationStructureInstanceKHR {
        transform: vk::TransformMatrixKHR { matrix: identity },
        instance_custom_index_and_mask: vk::Packed24_8::new(0, 0xff),
        instance_shader_binding_table_record_offset_and_flags: vk::Packed24_8::new(0, flags.as_raw() as u8),
        acceleration_structure_reference: vk::AccelerationStructureReferenceKHR { device_handle: bottom },
    };
    // SAFETY: the instance is plain data of 64 bytes without padding.
    let bytes = unsafe { std::mem::transmute::<vk::AccelerationStructureInstanceKHR, [u8; 64]>(instance) };
    let mut buffer = memory.buffer(&format!("{name}.instances"), 64, Purpose::Instances)?;
    buffer.mapped_or_fail()?[..64].copy_from_slice(&bytes);
    Ok(buffer)
}

fn instance_geometry(instances: &Buffer) -> vk::AccelerationStructureGeometryKHR<'static> {
    let data = vk::DeviceOrHostAddressConstKHR { device_address: instances.address() };
    let instances = vk::AccelerationStructureGeometryInstancesDataKHR::default().data(data);
    vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::INSTANCES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { instances })
}
