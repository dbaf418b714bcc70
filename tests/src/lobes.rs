//! A scene with every lobe: a ball of each material over a floor, under a triangle and a point light.

use caustics::scene::{EnvironmentMap, LightShape, PunctualLight, Scene, SceneCamera, SceneParts};
use caustics_kernels::interface::material::{FLAG_EMIT_BOTH_SIDES, FLAG_THIN, Material};
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::Vec3;

const BASE: Material = Material {
    base_color: Vec3::new(0.8, 0.5, 0.3),
    roughness: 1.0,
    emission: Vec3::ZERO,
    metallic: 0.0,
    absorption: Vec3::ZERO,
    ior: 1.5,
    transmission: 0.0,
    specular: 0.0,
    flags: 0,
    priority: 0,
    dispersion: 0.0,
    medium: 0,
};

/// Materials with their names; the first is the floor's, the last the light's.
fn materials() -> Vec<(&'static str, Material)> {
    let metal = Material { metallic: 1.0, ..BASE };
    let coat = Material { specular: 1.0, ..BASE };
    let glass = Material { transmission: 1.0, specular: 1.0, roughness: 0.0, ..BASE };
    vec![
        ("lambert", BASE),
        ("mirror", Material { roughness: 0.0, ..metal }),
        ("polished metal", Material { roughness: 0.1, ..metal }),
        ("rough metal", Material { roughness: 0.6, ..metal }),
        ("smooth coat", Material { roughness: 0.1, ..coat }),
        ("rough coat", Material { roughness: 0.5, ior: 1.8, ..coat }),
        ("half metal", Material { metallic: 0.5, roughness: 0.4, ..coat }),
        ("thin glass", Material { flags: FLAG_THIN, ..glass }),
        ("absorbing glass", Material { absorption: Vec3::new(0.1, 2.0, 5.0), ..glass }),
        ("dispersive glass", Material { dispersion: 2.0, ..glass }),
        ("rough dispersive glass", Material { dispersion: 2.0, roughness: 0.3, ..glass }),
        ("half glass", Material { transmission: 0.5, roughness: 0.2, ..glass }),
        ("rough glass", Material { roughness: 0.25, ior: 1.33, ..glass }),
        ("rougher glass", Material { roughness: 0.6, ior: 1.8, ..glass }),
        ("rough thin glass", Material { roughness: 0.4, flags: FLAG_THIN, ..glass }),
        ("light", Material { emission: Vec3::new(9.0, 8.0, 7.0), flags: FLAG_EMIT_BOTH_SIDES, ..BASE }),
    ]
}

/// Builds the scene.
pub fn scene() -> Scene {
    let (names, materials): (Vec<_>, Vec<_>) =
        materials().into_iter().map(|(name, material)| (name.to_string(), material)).unzip();
    let (mut triangles, mut surfaces) = (vec![], vec![]);
    let mut add = |corners: [Vec3; 3], normals: [Vec3; 3], material: usize| {
        let ([a, b, c], [normal_a, normal_b, normal_c]) = (corners, normals);
        triangles.push(Triangle { a, b, c });
        let material = material as u32;
        surfaces.push(TriangleSurface { normal_a, normal_b, normal_c, material, ..Default::default() });
    };

    let last = materials.len() - 1;
    let mut flat = |corners: [Vec3; 3], material| {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        add(corners, [normal; 3], material);
    };
    let (x, z) = (5.5, 2.0);
    let floor = [Vec3::new(-x, 0.0, -z), Vec3::new(-x, 0.0, z), Vec3::new(x, 0.0, z), Vec3::new(x, 0.0, -z)];
    flat([floor[0], floor[1], floor[2]], 0);
    flat([floor[0], floor[2], floor[3]], 0);
    flat([Vec3::new(-1.0, 2.5, -1.0), Vec3::new(1.0, 2.5, -1.0), Vec3::new(0.0, 2.5, 1.0)], last);

    for material in 1..last {
        let centre = Vec3::new(0.75 * (material as f32 - 0.5 * last as f32), 0.6, 0.0);
        for direction in ball() {
            add(direction.map(|d| centre + d * 0.35), direction, material);
        }
    }
    let point = PunctualLight::point(Vec3::new(1.5, 2.0, 1.0), Vec3::new(2.0, 3.0, 4.0));
    // Cone wide enough that the scene's origin lies in the falloff, where single steps sample lights.
    let direction = Vec3::new(0.0, -1.0, 0.0);
    let spot = PunctualLight {
        position: Vec3::new(-1.0, 2.0, 1.0),
        shape: LightShape::Spot { direction, inner: 0.3, outer: 0.9 },
        ..point
    };
    let direction = Vec3::new(0.36, -0.8, 0.48);
    // Keep it dimmer than the others, because its light does not vary over a floor.
    let intensity = 0.05 * point.intensity;
    let sun = PunctualLight { intensity, shape: LightShape::Directional { direction }, ..point };
    let eye = Vec3::new(0.0, 1.5, 4.0);
    let camera = SceneCamera::look_at("eye", eye, Vec3::new(0.0, 0.5, 0.0), Vec3::Y, 1.2);
    let parts = SceneParts {
        name: "lobes".into(),
        triangles,
        surfaces,
        materials,
        material_names: names,
        lights: vec![point, spot, sun],
        cameras: vec![camera],
        ..SceneParts::default()
    };
    let mut scene = parts.build().expect("the scene is sound");
    let sky = [0.04, 0.02, 0.01].map(Vec3::splat).to_vec();
    scene.set_environment(EnvironmentMap::new(1, 3, sky)).expect("the sky is sound");
    scene
}

/// Directions to the corners of a unit ball's triangles, counter-clockwise from outside.
fn ball() -> Vec<[Vec3; 3]> {
    let (rows, columns) = (8, 16);
    let at = |row: usize, column: usize| {
        let polar = std::f32::consts::PI * row as f32 / rows as f32;
        let around = std::f32::consts::TAU * (column % columns) as f32 / columns as f32;
        Vec3::new(polar.sin() * around.sin(), polar.cos(), polar.sin() * around.cos())
    };
    let quad =
        |row, column| [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
    let quads = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let mut triangles = vec![];
    for (row, [a, b, c, d]) in quads.map(|(row, column)| (row, quad(row, column))) {
        if row + 1 < rows {
            triangles.push([a, b, c]);
        }
        if row > 0 {
            triangles.push([a, c, d]);
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustics_kernels::interface::features::Features;

    #[test]
    fn scene_has_the_features_of_every_lobe_and_light() {
        let scene = scene();
        // All but textures, which have a scene of their own, and the ledger, which a setting requests.
        let all = Features((Features::ROUGH_DIELECTRIC.0 << 1) - 1);
        assert_eq!(scene.features(0.25), all | Features::DISPERSION | Features::THIN_WALLS);
        assert_eq!(scene.dropped_triangles, 0);
    }

    #[test]
    fn triangles_of_the_ball_face_outwards() {
        assert!(ball().iter().all(|[a, b, c]| (b - a).cross(c - a).dot(a + b + c) > 0.0));
    }
}
