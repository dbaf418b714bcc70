//! Builders of small scenes: panels, blocks, spheres and rings of a few materials, through [`SceneParts`].

use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

use caustics::scene::texture::{CornerCoordinates, Image, ImageTexture, Role};
use caustics::scene::{LightShape, PunctualLight, Scene, SceneCamera, SceneParts, TextureParts};
use caustics_kernels::interface::material::{FLAG_EMIT_BOTH_SIDES, FLAG_THIN, Material};
use caustics_kernels::interface::texture::{MaterialTextures, WRAP_REPEAT};
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::{DVec3, Vec2, Vec3};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Lambertian of this albedo.
pub fn lambert(albedo: f32) -> Material {
    Material { base_color: Vec3::splat(albedo), roughness: 1.0, ior: 1.5, ..Material::default() }
}

/// Lambert under a dielectric coat of index 1.5.
pub fn coated(albedo: f32, roughness: f32) -> Material {
    Material { specular: 1.0, roughness, ..lambert(albedo) }
}

/// Metal of this reflectance at normal incidence; a delta mirror below roughness 0.08.
pub fn metal(color: f32, roughness: f32) -> Material {
    Material { metallic: 1.0, roughness, ..lambert(color) }
}

/// Clear dielectric with a volume.
pub fn glass(ior: f32) -> Material {
    Material { transmission: 1.0, specular: 1.0, roughness: 0.0, ior, ..lambert(1.0) }
}

/// Clear dielectric with a volume and an Abbe number of 10: twice as dispersive as any glass.
pub fn flint(ior: f32) -> Material {
    Material { dispersion: 2.0, ..glass(ior) }
}

/// Clear dielectric without a volume: a thin wall.
pub fn pane(ior: f32) -> Material {
    Material { flags: FLAG_THIN, ..glass(ior) }
}

/// Black emitter of this radiance (W m^-2 sr^-1) on its front side.
pub fn emitter(radiance: f32) -> Material {
    Material { emission: Vec3::splat(radiance), ..lambert(0.0) }
}

/// Black emitter of this radiance (W m^-2 sr^-1) on both sides.
pub fn emitter_both(radiance: f32) -> Material {
    Material { flags: FLAG_EMIT_BOTH_SIDES, ..emitter(radiance) }
}

/// A scene under construction. Coordinates are f64 and in metres.
#[derive(Clone, Debug, Default)]
pub struct Builder {
    triangles: Vec<Triangle>,
    surfaces: Vec<TriangleSurface>,
    materials: Vec<Material>,
    lights: Vec<PunctualLight>,
    cameras: Vec<SceneCamera>,
    /// Images and textures; the records of materials and coordinates follow the order of materials and triangles.
    pub textures: TextureParts,
}

impl Builder {
    /// Adds a material and returns its id.
    pub fn material(&mut self, material: Material) -> u32 {
        self.textured(material, MaterialTextures::default())
    }

    /// Adds a material with textures and returns its id.
    pub fn textured(&mut self, material: Material, textures: MaterialTextures) -> u32 {
        self.materials.push(material);
        self.textures.materials.push(textures);
        self.materials.len() as u32 - 1
    }

    /// Adds a repeating texture and returns its id; `texel` returns the texel of a column and row.
    pub fn texture(
        &mut self,
        role: Role,
        width: u32,
        height: u32,
        texel: impl Fn(u32, u32) -> [u8; 4],
    ) -> u32 {
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let texels = texels.map(|(x, y)| texel(x, y)).collect();
        self.textures.images.push(Image { width, height, texels });
        let image = self.textures.images.len() - 1;
        self.textures.textures.push(ImageTexture {
            image,
            role,
            wrap: [WRAP_REPEAT; 2],
            nearest: false,
            finest: false,
        });
        self.textures.textures.len() as u32 - 1
    }

