//! The class of a lobe: the one place that decides which lobes are specular.

/// A set of classes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Classes(pub u32);

impl Classes {
    /// Lobes that a camera prefix passes and that make caustics.
    pub const SPECULAR: Classes = Classes(1);
    /// Lobes that end a camera prefix and receive caustics.
    pub const NON_SPECULAR: Classes = Classes(2);
    /// Both.
    pub const ALL: Classes = Classes(3);

    /// Whether the sets meet.
    #[inline]
    pub fn has(self, other: Classes) -> bool {
        self.0 & other.0 != 0
    }
}

/// Class of a reflection lobe of this perceptual roughness. Transmission is always specular, Lambert never.
#[inline]
pub fn reflection(roughness: f32, specular_roughness: f32) -> Classes {
    if roughness <= specular_roughness { Classes::SPECULAR } else { Classes::NON_SPECULAR }
}
