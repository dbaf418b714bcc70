//! Scattering at a surface: one lobe a file, and their mixture at a vertex. Imports `interface`, `math` and
//! `texture`.
//!
//! A material is up to four lobes, weighted as glTF does: metal; a coat over a Lambertian base; a dielectric. All rough
//! reflections share their facets. Local directions have the shading normal as z and point away from the surface.
//!
//! A lobe is a file, a line of `for_each_lobe` and a bit of `Features`. `albedo` checks each against its closed form.

/// Calls a macro with the lobes that reflect, except the dielectric. Reflections at facets are chosen and sampled together. Such a
/// lobe has `occurs`, `sampling_weight`, `eval` and `smooth`, and bits of `Features` for where it is rough and where it is
/// smooth. A diffuse lobe is never specular, and has `occurs`, `sampling_weight`, `eval`, `pdf`, `sample` and `albedo`. The first
/// diffuse lobe has the bit of all receivers.
macro_rules! for_each_lobe {
    ($then:ident) => {
        $then! {
            facets {
                metal METAL MIRROR;
                coat COAT COAT;
            }
            diffuse {
                lambert;
            }
        }
    };
}

/// Declares the modules of these lobes.
macro_rules! modules {
    (
        facets { $($facet:ident $rough:ident $smooth:ident;)* }
        diffuse { $first:ident; $($diffuse:ident $bit:ident;)* }
    ) => {
        $(pub mod $facet;)*
        pub mod $first;
        $(pub mod $diffuse;)*
    };
}
for_each_lobe!(modules);

pub mod albedo;
pub mod class;
pub mod dielectric;
pub mod dispersion;
pub mod fresnel;
pub mod ggx;
pub mod hemisphere;
mod lobes;
pub mod media;
pub mod normal_map;
pub mod rough_dielectric;
pub mod scatter;
pub mod textured;
pub mod thin_wall;
pub mod turn;
pub mod vertex;

use crate::interface::features::Features;
use crate::interface::material::Material;
use crate::math::{mean, warp};
use crate::surface::class::Classes;
use crate::surface::dispersion::Indices;
use caustics_kernel_macros::shared;
pub use lobes::may_have_non_delta_lobe;
use lobes::{LobeProbabilities, ROUGH_FACETS, SMOOTH_FACETS};
#[cfg(not(target_arch = "spirv"))]
pub use lobes::{features_of, names_of};
use spirv_std::glam::{Vec3, Vec4};

/// BSDF at one vertex, seen from one direction: the mixture of its lobes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bsdf {
    material: Material,
    /// Unit local direction to where the path came from, z > 0.
    to_previous: Vec3,
    /// Index on the path's side over index behind.
    pub eta: f32,
    /// Ratio of indices for each channel.
    etas: Vec3,
    /// Whether the dielectric is rough: it has facets.
    rough_dielectric: bool,
    /// Whether each facet reflects or transmits by its own Fresnel reflectance; then `probabilities.dielectric` covers both.
    by_facet: bool,
    features: Features,
    probabilities: LobeProbabilities,
    reflection_class: Classes,
}

/// Non-delta lobes of one class, evaluated in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluated {
    /// Scattering function (1/sr).
    pub f: Vec3,
    /// Density with which `sample` takes that direction within the class, its choice included.
    pub pdf_solid_angle: f32,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct Sampled {
    /// Unit local direction; z < 0 for transmission.
    pub direction: Vec3,
    /// f |cos| / pdf, the lobe's choice included; zero ends the path.
    pub weight: Vec3,
    /// Density of the class's non-delta lobes; 0 marks a delta lobe.
    pub pdf_solid_angle: f32,
    /// Class of the chosen lobe.
    pub class: Classes,
    /// Whether the direction passes the surface.
    pub transmitted: bool,
    /// Whether the direction passes without refraction (a thin wall).
    pub straight: bool,
    /// Index before over index behind, for transmission.
    pub eta: f32,
    /// Perceptual roughness of the lobe, for the ray cone (0 for a delta lobe).
    pub roughness: f32,
}

