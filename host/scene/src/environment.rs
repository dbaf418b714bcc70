//! Environment light: its image, and the tables for radiance lookup and direction sampling.

use std::path::Path;
use std::sync::Arc;

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::environment::Environment;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::light::Light;
use caustics_kernels::light::environment::{EnvironmentPyramid, direction_of, radiance_from};
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

use self::environment_image::EnvironmentImage;
use super::{Radiance, Scene, SceneError};

mod environment_image;

/// Minimum probability density of every direction, as a share of the uniform density. The map's texels are too wide for some
/// details, and none must be missed.
const MIN_SHARE: f64 = 1.0 / 64.0;
/// Largest factor on an image's radiance.
const MAX_SCALE: f32 = 1e15;

/// An environment for a scene; clones share its image.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    image: Arc<EnvironmentImage>,
    scale: f32,
    rotation: f32,
}

impl EnvironmentMap {
    /// Scales its radiance by `scale`, and sets its rotation around +y, from +z towards +x (degrees).
    pub fn placed(self, scale: f32, rotation: f32) -> EnvironmentMap {
        EnvironmentMap { scale, rotation, ..self }
    }

    /// An environment of constant radiance (W m^-2 sr^-1).
    pub fn constant(radiance: Vec3) -> EnvironmentMap {
        EnvironmentMap::from_image(EnvironmentImage::new(1, 1, vec![radiance]))
    }

    /// Decodes the bytes of a file; an error describes the fault.
    pub fn decode(bytes: &[u8]) -> Result<EnvironmentMap, String> {
        EnvironmentImage::decode(bytes).map(EnvironmentMap::from_image)
    }

    /// Reads an environment from a text: a radiance `R,G,B`, or the path of an image.
    ///
    /// # Errors
    ///
    /// Errors of [`EnvironmentMap::read`], or numbers outside of 0 to 1e30.
    pub fn named(text: &str) -> Result<EnvironmentMap, SceneError> {
        match EnvironmentMap::file(text) {
            Some(path) => EnvironmentMap::read(path),
            None => {
                let wrong = |what: &str| SceneError::Environment {
                    file: text.into(),
                    what: format!("{what}, or a file"),
                };
                text.parse().map(|Radiance(radiance)| EnvironmentMap::constant(radiance)).map_err(wrong)
            }
        }
    }

    /// Path that such a text names; `None` if the text is a radiance.
    pub fn file(text: &str) -> Option<&Path> {
        (!Radiance::is_meant(text)).then_some(Path::new(text))
    }

    /// Creates an environment from the radiances of a latitude-longitude image, row by row from the top; see
    /// [`EnvironmentMap::read`].
    ///
    /// # Panics
    ///
    /// If there are not exactly `width` times `height` radiances, or none.
    pub fn new(width: u32, height: u32, texels: Vec<Vec3>) -> EnvironmentMap {
        EnvironmentMap::from_image(EnvironmentImage::new(width, height, texels))
    }

    /// Reads a latitude-longitude image, Radiance HDR or EXR. Its middle is +z, a quarter from the left is +x, its top is +y.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, has another format, or would not fit into memory.
    pub fn read(path: &Path) -> Result<EnvironmentMap, SceneError> {
        let image = EnvironmentImage::read(path)
            .map_err(|what| SceneError::Environment { file: path.display().to_string(), what })?;
        Ok(EnvironmentMap::from_image(image))
    }

    fn from_image(image: EnvironmentImage) -> EnvironmentMap {
        EnvironmentMap { image: Arc::new(image), scale: 1.0, rotation: 0.0 }
    }
}

/// The tables of an environment; all are empty without one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnvironmentTables {
    /// One record.
    pub records: Vec<Environment>,
    /// The image, from its top.
    pub texels: Arc<[Vec3]>,
    /// Hierarchical CDF of its luminance over directions: a pyramid of sums.
    pub cdf: Vec<f32>,
    /// Mean radiance (W m^-2 sr^-1).
    mean: DVec3,
}

