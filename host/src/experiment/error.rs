//! How far a frame is from its reference, and how much more than it a cell flickers: measures, a row each.
//!
//! Each measure is taken of the whole picture, and of the caustics: `relmse_caustics` of that layer alone, `flip_caustics`
//! and `flicker_caustics` of the reference's path-traced light under the cell's caustics, which shows a person nothing but
//! the error of the caustics. FLIP is `flip_ldr` of `caustics compare`.
//!
//! To add a measure: a function of [`Seen`] and a row of [`MEASURES`]; results, CSV, `bench` and the report loop over it.

use glam::Vec3;

use super::gain::mean_variance;
use crate::image::Encoding;
use crate::metric::error_map::ErrorMap;
use crate::metric::flip::PIXELS_PER_DEGREE;
use crate::metric::flip_ldr::flip_ldr;
use crate::metric::pixels::Pixels;
use crate::metric::relmse;
use crate::picture::Picture;

/// A measure of error.
pub struct Measure {
    /// Key in results and CSV; units at its end, if it has any.
    pub key: &'static str,
    /// Its name in tables and on axes.
    pub head: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Where it misleads.
    pub wrong: &'static str,
    /// Whether a report draws speed against it.
    pub charted: bool,
    /// Its value; none where a picture is not finite, or what it is relative to is black or absent.
    pub of: fn(&Seen) -> Option<f64>,
}

impl Measure {
    /// Its key in names of files.
    pub fn slug(&self) -> String {
        self.key.replace('_', "-")
    }
}

/// All measures, in the order of tables. Each is better the smaller it is.
pub static MEASURES: [&Measure; 7] =
    [&FLIP, &FLIP_CAUSTICS, &RELMSE, &RELMSE_CAUSTICS, &FLICKER, &FLICKER_CAUSTICS, &CAUSTICS_VARIANCE];

/// FLIP of the picture.
pub static FLIP: Measure = Measure {
    key: "flip",
    head: "FLIP",
    about: "Mean FLIP, the difference that a person sees between picture and reference, 0 to 1",
    wrong: "it forgives light that is lost evenly: look at relMSE beside it",
    charted: true,
    of: |seen| seen.mean(|now| flip(&now.whole, &seen.truth.whole, seen.exposure)),
};

/// FLIP of the caustics.
pub static FLIP_CAUSTICS: Measure = Measure {
    key: "flip_caustics",
    head: "FLIP of caustics",
    about: "Mean FLIP of the caustics over the reference's other light",
    wrong: "caustics of a part of the picture are averaged with the rest of it",
    charted: true,
    of: |seen| seen.mean(|now| flip(now.caustics_in_place.as_ref()?, &seen.truth.whole, seen.exposure)),
};

/// Relative mean squared error of the picture.
pub static RELMSE: Measure = Measure {
    key: "relmse",
    head: "relMSE",
    about: "Relative mean squared error of the picture",
    wrong: "ten pixels can be nine tenths of it",
    charted: true,
    of: |seen| seen.mean(|now| relative(&now.whole, &seen.truth.whole)),
};

/// Relative mean squared error of the caustics.
pub static RELMSE_CAUSTICS: Measure = Measure {
    key: "relmse_caustics",
    head: "relMSE of caustics",
    about: "Relative mean squared error of the layer of caustics",
    wrong: "dim places weigh as much as bright ones",
    charted: true,
    of: |seen| seen.mean(|now| relative(now.caustics.as_ref()?, seen.truth.caustics.as_ref()?)),
};

/// Flicker of the picture.
pub static FLICKER: Measure = Measure {
    key: "flicker",
    head: "flicker",
    about: "FLIP between a frame and the one before, beyond that of the reference",
    wrong: "what is steadily wrong does not flicker",
    charted: false,
    of: |seen| {
        let change =
            |now: &MeasuredPicture, before: &MeasuredPicture| flip(&now.whole, &before.whole, seen.exposure);
        seen.change(&change)
    },
};

/// Flicker of the caustics.
pub static FLICKER_CAUSTICS: Measure = Measure {
    key: "flicker_caustics",
    head: "flicker of caustics",
    about: "Flicker of the caustics over the reference's other light",
    wrong: "what is steadily wrong does not flicker",
    charted: false,
    of: |seen| {
        let change = |now: &MeasuredPicture, before: &MeasuredPicture| {
            flip(now.caustics_in_place.as_ref()?, before.caustics_in_place.as_ref()?, seen.exposure)
        };
        seen.change(&change)
    },
};

/// Variance of the caustics.
pub static CAUSTICS_VARIANCE: Measure = Measure {
    key: "caustics_variance_radiance2",
    head: "variance",
    about: "Variance of the caustics' radiance between seeds, mean over pixels and channels (W^2 m^-4 sr^-2)",
    wrong: "light that is lost in every run has no variance",
    charted: false,
    of: |seen| {
        let layers: Vec<&[Vec3]> = seen.now.iter().map(|now| now.radiance.as_slice()).collect();
        mean_variance(&layers)
    },
};

/// A frame of a cell, once a seed, beside the truth.
pub struct Seen<'a> {
    /// The pictures of the seeds.
    pub now: &'a [MeasuredPicture],
    /// Those of the frame before, in the same order; empty where none was measured.
    pub before: &'a [MeasuredPicture],
    /// The reference of the frame.
    pub truth: &'a MeasuredPicture,
    /// That of the frame before.
    pub truth_before: Option<&'a MeasuredPicture>,
    /// Exposure of the display (stops).
    pub exposure: f64,
}

