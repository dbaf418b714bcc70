//! `resolve.history`: flux to radiance, with what the frame before lent; and what this frame leaves to the next one.

use crate::gather::accumulator::Sum;
use crate::gather::contribution::contribution;
use crate::interface::frame::FrameParams;
use crate::interface::history::{HistoryPoint, HistorySettings, Lent};
use crate::interface::material::Material;
use crate::interface::needs::Needs;
use crate::interface::point::{DepositLight, PointGeometry, PointShading};
use crate::math::{PI, octahedral};
use crate::surface::textured::material_of;
use spirv_std::glam::Vec3;

/// A pixel's caustic, and its part of the history.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Remembered {
    /// Radiance of the caustic [W m^-2 sr^-1].
    pub radiance: Vec3,
    /// The point, as the next frame finds it.
    pub point: HistoryPoint,
    /// The light that it lends (see `Lent::mean`).
    pub mean: Vec3,
}

/// Reflectance below which light cannot be told from what a point reflects [1/sr].
const LEAST_REFLECTANCE: f32 = 1.0e-4;

/// Blends the light of this frame with what was lent: (n old + new) / (n + 1).
#[inline(always)]
pub fn remember(
    pixel: u32,
    point: &PointGeometry,
    shading: &PointShading,
    materials: &[Material],
    accumulator: &[u32],
    lent: &Lent,
    settings: &HistorySettings,
    params: &FrameParams,
    needs: Needs,
) -> Remembered {
    let mut out = Remembered::default();
    out.point.position = point.position;
    if point.depth == 0 {
        return out;
    }
    let (sum, _) = Sum::read(accumulator, pixel, params.quantum);
    // In the order of `resolve`: without history the picture is the same to the bit.
    out.radiance = shading.throughput * (sum / point.radius) / (PI * point.radius);
    let fresh = (sum / point.radius) / (PI * point.radius);

    // What a Lambertian point reflects is the product of its light and this, to the bit; what others reflect, nearly.
    let mut reflectance = Vec3::ONE;
    if settings.demodulates != 0 {
        let head_on =
            DepositLight { to_light: shading.shading_normal, flux: Vec3::ONE, ..Default::default() };
        let material = material_of(shading, materials, needs);
        reflectance = contribution(shading, material, &head_on, params.specular_roughness, needs);
    }
    if reflectance.max_element() < LEAST_REFLECTANCE {
        return out;
    }
    let share = 1.0 / (lent.samples + 1.0);
    out.mean = demodulated(fresh, reflectance);
    if lent.samples > 0.0 {
        out.mean = lent.mean + (out.mean - lent.mean) * share;
        out.radiance = shading.throughput * reflectance * out.mean;
    }
    out.point = HistoryPoint {
        position: point.position + lent.offset * (1.0 - share),
        radius: point.radius,
        normal: octahedral::encode(point.normal),
        to_viewer: octahedral::encode(shading.to_viewer),
        material: shading.material,
        samples: lent.samples + 1.0,
    };
    out
}

/// Light over reflectance; a channel that is not reflected is taken for the mean of the others.
#[inline(always)]
fn demodulated(radiance: Vec3, reflectance: Vec3) -> Vec3 {
    let is_seen = |r: f32| if r >= LEAST_REFLECTANCE { 1.0 } else { 0.0 };
    let seen = Vec3::new(is_seen(reflectance.x), is_seen(reflectance.y), is_seen(reflectance.z));
    let light = seen * radiance / reflectance.max(Vec3::splat(LEAST_REFLECTANCE));
    let mean = light.element_sum() / seen.element_sum();
    light + (Vec3::ONE - seen) * mean
}
