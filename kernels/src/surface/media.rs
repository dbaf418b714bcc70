//! The stack of nested media that a path is inside of: up to four materials, innermost first.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::NONE;
use crate::interface::material::Material;
use spirv_std::glam::Vec3;

/// Materials around a point, innermost first; `NONE` where the stack ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MediaStack {
    inner: u32,
    second: u32,
    third: u32,
    fourth: u32,
}

impl MediaStack {
    /// Vacuum.
    pub const VACUUM: MediaStack = MediaStack { inner: NONE, second: NONE, third: NONE, fourth: NONE };

    /// The stack inside `material`; the outermost is forgotten if four are there already (second value true).
    #[inline]
    pub fn entered(self, material: u32) -> (Self, bool) {
        let inside =
            MediaStack { inner: material, second: self.inner, third: self.second, fourth: self.third };
        (inside, self.fourth != NONE)
    }

    /// The stack after leaving `material`; unchanged if the path was not inside.
    #[inline]
    pub fn left(self, material: u32) -> Self {
        let MediaStack { inner, second, third, fourth } = self;
        if inner == material {
            MediaStack { inner: second, second: third, third: fourth, fourth: NONE }
        } else if second == material {
            MediaStack { inner, second: third, third: fourth, fourth: NONE }
        } else if third == material {
            MediaStack { inner, second, third: fourth, fourth: NONE }
        } else if fourth == material {
            MediaStack { inner, second, third, fourth: NONE }
        } else {
            self
        }
    }

    /// Whether the path is inside `material`.
    #[inline]
    pub fn holds(self, material: u32) -> bool {
        self.inner == material || self.second == material || self.third == material || self.fourth == material
    }

    /// The stack inside `material` that is around all of it; forgotten if four are there already.
    #[inline]
    pub fn inside_of(self, material: u32) -> Self {
        let MediaStack { inner, second, third, fourth } = self;
        if inner == NONE {
            MediaStack { inner: material, ..self }
        } else if second == NONE {
            MediaStack { second: material, ..self }
        } else if third == NONE {
            MediaStack { third: material, ..self }
        } else if fourth == NONE {
            MediaStack { inner, second, third, fourth: material }
        } else {
            self
        }
    }

    /// Index of refraction here.
    #[inline(always)]
    pub fn ior(self, materials: &[Material]) -> f32 {
        if self.inner == NONE { 1.0 } else { materials[self.inner as usize].ior }
    }

    /// Share of light left after `distance` [m] here.
    #[inline(always)]
    pub fn transmittance(self, materials: &[Material], distance: f32) -> Vec3 {
        if self.inner == NONE {
            return Vec3::ONE;
        }
        let absorption = materials[self.inner as usize].absorption;
        Vec3::new(
            (-absorption.x * distance).exp(),
            (-absorption.y * distance).exp(),
            (-absorption.z * distance).exp(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn media_may_be_left_out_of_order() {
        let (stack, _) = MediaStack::VACUUM.entered(1);
        let (stack, overflow) = stack.entered(2);
        assert!(!overflow);
        assert_eq!(stack.left(1), MediaStack::VACUUM.entered(2).0);
        assert_eq!(stack.left(2), MediaStack::VACUUM.entered(1).0);
        assert_eq!(stack.left(9), stack);
    }

    #[test]
    fn a_stack_grows_from_both_ends() {
        let (stack, _) = MediaStack::VACUUM.inside_of(2).inside_of(3).entered(1);
        let (same, _) = MediaStack::VACUUM.entered(3).0.entered(2).0.entered(1);
        assert_eq!(stack, same);
        assert!(stack.holds(3) && !stack.holds(4) && stack.inside_of(4).inside_of(5).holds(4));
        assert!(!stack.inside_of(4).inside_of(5).holds(5), "only four fit");
    }

    #[test]
    fn the_fifth_medium_is_counted() {
        let mut stack = MediaStack::VACUUM;
        for id in 0..4 {
            let (inside, overflow) = stack.entered(id);
            assert!(!overflow);
            stack = inside;
        }
        assert!(stack.entered(4).1);
    }

    #[test]
    fn absorption_follows_beer() {
        let mut material = Material { absorption: Vec3::new(0.0, 1.0, 2.0), ..Default::default() };
        material.ior = 1.5;
        let inside = MediaStack::VACUUM.entered(0).0;
        let left = inside.transmittance(&[material], 0.5);
        assert!((left - Vec3::new(1.0, (-0.5f32).exp(), (-1.0f32).exp())).length() < 1e-6);
        assert_eq!(inside.ior(&[material]), 1.5);
    }
}