impl EnvironmentTables {
    /// Fits the sphere around the environment's light paths to these points (m).
    pub(super) fn enclose(&mut self, hull: &[DVec3]) {
        let Some(record) = self.records.first_mut() else { return };
        let corners = || hull.iter().copied();
        let (low, high) =
            corners().fold((DVec3::MAX, DVec3::MIN), |(low, high), p| (low.min(p), high.max(p)));
        let centre = if low.x <= high.x { 0.5 * (low + high) } else { DVec3::ZERO };
        let radius = corners().map(|p| p.distance(centre)).fold(0.0, f64::max);
        record.centre = centre.as_vec3();
        // Enlarge slightly: path origins are rounded to f32.
        record.radius = (radius * 1.001 + 1e-6 * centre.abs().max_element()) as f32;
    }

    /// Light record of the environment, without a selection probability, and its flux by channel (W).
    pub(super) fn light(&self) -> Option<(Light, DVec3)> {
        let record = self.records.first()?;
        let light = Light {
            position: record.centre,
            triangle: NONE,
            emission: self.mean.as_vec3(),
            kind: Features::ENVIRONMENT.0,
            ..Light::default()
        };
        let across = std::f64::consts::PI * f64::from(record.radius) * f64::from(record.radius);
        Some((light, self.mean * (4.0 * std::f64::consts::PI * across)))
    }
}

impl Scene {
    /// Replaces the environment of the scene.
    ///
    /// # Errors
    ///
    /// If scale or rotation is out of range, or a moving scene cannot be posed at time 0, which it is set to.
    pub fn set_environment(&mut self, map: EnvironmentMap) -> Result<(), SceneError> {
        let EnvironmentMap { image, scale, rotation } = map;
        if !(0.0..=MAX_SCALE).contains(&scale) || !rotation.is_finite() {
            let what = format!("scale {scale} and rotation {rotation} cannot be used");
            return Err(SceneError::Environment { file: self.name.clone(), what });
        }
        let record = Environment {
            scale: Vec3::splat(scale),
            width: image.width,
            height: image.height,
            turn: (f64::from(rotation) / 360.0).rem_euclid(1.0) as f32 % 1.0,
            ..Environment::default()
        };
        let (width, height) = (image.width, image.height);
        self.environment =
            EnvironmentTables { records: vec![record], texels: image.texels.clone(), ..Default::default() };
        let (cdf, mean) = self.brightness(width.max(2 * height));
        (self.environment.cdf, self.environment.mean) = (cdf, mean);
        self.light_again()
    }

    /// Computes the pyramid of the image's mean channel over directions, and the mean radiance. `width` is the image's (texels).
    fn brightness(&self, width: u32) -> (Vec<f32>, DVec3) {
        let tables = self.tables();
        // A texel of the map is as wide as 1/1800 of a turn. Sample two points a texel of the image along each axis.
        let steps = (width * 2).div_ceil(1800).clamp(1, 8);
        let mut cdf = vec![0.0; EnvironmentPyramid::NODES as usize];
        let texels = &mut cdf[..EnvironmentPyramid::TEXELS as usize];
        let sums: Vec<DVec3> = texels
            .par_chunks_mut(EnvironmentPyramid::SIDE as usize)
            .enumerate()
            .map(|(row, texels)| {
                let mut all = DVec3::ZERO;
                for (column, texel) in texels.iter_mut().enumerate() {
                    let mut sum = DVec3::ZERO;
                    for step in 0..steps * steps {
                        let within = Vec2::new((step % steps) as f32 + 0.5, (step / steps) as f32 + 0.5);
                        let at = Vec2::new(column as f32, row as f32) + within / steps as f32;
                        sum += radiance_from(tables, direction_of(at / EnvironmentPyramid::SIDE as f32))
                            .as_dvec3();
                    }
                    sum /= f64::from(steps * steps);
                    *texel = (sum.element_sum() / 3.0) as f32;
                    all += sum;
                }
                all
            })
            .collect();
        let mean = sums.into_iter().sum::<DVec3>() / f64::from(EnvironmentPyramid::TEXELS);
        let min_radiance = (MIN_SHARE * mean.element_sum() / 3.0) as f32;
        texels.par_iter_mut().for_each(|texel| *texel = texel.max(min_radiance));
        for level in 1..=EnvironmentPyramid::TOP {
            for index in 0..EnvironmentPyramid::count(level, 1) {
                let node = EnvironmentPyramid::node(level, index);
                cdf[node.slot as usize] = node.below.iter().map(|&below| cdf[below as usize]).sum();
            }
        }
        (cdf, mean)
    }
}
