//! A floor for scenes without one, which receives their caustics.

use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::texture::MaterialTextures;
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::Vec3;

use super::SceneParts;
use super::texture::CornerCoordinates;

/// Half side of the floor, in radii of the bounds above it.
const REACH: f32 = 5.0;
/// Gap below the bounds, in radii; coinciding faces would leave the nearest hit to rounding.
const GAP: f32 = 1e-4;
/// Albedo of the floor.
const ALBEDO: f32 = 0.5;

impl SceneParts {
    /// Adds a Lambertian square under the bounds. [`Scene::bounds`](super::Scene::bounds) excludes the floor.
    pub fn add_floor(&mut self) {
        let [lower, upper] = self.bounds();
        self.bounds = Some([lower, upper]);
        let (centre, radius) = (0.5 * (lower + upper), 0.5 * lower.distance(upper));
        let (y, reach) = (lower.y - GAP * radius, REACH * radius);
        let corner = |x: f32, z: f32| Vec3::new(centre.x + x * reach, y, centre.z + z * reach);
        let [a, b, c, d] = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
        let material = self.materials.len() as u32;
        let (normal_a, normal_b, normal_c) = (Vec3::Y, Vec3::Y, Vec3::Y);
        for triangle in [Triangle { a, b, c }, Triangle { a, b: c, c: d }] {
            self.triangles.push(triangle);
            let surface =
                TriangleSurface { normal_a, normal_b, normal_c, material, ..TriangleSurface::default() };
            self.surfaces.push(surface);
            if !self.textures.textures.is_empty() {
                self.textures.coordinates.push(CornerCoordinates::default());
            }
        }
        let base_color = Vec3::splat(ALBEDO);
        self.materials.push(Material { base_color, roughness: 1.0, ior: 1.5, ..Material::default() });
        self.material_names.push("floor".into());
        if !self.textures.materials.is_empty() {
            self.textures.materials.push(MaterialTextures::default());
        }
    }
}
