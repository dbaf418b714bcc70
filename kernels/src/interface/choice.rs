//! Choices between a few settings that are no files of their own: their values as kernels compare them, and as users name them.

/// A choice: its values, with their names and what they are.
macro_rules! choice {
    (
        $(#[$documentation:meta])* $choice:ident
        $($(#[$of_value:meta])* $value:ident $name:literal $description:literal)*
    ) => {
        $(#[$documentation])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u32)]
        pub enum $choice {
            $($(#[$of_value])* $value,)*
        }

        #[cfg(not(target_arch = "spirv"))]
        impl $choice {
            /// Every value.
            pub const ALL: &[$choice] = &[$($choice::$value),*];

            /// Its name on the command line.
            pub fn name(self) -> &'static str {
                match self {
                    $($choice::$value => $name,)*
                }
            }

            /// Description, in one line.
            pub fn description(self) -> &'static str {
                match self {
                    $($choice::$value => $description,)*
                }
            }
        }

        #[cfg(not(target_arch = "spirv"))]
        impl $crate::interface::named::Named for $choice {
            fn all() -> Vec<Self> {
                Self::ALL.to_vec()
            }

            fn name(self) -> &'static str {
                Self::name(self)
            }

            fn description(self) -> &'static str {
                Self::description(self)
            }
        }
    };
}

choice! {
    /// Which light is a caustic, and so the light paths'; all other is found from the camera.
    Caustics
    /// What meets a specular lobe first. Light of diffuse surfaces that meets one later is found by light sampling at those
    /// surfaces, with far less noise, unless what is lit first is small and bright.
    First "first" "light whose first surface is specular; the camera finds the rest"
    /// What meets a specular lobe anywhere, as published [Moreau and Doggett 2022].
    Any "any" "light that met anything specular before its collection point, as published"
}

choice! {
    /// How camera paths find lights at their first vertices, up to the collection point.
    LightSampler
    /// All lights where they are few, else the best of some.
    Resampled "resampled" "all of up to four lights, else one of eight candidates by what they would give"
    /// One light a vertex, sampled by its power, as published.
    Power "power" "one light, sampled by its power"
    /// One light a vertex, each as likely as the others: what the other settings are held against.
    Uniform "uniform" "one light, all alike"
}

choice! {
    /// Where the random numbers of camera paths come from.
    Sampler
    /// Every number is independent of all others.
    Independent "independent" "every number by itself"
    /// A pixel's frames take turns in low-discrepancy sequences: the more they are, the more evenly they fill.
    Sobol "sobol" "a pixel's frames spread evenly, by Owen-scrambled Sobol sequences"
    /// The same, and of each frame the pixels beside each other.
    Blue "blue" "the same, and pixels beside each other spread evenly too: their noise is fine and evens out"
}

choice! {
    /// Path-traced light of the previous frame that collection points reuse.
    PathHistory
    /// Nothing.
    None "none" "nothing: path-traced light does not outlive its frame"
    /// As many frames' worth as paths that are traced again say still hold.
    Validated "validated" "up to 32 frames that still hold by paths traced again, in a still view all of them"
}

choice! {
    /// What is done about rare bright samples of camera paths.
    Fireflies
    /// Nothing: frames are unbiased.
    Kept "kept" "nothing: frames are unbiased"
    /// They are bounded by the pixels around, and their energy is lost.
    Bounded "bounded" "at most eight times the mean around, which loses one or two hundredths of the light"
}

choice! {
    /// Positions in a pixel that camera rays pass through.
    PixelFilter
    /// The centre.
    Centre "centre" "rays through pixel centres"
    /// Positions that are uniform over the pixel.
    Box "box" "rays uniform over the pixel"
}

choice! {
    /// Level of its textures that a camera prefix sees; every other path sees the finest.
    TextureFilter
    /// That of the pixel's ray cone: one ray a pixel does not flicker, and materials are not what they are close by.
    Cone "cone" "that of the pixel's footprint: still in one frame, not quite the material"
    /// The finest: rays over the whole pixel must average it, and then its image is right.
    Finest "finest" "the finest: right where rays over the whole pixel are averaged"
}
