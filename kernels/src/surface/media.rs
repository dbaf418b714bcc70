//! The media around a position: up to four materials, the one of highest priority first [Schmidt and Budge 2002].
//!
//! They depend on the position alone, whatever way a path took there: light and camera paths find the same media. Light travels
//! in the first medium. A face whose first medium is the same on both sides does nothing.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::material::{FLAG_HANGING, FLAG_OPEN_SURFACE, Material};
use crate::surface::dispersion::Channel;
use caustics_kernel_macros::shared;
use spirv_std::glam::{UVec2, Vec3};

/// Largest number of media in a stack.
const DEPTH: u32 = 4;

/// Largest number of materials of a scene, whose ids take half a word.
pub const MAX_MATERIALS: usize = NO_MEDIUM as usize;

/// Entry of a stack without a medium.
const NO_MEDIUM: u32 = 0xffff;

/// Materials around a position by falling priority; a material stands twice where two of its solids overlap. A path keeps three
/// stacks in registers of a GPU, so two materials share a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MediaStack {
    /// First material in the lower half, second in the upper.
    upper: u32,
    /// Third material in the lower half, fourth in the upper.
    lower: u32,
}

/// The media on both sides of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sides {
    /// Media on the side that the path came from.
    pub before: MediaStack,
    /// Media on the other side.
    pub behind: MediaStack,
    /// Media along the segment that ends at the face.
    pub along: MediaStack,
    /// Whether the face agrees with the media of the path: it leaves no medium that the path was not in.
    pub is_expected: bool,
    /// Whether a fifth medium overflowed the stack.
    pub overflow: bool,
}

impl Sides {
    /// Whether one medium, of higher priority than the face's, lies on both sides: the face does nothing.
    #[inline(always)]
    pub fn is_covered(self, materials: &[Material]) -> bool {
        let (before, behind) = (self.before.first(), self.behind.first());
        if before == behind || before == NO_MEDIUM || behind == NO_MEDIUM {
            return before == behind;
        }
        materials[before as usize].medium == materials[behind as usize].medium
    }
}

impl MediaStack {
    /// Vacuum.
    pub const VACUUM: MediaStack = MediaStack { upper: NONE, lower: NONE };

    /// Packs the stack into two words.
    #[inline(always)]
    pub fn words(self) -> UVec2 {
        UVec2::new(self.upper, self.lower)
    }

    /// Unpacks a stack from two words.
    #[inline(always)]
    pub fn from_words(words: UVec2) -> Self {
        MediaStack { upper: words.x, lower: words.y }
    }

    #[inline(always)]
    fn new(first: u32, second: u32, third: u32, fourth: u32) -> Self {
        MediaStack { upper: first | second << 16, lower: third | fourth << 16 }
    }

    /// Medium that light travels in here, or `NO_MEDIUM`.
    #[inline(always)]
    fn first(self) -> u32 {
        self.upper & 0xffff
    }

    /// Media inside of `material`, too. A stack of four forgets its last medium; the second value says so.
    #[inline(always)]
    pub fn entered(self, material: u32, materials: &[Material]) -> (Self, bool) {
        let priority = materials[material as usize].priority;
        let mut index = 0;
        while index < DEPTH && !outranks(priority, self.at(index), materials) {
            index += 1;
        }
        (self.inserted(material, index), self.at(3) != NO_MEDIUM)
    }

    /// Medium at an index, counted from that of the highest priority.
    #[inline(always)]
    fn at(self, index: u32) -> u32 {
        let two = if index < 2 { self.upper } else { self.lower };
        two >> (16 * (index & 1)) & 0xffff
    }

    /// Stack with `material` inserted at an index; unchanged where that is behind the last.
    #[shared]
    fn inserted(self, material: u32, index: u32) -> Self {
        let (first, second, third) = (self.at(0), self.at(1), self.at(2));
        if index == 0 {
            MediaStack::new(material, first, second, third)
        } else if index == 1 {
            MediaStack::new(first, material, second, third)
        } else if index == 2 {
            MediaStack::new(first, second, material, third)
        } else if index == 3 {
            MediaStack::new(first, second, third, material)
        } else {
            self
        }
    }

    /// Media outside of `material`; unchanged if it is not in the stack.
    #[shared]
    pub fn left(self, material: u32) -> Self {
        let (first, second, third, fourth) = (self.at(0), self.at(1), self.at(2), self.at(3));
        if first == material {
            MediaStack::new(second, third, fourth, NO_MEDIUM)
        } else if second == material {
            MediaStack::new(first, third, fourth, NO_MEDIUM)
        } else if third == material {
            MediaStack::new(first, second, fourth, NO_MEDIUM)
        } else if fourth == material {
            MediaStack::new(first, second, third, NO_MEDIUM)
        } else {
            self
        }
    }

    /// Whether `material` is in the stack.
    #[inline]
    pub fn holds(self, material: u32) -> bool {
        let (first, second, third, fourth) = (self.at(0), self.at(1), self.at(2), self.at(3));
        first == material || second == material || third == material || fourth == material
    }

