//! How far a frame is from its reference, and how much more than it a cell flickers.
//!
//! Each measure is taken of the whole picture, and of the caustics: `relmse_caustics` of that layer alone, `flip_caustics`
//! and `flicker_caustics` of the reference's path-traced light under the cell's caustics, which shows a person nothing but
//! the error of the caustics. FLIP is `flip_ldr` of `caustics compare`.

use glam::Vec3;

use crate::image::Encoding;
use crate::metric::error_map::ErrorMap;
use crate::metric::flip::PIXELS_PER_DEGREE;
use crate::metric::flip_ldr::flip_ldr;
use crate::metric::pixels::Pixels;
use crate::metric::relmse;
use crate::picture::Picture;

/// A picture as it is measured; empty parts have no measure.
#[derive(Clone, Debug)]
pub struct Look {
    /// All light.
    whole: Pixels,
    /// The caustics alone.
    caustics: Option<Pixels>,
    /// The caustics over the reference's other light.
    caustics_in_place: Option<Pixels>,
}

/// FLIP and relative mean squared errors; None where a picture is not finite, or a reference black.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// FLIP of the picture.
    pub flip: Option<f64>,
    /// FLIP of the caustics.
    pub flip_caustics: Option<f64>,
    /// Relative mean squared error of the picture.
    pub relmse: Option<f64>,
    /// That of the caustics.
    pub relmse_caustics: Option<f64>,
}

impl Look {
    /// A picture beside the reference of its frame.
    pub fn new(picture: &Picture, reference: &Picture) -> Look {
        let of = |values: Vec<Vec3>| Pixels {
            width: picture.width,
            height: picture.height,
            values: values.into_iter().map(Vec3::as_dvec3).collect(),
        };
        let in_place = || {
            let pairs = reference.path.iter().zip(&picture.caustics);
            of(pairs.map(|(path, caustics)| *path + *caustics).collect())
        };
        let split = !picture.caustics.is_empty();
        Look {
            whole: of(picture.beauty()),
            caustics: split.then(|| of(picture.caustics.clone())),
            caustics_in_place: split.then(in_place),
        }
    }

    /// How far it is from the reference; `exposure` is that of the display (stops).
    pub fn errors(&self, reference: &Look, exposure: f64) -> Errors {
        Errors {
            flip: flip(&self.whole, &reference.whole, exposure),
            flip_caustics: self
                .caustics_in_place
                .as_ref()
                .and_then(|image| flip(image, &reference.whole, exposure)),
            relmse: relative(&self.whole, &reference.whole),
            relmse_caustics: self
                .caustics
                .as_ref()
                .zip(reference.caustics.as_ref())
                .and_then(|(image, reference)| relative(image, reference)),
        }
    }

    /// FLIP of each pixel of the picture, if it is finite; `exposure` is that of the display (stops).
    pub fn flip_map(&self, reference: &Look, exposure: f64) -> Option<ErrorMap> {
        flip_map(&self.whole, &reference.whole, exposure)
    }

    /// What a person sees change since the frame before: FLIP of the picture, and of the caustics.
    pub fn change(&self, before: &Look, exposure: f64) -> (Option<f64>, Option<f64>) {
        let caustics = self.caustics_in_place.as_ref().zip(before.caustics_in_place.as_ref());
        (
            flip(&self.whole, &before.whole, exposure),
            caustics.and_then(|(now, before)| flip(now, before, exposure)),
        )
    }
}

fn flip(image: &Pixels, reference: &Pixels, exposure: f64) -> Option<f64> {
    flip_map(image, reference, exposure).map(|map| map.mean())
}

fn flip_map(image: &Pixels, reference: &Pixels, exposure: f64) -> Option<ErrorMap> {
    let finite = image.non_finite_count() + reference.non_finite_count() == 0;
    finite.then(|| flip_ldr(image, reference, Encoding::Linear, exposure, PIXELS_PER_DEGREE))
}

fn relative(image: &Pixels, reference: &Pixels) -> Option<f64> {
    let value = relmse::relmse(&relmse::errors(image, reference));
    (value.is_finite() && relmse::least_square(reference) > 0.0).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(path: f32, caustics: f32) -> Picture {
        let layer = |value| (0..64).map(|i| Vec3::splat(value * (1.0 + (i % 5) as f32))).collect();
        Picture { width: 8, height: 8, path: layer(path), caustics: layer(caustics), ..Picture::default() }
    }

    #[test]
    fn a_picture_is_no_way_from_itself_and_a_brighter_one_is() {
        let truth = picture(0.2, 0.1);
        let reference = Look::new(&truth, &truth);
        let none = reference.errors(&reference, 0.0);
        assert_eq!(none.flip.zip(none.relmse), Some((0.0, 0.0)));
        let brighter = Look::new(&picture(0.2, 0.2), &truth);
        let errors = brighter.errors(&reference, 0.0);
        assert!(errors.flip.unwrap() > 0.01 && errors.relmse_caustics.unwrap() > 0.5, "{errors:?}");
        assert_eq!(errors.flip, errors.flip_caustics, "all that is wrong are the caustics");
        // Twice the caustics, a third more of all: squares of 1 and 1/3, but for eps.
        assert!(errors.relmse.unwrap() < errors.relmse_caustics.unwrap() / 8.0);
    }

    #[test]
    fn errors_of_the_path_are_none_of_the_caustics() {
        let truth = picture(0.2, 0.1);
        let errors = Look::new(&picture(0.4, 0.1), &truth).errors(&Look::new(&truth, &truth), 0.0);
        assert!(errors.flip.unwrap() > 0.01);
        assert_eq!(errors.flip_caustics.zip(errors.relmse_caustics), Some((0.0, 0.0)));
    }

    #[test]
    fn what_is_not_there_has_no_measure() {
        let dark = picture(0.2, 0.0);
        let reference = Look::new(&dark, &dark);
        assert_eq!(Look::new(&picture(0.2, 0.1), &dark).errors(&reference, 0.0).relmse_caustics, None);
        let wrong = Look::new(&picture(f32::NAN, 0.0), &dark).errors(&reference, 0.0);
        assert_eq!((wrong.flip, wrong.relmse, wrong.flip_caustics), (None, None, Some(0.0)));
        let whole = Picture { caustics: vec![], ..dark.clone() };
        assert_eq!(Look::new(&whole, &dark).errors(&reference, 0.0).flip_caustics, None);
    }
}
