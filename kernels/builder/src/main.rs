//! Compiles `kernels/` to SPIR-V.
use spirv_builder::{Capability, SpirvBuilder, SpirvMetadata};
use std::path::Path;
fn main() -> anyhow::Result<()> {
    let kernels = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    for (name, rq) in [("base", false), ("rayquery", true)] {
        let mut b = SpirvBuilder::new(kernels, "spirv-unknown-vulkan1.2")
            .deny_warnings(false)
            .spirv_metadata(SpirvMetadata::NameVariables)
            .capability(Capability::VulkanMemoryModelDeviceScope)
            .scalar_block_layout(true);
        if rq { b = b.capability(Capability::RayQueryKHR).extension("SPV_KHR_ray_query").shader_crate_features(["ray-query".to_string()]); }
        let r = b.build()?;
        std::fs::copy(r.module.unwrap_single(), kernels.join(format!("{name}.spv")))?;
    }
    Ok(())
}
