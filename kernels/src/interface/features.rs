//! What a scene needs of the kernels: one bit set, a specialisation constant on the GPU, a value on the CPU.

use core::ops::BitOr;

/// Bits of what the scene needs. Code behind a bit that is not set is dead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features(pub u32);

impl Features {
    /// Some surface is metal of roughness >= 0.08.
    pub const METAL: Features = Features(1);
    /// Some metal is a delta mirror.
    pub const MIRROR: Features = Features(1 << 1);
    /// Some dielectric has a coat over its diffuse base.
    pub const COAT: Features = Features(1 << 2);
    /// Some surface transmits.
    pub const GLASS: Features = Features(1 << 3);
    /// Some volume absorbs.
    pub const ABSORPTION: Features = Features(1 << 4);
    /// Some triangle emits.
    pub const AREA_LIGHTS: Features = Features(1 << 5);
    /// There is a point light.
    pub const POINT_LIGHTS: Features = Features(1 << 6);
    /// Some surface casts caustics: it has a specular lobe.
    pub const CASTERS: Features = Features(1 << 7);
    /// Vertex normals differ from the face's somewhere.
    pub const SMOOTH_NORMALS: Features = Features(1 << 8);
    /// Some surface has a non-specular lobe and can show a caustic.
    pub const RECEIVERS: Features = Features(1 << 9);
    /// Some transmission is rough.
    pub const ROUGH_GLASS: Features = Features(1 << 10);
    /// There is a spot light.
    pub const SPOT_LIGHTS: Features = Features(1 << 11);
    /// There is a directional light.
    pub const DIRECTIONAL_LIGHTS: Features = Features(1 << 12);
    /// Some material is textured.
    pub const TEXTURES: Features = Features(1 << 13);
    /// Some material has a normal map.
    pub const NORMAL_MAPS: Features = Features(1 << 14);
    /// Some surface has holes: its alpha is cut off.
    pub const CUT_OUTS: Features = Features(1 << 15);
    /// Somebody asks where the light's energy goes.
    pub const LEDGER: Features = Features(1 << 16);
    /// The eye or a light stands inside of a medium.
    pub const ENCLOSED: Features = Features(1 << 17);
    /// Some mesh moves.
    pub const INSTANCES: Features = Features(1 << 18);
    /// Solids of media may overlap, or some medium is a sheet.
    pub const NESTED: Features = Features(1 << 19);
    /// Some medium is a sheet: its surface is open.
    pub const SHEETS: Features = Features(1 << 20);
    /// Points lend to those of the next frame: where mirrors and lenses image them is known.
    pub const HISTORY: Features = Features(1 << 21);
    /// Everything.
    pub const ALL: Features = Features((1 << 22) - 1);
    /// Bits and names, for printing.
    pub const NAMES: [(Features, &'static str); 22] = [
        (Self::METAL, "metal"),
        (Self::MIRROR, "mirror"),
        (Self::COAT, "coat"),
        (Self::GLASS, "glass"),
        (Self::ABSORPTION, "absorption"),
        (Self::AREA_LIGHTS, "area-lights"),
        (Self::POINT_LIGHTS, "point-lights"),
        (Self::CASTERS, "casters"),
        (Self::SMOOTH_NORMALS, "smooth-normals"),
        (Self::RECEIVERS, "receivers"),
        (Self::ROUGH_GLASS, "rough-glass"),
        (Self::SPOT_LIGHTS, "spot-lights"),
        (Self::DIRECTIONAL_LIGHTS, "directional-lights"),
        (Self::TEXTURES, "textures"),
        (Self::NORMAL_MAPS, "normal-maps"),
        (Self::CUT_OUTS, "cut-outs"),
        (Self::LEDGER, "ledger"),
        (Self::ENCLOSED, "enclosed"),
        (Self::INSTANCES, "instances"),
        (Self::NESTED, "nested"),
        (Self::SHEETS, "sheets"),
        (Self::HISTORY, "history"),
    ];

    /// Whether any bit of `other` is set.
    #[inline]
    pub fn has(self, other: Features) -> bool {
        self.0 & other.0 != 0
    }
}

impl BitOr for Features {
    type Output = Features;
    #[inline]
    fn bitor(self, other: Features) -> Features {
        Features(self.0 | other.0)
    }
}
