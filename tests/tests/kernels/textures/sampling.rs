//! Filtered texels against an independent oracle, and the level that a camera path chooses.

use caustics::scene::Scene;
use caustics::scene::texture::Role;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::point::PointShading;
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::interface::texture::{
    MaterialTextures, Texture, WRAP_CLAMP, WRAP_MIRRORED, WRAP_REPEAT,
};
use caustics_kernels::math::cone::RayCone;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::surface::textured::{material_at, material_of, packed};
use caustics_kernels::surface::vertex::vertex;
use caustics_kernels::texture::sample::{level_of, sample};
use caustics_kernels::trace::Tracer;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec2, Vec3};

const SIZES: [(u32, u32); 5] = [(1, 1), (2, 3), (16, 8), (7, 5), (64, 64)];
const WRAPS: [u32; 3] = [WRAP_REPEAT, WRAP_MIRRORED, WRAP_CLAMP];

fn noise(x: u32, y: u32) -> [u8; 4] {
    let mut rng = Rng::new(Stream::Camera, 5, x, y);
    rng.next4().to_array().map(|u| (u * 256.0) as u8)
}

/// A scene with textures of every size, wrap and role, nearest ones too.
fn gallery() -> Scene {
    let mut b = Builder::default();
    for role in [Role::Color, Role::Data, Role::Normal] {
        for (width, height) in SIZES {
            for wrap in WRAPS {
                for nearest in [false, true] {
                    let id = b.texture(role, width, height, noise);
                    let texture = &mut b.textures.textures[id as usize];
                    (texture.wrap, texture.nearest) = ([wrap, WRAPS[id as usize % 3]], nearest);
                }
            }
        }
    }
    let wall = b.material(lambert(0.5));
    b.panel(wall, DVec3::ZERO, DVec3::X, DVec3::Y);
    b.build()
}

/// A texel of a level, decoded in f64 by the formulas of the standards.
fn texel(scene: &Scene, texture: &Texture, level: u32, x: i64, y: i64) -> [f64; 4] {
    let sizes = (0..=level)
        .map(|level| (i64::from(texture.width >> level).max(1), i64::from(texture.height >> level).max(1)));
    let sizes: Vec<_> = sizes.collect();
    let before: i64 = sizes[..level as usize].iter().map(|(w, h)| w * h).sum();
    let (width, height) = sizes[level as usize];
    let inside = |texel: i64, size: i64, wrap: u32| match wrap {
        WRAP_REPEAT => texel.rem_euclid(size),
        WRAP_MIRRORED => {
            let folded = texel.rem_euclid(2 * size);
            if folded < size { folded } else { 2 * size - 1 - folded }
        }
        _ => texel.clamp(0, size - 1),
    };
    let at = inside(y, height, texture.wrap_v) * width + inside(x, width, texture.wrap_u);
    let word = scene.textures.texels[(i64::from(texture.offset) + before + at) as usize];
    let bytes = word.to_le_bytes().map(f64::from);
    let share = bytes.map(|byte| byte / 255.0);
    match texture.encoding {
        0 => share,
        1 => {
            let linear = |e: f64| if e <= 0.04045 { e / 12.92 } else { ((e + 0.055) / 1.055).powf(2.4) };
            [linear(share[0]), linear(share[1]), linear(share[2]), share[3]]
        }
        _ => bytes.map(|byte| (byte - 128.0) / 127.0),
    }
}

fn oracle(scene: &Scene, texture: &Texture, uv: Vec2, lod: f64) -> [f64; 4] {
    let in_level = |level: u32| {
        let x = f64::from(uv.x) * f64::from((texture.width >> level).max(1));
        let y = f64::from(uv.y) * f64::from((texture.height >> level).max(1));
        if texture.nearest != 0 {
            return texel(scene, texture, level, x.floor() as i64, y.floor() as i64);
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let mut sum = [0.0; 4];
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weight =
                |along: f64, d: i64| if d == 1 { along - along.floor() } else { 1.0 - along + along.floor() };
            let found = texel(scene, texture, level, x.floor() as i64 + dx, y.floor() as i64 + dy);
            (0..4).for_each(|k| sum[k] += found[k] * weight(x, dx) * weight(y, dy));
        }
        sum
    };
    let finer = lod.floor();
    let (a, b) = (in_level(finer as u32), in_level((finer as u32 + 1).min(texture.level_count - 1)));
    std::array::from_fn(|k| a[k] * (1.0 - lod + finer) + b[k] * (lod - finer))
}

/// Coordinates up to three periods off, and footprints from zero to more than the texture.
#[test]
fn filtered_texels_match_a_double_precision_oracle() {
    let scene = gallery();
    let tables = scene.tables().textures;
    for (id, texture) in scene.textures.textures.iter().enumerate() {
        let mut worst = 0.0_f64;
        let mut jumps = 0;
        for path in 0..2000 {
            let u = Rng::new(Stream::Light, 7, path, id as u32).next4();
            let uv = Vec2::new(6.0 * u.x - 3.0, 6.0 * u.y - 3.0);
            let footprint = if path % 2 == 0 { 0.0 } else { (u.z * 10.0 - 8.0).exp2() };
            let side = (f64::from(texture.width) * f64::from(texture.height)).sqrt();
            let lod = (f64::from(footprint) * side).max(1.0).log2().min(f64::from(texture.level_count - 1));
            let expected = oracle(&scene, texture, uv, lod);
            let got = sample(tables, id as u32, uv, footprint).to_array();
            let off = (0..4).map(|k| (f64::from(got[k]) - expected[k]).abs()).fold(0.0, f64::max);
            // Beside a border between texels rounding may choose the other.
            if texture.nearest != 0 && off > 1e-4 {
                jumps += 1;
            } else {
                worst = worst.max(off);
            }
        }
        // A coordinate of 3 has an ulp of 2.4e-7: over 64 texels that shifts the weights by 1.5e-5.
        assert!(worst < 5e-5 && jumps <= 2, "{texture:?}: {worst:e}, {jumps} jumps");
    }
}

