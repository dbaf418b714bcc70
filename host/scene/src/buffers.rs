//! The scene's tables as the buffers that runners hold.

use bytemuck::cast_slice;

use super::Scene;

impl Scene {
    /// The tables, each with the name that kernels bind it by.
    pub fn buffers(&self) -> [(&'static str, &[u8]); 18] {
        let textures = &self.textures;
        [
            ("triangles", cast_slice(&self.triangles)),
            ("surfaces", cast_slice(&self.surfaces)),
            ("materials", cast_slice(&self.materials)),
            ("lights", cast_slice(&self.lights)),
            ("light_bvh", cast_slice(&self.light_bvh)),
            ("environment", cast_slice(&self.environment.records)),
            ("environment_texels", cast_slice(&self.environment.texels)),
            ("environment_cdf", cast_slice(&self.environment.cdf)),
            ("instances", cast_slice(&self.instances)),
            ("nodes", cast_slice(&self.nodes)),
            ("blocks", cast_slice(&self.blocks)),
            ("textures", cast_slice(&textures.textures)),
            ("material_textures", cast_slice(&textures.materials)),
            ("texture_coordinates", cast_slice(&textures.coordinates)),
            ("texels_0", cast_slice(textures.chunk(0))),
            ("texels_1", cast_slice(textures.chunk(1))),
            ("texels_2", cast_slice(textures.chunk(2))),
            ("texels_3", cast_slice(textures.chunk(3))),
        ]
    }
}
