//! Scattering at a surface: one lobe a file, and their mixture at a vertex. Imports `interface`, `math` and
//! `texture`.
//!
//! A material is up to four lobes, weighted as glTF does: metal; a coat over a Lambertian base; glass. All rough
//! reflections share their facets. Local directions have the shading normal as z and point away from the surface.

pub mod albedo;
pub mod class;
pub mod coat;
pub mod fold;
pub mod fresnel;
pub mod ggx;
pub mod glass;
pub mod lambert;
pub mod media;
pub mod metal;
pub mod normal_map;
pub mod rough_glass;
pub mod scatter;
pub mod textured;
pub mod turn;
pub mod vertex;

use crate::interface::features::Features;
use crate::interface::material::Material;
use crate::math::mean;
use crate::surface::class::Classes;
use spirv_std::glam::{Vec3, Vec4};

/// The mixture of lobes at one vertex, seen from one direction.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    material: Material,
    /// Unit local direction to where the path came from, z > 0.
    to_previous: Vec3,
    /// Index on the path's side over index behind.
    pub eta: f32,
    /// Whether the glass has facets.
    rough_glass: bool,
    features: Features,
    chances: Chances,
    reflection_class: Classes,
}

/// Chance of each lobe to be chosen; they sum to 1, or to 0 where nothing scatters.
#[derive(Clone, Copy, Debug)]
struct Chances {
    metal: f32,
    coat: f32,
    lambert: f32,
    /// Smooth glass, or what rough glass transmits.
    glass: f32,
    /// What rough glass reflects.
    gloss: f32,
}

/// The non-delta lobes of one class towards one direction.
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
    /// Whether the direction passes without bending (a thin wall).
    pub straight: bool,
    /// Index before over index behind, for transmission.
    pub eta: f32,
    /// Perceptual roughness of the lobe, for the ray cone (0 for a delta lobe).
    pub roughness: f32,
}

impl Bsdf {
    /// The mixture of `classes`' lobes. `eta` = index on the path's side over index behind the surface.
    #[inline(always)]
    pub fn new(
        material: Material,
        to_previous: Vec3,
        eta: f32,
        specular_roughness: f32,
        classes: Classes,
        features: Features,
    ) -> (Self, GlassInterface) {
        let reflection_class = class::reflection(material.roughness, specular_roughness);
        let dielectric = 1.0 - material.metallic;
        let cos = to_previous.z;

        // Weigh each lobe by what it is about to scatter.
        let mut chances = Chances { metal: 0.0, coat: 0.0, lambert: 0.0, glass: 0.0, gloss: 0.0 };
        if features.has(Features::METAL | Features::MIRROR) && classes.has(reflection_class) {
            chances.metal = material.metallic * mean(fresnel::schlick(material.base_color, cos));
        }
        let mut under_coat = 1.0;
        if features.has(Features::COAT) {
            let reflectance = coat::reflectance(&material, cos);
            under_coat = 1.0 - reflectance;
            if classes.has(reflection_class) {
                chances.coat = dielectric * (1.0 - material.transmission) * reflectance;
            }
        }
        if classes.has(Classes::NON_SPECULAR) {
            chances.lambert =
                dielectric * (1.0 - material.transmission) * under_coat * mean(material.base_color);
        }
        let mut glass = GlassInterface { eta, reflectance: 0.0 };
        let rough_glass = features.has(Features::ROUGH_GLASS) && rough_glass::is_rough(&material, eta);
        if rough_glass {
            let share = dielectric * material.transmission;
            let reflected = rough_glass::reflection_chance(&material, cos, eta);
            if classes.has(reflection_class) {
                chances.gloss = share * reflected;
            }
            if classes.has(Classes::SPECULAR) {
                chances.glass = share * (1.0 - reflected) * mean(material.base_color);
            }
        } else if features.has(Features::GLASS) && classes.has(Classes::SPECULAR) {
            glass.reflectance = glass::reflectance(&material, cos, eta);
            let passed = (1.0 - glass.reflectance) * mean(material.base_color);
            chances.glass = dielectric * material.transmission * (glass.reflectance + passed);
        }
        let sum = chances.metal + chances.coat + chances.lambert + chances.glass + chances.gloss;
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        chances.metal *= scale;
        chances.coat *= scale;
        chances.lambert *= scale;
        chances.glass *= scale;
        chances.gloss *= scale;
        (Bsdf { material, to_previous, eta, rough_glass, features, chances, reflection_class }, glass)
    }

    /// Whether any lobe scatters.
    #[inline]
    pub fn scatters(&self) -> bool {
        self.reflections() + self.chances.lambert + self.chances.glass > 0.0
    }

    /// Chance of all reflections but Lambert's and smooth glass's.
    #[inline]
    fn reflections(&self) -> f32 {
        self.chances.metal + self.chances.coat + self.chances.gloss
    }

    /// Chance that `sample` takes a lobe of this class.
    #[inline]
    pub fn class_chance(&self, class: Classes) -> f32 {
        let mut chance = if class.has(self.reflection_class) { self.reflections() } else { 0.0 };
        if class.has(Classes::NON_SPECULAR) {
            chance += self.chances.lambert;
        }
        if class.has(Classes::SPECULAR) {
            chance += self.chances.glass;
        }
        chance
    }

