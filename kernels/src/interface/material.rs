//! Materials as the kernels see them: glTF factors, resolved.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// A glTF metallic-roughness material with its extensions resolved to factors.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Material {
    /// Base colour (diffuse albedo, F0 of the metal, tint of transmission).
    pub base_color: Vec3,
    /// Perceptual roughness in [0, 1]; the GGX width is its square.
    pub roughness: f32,
    /// Emitted radiance (W m^-2 sr^-1).
    pub emission: Vec3,
    /// Share of metal in [0, 1].
    pub metallic: f32,
    /// Absorption coefficient inside the volume [1/m].
    pub absorption: Vec3,
    /// Index of refraction relative to vacuum.
    pub ior: f32,
    /// Share of the dielectric part that transmits instead of scattering diffusely, in [0, 1].
    pub transmission: f32,
    /// Factor on the dielectric's F0 (KHR_materials_specular); 0 removes the coat.
    pub specular: f32,
    /// Bits `FLAG_*`.
    pub flags: u32,
    /// Priority of the medium: the highest one wins where media overlap. The loader makes the file's numbers a strict order.
    pub priority: i32,
    /// 20 over the Abbe number (KHR_materials_dispersion): the difference of `ior` between channels.
    pub dispersion: f32,
    /// Index of the material of this record: its own index, or that of the first record if solids of one material have several
    /// priorities.
    pub medium: u32,
}

impl Material {
    /// Whether light passes its surface.
    #[inline]
    pub fn transmits(&self) -> bool {
        self.transmission > 0.0 && self.metallic < 1.0
    }

    /// Whether its surface bounds a medium.
    #[inline]
    pub fn is_medium(&self) -> bool {
        self.transmits() && self.flags & FLAG_THIN == 0
    }
}

/// Both faces emit.
pub const FLAG_EMIT_BOTH_SIDES: u32 = 1;
/// Transmission without a volume: an infinitely thin wall that does not refract light.
pub const FLAG_THIN: u32 = 2;
/// A medium whose surface is open or inside out: it bounds no solid, and its faces alone define where the medium is.
pub const FLAG_OPEN_SURFACE: u32 = 4;
/// An open surface that encloses no inside, as paths come round its border. Its medium fills only the space between its inner
/// side and the next face.
pub const FLAG_HANGING: u32 = 8;
/// A texture scales the base colour.
pub const FLAG_COLOR_TEXTURE: u32 = 1 << 16;
/// A texture scales roughness and metallic.
pub const FLAG_ROUGHNESS_TEXTURE: u32 = 1 << 17;
/// A texture scales the emission.
pub const FLAG_EMISSIVE_TEXTURE: u32 = 1 << 18;
/// A texture turns the shading normal.
pub const FLAG_NORMAL_MAP: u32 = 1 << 19;
/// The surface is absent where alpha is below the cut-off.
pub const FLAG_CUT_OUT: u32 = 1 << 20;
/// Alpha is the share of rays that meet the surface.
pub const FLAG_BLEND: u32 = 1 << 21;
/// Some texture changes how the surface scatters from point to point.
pub const FLAGS_SCATTER_TEXTURE: u32 = FLAG_COLOR_TEXTURE | FLAG_ROUGHNESS_TEXTURE | FLAG_NORMAL_MAP;
/// Some texture is looked up where a path scatters.
pub const FLAGS_TEXTURE: u32 = FLAGS_SCATTER_TEXTURE | FLAG_EMISSIVE_TEXTURE;

const _: () = assert!(size_of::<Material>() == 72);