    /// Adds a triangle with vertex normals.
    pub fn triangle(&mut self, material: u32, corners: [DVec3; 3], normals: [DVec3; 3]) {
        let [a, b, c] = corners.map(|corner| corner.as_vec3());
        let [normal_a, normal_b, normal_c] = normals.map(|normal| normal.normalize().as_vec3());
        self.triangles.push(Triangle { a, b, c });
        self.surfaces.push(TriangleSurface {
            normal_a,
            normal_b,
            normal_c,
            material,
            ..TriangleSurface::default()
        });
        self.textures.coordinates.push(CornerCoordinates::default());
    }

    /// Adds a triangle with vertex normals and texture coordinates.
    pub fn mapped_triangle(
        &mut self,
        material: u32,
        corners: [DVec3; 3],
        normals: [DVec3; 3],
        uv: [Vec2; 3],
    ) {
        self.triangle(material, corners, normals);
        *self.textures.coordinates.last_mut().expect("one was added") =
            CornerCoordinates { uv, tangents: None };
    }

    /// Adds a flat parallelogram; its front is where `right` x `up` points, and a texture stands upright on it.
    pub fn panel(&mut self, material: u32, centre: DVec3, right: DVec3, up: DVec3) {
        let n = right.cross(up);
        let [a, b, c, d] =
            [centre - right - up, centre + right - up, centre + right + up, centre - right + up];
        let [uv_a, uv_b, uv_c, uv_d] = [Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO];
        self.mapped_triangle(material, [a, b, c], [n; 3], [uv_a, uv_b, uv_c]);
        self.mapped_triangle(material, [a, c, d], [n; 3], [uv_a, uv_c, uv_d]);
    }

