//! BSDF mixture: selection probabilities, evaluation and sampling of all lobes, made from the list `for_each_lobe`.

use crate::interface::features::Features;
use crate::interface::material::Material;
use crate::surface::class::Classes;
use crate::surface::{Bsdf, Evaluated, ggx};
#[cfg(not(target_arch = "spirv"))]
use crate::surface::{class, dielectric};
use spirv_std::glam::{Vec3, Vec4};

/// Declares probabilities, sums and choices, one line for each lobe.
macro_rules! lobes {
    (
        facets { $($facet:ident $rough:ident $smooth:ident;)* }
        diffuse { $first:ident; $($diffuse:ident $bit:ident;)* }
    ) => {
        use crate::surface::{$($facet,)* $first $(, $diffuse)*};

        /// Features of rough reflections at facets.
        pub const ROUGH_FACETS: Features = Features(Features::ROUGH_DIELECTRIC.0 $(| Features::$rough.0)*);
        /// Features of smooth reflections.
        pub const SMOOTH_FACETS: Features = Features(0 $(| Features::$smooth.0)*);

        /// Probability of each lobe to be chosen; they sum to 1, or to 0 where nothing scatters.
        #[derive(Clone, Copy, Debug, Default)]
        pub struct LobeProbabilities {
            $(pub $facet: f32,)*
            pub $first: f32,
            $(pub $diffuse: f32,)*
            /// Smooth dielectric, or transmission by a rough one.
            pub dielectric: f32,
            /// Reflection by a rough dielectric.
            pub gloss: f32,
        }

        impl LobeProbabilities {
            /// Probability of all reflections at facets.
            #[inline]
            pub fn reflections(&self) -> f32 {
                0.0 $(+ self.$facet)* + self.gloss
            }

            /// Probability of all diffuse lobes.
            #[inline]
            pub fn diffuse(&self) -> f32 {
                self.$first $(+ self.$diffuse)*
            }

            /// Scales the probabilities to a sum of 1.
            #[inline(always)]
            pub fn normalised(self) -> LobeProbabilities {
                let sum = 0.0 $(+ self.$facet)* + self.$first $(+ self.$diffuse)* + self.dielectric + self.gloss;
                let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
                LobeProbabilities {
                    $($facet: self.$facet * scale,)*
                    $first: self.$first * scale,
                    $($diffuse: self.$diffuse * scale,)*
                    dielectric: self.dielectric * scale,
                    gloss: self.gloss * scale,
                }
            }
        }

        impl Bsdf {
            /// Sampling weights of the lobes of `classes` without the dielectric: approximate shares of the flux that each
            /// scatters.
            #[inline(always)]
            pub(super) fn sampling_weights(&self, classes: Classes) -> LobeProbabilities {
                let mut probabilities = LobeProbabilities::default();
                if classes.has(self.reflection_class) {
                    $(
                        if self.features.has(Features::$rough | Features::$smooth) {
                            probabilities.$facet = $facet::sampling_weight(self);
                        }
                    )*
                }
                if classes.has(Classes::NON_SPECULAR) {
                    probabilities.$first = $first::sampling_weight(self);
                    $(
                        if self.features.has(Features::$bit) {
                            probabilities.$diffuse = $diffuse::sampling_weight(self);
                        }
                    )*
                }
                probabilities
            }

            /// Evaluates reflections at facets without that of the dielectric. `facets` = D G / (4 cos cos), `reflected` is their
            /// density (1/sr).
            #[inline(always)]
            pub(super) fn eval_facets(&self, facets: f32, reflected: f32, cos_half: f32) -> Evaluated {
                let (mut f, mut pdf_solid_angle) = (Vec3::ZERO, 0.0);
                $(
                    if self.features.has(Features::$rough) {
                        f += $facet::eval(self, facets, cos_half);
                        pdf_solid_angle += self.probabilities.$facet * reflected;
                    }
                )*
                Evaluated { f, pdf_solid_angle }
            }

            /// Adds the diffuse lobes in a direction to `others`.
            #[inline(always)]
            pub(super) fn eval_diffuse(&self, direction: Vec3, others: Evaluated) -> Evaluated {
                #[allow(unused_mut)]
                let (mut f, mut pdf_solid_angle) = (
                    others.f + $first::eval(self, direction),
                    others.pdf_solid_angle + self.probabilities.$first * $first::pdf(self, direction),
                );
                $(
                    if self.features.has(Features::$bit) {
                        f += $diffuse::eval(self, direction);
                        pdf_solid_angle += self.probabilities.$diffuse * $diffuse::pdf(self, direction);
                    }
                )*
                Evaluated { f, pdf_solid_angle }
            }

            /// Weight of the smooth reflection that `u` chooses: its reflectance over its probability.
            #[inline(always)]
            pub(super) fn smooth_weight(&self, u: f32) -> Vec3 {
                let (mut lobe, mut probability, mut before) = (Vec3::ZERO, 1.0, 0.0);
                $(
                    if self.features.has(Features::$smooth) {
                        if u >= before {
                            (lobe, probability) = ($facet::smooth(self), self.probabilities.$facet);
                        }
                        before += self.probabilities.$facet;
                    }
                )*
                let _ = before;
                lobe / probability
            }

            /// Samples a direction of the diffuse lobe that `u` chooses.
            #[inline(always)]
            pub(super) fn sample_diffuse(&self, u: Vec4) -> Vec3 {
                #[allow(unused_mut)]
                let mut direction = $first::sample(self, u.y, u.z);
                #[allow(unused_mut)]
                let mut before = self.probabilities.reflections() + self.probabilities.$first;
                $(
                    if self.features.has(Features::$bit) && self.probabilities.$diffuse > 0.0 && u.x >= before {
                        direction = $diffuse::sample(self, u.y, u.z);
                    }
                    before += self.probabilities.$diffuse;
                )*
                let _ = before;
                direction
            }
        }

        /// Whether any lobe of a material may be non-delta, before it is known which of them scatter.
        #[inline(always)]
        #[allow(unused_variables)]
        pub fn may_have_non_delta_lobe(material: &Material, features: Features) -> bool {
            material.roughness >= ggx::DELTA_ROUGHNESS
                || $first::occurs(material)
                $(|| (features.has(Features::$bit) && $diffuse::occurs(material)))*
        }

        /// Names of the lobes that a material has, except the dielectric: those that reflect at facets, and those that are diffuse.
        #[cfg(not(target_arch = "spirv"))]
        pub fn names_of(material: &Material) -> (Vec<&'static str>, Vec<&'static str>) {
            let facets = [$(($facet::occurs(material), stringify!($facet)),)*];
            let diffuse = [
                ($first::occurs(material), stringify!($first)),
                $(($diffuse::occurs(material), stringify!($diffuse)),)*
            ];
            let names = |lobes: &[(bool, &'static str)]| {
                lobes.iter().filter(|(occurs, _)| *occurs).map(|(_, name)| *name).collect()
            };
            (names(&facets), names(&diffuse))
        }

        /// Features that the lobes of a material need. Specular lobes cast caustics, all others receive them.
        #[cfg(not(target_arch = "spirv"))]
        pub fn features_of(material: &Material, specular_roughness: f32) -> Features {
            let is_specular = class::reflection(material.roughness, specular_roughness) == Classes::SPECULAR;
            let is_smooth = material.roughness < ggx::DELTA_ROUGHNESS;
            let mut features = dielectric::features_of(material);
            let mut reflects = features.has(Features::DIELECTRIC);
            $(
                if $facet::occurs(material) {
                    reflects = true;
                    features = features | if is_smooth { Features::$smooth } else { Features::$rough };
                }
            )*
            if features.has(Features::DIELECTRIC) || (reflects && is_specular) {
                features = features | Features::CASTERS;
            }
            if $first::occurs(material) || (reflects && !is_specular) {
                features = features | Features::RECEIVERS;
            }
            $(
                if $diffuse::occurs(material) {
                    features = features | Features::$bit | Features::RECEIVERS;
                }
            )*
            features
        }
    };
}
for_each_lobe!(lobes);
