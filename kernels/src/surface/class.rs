//! The class of a lobe: this module alone decides which lobes are specular.

use crate::surface::ggx::DELTA_ROUGHNESS;

/// Set of classes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Classes(pub u32);

impl Classes {
    /// Lobes that a camera prefix passes and that make caustics.
    pub const SPECULAR: Classes = Classes(1);
    /// Lobes that end a camera prefix and receive caustics.
    pub const NON_SPECULAR: Classes = Classes(2);
    /// None.
    pub const NONE: Classes = Classes(0);
    /// Both.
    pub const ALL: Classes = Classes(3);

    /// Whether the sets have a class in common.
    #[inline]
    pub fn has(self, other: Classes) -> bool {
        self.0 & other.0 != 0
    }
}

/// Class of a reflection lobe of this perceptual roughness. A delta lobe is specular whatever the threshold, since it cannot be
/// evaluated at a collection point. Transmission is always specular, Lambert never. A rough dielectric above the threshold
/// therefore has two classes: it shows caustics that it reflects and casts those that it transmits.
#[inline]
pub fn reflection(roughness: f32, specular_roughness: f32) -> Classes {
    if roughness < DELTA_ROUGHNESS || roughness <= specular_roughness {
        Classes::SPECULAR
    } else {
        Classes::NON_SPECULAR
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delta_lobes_are_specular_whatever_the_threshold() {
        assert_eq!(reflection(0.05, 0.0), Classes::SPECULAR);
        assert_eq!(reflection(0.1, 0.05), Classes::NON_SPECULAR);
        assert_eq!(reflection(0.25, 0.25), Classes::SPECULAR);
    }
}