    /// Adds an axis-aligned block; `inwards` turns its fronts to the inside (a room).
    pub fn block(&mut self, material: u32, min: DVec3, max: DVec3, inwards: bool) {
        let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
        let flip = if inwards { -1.0 } else { 1.0 };
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let unit = |axis: usize| DVec3::AXES[axis % 3] * half[axis % 3];
                let right = flip * sign * unit(axis + 1);
                self.panel(material, centre + sign * unit(axis), right, unit(axis + 2));
            }
        }
    }

    /// Adds a sphere with smooth normals, poles on the y axis.
    pub fn sphere(&mut self, material: u32, centre: DVec3, radius: f64, segments: u32, rows: u32) {
        let at = |row: u32, segment: u32| {
            let (sin, cos) = match row {
                0 => (0.0, 1.0),
                row if row == rows => (0.0, -1.0),
                row => (PI * f64::from(row) / f64::from(rows)).sin_cos(),
            };
            let (s, c) = (TAU * f64::from(segment % segments) / f64::from(segments)).sin_cos();
            DVec3::new(sin * c, cos, -sin * s)
        };
        for row in 0..rows {
            for segment in 0..segments {
                let n =
                    [at(row, segment), at(row + 1, segment), at(row + 1, segment + 1), at(row, segment + 1)];
                let p = n.map(|n| centre + radius * n);
                let uv = [(row, segment), (row + 1, segment), (row + 1, segment + 1), (row, segment + 1)]
                    .map(|(row, segment)| {
                        Vec2::new(segment as f32 / segments as f32, row as f32 / rows as f32)
                    });
                if row + 1 != rows {
                    self.mapped_triangle(
                        material,
                        [p[0], p[1], p[2]],
                        [n[0], n[1], n[2]],
                        [uv[0], uv[1], uv[2]],
                    );
                }
                if row != 0 {
                    self.mapped_triangle(
                        material,
                        [p[0], p[2], p[3]],
                        [n[0], n[2], n[3]],
                        [uv[0], uv[2], uv[3]],
                    );
                }
            }
        }
    }

    /// Adds a block whose vertex normals are those of its corners, a frequent fault of models.
    pub fn smooth_block(&mut self, material: u32, centre: DVec3, half: f64) {
        let first = self.triangles.len();
        self.block(material, centre - half, centre + half, false);
        for (triangle, surface) in self.triangles.iter().zip(&mut self.surfaces).skip(first) {
            let away = |corner: Vec3| (corner - centre.as_vec3()).normalize();
            (surface.normal_a, surface.normal_b, surface.normal_c) =
                (away(triangle.a), away(triangle.b), away(triangle.c));
        }
    }

    /// Adds waves with smooth normals, `count` along x and eight facets each: y = height sin(k x) around `centre`.
    pub fn waves(&mut self, material: u32, centre: DVec3, half: f64, height: f64, count: u32) {
        let columns = 8 * count;
        let k = PI * f64::from(count) / half;
        let at = |column: u32, z: f64| {
            let x = half * (2.0 * f64::from(column) / f64::from(columns) - 1.0);
            let (sin, cos) = (k * x).sin_cos();
            (centre + DVec3::new(x, height * sin, z), DVec3::new(-height * k * cos, 1.0, 0.0))
        };
        for column in 0..columns {
            let (a, b) = (at(column, half), at(column + 1, half));
            let (c, d) = (at(column + 1, -half), at(column, -half));
            self.triangle(material, [a.0, b.0, c.0], [a.1, b.1, c.1]);
            self.triangle(material, [a.0, c.0, d.0], [a.1, c.1, d.1]);
        }
    }

    /// Adds the inside of a cylinder's wall (a ring of no thickness, axis on y) over angles `from`..`to` around the
    /// axis. Angle 0 is +x, and angles grow towards +z. Fronts and normals look at the axis.
    #[expect(clippy::too_many_arguments, reason = "a shape in one call")]
    pub fn wall(
        &mut self,
        material: u32,
        base: DVec3,
        radius: f64,
        height: f64,
        from: f64,
        to: f64,
        segments: u32,
    ) {
        let at = |segment: u32| {
            let (sin, cos) = (from + (to - from) * f64::from(segment) / f64::from(segments)).sin_cos();
            DVec3::new(cos, 0.0, sin)
        };
        for segment in 0..segments {
            let (left, right) = (at(segment), at(segment + 1));
            let (a, b) = (base + radius * left, base + radius * right);
            let up = height * DVec3::Y;
            self.triangle(material, [a, b, b + up], [-left, -right, -right]);
            self.triangle(material, [a, b + up, a + up], [-left, -right, -left]);
        }
    }

    /// Adds a point light of this intensity (W/sr) in every channel.
    pub fn light(&mut self, position: DVec3, intensity: f32) {
        self.colored_light(position, Vec3::splat(intensity));
    }

    /// Adds a point light of this intensity (W/sr).
    pub fn colored_light(&mut self, position: DVec3, intensity: Vec3) {
        self.lights.push(PunctualLight::point(position.as_vec3(), intensity));
    }

    /// Adds a spot light of this intensity (W/sr) in its inner cone; angles to the axis in radians.
    pub fn spot(&mut self, position: DVec3, direction: DVec3, inner: f64, outer: f64, intensity: f32) {
        let direction = direction.normalize().as_vec3();
        let shape = LightShape::Spot { direction, inner, outer };
        let (position, intensity) = (position.as_vec3(), Vec3::splat(intensity));
        self.lights.push(PunctualLight { position, intensity, shape });
    }

    /// Adds a directional light of this irradiance across (W/m^2).
    pub fn directional(&mut self, direction: DVec3, irradiance: f32) {
        let shape = LightShape::Directional { direction: direction.normalize().as_vec3() };
        self.lights.push(PunctualLight { position: Vec3::ZERO, intensity: Vec3::splat(irradiance), shape });
    }

    /// Adds a camera with y upwards (z where it looks along y).
    pub fn camera(&mut self, eye: DVec3, target: DVec3, fov_y: f32) {
        let (eye, target) = (eye.as_vec3(), target.as_vec3());
        let steep = (target - eye).normalize().y.abs() > 0.999;
        let up = if steep { Vec3::Z } else { Vec3::Y };
        self.cameras.push(SceneCamera::look_at("main", eye, target, up, fov_y));
    }

    /// Multiplies lengths by `scale`, intensities by its square and absorption by its inverse, so that the image stays.
    pub fn scaled(mut self, scale: f32) -> Self {
        for triangle in &mut self.triangles {
            (triangle.a, triangle.b, triangle.c) =
                (triangle.a * scale, triangle.b * scale, triangle.c * scale);
        }
        for light in &mut self.lights {
            // Keep a directional light's irradiance: it is a radiance over an angle.
            if !matches!(light.shape, LightShape::Directional { .. }) {
                light.position *= scale;
                light.intensity *= scale * scale;
            }
        }
        self.materials.iter_mut().for_each(|material| material.absorption /= scale);
        self.cameras.iter_mut().for_each(|camera| camera.position *= scale);
        self
    }

    /// Multiplies all light by `scale`.
    pub fn brightened(mut self, scale: f32) -> Self {
        self.lights.iter_mut().for_each(|light| light.intensity *= scale);
        self.materials.iter_mut().for_each(|material| material.emission *= scale);
        self
    }

    /// Builds the scene.
    pub fn build(self) -> Scene {
        let material_names = (0..self.materials.len()).map(|id| format!("material {id}")).collect();
        let Builder { triangles, surfaces, materials, lights, cameras, textures } = self;
        let parts = SceneParts {
            name: "test".into(),
            triangles,
            surfaces,
            materials,
            material_names,
            lights,
            cameras,
            textures,
            ..SceneParts::default()
        };
        parts.build().expect("a test's scene is valid")
    }
}

