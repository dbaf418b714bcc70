//! Choices between a few settings without files of their own: their values in kernels, and their names for users.

/// Declares a choice: its values, with their names and descriptions.
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

            /// Name on the command line.
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
    /// Light that counts as a caustic: light paths carry it, and camera paths find all other light.
    Caustics
    /// Light that meets a specular lobe first. Light of diffuse surfaces that meets one later is found by light sampling at those
    /// surfaces. That has far less noise, unless the surface lit first is small and bright.
    First "first" "light whose first surface is specular; camera paths find all other light"
    /// Light that meets a specular lobe anywhere, as published [Moreau and Doggett 2022].
    Any "any" "light that met a specular surface anywhere before its collection point, as published"
}

choice! {
    /// Treatment of thin smooth walls of glass, which refract nothing.
    ThinWalls
    /// Light samples and paths pass them: passing is no scattering event.
    Passed "passed" "light samples pass them, and passing is no bounce: windows, shades and bulbs have little noise"
    /// Passing is a specular event, as published.
    Event "event" "a specular event, as published: all light through them is a caustic"
}

choice! {
    /// Choice of lights at the first vertices of camera paths, up to the collection point.
    LightSampler
    /// All lights where they are few, else the best of several candidates.
    Resampled "resampled" "all lights where there are up to four; else one of eight candidates, by its unshadowed contribution"
    /// One light a vertex, sampled by its power, as published.
    Power "power" "one light, sampled by its power"
    /// One light a vertex, all with equal probability: the baseline for the other settings.
    Uniform "uniform" "one light, all with equal probability"
    /// All lights where they are few, else the best of several candidates from the light BVH.
    Bvh "bvh" "as resampled, with candidates that the light BVH samples for the vertex; one such light behind the collection point"
}

choice! {
    /// Source of the random numbers of camera paths.
    Sampler
    /// Every number is independent of all others.
    Independent "independent" "independent random numbers"
    /// Low-discrepancy sequences in which a pixel's frames take turns: more frames fill them more evenly.
    Sobol "sobol" "Owen-scrambled Sobol sequences over the frames of a pixel"
    /// Sobol sequences that also spread evenly over the neighbouring pixels of each frame.
    Blue "blue" "Sobol sequences that also spread evenly over neighbouring pixels: the noise is fine-grained"
}

choice! {
    /// Path-traced light of the previous frame that collection points reuse.
    PathHistory
    /// No path-traced light.
    None "none" "no reuse of path-traced light"
    /// Light of as many frames as still hold by the paths that are traced again.
    Validated "validated" "reuses up to 32 frames, validated by paths that are traced again; in a still view all frames"
}

choice! {
    /// Indirect light that collection points share.
    IndirectShare
    /// Each point shows what its own camera path found.
    None "none" "none: each pixel shows what its own camera path found"
    /// Points show the mean of the samples of points around them.
    Points "points" "collection points share samples within a few pixels, fewer with every frame: far less noise, and some blur"
}

choice! {
    /// Ends of camera paths at the second non-specular vertex.
    IndirectEnd
    /// None: every camera path goes on.
    Path "path" "every camera path goes on until it leaves the scene or Russian roulette ends it"
    /// Diffuse surfaces that the radiance cache knows.
    Cache "cache" "most paths end in a radiance cache, which earlier frames filled: less time and noise, and some blur of light"
}

choice! {
    /// Treatment of rare bright samples of camera paths.
    Fireflies
    /// None: frames are unbiased.
    Kept "kept" "keeps them: frames are unbiased"
    /// Bound by the pixels around, which loses the energy above the bound.
    Bounded "bounded" "bounds them by eight times the mean around, which loses 1 to 2 % of the light"
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
    /// Level of the pixel's ray cone: one ray a pixel does not flicker, but materials look different from close by.
    Cone "cone" "the level of the pixel's footprint: one frame has no aliasing, but materials look slightly different"
    /// Finest level: correct where rays over the whole pixel average it.
    Finest "finest" "the finest level: exact where rays over the whole pixel are averaged"
}
