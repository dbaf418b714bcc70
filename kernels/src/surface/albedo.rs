//! Share of flux that a surface scatters on, estimated independently of `Bsdf::sample` for the energy ledger. It uses closed
//! forms. At facets it samples one normal from D cos [Walter et al. 2007, eq. 35, 36], with all that the facet reflects and
//! refracts. It shares neither the sampler of visible normals nor the choice of lobes, so that an error in either shows.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::features::Features;
use crate::interface::material::FLAG_THIN;
use crate::math::trig::sin_cos_turns;
use crate::surface::class::Classes;
use crate::surface::{Bsdf, dielectric, dispersion, ggx, rough_dielectric};
use spirv_std::glam::Vec3;

/// Declares sums over the lobes that reflect, except the dielectric.
macro_rules! sums {
    (
        facets { $($facet:ident $rough:ident $smooth:ident;)* }
        diffuse { $first:ident; $($diffuse:ident $bit:ident;)* }
    ) => {
        use crate::surface::{$($facet,)* $first $(, $diffuse)*};

        /// Albedo of the diffuse lobes.
        #[inline(always)]
        pub fn diffuse(bsdf: &Bsdf) -> Vec3 {
            #[allow(unused_mut)]
            let mut sum = $first::albedo(bsdf);
            $(
                if bsdf.features.has(crate::interface::features::Features::$bit) {
                    sum += $diffuse::albedo(bsdf);
                }
            )*
            sum
        }

        /// Albedo of smooth reflections.
        #[inline(always)]
        fn smooth(bsdf: &Bsdf) -> Vec3 {
            Vec3::ZERO $(+ $facet::smooth(bsdf))*
        }

        /// Albedo of rough reflections, by the flux that a facet carries.
        #[inline(always)]
        fn rough(bsdf: &Bsdf, carried: f32, cos_half: f32) -> Vec3 {
            Vec3::ZERO $(+ $facet::eval(bsdf, carried, cos_half))*
        }
    };
}
for_each_lobe!(sums);

/// Unbiased estimate of the albedo of the lobes of `classes`, for light from the side of the path; `u`, `v` are uniform.
#[inline]
pub fn albedo(bsdf: &Bsdf, classes: Classes, u: f32, v: f32) -> Vec3 {
    let Bsdf { material, to_previous, eta, .. } = *bsdf;
    let material = &material;
    let cos = to_previous.z;
    let passing = bsdf.dielectric_share();

    let mut sum = if classes.has(Classes::NON_SPECULAR) { diffuse(bsdf) } else { Vec3::ZERO };
    let (passes, reflects) = (classes.has(Classes::SPECULAR), classes.has(bsdf.reflection_class));
    let facets = material.roughness >= ggx::DELTA_ROUGHNESS;
    let rough_dielectric = rough_dielectric::is_rough(material, eta);
    // Add smooth reflections and the smooth dielectric, in closed form
    if !facets && passes {
        sum += smooth(bsdf);
    }
    if !rough_dielectric && passes {
        let mut reflected = Vec3::splat(dielectric::reflectance(material, cos, eta));
        if bsdf.features.has(Features::DISPERSION) && material.is_medium() {
            reflected = dispersion::reflectances(cos, bsdf.etas);
        }
        sum += (reflected + material.base_color * (Vec3::ONE - reflected)) * passing;
    }
    if !facets {
        return sum;
    }

    // Sample one normal from D cos. It carries F G |to_previous . half| / (cos |half.z|).
    let alpha = ggx::alpha(material.roughness);
    let tan_squared = alpha * alpha * u / (1.0 - u);
    let z = 1.0 / (1.0 + tan_squared).sqrt();
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cosine) = sin_cos_turns(v);
    let half = Vec3::new(r * cosine, r * sin, z);
    let cos_half = to_previous.dot(half);
    if cos_half <= 0.0 {
        return sum;
    }
    let seen = cos_half / (cos * z);
    let reflected = dielectric::reflectance(material, cos_half, eta);
    // Add reflection at this facet
    let cos_mirrored = 2.0 * cos_half * z - cos;
    if cos_mirrored > 0.0 && reflects {
        let carried = seen * ggx::shadowing(cos, cos_mirrored, alpha);
        sum += rough(bsdf, carried, cos_half);
        if rough_dielectric {
            sum += Vec3::splat(passing * reflected * carried);
        }
    }
    if rough_dielectric && passes {
        // Add refraction at this facet. Find the cosine behind the plane by Snell's law, or for a thin wall by mirroring.
        let square = 1.0 - eta * eta * (1.0 - cos_half * cos_half);
        let mut cos_behind = eta * cos - (eta * cos_half - square.max(0.0).sqrt()) * z;
        if material.flags & FLAG_THIN != 0 {
            cos_behind = cos_mirrored;
        }
        if cos_behind > 0.0 {
            let carried = seen * ggx::shadowing(cos, cos_behind, alpha);
            sum += material.base_color * (passing * (1.0 - reflected) * carried);
        }
    }
    sum
}
