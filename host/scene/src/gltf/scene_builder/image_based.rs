//! EXT_lights_image_based: environment light from the faces of a cube, resampled to a latitude-longitude image.
//!
//! The level with the largest faces is used; smaller levels are blurred for other renderers. Without usable faces, the irradiance
//! coefficients approximate the light. Colours of PNG files are divided by alpha (RGBD).

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec2, DVec3, Vec3};

use super::image::ImageReader;
use crate::gltf::context::ImportContext;
use crate::gltf::decoding::model::Model;
use crate::gltf::document::extension::{IMAGE_BASED as OWNER, ImageBasedLight};
use crate::texture::{Image, srgb};
use crate::{EnvironmentMap, SceneError};

/// Maximum height of the image (texels).
const MAX_HEIGHT: u32 = 2048;
/// Height of an image from irradiance coefficients (texels).
const SMOOTH_HEIGHT: u32 = 32;

/// Reads the environment of the light that the default scene refers to, if any.
pub fn read(model: &Model, context: &mut ImportContext<'_>) -> Result<Option<EnvironmentMap>, SceneError> {
    let error =
        |context: &ImportContext<'_>, what: &str| context.environment_error(format_args!("{OWNER}: {what}"));
    let light = match &model.image_based {
        None => return Ok(None),
        Some(Err(what)) => {
            context.replace(OWNER, what, "rendered without it", error(context, what))?;
            return Ok(None);
        }
        Some(Ok(light)) => light,
    };
    let rotation = rotation(light.rotation);
    let map = match faces(model, context, light) {
        Ok(faces) => {
            let side = faces.iter().map(|face| face.width.max(face.height)).max().unwrap_or(1);
            Some(environment_map(side.saturating_mul(2).min(MAX_HEIGHT), side, rotation, |d| seen(&faces, d)))
        }
        Err(what) => {
            context.replace(OWNER, &what, "lit by its irradianceCoefficients", error(context, &what))?;
            coefficients(light).map(|all| environment_map(SMOOTH_HEIGHT, 1, rotation, |d| radiance(&all, d)))
        }
    };
    let intensity = light.intensity.unwrap_or(1.0) as f32;
    Ok(map.map(|map| map.placed(intensity, 0.0)))
}

/// Rotation of a quaternion; the identity if it is missing or has no length.
fn rotation(quaternion: Option<[f64; 4]>) -> DQuat {
    let quaternion = quaternion.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let length = DQuat::from_array(quaternion).length();
    if length.is_normal() { DQuat::from_array(quaternion.map(|part| part / length)) } else { DQuat::IDENTITY }
}

/// Face of the cube: linear radiances.
struct Face {
    width: u32,
    height: u32,
    texels: Vec<Vec3>,
}

/// Reads the six faces of the largest level. An error describes the fault.
fn faces(
    model: &Model,
    context: &mut ImportContext<'_>,
    light: &ImageBasedLight,
) -> Result<Vec<Face>, String> {
    let images = light.specular_images.first().map_or(&[][..], Vec::as_slice);
    if images.len() != 6 {
        return Err(format!(
            "specularImages has {} faces in its first level and should have 6",
            images.len()
        ));
    }
    let reader = ImageReader { document: model, folder: context.folder };
    let named = |index: usize, what: String| format!("image {index} {what}");
    let mut texels = 0;
    for &index in images {
        let (width, height) = reader.size(index).map_err(|what| named(index, what))?;
        texels += u64::from(width) * u64::from(height);
    }
    // Reserve memory for bytes and radiances.
    context.take(24 * texels, "its environment").map_err(|error| error.to_string())?;
    let linear = srgb::Decoder::default();
    let read = |&index: &usize| {
        let Image { width, height, texels } = reader.read(index).map_err(|what| named(index, what))?;
        let decode = |[red, green, blue, alpha]: [u8; 4]| {
            Vec3::from([red, green, blue].map(|byte| linear.decode(byte))) / (f32::from(alpha.max(1)) / 255.0)
        };
        Ok(Face { width, height, texels: texels.into_iter().map(decode).collect() })
    };
    images.iter().map(read).collect()
}

