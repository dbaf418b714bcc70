//! Punctual lights [KHR_lights_punctual]: points, spots and directional lights,
//! and their records in the light table.

use std::f64::consts::{FRAC_PI_2, PI};

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::light::Light;
use caustics_kernels::math::frame::ShadingFrame;
use glam::{DAffine3, DVec2, DVec3, Vec3};
use gltf::json::extensions::scene::khr_lights_punctual::{self, Type};
use gltf::json::validation::Checked;

use super::geometry;

/// Minimum outer angle of a spot (rad): a chord of such a cone still has three digits in f32.
const MIN_CONE: f64 = 1e-4;

/// A light without an area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PunctualLight {
    /// Position (m); not used by directional lights.
    pub position: Vec3,
    /// Radiant intensity of each channel (W sr^-1), for a spot within its inner cone.
    /// A directional light has its irradiance on a perpendicular plane instead (W m^-2).
    pub intensity: Vec3,
    /// Angular distribution.
    pub shape: LightShape,
}

/// Angular distribution of a punctual light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum LightShape {
    /// Evenly in all directions.
    #[default]
    Point,
    /// Into a cone: fully up to the inner angle, falling to nothing at the outer.
    Spot {
        /// Unit axis.
        direction: Vec3,
        /// Inner angle to the axis (rad), at least 0.
        inner: f64,
        /// Outer angle to the axis (rad), above the inner, at most pi / 2.
        outer: f64,
    },
    /// Everywhere alike, from infinitely far away.
    Directional {
        /// Unit direction of travel.
        direction: Vec3,
    },
}

impl LightShape {
    /// Reads a light of a file, along -z; an error describes the fault.
    pub fn from_gltf(light: &khr_lights_punctual::Light) -> Result<LightShape, String> {
        match light.type_ {
            Checked::Valid(Type::Point) => Ok(LightShape::Point),
            Checked::Valid(Type::Directional) => Ok(LightShape::Directional { direction: Vec3::NEG_Z }),
            Checked::Valid(Type::Spot) => {
                let cone = light.spot.as_ref();
                let inner = f64::from(cone.map_or(0.0, |cone| cone.inner_cone_angle));
                let outer = f64::from(cone.map_or(std::f32::consts::FRAC_PI_4, |cone| cone.outer_cone_angle));
                match cone_fault(inner, outer) {
                    Some(fault) => Err(format!("has {fault}")),
                    None => Ok(LightShape::Spot { direction: Vec3::NEG_Z, inner, outer }),
                }
            }
            Checked::Invalid => Err("is no point, spot or directional light".into()),
        }
    }

    /// Kernel feature of this type of light.
    pub fn feature(self) -> Features {
        match self {
            LightShape::Point => Features::POINT_LIGHTS,
            LightShape::Spot { .. } => Features::SPOT_LIGHTS,
            LightShape::Directional { .. } => Features::DIRECTIONAL_LIGHTS,
        }
    }
}

impl PunctualLight {
    /// A point that emits evenly.
    pub fn point(position: Vec3, intensity: Vec3) -> Self {
        PunctualLight { position, intensity, shape: LightShape::Point }
    }

    /// Transforms the light of a node, in a world recentred to `origin` (m).
    /// `None` if the light needs a direction and the node's axes have no length.
    pub fn placed(&self, to_world: &DAffine3, origin: DVec3) -> Option<Self> {
        // The direction is -z; scale has no effect.
        let aim = || (-to_world.matrix3.z_axis).try_normalize().map(|direction| direction.as_vec3());
        let shape = match self.shape {
            LightShape::Spot { inner, outer, .. } => LightShape::Spot { direction: aim()?, inner, outer },
            LightShape::Directional { .. } => LightShape::Directional { direction: aim()? },
            evenly => evenly,
        };
        // A directional light has no position.
        let stands = !matches!(shape, LightShape::Directional { .. });
        let position = if stands { (to_world.translation - origin).as_vec3() } else { Vec3::ZERO };
        Some(PunctualLight { position, shape, ..*self })
    }

    /// Reason why no kernel can use the light; `None` if it is valid.
    pub fn fault(&self) -> Option<String> {
        let lit = self.intensity.to_array().iter().all(|value| (0.0..=1e30).contains(value));
        let placed = matches!(self.shape, LightShape::Directional { .. })
            || self.position.is_finite()
                && f64::from(self.position.abs().max_element()) <= geometry::MAX_COORDINATE;
        if !lit || !placed {
            return Some("a position or an intensity that cannot be used".into());
        }
        let (LightShape::Spot { direction, .. } | LightShape::Directional { direction }) = self.shape else {
            return None;
        };
        if !direction.is_finite() || (direction.length() - 1.0).abs() > 1e-3 {
            return Some("a direction that is not of unit length".into());
        }
        match self.shape {
            LightShape::Spot { inner, outer, .. } => cone_fault(inner, outer),
            _ => None,
        }
    }

    /// Whether its light is parallel.
    pub fn is_directional(&self) -> bool {
        matches!(self.shape, LightShape::Directional { .. })
    }

