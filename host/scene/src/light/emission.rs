//! Mean emission of a triangle, which determines its selection probability.

use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::{FLAG_BLEND, FLAG_CUT_OUT, FLAG_EMISSIVE_TEXTURE};
use caustics_kernels::interface::scene::SceneTables;
use caustics_kernels::texture::emission::emission_at;
use glam::DVec3;

/// Maximum number of samples on all triangles. Above it, selection probabilities are less exact; the light is not.
const MAX_POSITIONS: f32 = 1.0e7;
/// Minimum and maximum number of steps along a triangle's edge.
const STEPS: (f32, f32) = (8.0, 1000.0);

/// Light that samples may have missed, in samples of full emission.
const MISSED: f64 = 0.01;
/// Flags of materials whose emission varies over a triangle or is reduced by alpha.
const VARIES: u32 = FLAG_EMISSIVE_TEXTURE | FLAG_CUT_OUT | FLAG_BLEND;

/// Mean radiance over a triangle (W m^-2 sr^-1), with texture and alpha, from samples half a texel apart. Where these are too many, samples
/// are of coarser levels of the texture.
pub fn mean(scene: SceneTables<'_>, triangle: u32) -> DVec3 {
    let id = scene.surfaces[triangle as usize].material as usize;
    let material = &scene.materials[id];
    let emission = material.emission.as_dvec3();
    if emission == DVec3::ZERO || material.flags & VARIES == 0 {
        return emission;
    }
    let record = scene.textures.material_textures[id];
    let (mut texels, mut longest) = (1.0_f32, 0.0_f32);
    if let Some(coordinates) = scene.textures.texture_coordinates.get(triangle as usize) {
        let (b, c) = (coordinates.uv_b - coordinates.uv_a, coordinates.uv_c - coordinates.uv_a);
        longest = b.length().max(c.length()).max((c - b).length());
        for texture in [record.emissive, record.base_color] {
            if let Some(texture) = scene.textures.textures.get(texture as usize) {
                texels = texels.max(longest * texture.width.max(texture.height) as f32);
            }
        }
    }
    let max_steps = (MAX_POSITIONS / scene.triangles.len() as f32).sqrt().clamp(STEPS.0, STEPS.1);
    let steps = (2.0 * texels).clamp(STEPS.0, max_steps).ceil() as u32;
    let footprint = if 2.0 * texels > steps as f32 { longest / steps as f32 } else { 0.0 };

    // Sample the centres of upright and inverted sub-triangles.
    let mut sum = DVec3::ZERO;
    for row in 0..steps {
        for column in 0..steps - row {
            for third in [1.0, 2.0] {
                if third == 2.0 && column + row + 1 == steps {
                    continue;
                }
                let at = |step: u32| (step as f32 + third / 3.0) / steps as f32;
                let (u, v) = (at(column), at(row));
                sum += emission_at(scene, Features::ALL, triangle, u, v, footprint).as_dvec3();
            }
        }
    }
    if footprint > 0.0 && sum == DVec3::ZERO {
        // A triangle without light is no emitter. Samples that are too few may have missed all lit texels.
        sum = DVec3::splat(MISSED);
    }
    emission * sum / (f64::from(steps) * f64::from(steps))
}