/// Resamples a radiance function to an image of this height, with enough samples for faces of `side` texels.
fn environment_map(height: u32, side: u32, rotation: DQuat, seen: impl Fn(DVec3) -> Vec3) -> EnvironmentMap {
    let height = height.max(2);
    let width = 2 * height;
    // Take twice as many samples as a face has texels in its quarter of a turn.
    let steps = (4 * side.max(1)).div_ceil(width).clamp(1, 8) * 2;
    let back = rotation.inverse();
    let mut texels = Vec::with_capacity((width * height) as usize);
    for row in 0..height {
        for column in 0..width {
            let mut sum = Vec3::ZERO;
            for step in 0..steps * steps {
                let within = |step: u32| (f64::from(step) + 0.5) / f64::from(steps);
                let down = PI * (f64::from(row) + within(step / steps)) / f64::from(height);
                let along = TAU * (f64::from(column) + within(step % steps)) / f64::from(width);
                let direction = DVec3::new(down.sin() * along.sin(), down.cos(), -down.sin() * along.cos());
                sum += seen(back * direction);
            }
            texels.push(sum / (steps * steps) as f32);
        }
    }
    EnvironmentMap::new(width, height, texels)
}

/// Face in a direction (+x, -x, +y, -y, +z, -z) and the position on it, from its left and from its top. Seen from inside, each
/// face is upright and not mirrored: OpenGL's cube map flipped about the vertical axis.
fn face_and_uv(direction: DVec3) -> (usize, DVec2) {
    let DVec3 { x, y, z } = direction;
    let size = direction.abs();
    let (face, left, top) = if size.x >= size.y && size.x >= size.z {
        if x > 0.0 { (0, z, -y) } else { (1, -z, -y) }
    } else if size.y >= size.z {
        if y > 0.0 { (2, -x, z) } else { (3, -x, -z) }
    } else if z > 0.0 {
        (4, -x, -y)
    } else {
        (5, x, -y)
    };
    (face, 0.5 + 0.5 * DVec2::new(left, top) / size.max_element())
}

/// Radiance in a direction, bilinear within its face.
fn seen(faces: &[Face], direction: DVec3) -> Vec3 {
    let (face, at) = face_and_uv(direction);
    let Face { width, height, texels } = &faces[face];
    let split = |share: f64, side: u32| {
        let at = (share * f64::from(side) - 0.5).clamp(0.0, f64::from(side - 1));
        let first = at as u32;
        (first, (first + 1).min(side - 1), (at - f64::from(first)) as f32)
    };
    let ((left, right, x), (top, bottom, y)) = (split(at.x, *width), split(at.y, *height));
    let texel = |column: u32, row: u32| texels[(row * width + column) as usize];
    let between = |row: u32| texel(left, row).lerp(texel(right, row), x);
    between(top).lerp(between(bottom), y)
}

/// Nine irradiance coefficients.
fn coefficients(light: &ImageBasedLight) -> Option<[Vec3; 9]> {
    let all = light.irradiance_coefficients.as_ref()?;
    let vectors: Vec<Vec3> = all.iter().map(|row| Vec3::from(row.map(|number| number as f32))).collect();
    vectors.try_into().ok()
}

/// Radiance that gives this irradiance [Ramamoorthi and Hanrahan 2001, An efficient representation for irradiance environment
/// maps]. Divides the coefficients of the three bands by pi, 2 pi / 3 and pi / 4.
fn radiance(irradiance: &[Vec3; 9], direction: DVec3) -> Vec3 {
    let Vec3 { x, y, z } = direction.as_vec3();
    let pi = std::f32::consts::PI;
    let (of_1, of_2) = (1.5 / pi, 4.0 / pi);
    let functions = [
        0.282_095 / pi,
        0.488_603 * of_1 * y,
        0.488_603 * of_1 * z,
        0.488_603 * of_1 * x,
        1.092_548 * of_2 * x * y,
        1.092_548 * of_2 * y * z,
        0.315_392 * of_2 * (3.0 * z * z - 1.0),
        1.092_548 * of_2 * x * z,
        0.546_274 * of_2 * (x * x - y * y),
    ];
    let sum: Vec3 =
        irradiance.iter().zip(functions).map(|(coefficient, function)| *coefficient * function).sum();
    sum.max(Vec3::ZERO)
}