    /// Media at a face, for a path that comes through these: the medium of a hanging open surface has ended there.
    #[inline(always)]
    pub fn settled(self, features: Features, materials: &[Material]) -> Self {
        let mut settled = self;
        if features.has(Features::OPEN_SURFACES) {
            let mut index = 0;
            while index < DEPTH {
                let id = self.at(index);
                if id != NO_MEDIUM && materials[id as usize].flags & FLAG_HANGING != 0 {
                    settled = settled.left(id);
                }
                index += 1;
            }
        }
        settled
    }

    /// Media on both sides of a face of the medium `material`, for a path that comes through these.
    ///
    /// The back of a solid that the path is not in does nothing. The face of an open surface alone decides where its medium is,
    /// whatever the path came through. So a path and its reverse agree.
    #[inline(always)]
    pub fn at_face(self, material: u32, front: bool, features: Features, materials: &[Material]) -> Sides {
        let is_expected = self.holds(material) != front;
        let is_open_surface = materials[material as usize].flags & FLAG_OPEN_SURFACE != 0;
        let around = self.settled(features, materials);
        let outside = if is_open_surface { around.left(material) } else { around };
        let (mut inside, mut overflow) = (around, false);
        if front || is_open_surface {
            (inside, overflow) = outside.entered(material, materials);
        }
        if front {
            let is_expected = is_expected || !is_open_surface;
            return Sides { before: outside, behind: inside, along: self, is_expected, overflow };
        }
        let mut along = self;
        if is_open_surface {
            along = self.left(material).entered(material, materials).0;
        }
        Sides { before: inside, behind: inside.left(material), along, is_expected, overflow }
    }

    /// Index of refraction here; in a channel, where any medium disperses.
    #[inline(always)]
    pub fn ior(self, channel: Channel, features: Features, materials: &[Material]) -> f32 {
        let first = self.first();
        if first == NO_MEDIUM {
            return 1.0;
        }
        let material = &materials[first as usize];
        if features.has(Features::DISPERSION) { channel.ior(material) } else { material.ior }
    }

    /// Index of refraction here, in each channel.
    #[inline(always)]
    pub fn iors(self, features: Features, materials: &[Material]) -> Vec3 {
        Vec3::new(
            self.ior(Channel::RED, features, materials),
            self.ior(Channel::GREEN, features, materials),
            self.ior(Channel::BLUE, features, materials),
        )
    }

    /// Whether the medium here refracts channels differently.
    #[inline(always)]
    pub fn disperses(self, materials: &[Material]) -> bool {
        let first = self.first();
        first != NO_MEDIUM && materials[first as usize].dispersion > 0.0
    }

    /// Transmittance over `distance` (m) here: exp(-absorption times distance).
    #[inline(always)]
    pub fn transmittance(self, materials: &[Material], distance: f32) -> Vec3 {
        let first = self.first();
        if first == NO_MEDIUM {
            return Vec3::ONE;
        }
        let absorption = materials[first as usize].absorption;
        Vec3::new(
            (-absorption.x * distance).exp(),
            (-absorption.y * distance).exp(),
            (-absorption.z * distance).exp(),
        )
    }
}

/// Whether a medium of this priority stands before another; one of equal priority does.
#[inline(always)]
fn outranks(priority: i32, other: u32, materials: &[Material]) -> bool {
    other == NO_MEDIUM || priority >= materials[other as usize].priority
}

#[cfg(test)]
mod tests {
    use super::*;

    const FEATURES: Features = Features::OPEN_SURFACES;

    /// Five media of rising priority. The last is an open surface.
    fn five() -> [Material; 5] {
        let mut materials = [0, 1, 2, 3, 4].map(|priority| Material {
            priority,
            medium: priority as u32,
            ..Material::default()
        });
        materials[4].flags = FLAG_OPEN_SURFACE;
        materials
    }

    fn within(ids: &[u32]) -> MediaStack {
        ids.iter().fold(MediaStack::VACUUM, |media, &id| media.entered(id, &five()).0)
    }

    #[test]
    fn media_are_the_same_in_whatever_order_they_are_entered() {
        assert_eq!(within(&[2, 0, 3]), within(&[3, 2, 0]));
        assert_eq!(within(&[1, 2, 1, 0]), within(&[0, 1, 1, 2]));
        assert_eq!(within(&[1, 2, 1]).left(2).left(1), within(&[1]));
        assert_eq!(within(&[1, 2]).left(3), within(&[1, 2]));
        assert!(within(&[0, 2]).holds(0) && !within(&[0, 2]).holds(1));
    }

    #[test]
    fn the_fifth_medium_is_counted_and_the_lowest_forgotten() {
        let full = within(&[0, 1, 2, 3]);
        assert_eq!(full.entered(4, &five()), (within(&[1, 2, 3, 4]), true));
        assert_eq!(within(&[1, 2, 3, 4]).entered(0, &five()), (within(&[1, 2, 3, 4]), true));
        assert!(!within(&[1, 2, 3]).entered(0, &five()).1);
    }

