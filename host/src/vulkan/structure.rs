//! Acceleration structures: bottom levels over the primitives of buffers, and a top level over their instances.
//!
//! The device builds them into storage that is allocated once for the maximum count. Builds on the host and indirect builds
//! are not used: lavapipe supports neither.

use std::sync::Arc;

use ash::vk;
use caustics_kernels::interface::instance::Transform;

use super::buffer::{Buffer, Purpose};
use super::context::Context;
use super::error::VulkanError;
use super::memory::DeviceAllocator;
use super::primitives::Primitives;

/// Primitives of one bottom level in a buffer.
#[derive(Clone, Copy)]
pub struct BlasGeometry<'a> {
    /// Buffer, which must outlive the structure.
    pub buffer: &'a Buffer,
    /// Index of the first primitive.
    pub first: u64,
    /// Maximum number of primitives.
    pub capacity: u64,
}

/// Instance of a bottom level.
#[derive(Clone, Copy)]
pub struct TlasInstance {
    /// Index of the bottom level.
    pub part: usize,
    /// Transform from instance space to world space.
    pub to_world: Transform,
    /// Index of the instance that kernels read; 24 bits.
    pub custom_index: u32,
}

/// Top-level structure with instances of bottom levels.
pub struct Hierarchy {
    name: &'static str,
    primitives: Primitives,
    bottoms: Vec<Bottom>,
    top: Structure,
    instances: Buffer,
    instance_count: u32,
    scratch: Buffer,
    context: Arc<Context>,
}

struct Bottom {
    structure: Structure,
    address: u64,
    capacity: u32,
}

impl Hierarchy {
    /// Allocates a structure over at most `capacity` primitives at the beginning of a buffer, which must outlive it. This
    /// does not build it.
    pub fn new(
        memory: &Arc<DeviceAllocator>,
        name: &'static str,
        primitives: Primitives,
        buffer: &Buffer,
        capacity: u64,
    ) -> Result<Hierarchy, VulkanError> {
        Self::from_parts(memory, name, primitives, &[BlasGeometry { buffer, first: 0, capacity }], 1)
    }