/// Loads a committed scene.
pub fn committed(name: &str) -> Scene {
    Scene::load(&folder(name).join("scene.gltf")).expect("committed scenes load")
}

/// Copies the files of a committed scene; returns the folder, and the document for changes.
pub fn copied(name: &str) -> (TempDir, Value) {
    let copy = tempfile::tempdir().expect("a folder");
    for file in std::fs::read_dir(folder(name)).expect("a scene") {
        let file = file.expect("a file");
        std::fs::copy(file.path(), copy.path().join(file.file_name())).expect("a copy");
    }
    let text = std::fs::read(copy.path().join("scene.gltf")).expect("a document");
    (copy, serde_json::from_slice(&text).expect("JSON"))
}

/// Turns the ring of `moving-caster` or `light-off` into glass.
pub fn make_glass(document: &mut Value) {
    document["materials"][1] = json!({
        "name": "ring",
        "extensions": {
            "KHR_materials_ior": { "ior": 1.5 },
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_volume": { "thicknessFactor": 0.01 },
        },
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.0 },
    });
    let used = ["specular", "emissive_strength", "ior", "transmission", "volume"];
    document["extensionsUsed"] = used.map(|name| format!("KHR_materials_{name}")).to_vec().into();
}

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name)
}

/// A grey room seen from one end, with a mirror and a light in the other half. A wall of this half thickness (m) may
/// separate the halves.
pub fn half_room(wall: Option<f64>) -> Scene {
    let mut b = Builder::default();
    let grey = b.material(lambert(0.6));
    let mirror = b.material(metal(1.0, 0.0));
    b.block(grey, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.panel(mirror, DVec3::new(0.0, 0.0, -0.99), 0.9 * DVec3::X, 0.9 * DVec3::Y);
    if let Some(half) = wall {
        b.block(grey, DVec3::new(-1.1, -1.1, -half), DVec3::new(1.1, 1.1, half), false);
    }
    b.light(DVec3::new(0.2, 0.3, -0.5), 1.0);
    b.camera(DVec3::new(0.0, 0.0, 0.95), DVec3::ZERO, 0.9);
    b.build()
}

/// A closed room of 2 x 2 x 2 m around the origin under an area light and a point light. It holds an absorbing glass
/// ball, a mirror ring, a coated block and a glossy plate.
pub fn mixed_room() -> Builder {
    let mut b = Builder::default();
    let wall = b.material(lambert(0.6));
    let ball = b.material(Material { absorption: Vec3::new(0.5, 1.0, 2.0), ..glass(1.5) });
    let ring = b.material(metal(0.9, 0.0));
    let block = b.material(coated(0.5, 0.4));
    let plate = b.material(metal(0.8, 0.2));
    let light = b.material(emitter(40.0));
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.sphere(ball, DVec3::new(-0.35, -0.645, 0.1), 0.35, 48, 24);
    b.wall(ring, DVec3::new(0.45, -0.999, 0.2), 0.3, 0.15, 0.0, TAU, 96);
    b.block(block, DVec3::new(0.3, -0.998, -0.8), DVec3::new(0.8, -0.5, -0.4), false);
    b.panel(plate, DVec3::new(-0.99, -0.2, 0.0), DVec3::new(0.0, 0.0, -0.5), DVec3::new(0.0, 0.5, 0.0));
    b.panel(light, DVec3::new(0.2, 0.98, 0.1), DVec3::new(0.15, 0.0, 0.0), DVec3::new(0.0, 0.0, 0.15));
    b.light(DVec3::new(-0.5, 0.7, 0.5), 0.3);
    b.camera(DVec3::new(0.1, 0.2, 0.95), DVec3::new(0.0, -0.45, 0.0), 0.9);
    b
}

/// Textures that blend by this alpha everywhere.
pub fn veil(share: f32) -> MaterialTextures {
    MaterialTextures { alpha: share, blends: 1, ..MaterialTextures::default() }
}

/// A room of 2 x 2 x 2 m with an area light, a glass ball, a mirror and blended surfaces. These are a tinted pane
/// before the light, a glossy pane before the ball, leaves of soft alpha, and a two-sided textured emitter.
pub fn blended_room() -> Builder {
    let mut b = Builder::default();
    let (wall, ball) = (b.material(lambert(0.5)), b.material(glass(1.5)));
    let (light, mirror) = (b.material(emitter(8.0)), b.material(metal(0.9, 0.0)));
    let soft = |x: u32, y: u32| 20 + 30 * ((x.abs_diff(4) + y.abs_diff(4)) as u8 % 8);
    let leaf = b.texture(Role::Color, 8, 8, |x, y| [120, 200, 60, soft(x, y)]);
    let glow =
        b.texture(Role::Color, 8, 8, |x, y| [(40 + 25 * x) as u8, (200 - 20 * y) as u8, 120, soft(y, x)]);
    let tinted = b.textured(Material { base_color: Vec3::new(0.8, 0.3, 0.2), ..lambert(0.0) }, veil(0.4));
    let glossy = b.textured(metal(0.8, 0.15), veil(0.5));
    let leaves = b.textured(lambert(0.9), MaterialTextures { base_color: leaf, ..veil(0.9) });
    let glowing = MaterialTextures { base_color: glow, emissive: glow, ..veil(0.8) };
    let glowing = b.textured(Material { base_color: Vec3::splat(0.3), ..emitter_both(4.0) }, glowing);
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.panel(light, DVec3::new(0.1, 0.95, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
    b.sphere(ball, DVec3::new(-0.35, -0.6, -0.1), 0.35, 64, 32);
    b.panel(mirror, DVec3::new(0.5, -0.3, -0.95), 0.4 * DVec3::X, 0.5 * DVec3::Y);
    b.panel(tinted, DVec3::new(-0.3, 0.2, 0.0), 0.5 * DVec3::Z, 0.5 * DVec3::X);
    b.panel(glossy, DVec3::new(-0.4, -0.5, 0.4), 0.4 * DVec3::X, 0.3 * DVec3::Y);
    b.panel(leaves, DVec3::new(0.45, -0.4, 0.1), 0.4 * DVec3::X, 0.5 * DVec3::Y);
    b.panel(glowing, DVec3::new(0.6, 0.1, -0.4), DVec3::new(0.1, 0.0, 0.25), 0.3 * DVec3::Y);
    b.camera(DVec3::new(0.1, 0.2, 0.95), DVec3::new(0.0, -0.3, 0.0), 1.0);
    b
}

/// A room of 2 x 2 x 2 m with a dispersive ball and block, under a warm light between tinted walls: channels differ.
pub fn dispersive_room() -> Scene {
    let mut b = Builder::default();
    let wall = b.material(Material { base_color: Vec3::new(0.6, 0.5, 0.3), ..lambert(0.0) });
    let light = b.material(Material { emission: Vec3::new(12.0, 8.0, 4.0), ..emitter(0.0) });
    let (ball, block) = (b.material(flint(1.6)), b.material(Material { roughness: 0.2, ..flint(1.5) }));
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.panel(light, DVec3::new(0.1, 0.95, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
    b.sphere(ball, DVec3::new(-0.4, -0.6, 0.0), 0.35, 64, 32);
    b.block(block, DVec3::new(0.2, -0.95, -0.5), DVec3::new(0.7, -0.3, 0.0), false);
    b.camera(DVec3::new(0.1, 0.2, 0.95), DVec3::new(0.0, -0.4, 0.0), 1.0);
    b.build()
}

/// A room of 2 x 2 x 2 m in which lobes of every width stand close to `light_count` area lights of several sizes.
pub fn room_of_lights(light_count: u32) -> Builder {
    let mut b = Builder::default();
    let (wall, coat) = (b.material(lambert(0.6)), b.material(coated(0.5, 0.3)));
    let (plate, rough) =
        (b.material(metal(0.8, 0.15)), b.material(Material { roughness: 0.3, ..glass(1.5) }));
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.panel(plate, DVec3::new(0.0, -0.4, -0.95), 0.6 * DVec3::X, 0.4 * DVec3::Y);
    b.panel(coat, DVec3::new(0.0, -0.98, 0.0), 0.6 * DVec3::Z, 0.6 * DVec3::X);
    b.sphere(rough, DVec3::new(-0.4, -0.6, 0.0), 0.3, 32, 16);
    for id in 0..light_count {
        let angle = TAU * f64::from(id) / f64::from(light_count);
        let (size, height) = (0.03 + 0.02 * f64::from(id % 4), 0.9 - 0.35 * f64::from(id % 5));
        let light = b.material(emitter(4.0 + 3.0 * (id % 3) as f32));
        let centre = DVec3::new(0.7 * angle.cos(), height, 0.7 * angle.sin());
        b.panel(light, centre, size * DVec3::X, size * DVec3::Z);
    }
    b.camera(DVec3::new(0.1, 0.2, 0.95), DVec3::new(0.0, -0.45, 0.0), 0.9);
    b
}

/// A basin of 2 x 2 x 2 m around the origin under a light, half full of tinted water. Its open surface leaves gaps
/// of 1 mm to the walls.
pub fn pool(eye: DVec3, target: DVec3) -> Builder {
    let mut b = Builder::default();
    let water = b.material(Material { absorption: Vec3::new(0.5, 1.0, 2.0), ..glass(1.33) });
    let concrete = b.material(lambert(0.5));
    let light = b.material(emitter(8.0));
    b.block(concrete, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.panel(water, DVec3::ZERO, 0.999 * DVec3::Z, 0.999 * DVec3::X);
    b.panel(light, DVec3::new(0.1, 0.95, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
    b.camera(eye, target, 1.0);
    b
}

/// Objects on a floor under an open sky, by a spot and a directional light: a glass ball and a metal ring cast
/// caustics.
pub fn open_air() -> Builder {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.6));
    let ball = b.material(Material { absorption: Vec3::new(0.5, 1.0, 2.0), ..glass(1.5) });
    let ring = b.material(metal(0.9, 0.0));
    b.panel(floor, DVec3::new(0.0, -1.0, 0.0), 1.2 * DVec3::Z, 1.2 * DVec3::X);
    b.sphere(ball, DVec3::new(-0.35, -0.645, 0.1), 0.35, 48, 24);
    b.wall(ring, DVec3::new(0.45, -0.999, 0.2), 0.3, 0.15, 0.0, TAU, 96);
    b.spot(DVec3::new(-0.5, 0.9, 0.5), DVec3::new(0.3, -1.5, -0.3), 0.2, 0.6, 2.0);
    b.directional(DVec3::new(-0.5, -0.7, -0.2), 1.5);
    b.camera(DVec3::new(0.1, 0.4, 1.6), DVec3::new(0.0, -0.8, 0.0), 0.9);
    b
}