    #[test]
    fn a_face_below_a_higher_medium_is_covered() {
        let materials = five();
        assert!(within(&[2]).at_face(1, true, FEATURES, &materials).is_covered(&materials));
        assert!(within(&[1, 2]).at_face(1, false, FEATURES, &materials).is_covered(&materials));
        assert!(!within(&[1]).at_face(2, true, FEATURES, &materials).is_covered(&materials));
        assert!(
            within(&[1]).at_face(1, true, FEATURES, &materials).is_covered(&materials),
            "two solids of one medium"
        );
    }

    #[test]
    fn two_solids_of_one_material_meet_without_a_face_whatever_their_priorities() {
        let mut materials = five();
        materials[3].medium = 0;
        // A small solid reaches out of a large one: the surfaces of both vanish within the other.
        assert!(within(&[0]).at_face(3, true, FEATURES, &materials).is_covered(&materials));
        assert!(within(&[0, 3]).at_face(0, false, FEATURES, &materials).is_covered(&materials));
        assert!(within(&[0, 3]).at_face(3, false, FEATURES, &materials).is_covered(&materials));
        // With another medium around the small solid, its surface is there.
        assert!(!within(&[0, 1]).at_face(3, true, FEATURES, &materials).is_covered(&materials));
        assert!(!within(&[]).at_face(3, true, FEATURES, &materials).is_covered(&materials));
        assert!(!within(&[3]).at_face(3, false, FEATURES, &materials).is_covered(&materials));
    }

    #[test]
    fn the_back_of_a_solid_that_the_path_is_not_in_does_nothing() {
        let sides = within(&[1]).at_face(2, false, FEATURES, &five());
        assert!(!sides.is_expected && sides.is_covered(&five()) && sides.behind == within(&[1]));
    }

    #[test]
    fn an_open_surface_has_the_same_sides_for_a_path_and_its_reverse() {
        let materials = five();
        for outside in [within(&[]), within(&[1])] {
            let inside = outside.entered(4, &materials).0;
            for wrong in [false, true] {
                let down = if wrong { inside } else { outside }.at_face(4, true, FEATURES, &materials);
                let up = if wrong { outside } else { inside }.at_face(4, false, FEATURES, &materials);
                assert_eq!((down.before, down.behind), (outside, inside));
                assert_eq!((up.before, up.behind), (inside, outside));
                assert!(down.is_expected != wrong && up.is_expected != wrong);
            }
        }
    }

    #[test]
    fn the_medium_of_a_hanging_open_surface_ends_at_the_next_face() {
        let mut materials = five();
        materials[4].flags = FLAG_OPEN_SURFACE | FLAG_HANGING;
        let (outside, below) = (within(&[1]), within(&[1, 4]));
        assert_eq!(below.settled(FEATURES, &materials), outside);
        assert_eq!(outside.settled(FEATURES, &materials), outside);
        // Into another solid, and back out of it to the open surface: both ways the same.
        let down = below.at_face(2, true, FEATURES, &materials);
        assert_eq!((down.along, down.before, down.behind), (below, outside, within(&[1, 2])));
        let up = down.behind.at_face(2, false, FEATURES, &materials);
        assert_eq!((up.along, up.behind), (down.behind, outside));
        let up = up.behind.at_face(4, false, FEATURES, &materials);
        assert_eq!((up.along, up.before, up.behind), (below, below, outside));
        // From one open surface to the next: the segment is the same from both ends.
        let next = below.at_face(4, true, FEATURES, &materials);
        assert_eq!((next.along, next.before, next.behind), (below, outside, below));
    }

    #[test]
    fn the_medium_of_highest_priority_decides_dispersion() {
        let mut materials = five();
        materials.iter_mut().for_each(|material| material.ior = 1.5);
        materials[1].dispersion = 2.0;
        let ior = |media: MediaStack, features| media.ior(Channel::BLUE, features, &materials);
        assert_eq!(ior(within(&[0, 1]), Features::DISPERSION), 1.525);
        assert_eq!(ior(within(&[0, 1, 2]), Features::DISPERSION), 1.5);
        assert_eq!(ior(within(&[0, 1]), Features(0)), 1.5);
        assert!(within(&[0, 1]).disperses(&materials) && !within(&[1, 2]).disperses(&materials));
        assert!(!MediaStack::VACUUM.disperses(&materials));
    }

    #[test]
    fn absorption_follows_beer() {
        let mut material = Material { absorption: Vec3::new(0.0, 1.0, 2.0), ..Default::default() };
        material.ior = 1.5;
        let inside = MediaStack::VACUUM.entered(0, &[material]).0;
        let left = inside.transmittance(&[material], 0.5);
        assert!((left - Vec3::new(1.0, (-0.5f32).exp(), (-1.0f32).exp())).length() < 1e-6);
        assert_eq!(inside.ior(Channel::GREEN, Features(0), &[material]), 1.5);
    }
}