impl Bsdf {
    /// Mixture of the lobes of `classes`. With `divides`, a caller divides by [`class_probability`](Self::class_probability): the
    /// class is chosen with that probability.
    #[shared]
    pub fn new(
        material: Material,
        to_previous: Vec3,
        indices: Indices,
        specular_roughness: f32,
        classes: Classes,
        divides: bool,
        features: Features,
    ) -> (Self, DielectricInterface) {
        let Indices { eta, etas, .. } = indices;
        let reflection_class = class::reflection(material.roughness, specular_roughness);
        let rough_dielectric =
            features.has(Features::ROUGH_DIELECTRIC) && rough_dielectric::is_rough(&material, eta);
        let follows_both = classes.has(reflection_class) && classes.has(Classes::SPECULAR);
        let by_facet =
            rough_dielectric && follows_both && (!divides || reflection_class == Classes::SPECULAR);
        let probabilities = LobeProbabilities::default();
        let mut bsdf = Bsdf {
            material,
            to_previous,
            eta,
            etas,
            rough_dielectric,
            by_facet,
            features,
            probabilities,
            reflection_class,
        };

        // Weigh each lobe by the flux that it is about to scatter.
        let mut probabilities = bsdf.sampling_weights(classes);
        // Weigh the dielectric: with a choice by facet, with a choice before the facet, or smooth
        let mut dielectric = DielectricInterface { indices, reflectance: 0.0, reflectances: Vec3::ZERO };
        let cos = to_previous.z;
        if by_facet {
            let reflected = dielectric::reflectance(&material, cos, eta);
            probabilities.dielectric =
                bsdf.dielectric_share() * (reflected + (1.0 - reflected) * mean(material.base_color));
        } else if rough_dielectric {
            let reflected = rough_dielectric::reflection_probability(&material, cos, eta);
            if classes.has(reflection_class) {
                probabilities.gloss = bsdf.dielectric_share() * reflected;
            }
            if classes.has(Classes::SPECULAR) {
                probabilities.dielectric =
                    bsdf.dielectric_share() * (1.0 - reflected) * mean(material.base_color);
            }
        } else if features.has(Features::DIELECTRIC)
            && classes.has(Classes::SPECULAR)
            && bsdf.dielectric_share() > 0.0
        {
            if features.has(Features::DISPERSION) && indices.is_dispersive {
                let reflectances = dispersion::reflectances(cos, etas);
                let passed = material.base_color * (Vec3::ONE - reflectances);
                dielectric.reflectances = reflectances;
                probabilities.dielectric = bsdf.dielectric_share() * indices.mean(reflectances + passed);
            } else {
                dielectric.reflectance = dielectric::reflectance(&material, cos, eta);
                let passed = (1.0 - dielectric.reflectance) * mean(material.base_color);
                probabilities.dielectric = bsdf.dielectric_share() * (dielectric.reflectance + passed);
            }
        }
        bsdf.probabilities = probabilities.normalised();
        (bsdf, dielectric)
    }

    /// Whether any lobe scatters.
    #[inline]
    pub fn scatters(&self) -> bool {
        self.probabilities.reflections() + self.probabilities.diffuse() + self.probabilities.dielectric > 0.0
    }

    /// Whether any lobe that scatters is non-delta, so that light sampling may contribute.
    #[inline]
    pub fn has_non_delta_lobe(&self) -> bool {
        let rough = self.material.roughness >= ggx::DELTA_ROUGHNESS;
        self.probabilities.diffuse() > 0.0
            || (rough && self.probabilities.reflections() > 0.0)
            || (self.rough_dielectric && self.probabilities.dielectric > 0.0)
    }

    /// Whether a lobe of this class, diffuse ones aside, may be non-delta.
    #[inline]
    pub fn has_non_delta_lobe_in(&self, class: Classes) -> bool {
        let rough = self.material.roughness >= ggx::DELTA_ROUGHNESS;
        (rough && class.has(self.reflection_class)) || (self.rough_dielectric && class.has(Classes::SPECULAR))
    }