#[test]
fn texel_centres_give_their_texel() {
    let scene = gallery();
    for (id, texture) in scene.textures.textures.iter().enumerate() {
        for y in 0..texture.height {
            for x in 0..texture.width {
                let uv = Vec2::new(
                    (x as f32 + 0.5) / texture.width as f32,
                    (y as f32 + 0.5) / texture.height as f32,
                );
                let expected = texel(&scene, texture, 0, i64::from(x), i64::from(y));
                let got = sample(scene.tables().textures, id as u32, uv, 0.0).to_array();
                // Weights are off by an ulp of the coordinate in texels, 4e-6 of 64.
                assert!(
                    (0..4).all(|k| (f64::from(got[k]) - expected[k]).abs() < 2e-5),
                    "{texture:?} {x} {y}"
                );
            }
        }
    }
}

#[test]
fn constant_textures_are_constant_at_every_level() {
    let mut b = Builder::default();
    let wall = b.material(lambert(0.5));
    b.panel(wall, DVec3::ZERO, DVec3::X, DVec3::Y);
    let roles = [Role::Color, Role::Data, Role::Normal];
    let ids = roles.map(|role| b.texture(role, 13, 40, |_, _| [200, 100, 50, 25]));
    let scene = b.build();
    for id in ids {
        let first = sample(scene.tables().textures, id, Vec2::ZERO, 0.0);
        let mut averaged = sample(scene.tables().textures, id, Vec2::ZERO, 0.9);
        if id == ids[2] {
            // Averages of normals are stored with unit length, their alpha like a share.
            let unit = first.truncate().normalize();
            assert!((averaged.truncate() - unit).length() < 0.01, "{averaged} {unit}");
            averaged = first;
        }
        assert!((first - averaged).abs().max_element() < 1e-6);
        for step in 0..200 {
            let uv = Vec2::new(step as f32 * 0.37, step as f32 * 0.73);
            let got = sample(scene.tables().textures, id, uv, step as f32 * 0.01);
            let expected = if id == ids[2] { got } else { first };
            assert!((got - expected).abs().max_element() < 1e-6, "{got} {expected}");
        }
    }
}

/// A camera path of twice the length sees texels of twice the width.
#[test]
fn level_grows_by_one_when_the_distance_doubles() {
    let mut b = Builder::default();
    let texture = b.texture(Role::Color, 256, 128, noise);
    let record = MaterialTextures { base_color: texture, ..MaterialTextures::default() };
    let wall = b.textured(lambert(1.0), record);
    b.panel(wall, DVec3::ZERO, 2.0 * DVec3::X, 1.0 * DVec3::Y);
    let scene = b.build();
    let features = scene.features(0.25);
    assert!(features.has(Features::TEXTURES));
    for slant in [0.0, 1.0] {
        let direction = Vec3::new(slant, 0.0, -1.0).normalize();
        let level = |distance: f32| {
            let ray = Ray::endless(Vec3::new(0.1, 0.2, 0.0) - direction * distance, direction);
            let hit = scene.tracer(features).closest(&ray);
            let cone = RayCone::at_eye(0.01).advance(hit.distance);
            let here = vertex(scene.tables(), features, &ray, &hit, cone.total_width());
            level_of(scene.textures.textures[0], here.uv_footprint)
        };
        // 4 x 2 m carry 256 x 128 texels: at 5 m the cone is 5 cm wide, or 3.2 texels, over the cosine.
        let expected = (3.2 / direction.z.abs()).log2();
        assert!((level(5.0) - expected).abs() < 1e-4, "{} {expected}", level(5.0));
        assert!((level(10.0) - level(5.0) - 1.0).abs() < 1e-4);
    }
}

/// A collection point stores the textured material that paths saw, to the bit.
#[test]
fn collection_points_store_the_textured_material_to_the_bit() {
    let mut b = Builder::default();
    let color = b.texture(Role::Color, 16, 16, noise);
    let rough = b.texture(Role::Data, 16, 16, noise);
    let both =
        MaterialTextures { base_color: color, metallic_roughness: rough, ..MaterialTextures::default() };
    let only_rough = MaterialTextures { base_color: caustics_kernels::interface::NONE, ..both };
    let base = metal(0.7, 0.9);
    let ids = [b.textured(base, both), b.textured(base, only_rough), b.material(base)];
    for (at, id) in ids.into_iter().enumerate() {
        b.panel(id, DVec3::new(0.0, 0.0, -(at as f64)), DVec3::X, DVec3::Y);
    }
    let scene = b.build();
    let features = scene.features(0.25);
    let mut seen = std::collections::BTreeSet::new();
    for path in 0..3000 {
        let u = Rng::new(Stream::Camera, 1, path, 0).next4();
        let z = 0.5 - (path % 3) as f32;
        let ray = Ray::endless(Vec3::new(2.0 * u.x - 1.0, 2.0 * u.y - 1.0, z), Vec3::NEG_Z);
        let hit = scene.tracer(features).closest(&ray);
        let here = vertex(scene.tables(), features, &ray, &hit, u.z);
        let material = material_at(scene.tables(), &here, features);
        let (red_green, blue_roughness_metallic) = packed(&material);
        let point = PointShading {
            material: here.material,
            red_green,
            blue_roughness_metallic,
            ..PointShading::default()
        };
        assert_eq!(material_of(&point, &scene.materials, features), material);
        seen.insert(material.roughness.to_bits());
    }
    assert!(seen.len() > 50, "the test has nothing to check");
}