    /// The non-delta lobes of `class` towards a local direction; f is that of flux, also where it passes (z < 0). Zero where
    /// the path came from below.
    #[inline(always)]
    pub fn eval(&self, direction: Vec3, class: Classes) -> Evaluated {
        let mut f = Vec3::ZERO;
        let mut pdf = 0.0;
        if self.to_previous.z <= 0.0 {
            return Evaluated { f, pdf_solid_angle: pdf };
        }
        if direction.z <= 0.0 {
            if self.rough_glass && direction.z < 0.0 && class.has(Classes::SPECULAR) {
                let (passed, density) =
                    rough_glass::eval(&self.material, self.to_previous, direction, self.eta);
                f = self.material.base_color * (self.glass_share() * passed);
                pdf = self.chances.glass * density;
            }
            return Evaluated { f, pdf_solid_angle: pdf };
        }
        let half = (self.to_previous + direction).normalize();
        let cos_half = self.to_previous.dot(half);
        let opaque = (1.0 - self.material.metallic) * (1.0 - self.material.transmission);
        let rough = self.material.roughness >= ggx::DELTA_ROUGHNESS && class.has(self.reflection_class);
        if self.features.has(Features::METAL | Features::COAT | Features::ROUGH_GLASS) && rough {
            let alpha = ggx::alpha(self.material.roughness);
            let facets = ggx::eval(self.to_previous, direction, half, alpha);
            let reflected = ggx::visible_pdf(self.to_previous, half, alpha);
            if self.features.has(Features::METAL) {
                f += metal::eval(&self.material, facets, cos_half);
                pdf += self.chances.metal * reflected;
            }
            if self.features.has(Features::COAT) {
                f += Vec3::splat(opaque * coat::eval(&self.material, facets, cos_half));
                pdf += self.chances.coat * reflected;
            }
            if self.rough_glass {
                let share = self.glass_share() * glass::reflectance(&self.material, cos_half, self.eta);
                f += Vec3::splat(share * facets);
                pdf += self.chances.gloss * reflected;
            }
        }
        if class.has(Classes::NON_SPECULAR) {
            let mut base = opaque;
            if self.features.has(Features::COAT) {
                base *= coat::base_share(&self.material, self.to_previous.z, direction.z);
            }
            f += lambert::eval(&self.material) * base;
            pdf += self.chances.lambert * lambert::pdf(direction);
        }
        Evaluated { f, pdf_solid_angle: pdf }
    }

    /// Estimate of the share of flux that all lobes of all classes scatter, apart from `sample`; `u` is uniform.
    #[inline(always)]
    pub fn albedo(&self, u: Vec4) -> Vec3 {
        albedo::albedo(&self.material, self.to_previous, self.eta, u.x, u.y)
    }

    /// Share of glass among what the material is.
    #[inline]
    fn glass_share(&self) -> f32 {
        (1.0 - self.material.metallic) * self.material.transmission
    }

    /// Samples one lobe; `u` = (choice of lobe, two for its direction, one for glass).
    #[inline(always)]
    pub fn sample(&self, glass: GlassInterface, u: Vec4) -> Sampled {
        let reflections = self.reflections();
        let into_glass = u.x >= reflections + self.chances.lambert && self.chances.glass > 0.0;
        if self.features.has(Features::GLASS) && into_glass && !self.rough_glass {
            return glass::sample(&self.material, self.to_previous, glass, self.chances.glass, u.w);
        }

        // A smooth reflection is a delta lobe of its own.
        let reflect = u.x < reflections;
        if self.features.has(Features::MIRROR | Features::COAT)
            && reflect
            && self.material.roughness < ggx::DELTA_ROUGHNESS
        {
            let cos = self.to_previous.z;
            let opaque = (1.0 - self.material.metallic) * (1.0 - self.material.transmission);
            let (lobe, chance) = if u.x < self.chances.metal {
                (fresnel::schlick(self.material.base_color, cos) * self.material.metallic, self.chances.metal)
            } else {
                (Vec3::splat(opaque * coat::reflectance(&self.material, cos)), self.chances.coat)
            };
            return Sampled {
                direction: Vec3::new(-self.to_previous.x, -self.to_previous.y, cos),
                weight: lobe / chance,
                pdf_solid_angle: 0.0,
                class: self.reflection_class,
                transmitted: false,
                straight: false,
                eta: 1.0,
                roughness: 0.0,
            };
        }

        // Everything else is weighed with all non-delta lobes of its class.
        let mut class = Classes::NON_SPECULAR;
        let mut roughness = 1.0;
        let mut direction = lambert::sample(u.y, u.z);
        let transmitted = self.rough_glass && into_glass;
        if transmitted {
            class = Classes::SPECULAR;
            roughness = self.material.roughness;
            direction = rough_glass::sample(&self.material, self.to_previous, self.eta, u.y, u.z);
        } else if self.features.has(Features::METAL | Features::COAT | Features::ROUGH_GLASS) && reflect {
            class = self.reflection_class;
            roughness = self.material.roughness;
            direction = ggx::sample(self.to_previous, ggx::alpha(roughness), u.y, u.z);
        }
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

/// What a smooth dielectric interface does at one vertex.
#[derive(Clone, Copy, Debug)]
pub struct GlassInterface {
    /// Index on the path's side over index behind.
    pub eta: f32,
    /// Share that is reflected.
    pub reflectance: f32,
}