    /// Whether any lobe that is not specular scatters.
    #[inline]
    pub fn receives(&self) -> bool {
        let mut probability = self.probabilities.diffuse();
        if self.reflection_class == Classes::NON_SPECULAR {
            probability += self.probabilities.reflections();
            if self.by_facet {
                probability += self.probabilities.dielectric;
            }
        }
        probability > 0.0
    }

    /// Probability that `sample` takes a lobe of this class, in a mixture that `divides`.
    #[inline]
    pub fn class_probability(&self, class: Classes) -> f32 {
        let mut probability =
            if class.has(self.reflection_class) { self.probabilities.reflections() } else { 0.0 };
        if class.has(Classes::NON_SPECULAR) {
            probability += self.probabilities.diffuse();
        }
        if class.has(Classes::SPECULAR) {
            probability += self.probabilities.dielectric;
        }
        probability
    }

    /// Probability that `sample` takes a diffuse lobe.
    #[inline]
    pub fn diffuse_probability(&self) -> f32 {
        self.probabilities.diffuse()
    }

    /// Evaluates the non-delta lobes of `class` in a local direction (pbrt: `f` and `PDF`). f is that of flux, for transmission
    /// (z < 0) too. Zero where the path came from below.
    #[shared]
    pub fn eval(self, direction: Vec3, class: Classes) -> Evaluated {
        let mut f = Vec3::ZERO;
        let mut pdf = 0.0;
        if self.to_previous.z <= 0.0 {
            return Evaluated { f, pdf_solid_angle: pdf };
        }
        // Transmit through a rough dielectric
        if direction.z <= 0.0 {
            if self.rough_dielectric && direction.z < 0.0 && class.has(Classes::SPECULAR) {
                let passed = rough_dielectric::eval(&self.material, self.to_previous, direction, self.eta);
                f = self.material.base_color * (self.dielectric_share() * passed.f);
                pdf = self.probabilities.dielectric * passed.pdf_solid_angle;
                if self.by_facet {
                    pdf *= rough_dielectric::shares(passed.reflectance, mean(self.material.base_color)).1;
                }
            }
            return Evaluated { f, pdf_solid_angle: pdf };
        }
        // Reflect at the facets of all rough lobes
        let rough = self.material.roughness >= ggx::DELTA_ROUGHNESS && class.has(self.reflection_class);
        if self.features.has(ROUGH_FACETS) && rough {
            let half = (self.to_previous + direction).normalize();
            let cos_half = self.to_previous.dot(half);
            let alpha = ggx::alpha(self.material.roughness);
            let facets = ggx::eval(self.to_previous, direction, half, alpha);
            let reflected = ggx::visible_pdf(self.to_previous, half, alpha);
            let mut sum = self.eval_facets(facets, reflected, cos_half);
            if self.rough_dielectric {
                let reflectance = dielectric::reflectance(&self.material, cos_half, self.eta);
                let mut probability = self.probabilities.gloss;
                if self.by_facet {
                    let tint = mean(self.material.base_color);
                    probability =
                        self.probabilities.dielectric * rough_dielectric::shares(reflectance, tint).0;
                }
                let share = self.dielectric_share() * reflectance;
                sum.f += Vec3::splat(share * facets);
                sum.pdf_solid_angle += probability * reflected;
            }
            (f, pdf) = (sum.f, sum.pdf_solid_angle);
        }
        if class.has(Classes::NON_SPECULAR) {
            // Add the diffuse lobes
            return self.eval_diffuse(direction, Evaluated { f, pdf_solid_angle: pdf });
        }
        Evaluated { f, pdf_solid_angle: pdf }
    }

    /// Estimate of the share of flux that all lobes of `classes` scatter, independent of `sample`; `u` is uniform.
    #[shared]
    pub fn albedo(self, classes: Classes, u: Vec4) -> Vec3 {
        albedo::albedo(&self, classes, u.x, u.y)
    }

    /// Share of the lobes that are neither metal nor dielectric.
    #[inline]
    fn opaque_share(&self) -> f32 {
        (1.0 - self.material.metallic) * (1.0 - self.material.transmission)
    }

    /// Share of the dielectric.
    #[inline]
    fn dielectric_share(&self) -> f32 {
        (1.0 - self.material.metallic) * self.material.transmission
    }