impl<'a> Seen<'a> {
    /// One picture by itself, at an exposure of 0.
    pub fn one(now: &'a MeasuredPicture, truth: &'a MeasuredPicture) -> Seen<'a> {
        Seen { now: std::slice::from_ref(now), before: &[], truth, truth_before: None, exposure: 0.0 }
    }

    /// The mean over the seeds, if all have a value.
    fn mean(&self, of: impl Fn(&MeasuredPicture) -> Option<f64>) -> Option<f64> {
        mean(self.now.iter().map(of))
    }

    /// The mean change since the frame before, beyond that of the reference.
    fn change(&self, of: &dyn Fn(&MeasuredPicture, &MeasuredPicture) -> Option<f64>) -> Option<f64> {
        let truth = of(self.truth, self.truth_before?)?;
        let pairs = self.now.iter().zip(self.before);
        Some(mean(pairs.map(|(now, before)| of(now, before)))? - truth)
    }
}

/// The mean of values that are all there.
pub fn mean(values: impl ExactSizeIterator<Item = Option<f64>>) -> Option<f64> {
    let count = values.len() as f64;
    values.sum::<Option<f64>>().map(|sum| sum / count).filter(|mean| mean.is_finite())
}

/// A picture as it is measured; empty parts have no measure.
#[derive(Clone, Debug)]
pub struct MeasuredPicture {
    /// All light.
    whole: Pixels,
    /// The caustics alone.
    caustics: Option<Pixels>,
    /// The caustics over the reference's other light.
    caustics_in_place: Option<Pixels>,
    /// Radiance of the caustics.
    radiance: Vec<Vec3>,
}

impl MeasuredPicture {
    /// A picture beside the reference of its frame.
    pub fn new(picture: &Picture, reference: &Picture) -> MeasuredPicture {
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
        MeasuredPicture {
            whole: of(picture.beauty()),
            caustics: split.then(|| of(picture.caustics.clone())),
            caustics_in_place: split.then(in_place),
            radiance: picture.caustics.clone(),
        }
    }

    /// FLIP of each pixel of the picture, if it is finite; `exposure` is that of the display (stops).
    pub fn flip_map(&self, reference: &MeasuredPicture, exposure: f64) -> Option<ErrorMap> {
        flip_map(&self.whole, &reference.whole, exposure)
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

    /// Measures of pictures, those before, and of truths.
    fn seen(now: &[&Picture], before: &[&Picture], truths: [&Picture; 2]) -> [Option<f64>; 7] {
        let of = |pictures: &[&Picture], truth: &Picture| -> Vec<MeasuredPicture> {
            pictures.iter().map(|picture| MeasuredPicture::new(picture, truth)).collect()
        };
        let [truth_before, truth] = truths.map(|truth| MeasuredPicture::new(truth, truth));
        let (now, before) = (of(now, truths[1]), of(before, truths[0]));
        let seen = Seen {
            now: &now,
            before: &before,
            truth: &truth,
            truth_before: Some(&truth_before),
            exposure: 0.0,
        };
        MEASURES.map(|measure| (measure.of)(&seen))
    }

    fn alone(picture: &Picture, truth: &Picture) -> [Option<f64>; 4] {
        let [flip, flip_caustics, relmse, relmse_caustics, ..] = seen(&[picture], &[], [truth, truth]);
        [flip, flip_caustics, relmse, relmse_caustics]
    }

    #[test]
    fn a_picture_is_no_way_from_itself_and_a_brighter_one_is() {
        let truth = picture(0.2, 0.1);
        assert_eq!(alone(&truth, &truth), [Some(0.0); 4]);
        let [flip, flip_caustics, relmse, relmse_caustics] =
            alone(&picture(0.2, 0.2), &truth).map(Option::unwrap);
        assert!(flip > 0.01 && relmse_caustics > 0.5, "{flip} {relmse_caustics}");
        assert_eq!(flip, flip_caustics, "all that is wrong are the caustics");
        // Twice the caustics, a third more of all: squares of 1 and 1/3, but for eps.
        assert!(relmse < relmse_caustics / 8.0);
    }

    #[test]
    fn errors_of_the_path_are_none_of_the_caustics() {
        let [flip, flip_caustics, _, relmse_caustics] = alone(&picture(0.4, 0.1), &picture(0.2, 0.1));
        assert!(flip.unwrap() > 0.01);
        assert_eq!(flip_caustics.zip(relmse_caustics), Some((0.0, 0.0)));
    }

    #[test]
    fn what_is_not_there_has_no_measure() {
        let dark = picture(0.2, 0.0);
        assert_eq!(alone(&picture(0.2, 0.1), &dark)[3], None);
        let wrong = alone(&picture(f32::NAN, 0.0), &dark);
        assert_eq!(wrong[..3], [None, Some(0.0), None]);
        let whole = Picture { caustics: vec![], ..dark.clone() };
        assert_eq!(alone(&whole, &dark)[1], None);
    }

    #[test]
    fn flicker_is_change_beyond_that_of_the_truth_and_variance_is_between_seeds() {
        let [dim, bright] = [picture(0.2, 0.1), picture(0.2, 0.2)];
        let measures = seen(&[&bright], &[&dim], [&dim, &bright]);
        assert_eq!(measures[4..], [Some(0.0), Some(0.0), None], "it changes as the truth does");
        let measures = seen(&[&bright, &dim], &[&dim, &dim], [&dim, &dim]);
        assert!(measures[4].unwrap() > 0.01 && measures[5] == measures[4] && measures[6].unwrap() > 0.0);
        assert_eq!(seen(&[&dim, &dim], &[&dim, &dim], [&dim, &dim])[4..], [Some(0.0), Some(0.0), Some(0.0)]);
        assert_eq!(seen(&[&bright], &[], [&dim, &bright])[4], None, "no frame before");
    }
}
