//! Features that a scene needs of the kernels: one bit set, a specialisation constant on the GPU, a value on the CPU.

use core::ops::BitOr;

use crate::interface::light::for_each_light;

/// Bits of the features that the scene needs. Code behind a bit that is not set is dead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features(pub u32);

/// Declares the bits, a line each, with their names.
macro_rules! bits {
    ($($(#[$doc:meta])* $bit:ident $name:literal;)*) => {
        /// Positions of the bits.
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Bit {
            $($bit,)*
            COUNT,
        }

        impl Features {
            $(
                $(#[$doc])*
                pub const $bit: Features = Features(1 << Bit::$bit as u32);
            )*
            /// All features.
            pub const ALL: Features = Features(u32::MAX >> (u32::BITS - Bit::COUNT as u32));
            /// Bits and names, for printing.
            pub const NAMES: [(Features, &'static str); Bit::COUNT as usize] = [$((Self::$bit, $name)),*];
        }
    };
}

/// The bits of the types of lights, and all others.
macro_rules! lights_and_others {
    ($($(#[$doc:meta])* $file:ident $light:ident $name:literal;)*) => {
        bits! {
            $($(#[$doc])* $light $name;)*
            /// Some surface is metal of roughness >= 0.08.
            METAL "metal";
            /// Some metal is a delta mirror.
            MIRROR "mirror";
            /// Some dielectric has a coat over its diffuse base.
            COAT "coat";
            /// Some surface transmits.
            DIELECTRIC "glass";
            /// Some volume absorbs.
            ABSORPTION "absorption";
            /// Some surface casts caustics: it has a specular lobe.
            CASTERS "casters";
            /// Vertex normals differ from the face's somewhere.
            SMOOTH_NORMALS "smooth-normals";
            /// Some surface has a non-specular lobe and can show a caustic.
            RECEIVERS "receivers";
            /// Some transmission is rough.
            ROUGH_DIELECTRIC "rough-glass";
            /// Some material is textured.
            TEXTURES "textures";
            /// Some material has a normal map.
            NORMAL_MAPS "normal-maps";
            /// Some surface has holes: its alpha is cut off.
            CUT_OUTS "cut-outs";
            /// The energy ledger is recorded.
            LEDGER "ledger";
            /// The eye or a light stands inside of a medium.
            STARTS_IN_MEDIUM "starts-in-medium";
            /// Some mesh moves, or is stored once for many nodes.
            INSTANCES "instances";
            /// Solids of media may overlap, or the surface of some medium is open.
            NESTED "nested";
            /// The surface of some medium is open.
            OPEN_SURFACES "open-surfaces";
            /// Points are reused in the next frame, so their virtual images in mirrors and lenses are computed.
            HISTORY "history";
            /// Path-traced light is bounded, smoothed or reused, so its parts are stored.
            PARTS "parts";
            /// Some surface blends: a share of rays meets it.
            BLENDS "blends";
            /// Some medium refracts colours differently.
            DISPERSION "dispersion";
            /// Some thin wall lets light samples pass.
            THIN_WALLS "thin-walls";
            /// Emission is guided, and some lights share its maps.
            LIGHT_PYRAMIDS "light-pyramids";
            /// Vertices sample lights by the light BVH.
            LIGHT_BVH "light-bvh";
            /// Collection points share indirect light, or camera paths end in a radiance cache: paths keep what they find behind a vertex.
            INDIRECT "indirect";
        }
    };
}
for_each_light!(lights_and_others);

impl Features {
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