    /// Its record of the light table, not yet chosen among others, and its emitted flux of each channel (W). All that parallel
    /// light meets lies within the hull of these points (m).
    pub fn record(&self, hull: &[DVec3]) -> (Light, DVec3) {
        let light = Light {
            position: self.position,
            triangle: NONE,
            emission: self.intensity,
            kind: self.shape.feature().0,
            ..Light::default()
        };
        let (light, share) = match self.shape {
            LightShape::Point => (light, 4.0 * PI),
            LightShape::Spot { direction, inner, outer } => {
                let cone = versine(outer);
                let width = cone - versine(inner);
                // The integral of the falloff over directions: the inner cone, and a third of the ring around it.
                let solid_angle = 2.0 * PI * (cone - width + width / 3.0);
                let (cone, falloff) = (cone as f32, (1.0 / width) as f32);
                (Light { direction, cone, falloff, ..light }, solid_angle)
            }
            LightShape::Directional { direction } => {
                let (position, radius) = disc_before(hull, direction);
                let area = PI * f64::from(radius) * f64::from(radius);
                (Light { direction, position, radius, ..light }, area)
            }
        };
        (light, self.intensity.as_dvec3() * share)
    }
}

/// Why these angles of a spot (rad) make no cone with a falloff.
fn cone_fault(inner: f64, outer: f64) -> Option<String> {
    // f32's pi / 2 lies a little above.
    let fits = inner >= 0.0 && inner < outer && (MIN_CONE..=FRAC_PI_2 + 1e-6).contains(&outer);
    (!fits).then(|| {
        format!(
            "an inner cone angle of {inner} rad and an outer of {outer} rad: 0 <= inner < outer <= pi / 2 is \
             needed, and an outer of at least {MIN_CONE} rad"
        )
    })
}

/// 1 - cos of an angle (rad), without cancellation.
fn versine(angle: f64) -> f64 {
    2.0 * (0.5 * angle).sin().powi(2)
}

/// Centre (m) and radius (m) of a disc across `direction` that lies before all points and through which all light passes that
/// meets their hull.
fn disc_before(hull: &[DVec3], direction: Vec3) -> (Vec3, f32) {
    let frame = ShadingFrame::new(direction);
    let (x, y, z) = (frame.x.as_dvec3(), frame.y.as_dvec3(), direction.as_dvec3());
    let corners = || hull.iter().copied();
    let across = |p: DVec3| DVec2::new(p.dot(x), p.dot(y));
    let (low, high) =
        corners().map(across).fold((DVec2::MAX, DVec2::MIN), |(low, high), p| (low.min(p), high.max(p)));
    let (nearest, farthest) =
        corners().map(|p| p.dot(z)).fold((f64::MAX, f64::MIN), |(low, high), p| (low.min(p), high.max(p)));
    let centre = 0.5 * (low + high);
    let radius = corners().map(|p| (across(p) - centre).length()).fold(0.0, f64::max);

    // A little wider and farther out than needed: starts of paths are rounded to f32.
    let size = radius.max(farthest - nearest);
    let start = x * centre.x + y * centre.y + z * (nearest - 0.01 * size);
    (start.as_vec3(), (radius + 1e-6 * size.max(start.abs().max_element())) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A right triangle in the plane z = 0.
    fn triangle() -> [DVec3; 3] {
        [DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0), DVec3::new(0.0, 2.0, 0.0)]
    }

    fn directional(direction: Vec3) -> PunctualLight {
        PunctualLight { shape: LightShape::Directional { direction }, ..PunctualLight::default() }
    }

    #[test]
    fn discs_lie_before_the_scene_and_cover_it() {
        for direction in [Vec3::NEG_Z, Vec3::Z, Vec3::X, Vec3::new(0.6, 0.0, -0.8)] {
            let (light, _) = directional(direction).record(&triangle());
            for corner in triangle() {
                let along = corner.as_vec3() - light.position;
                let depth = along.dot(direction);
                assert!(depth > 0.0, "{direction}: {depth}");
                assert!((along - direction * depth).length() < light.radius);
            }
            // The disc is no wider than the circle around the bounds of the scene.
            assert!(light.radius < 2.0_f32.sqrt() + 1e-4, "{}", light.radius);
        }
    }

    #[test]
    fn fluxes_are_integrals_of_the_intensity() {
        let spot = |inner, outer| PunctualLight {
            intensity: Vec3::ONE,
            shape: LightShape::Spot { direction: Vec3::Z, inner, outer },
            ..PunctualLight::default()
        };
        // By a fine sum over the angle.
        let (inner, outer) = (0.3_f64, 0.8_f64);
        let step = outer / 1e5;
        let sum: f64 = (0..100_000)
            .map(|i| {
                let angle = (f64::from(i) + 0.5) * step;
                let line = ((angle.cos() - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
                2.0 * PI * angle.sin() * step * line * line
            })
            .sum();
        assert!((spot(inner, outer).record(&[]).1.x / sum - 1.0).abs() < 1e-8);
        let flat =
            PunctualLight { intensity: Vec3::splat(3.0), ..directional(Vec3::NEG_Z) }.record(&triangle());
        assert!((flat.1.x / (3.0 * PI * 2.0) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn lights_that_shine_nowhere_are_refused() {
        assert_eq!(directional(Vec3::Z).fault(), None);
        assert!(directional(Vec3::ZERO).fault().is_some());
        assert!(directional(Vec3::splat(f32::NAN)).fault().is_some());
        assert!(PunctualLight::point(Vec3::ZERO, Vec3::NEG_X).fault().is_some());
        for (inner, outer) in [(0.0, FRAC_PI_2), (0.0, f64::from(std::f32::consts::FRAC_PI_2)), (0.5, 0.6)] {
            assert_eq!(cone_fault(inner, outer), None);
        }
        for (inner, outer) in [(0.5, 0.5), (0.6, 0.5), (-0.1, 0.5), (0.0, 1.6), (0.0, 1e-6), (0.0, f64::NAN)]
        {
            assert!(cone_fault(inner, outer).unwrap().contains("cone angle"));
        }
    }
}