    /// Allocates a structure over parts of buffers with at most `max_instances` instances. At first, the first part has one
    /// instance with the identity.
    pub fn from_parts(
        memory: &Arc<DeviceAllocator>,
        name: &'static str,
        primitives: Primitives,
        parts: &[BlasGeometry<'_>],
        max_instances: u32,
    ) -> Result<Hierarchy, VulkanError> {
        let context = Arc::clone(&memory.context);
        let mut bottoms = Vec::with_capacity(parts.len());
        let mut scratch_bytes = 0;
        for (id, part) in parts.iter().enumerate() {
            // Vertex indices have 32 bits.
            let limit = context.candidate.max_primitives.min(u64::from(u32::MAX / 3));
            let limit = limit.min((part.buffer.bytes() / primitives.stride()).saturating_sub(part.first));
            if part.capacity > limit {
                return Err(VulkanError::TooManyPrimitives { structure: name, count: part.capacity, limit });
            }
            let capacity = part.capacity as u32;
            let address = part.buffer.address() + part.first * primitives.stride();
            let geometry = primitives.geometry(address, capacity);
            let label = if id == 0 { format!("{name}.bottom") } else { format!("{name}.bottom.{id}") };
            let (structure, scratch) =
                Structure::new(memory, &label, Level::Bottom, primitives, geometry, capacity)?;
            scratch_bytes = scratch.max(scratch_bytes);
            bottoms.push(Bottom { structure, address, capacity });
        }
        let bytes = u64::from(max_instances) * INSTANCE_BYTES as u64;
        let instances = Buffer::new(memory, &format!("{name}.instances"), bytes, Purpose::Instances)?;
        let (top, top_scratch) = Structure::new(
            memory,
            name,
            Level::Top,
            primitives,
            instance_geometry(&instances),
            max_instances,
        )?;
        // All builds share the scratch buffer. Its address is rounded up on use.
        let bytes = scratch_bytes.max(top_scratch) + context.candidate.scratch_alignment;
        let scratch = Buffer::new(memory, &format!("{name}.scratch"), bytes, Purpose::Scratch)?;
        let mut hierarchy =
            Hierarchy { name, primitives, bottoms, top, instances, instance_count: 0, scratch, context };
        hierarchy.set_instances(&[TlasInstance {
            part: 0,
            to_world: Transform::IDENTITY,
            custom_index: 0,
        }])?;
        Ok(hierarchy)
    }

    /// Fails if `count` exceeds the allocated number of primitives.
    pub fn check(&self, count: u32) -> Result<(), VulkanError> {
        let capacity = self.bottoms.first().map_or(0, |bottom| bottom.capacity);
        if count <= capacity {
            return Ok(());
        }
        let (count, limit) = (u64::from(count), u64::from(capacity));
        Err(VulkanError::TooManyPrimitives { structure: self.name, count, limit })
    }

    /// Sets the instances for the next build of the top level. The device must be idle.
    pub fn set_instances(&mut self, tlas_instances: &[TlasInstance]) -> Result<(), VulkanError> {
        let records = self.instances.mapped_or_fail()?;
        for (record, tlas_instance) in
            records.as_chunks_mut::<INSTANCE_BYTES>().0.iter_mut().zip(tlas_instances)
        {
            *record = instance(tlas_instance, self.bottoms[tlas_instance.part].structure.address);
        }
        self.instance_count = tlas_instances.len() as u32;
        Ok(())
    }

    /// Returns the top level, which kernels bind.
    pub(super) fn top(&self) -> vk::AccelerationStructureKHR {
        self.top.raw
    }

    /// Records the build of all levels. The first bottom level has its buffer's first `count` primitives; `barrier` orders
    /// the builds.
    pub(super) fn record(&self, commands: vk::CommandBuffer, count: u32, barrier: impl Fn()) {
        for id in 0..self.bottoms.len() {
            let capacity = self.bottoms[id].capacity;
            self.record_bottom(commands, id, if id == 0 { count.min(capacity) } else { capacity });
            barrier();
        }
        self.record_top(commands);
    }

    /// Records the build of a bottom level over the first `count` primitives of its part.
    fn record_bottom(&self, commands: vk::CommandBuffer, part: usize, count: u32) {
        let Bottom { structure, address, .. } = &self.bottoms[part];
        self.record_level(
            commands,
            structure,
            Level::Bottom,
            self.primitives.geometry(*address, count),
            count,
        );
    }

    /// Records the build of the top level over the current instances.
    fn record_top(&self, commands: vk::CommandBuffer) {
        let geometry = instance_geometry(&self.instances);
        self.record_level(commands, &self.top, Level::Top, geometry, self.instance_count);
    }

    /// Records the update of the instances' transforms, and the builds of bottom levels with changed triangles.
    pub(super) fn record_again(&self, commands: vk::CommandBuffer, changed: &[usize], barrier: impl Fn()) {
        for &part in changed {
            self.record_bottom(commands, part, self.bottoms[part].capacity);
            barrier();
        }
        self.record_top(commands);
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

/// Size of an instance in its buffer (bytes).
const INSTANCE_BYTES: usize = 64;

/// Level of a hierarchy.
#[derive(Clone, Copy)]
enum Level {
    Bottom,
    Top,
}

/// Acceleration structure with its storage.
struct Structure {
    raw: vk::AccelerationStructureKHR,
    address: u64,
    context: Arc<Context>,
    // Fields drop after `drop`, which destroys the structure in this storage.
    _storage: Buffer,
}

impl Structure {
    /// Allocates a structure and returns it with the size of its scratch buffer (bytes).
    fn new(
        memory: &Arc<DeviceAllocator>,
        name: &str,
        level: Level,
        primitives: Primitives,
        geometry: vk::AccelerationStructureGeometryKHR<'_>,
        count: u32,
    ) -> Result<(Structure, u64), VulkanError> {
        let context = &memory.context;
        let device =
            context.structures.as_ref().ok_or_else(|| VulkanError::NotHardware { step: "build".into() })?;
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
        let storage = Buffer::new(memory, name, sizes.acceleration_structure_size, Purpose::Structure)?;
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

/// Returns the record of an instance.
fn instance(tlas_instance: &TlasInstance, bottom: u64) -> [u8; INSTANCE_BYTES] {
    let Transform { x, y, z, offset } = tlas_instance.to_world;
    let matrix = [
        x.x, y.x, z.x, offset.x, //
        x.y, y.y, z.y, offset.y, //
        x.z, y.z, z.z, offset.z,
    ];
    let flags = vk::GeometryInstanceFlagsKHR::TRIANGLE_FACING_CULL_DISABLE;
    let instance = vk::AccelerationStructureInstanceKHR {
        transform: vk::TransformMatrixKHR { matrix },
        instance_custom_index_and_mask: vk::Packed24_8::new(tlas_instance.custom_index, 0xff),
        instance_shader_binding_table_record_offset_and_flags: vk::Packed24_8::new(0, flags.as_raw() as u8),
        acceleration_structure_reference: vk::AccelerationStructureReferenceKHR { device_handle: bottom },
    };
    // SAFETY: the instance is plain data of 64 bytes without padding.
    unsafe { std::mem::transmute::<vk::AccelerationStructureInstanceKHR, [u8; INSTANCE_BYTES]>(instance) }
}

fn instance_geometry(instances: &Buffer) -> vk::AccelerationStructureGeometryKHR<'static> {
    let data = vk::DeviceOrHostAddressConstKHR { device_address: instances.address() };
    let instances = vk::AccelerationStructureGeometryInstancesDataKHR::default().data(data);
    vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::INSTANCES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { instances })
}