    /// Samples one lobe (pbrt: `Sample_f`); `u` = (choice of lobe, two for its direction, one for the dielectric).
    #[shared]
    pub fn sample(self, dielectric: DielectricInterface, u: Vec4) -> Sampled {
        let reflections = self.probabilities.reflections();
        let before_dielectric = reflections + self.probabilities.diffuse();
        let into_dielectric = u.x >= before_dielectric && self.probabilities.dielectric > 0.0;
        // Sample a smooth dielectric
        if self.features.has(Features::DIELECTRIC) && into_dielectric && !self.rough_dielectric {
            if self.features.has(Features::DISPERSION) && dielectric.indices.is_dispersive {
                let (tint, share) = (self.material.base_color, self.dielectric_share());
                let DielectricInterface { indices, reflectances, .. } = dielectric;
                let probability = self.probabilities.dielectric;
                let to_previous = self.to_previous;
                return dispersion::sample(
                    tint,
                    to_previous,
                    indices,
                    reflectances,
                    share,
                    probability,
                    u.w,
                    u.y,
                );
            }
            return dielectric::sample(
                &self.material,
                self.to_previous,
                dielectric,
                self.probabilities.dielectric,
                u.w,
            );
        }

        // Sample a smooth reflection, a delta lobe of its own.
        let reflect = u.x < reflections;
        if self.features.has(SMOOTH_FACETS) && reflect && self.material.roughness < ggx::DELTA_ROUGHNESS {
            return Sampled {
                direction: Vec3::new(-self.to_previous.x, -self.to_previous.y, self.to_previous.z),
                weight: self.smooth_weight(u.x),
                pdf_solid_angle: 0.0,
                class: self.reflection_class,
                transmitted: false,
                straight: false,
                eta: 1.0,
                roughness: 0.0,
            };
        }

        // Sample a direction of a non-delta lobe: at a facet, or diffuse.
        let mut class = Classes::NON_SPECULAR;
        let mut roughness = 1.0;
        let mut transmitted = self.rough_dielectric && into_dielectric;
        let direction;
        if self.features.has(ROUGH_FACETS) && (reflect || transmitted) {
            roughness = self.material.roughness;
            let half = warp::visible_ggx_normal(self.to_previous, ggx::alpha(roughness), u.y, u.z);
            if transmitted && self.by_facet {
                // Reuse the choice among lobes, which is uniform again within this one.
                let choice = (u.x - before_dielectric) / self.probabilities.dielectric;
                let cos_half = self.to_previous.dot(half);
                let reflectance = dielectric::reflectance(&self.material, cos_half, self.eta);
                let tint = mean(self.material.base_color);
                transmitted = choice >= rough_dielectric::shares(reflectance, tint).0;
            }
            if transmitted {
                class = Classes::SPECULAR;
                direction = rough_dielectric::refracted(&self.material, self.to_previous, self.eta, half);
            } else {
                class = self.reflection_class;
                direction = ggx::mirrored(self.to_previous, half);
            }
        } else {
            direction = self.sample_diffuse(u);
        }
        // Weigh the direction with all non-delta lobes of its class: f |cos| / pdf
        let evaluated = self.eval(direction, class);
        let mut weight = Vec3::ZERO;
        if evaluated.pdf_solid_angle > 0.0 && transmitted == (direction.z < 0.0) {
            weight = evaluated.f * (direction.z.abs() / evaluated.pdf_solid_angle);
        }
        Sampled {
            direction,
            weight,
            pdf_solid_angle: evaluated.pdf_solid_angle,
            class,
            transmitted,
            straight: false,
            eta: if transmitted { self.eta } else { 1.0 },
            roughness,
        }
    }
}

/// Smooth dielectric interface at one vertex.
#[derive(Clone, Copy, Debug)]
pub struct DielectricInterface {
    /// Index on the path's side over index behind.
    pub indices: Indices,
    /// Reflectance where all channels are refracted alike.
    pub reflectance: f32,
    /// Reflectance of each channel where they are not.
    pub reflectances: Vec3,
}
