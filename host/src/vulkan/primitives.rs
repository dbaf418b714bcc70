//! Primitives of acceleration structures.

use ash::vk;

/// Kind of a structure's primitives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primitives {
    /// Opaque triangles, three vertices of 12 bytes each. They are built once and optimised for tracing.
    Triangles,
    /// Triangles that may have holes: the query must confirm each hit.
    TrianglesWithHoles,
    /// Boxes of 24 bytes, each reported to a query once. They are rebuilt every frame and optimised for building.
    Boxes,
}

impl Primitives {
    /// Size of a primitive in its buffer (bytes).
    pub fn stride(self) -> u64 {
        match self {
            Primitives::Triangles | Primitives::TrianglesWithHoles => 36,
            Primitives::Boxes => 24,
        }
    }

    pub(super) fn flags(self) -> vk::BuildAccelerationStructureFlagsKHR {
        match self {
            Primitives::Triangles | Primitives::TrianglesWithHoles => {
                vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE
            }
            Primitives::Boxes => vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_BUILD,
        }
    }

    pub(super) fn geometry(self, address: u64, count: u32) -> vk::AccelerationStructureGeometryKHR<'static> {
        let data = vk::DeviceOrHostAddressConstKHR { device_address: address };
        let geometry = vk::AccelerationStructureGeometryKHR::default();
        match self {
            Primitives::Triangles | Primitives::TrianglesWithHoles => {
                let flags = if self == Primitives::Triangles {
                    vk::GeometryFlagsKHR::OPAQUE
                } else {
                    vk::GeometryFlagsKHR::NO_DUPLICATE_ANY_HIT_INVOCATION
                };
                let triangles = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
                    .vertex_format(vk::Format::R32G32B32_SFLOAT)
                    .vertex_data(data)
                    .vertex_stride(12)
                    .max_vertex((3 * count).max(1) - 1)
                    .index_type(vk::IndexType::NONE_KHR);
                geometry
                    .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
                    .geometry(vk::AccelerationStructureGeometryDataKHR { triangles })
                    .flags(flags)
            }
            Primitives::Boxes => {
                let aabbs =
                    vk::AccelerationStructureGeometryAabbsDataKHR::default().data(data).stride(self.stride());
                geometry
                    .geometry_type(vk::GeometryTypeKHR::AABBS)
                    .geometry(vk::AccelerationStructureGeometryDataKHR { aabbs })
                    .flags(vk::GeometryFlagsKHR::NO_DUPLICATE_ANY_HIT_INVOCATION)
            }
        }
    }
}
