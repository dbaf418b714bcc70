//! Measures of error: distance of a frame from its reference, and flicker beyond that of the reference.
//!
//! Each measure exists for the whole image and for the caustics. `relmse_caustics` reads the caustics layer alone.
//! `flip_caustics` and `flicker_caustics` read the measured caustics over the reference's path-traced light, so that only
//! errors of the caustics are visible. FLIP is `flip_ldr` of `caustics compare`.
//!
//! To add a measure, write a function of [`Seen`] and an entry of [`MEASURES`]; results, CSV, `bench` and the report loop
//! over it.

use std::cell::OnceCell;

use glam::{DVec3, Vec3};

use super::gain::mean_variance;
use caustics::image_file::Encoding;
use caustics::metric::caustic_region::CausticRegion;
use caustics::metric::error_map::ErrorMap;
use caustics::metric::flip::PIXELS_PER_DEGREE;
use caustics::metric::flip_ldr::flip_ldr;
use caustics::metric::percentile::percentile;
use caustics::metric::pixels::Pixels;
use caustics::metric::relmse;
use caustics::rendered_image::RenderedImage;

/// A measure of error.
pub struct Measure {
    /// Key in results and CSV; units at its end, if it has any.
    pub key: &'static str,
    /// Name in tables and on axes.
    pub head: &'static str,
    /// Description, in one line.
    pub description: &'static str,
    /// Limitations: where it misleads.
    pub limitations: &'static str,
    /// Whether a report draws speed against it.
    pub charted: bool,
    /// Its value; none where an image is not finite, or where the value that it relates to is zero or absent.
    pub compute: fn(&Seen) -> Option<MeasuredValue>,
}

/// A value found in a frame of several seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredValue {
    /// The mean over the seeds.
    pub value: f64,
    /// Its standard error, where two seeds or more have a value each.
    pub standard_error: Option<f64>,
}

impl MeasuredValue {
    /// Mean over the seeds; none where a seed has no value.
    fn from_seeds(values: impl Iterator<Item = Option<f64>>) -> Option<MeasuredValue> {
        let values = values.collect::<Option<Vec<f64>>>()?;
        let count = values.len() as f64;
        let value = values.iter().sum::<f64>() / count;
        let squares = values.iter().map(|one| (one - value).powi(2)).sum::<f64>();
        let standard_error = (values.len() > 1).then(|| (squares / (count * (count - 1.0))).sqrt());
        value.is_finite().then_some(MeasuredValue { value, standard_error })
    }
}

impl Measure {
    /// Its key with dashes, for file names.
    pub fn slug(&self) -> String {
        self.key.replace('_', "-")
    }

    /// Key of its standard error in a frame's record.
    pub fn standard_error_key(&self) -> String {
        format!("{}_standard_error", self.key)
    }
}

/// All measures, in the order of tables. Smaller is better for each.
pub static MEASURES: [&Measure; 15] = [
    &FLIP,
    &FLIP_CAUSTIC_REGION,
    &FLIP_CAUSTICS,
    &RELMSE,
    &RELMSE_TRIMMED,
    &RELMSE_TRIMMED_CAUSTIC_REGION,
    &RELMSE_CAUSTICS,
    &FLICKER,
    &FLICKER_CAUSTICS,
    &RELMSE_FLICKER,
    &PATH_NOISE,
    &PATH_BIAS2,
    &CAUSTICS_NOISE,
    &CAUSTICS_BIAS2,
    &CAUSTICS_VARIANCE,
];

/// FLIP of the image.
pub static FLIP: Measure = Measure {
    key: "flip",
    head: "FLIP",
    description: "Mean FLIP, the difference that a person sees between image and reference, 0 to 1",
    limitations: "it forgives light that is lost evenly: look at relMSE beside it",
    charted: true,
    compute: |seen| seen.mean(|now| Some(now.flip_map(seen.reference, seen.exposure)?.mean())),
};

/// FLIP of the image within the region of caustics.
pub static FLIP_CAUSTIC_REGION: Measure = Measure {
    key: "flip_caustic_region",
    head: "FLIP in the caustic region",
    description: "Mean FLIP of the image over the pixels in which caustics are a fifth of the reference's light",
    limitations: "caustics that are where the reference has none are not seen",
    charted: true,
    compute: |seen| {
        seen.mean(|now| {
            let map = now.flip_map(seen.reference, seen.exposure)?;
            Some(seen.reference.region.as_ref()?.mean(&map.values))
        })
    },
};

/// FLIP of the caustics.
pub static FLIP_CAUSTICS: Measure = Measure {
    key: "flip_caustics",
    head: "FLIP of caustics",
    description: "Mean FLIP of the caustics over the reference's other light",
    limitations: "caustics of a part of the image are averaged with the rest of it",
    charted: true,
    compute: |seen| {
        seen.mean(|now| flip(now.caustics_over_reference.as_ref()?, &seen.reference.whole, seen.exposure))
    },
};

/// Relative mean squared error of the image.
pub static RELMSE: Measure = Measure {
    key: "relmse",
    head: "relMSE",
    description: "Relative mean squared error of the image",
    limitations: "ten pixels can be nine tenths of it",
    charted: true,
    compute: |seen| seen.mean(|now| relative(&now.whole, &seen.reference.whole)),
};

/// Relative mean squared error of the image without its worst pixels.
pub static RELMSE_TRIMMED: Measure = Measure {
    key: "relmse_trimmed",
    head: "trimmed relMSE",
    description: "Relative mean squared error of the image, without the worst 0.1 % of the pixels",
    limitations: "fireflies are left out",
    charted: true,
    compute: |seen| seen.mean(|now| finite(relmse::trimmed(&errors(&now.whole, &seen.reference.whole)?))),
};

/// Relative mean squared error within the region of caustics, without the worst pixels.
pub static RELMSE_TRIMMED_CAUSTIC_REGION: Measure = Measure {
    key: "relmse_trimmed_caustic_region",
    head: "trimmed relMSE in the caustic region",
    description: "The same over the pixels in which caustics are a fifth of the reference's light",
    limitations: "caustics that are where the reference has none are not seen; fireflies are left out",
    charted: true,
    compute: |seen| {
        seen.mean(|now| {
            let errors = errors(&now.whole, &seen.reference.whole)?;
            finite(relmse::trimmed(&seen.reference.region.as_ref()?.pick(&errors)))
        })
    },
};

/// Relative mean squared error of the caustics.
pub static RELMSE_CAUSTICS: Measure = Measure {
    key: "relmse_caustics",
    head: "relMSE of caustics",
    description: "Relative mean squared error of the layer of caustics",
    limitations: "dim places weigh as much as bright ones",
    charted: true,
    compute: |seen| seen.mean(|now| relative(now.caustics.as_ref()?, seen.reference.caustics.as_ref()?)),
};

/// Flicker of the image.
pub static FLICKER: Measure = Measure {
    key: "flicker",
    head: "flicker",
    description: "FLIP between a frame and the one before, beyond that of the reference",
    limitations: "what is steadily wrong does not flicker",
    charted: false,
    compute: |seen| {
        let change =
            |now: &MeasuredImage, before: &MeasuredImage| flip(&now.whole, &before.whole, seen.exposure);
        seen.change(&change)
    },
};

/// Flicker of the caustics.
pub static FLICKER_CAUSTICS: Measure = Measure {
    key: "flicker_caustics",
    head: "flicker of caustics",
    description: "Flicker of the caustics over the reference's other light",
    limitations: "what is steadily wrong does not flicker",
    charted: false,
    compute: |seen| {
        let change = |now: &MeasuredImage, before: &MeasuredImage| {
            flip(
                now.caustics_over_reference.as_ref()?,
                before.caustics_over_reference.as_ref()?,
                seen.exposure,
            )
        };
        seen.change(&change)
    },
};

/// Flicker of the image, as a mean squared error.
pub static RELMSE_FLICKER: Measure = Measure {
    key: "relmse_flicker",
    head: "relMSE of flicker",
    description: "Mean squared change of the relative error since the frame before, without the worst 0.1 % of the pixels: \
                  twice the trimmed relMSE of frames with independent noise",
    limitations: "what is steadily wrong does not flicker; fireflies are left out",
    charted: false,
    compute: |seen| {
        let before = seen.reference_before?;
        let relative = |image: &MeasuredImage, reference: &MeasuredImage| {
            relative_to(&image.whole.minus(&reference.whole), &reference.whole)
        };
        let pairs = seen.now.iter().zip(seen.before);
        MeasuredValue::from_seeds(pairs.map(|(now, then)| {
            let changes = relative(now, seen.reference).into_iter().zip(relative(then, before));
            let squares: Vec<f64> = changes.map(|(now, then)| (now - then).length_squared() / 3.0).collect();
            finite(relmse::trimmed(&squares))
        }))
    },
};

/// Noise of the path-traced light.
pub static PATH_NOISE: Measure = Measure {
    key: "relmse_variance_path",
    head: "path noise",
    description: "Part of trimmed relMSE that is variance of the path-traced light between seeds",
    limitations: "blur lowers it: look at the bias beside it",
    charted: false,
    compute: |seen| seen.parts().path.map(|[variance, _]| variance),
};

/// Squared bias of the path-traced light.
pub static PATH_BIAS2: Measure = Measure {
    key: "relmse_bias2_path",
    head: "path bias",
    description: "Part of trimmed relMSE that is squared bias of the path-traced light: blur of a denoiser, light that lags, pixel centres \
                  instead of a filter",
    limitations: "noise of the reference counts as bias",
    charted: false,
    compute: |seen| seen.parts().path.map(|[_, bias2]| bias2),
};

/// Noise of the caustics, relative to all light.
pub static CAUSTICS_NOISE: Measure = Measure {
    key: "relmse_variance_caustics",
    head: "caustic noise",
    description: "Part of trimmed relMSE that is variance of the caustics between seeds",
    limitations: "blur lowers it: look at the bias beside it",
    charted: false,
    compute: |seen| seen.parts().caustics.map(|[variance, _]| variance),
};

/// Squared bias of the caustics, relative to all light.
pub static CAUSTICS_BIAS2: Measure = Measure {
    key: "relmse_bias2_caustics",
    head: "caustic bias",
    description: "Part of trimmed relMSE that is squared bias of the caustics: blur of discs, light that lags",
    limitations: "noise of the reference counts as bias",
    charted: false,
    compute: |seen| seen.parts().caustics.map(|[_, bias2]| bias2),
};

/// Variance of the caustics.
pub static CAUSTICS_VARIANCE: Measure = Measure {
    key: "caustics_variance_radiance2",
    head: "variance",
    description: "Variance of the caustics' radiance between seeds, mean over pixels and channels (W^2 m^-4 sr^-2)",
    limitations: "light that is lost in every run has no variance",
    charted: false,
    compute: |seen| {
        let layers: Vec<&[Vec3]> = seen.now.iter().map(|now| now.radiance.as_slice()).collect();
        Some(MeasuredValue { value: mean_variance(&layers)?, standard_error: None })
    },
};

/// Images of a frame of a run configuration, one per seed, and their reference.
pub struct Seen<'a> {
    /// The images of the seeds.
    pub now: &'a [MeasuredImage],
    /// Images of the frame before, in the same order; empty where none was measured.
    pub before: &'a [MeasuredImage],
    /// The reference of the frame.
    pub reference: &'a MeasuredImage,
    /// The reference of the frame before.
    pub reference_before: Option<&'a MeasuredImage>,
    /// Exposure of the display (stops).
    pub exposure: f64,
    /// Parts of relMSE, once computed.
    pub parts: OnceCell<ErrorParts>,
}

/// Variance and squared bias of each layer; none with fewer than two seeds, or where values are not finite.
#[derive(Clone, Copy, Debug, Default)]
pub struct ErrorParts {
    path: Option<[MeasuredValue; 2]>,
    caustics: Option<[MeasuredValue; 2]>,
}

impl<'a> Seen<'a> {
    /// One image alone, at an exposure of 0.
    pub fn one(now: &'a MeasuredImage, reference: &'a MeasuredImage) -> Seen<'a> {
        Seen {
            now: std::slice::from_ref(now),
            before: &[],
            reference,
            reference_before: None,
            exposure: 0.0,
            parts: OnceCell::new(),
        }
    }

    /// The mean over the seeds, if all have a value.
    fn mean(&self, value: impl Fn(&MeasuredImage) -> Option<f64>) -> Option<MeasuredValue> {
        MeasuredValue::from_seeds(self.now.iter().map(value))
    }

    /// Mean change since the frame before, beyond the change of the reference.
    fn change(
        &self,
        difference: &dyn Fn(&MeasuredImage, &MeasuredImage) -> Option<f64>,
    ) -> Option<MeasuredValue> {
        let reference = difference(self.reference, self.reference_before?)?;
        let pairs = self.now.iter().zip(self.before);
        MeasuredValue::from_seeds(pairs.map(|(now, before)| Some(difference(now, before)? - reference)))
    }
}

impl Seen<'_> {
    /// The parts of relMSE, without the worst 0.1 % of the pixels of the whole image.
    fn parts(&self) -> ErrorParts {
        let split = || {
            if self.now.len() < 2 {
                return None;
            }
            let kept = self.kept()?;
            Some(ErrorParts {
                path: self.split(&kept, |image| Some(&image.path)),
                caustics: self.split(&kept, |image| image.caustics.as_ref()),
            })
        };
        *self.parts.get_or_init(|| split().unwrap_or_default())
    }

    /// Variance of a layer between seeds, and its squared bias without that of the variance, both relative to all light. Their sum
    /// is the layer's part of relMSE over the pixels that are kept.
    fn split(
        &self,
        kept: &[bool],
        layer: fn(&MeasuredImage) -> Option<&Pixels>,
    ) -> Option<[MeasuredValue; 2]> {
        let reference = layer(self.reference)?;
        let runs = self.now.iter().map(layer).collect::<Option<Vec<_>>>()?;
        let count = runs.len() as f64;
        let mut mean = runs[0].clone();
        for run in &runs[1..] {
            mean.values.iter_mut().zip(&run.values).for_each(|(sum, value)| *sum += *value);
        }
        mean.values.iter_mut().for_each(|sum| *sum /= count);
        let square = |difference: &Pixels| {
            let relative = relative_to(difference, &self.reference.whole);
            let squares = relative.iter().map(|value| value.length_squared() / 3.0);
            let sum: f64 = squares.zip(kept).filter(|(_, kept)| **kept).map(|(square, _)| square).sum();
            sum / kept.iter().filter(|kept| **kept).count() as f64
        };
        let squares: f64 = runs.iter().map(|run| square(&run.minus(&mean))).sum();
        let variance = squares / (count - 1.0);
        let bias2 = square(&mean.minus(reference)) - variance / count;
        let values = [finite(variance)?, finite(bias2)?];
        Some(values.map(|value| MeasuredValue { value, standard_error: None }))
    }

    /// For each pixel whether its error is not among the worst 0.1 %.
    fn kept(&self) -> Option<Vec<bool>> {
        let of_seed = |image: &MeasuredImage| errors(&image.whole, &self.reference.whole);
        let seeds = self.now.iter().map(of_seed).collect::<Option<Vec<_>>>()?;
        let sums: Vec<f64> =
            (0..seeds[0].len()).map(|pixel| seeds.iter().map(|errors| errors[pixel]).sum()).collect();
        let max = percentile(&sums, 1.0 - relmse::TRIMMED);
        Some(sums.iter().map(|sum| *sum <= max).collect())
    }
}

/// Differences over the root of the reference's square, as relMSE relates them.
fn relative_to(difference: &Pixels, reference: &Pixels) -> Vec<DVec3> {
    let eps = DVec3::splat(relmse::min_square(reference));
    let pairs = difference.values.iter().zip(&reference.values);
    pairs.map(|(value, reference)| value / (reference * reference + eps).map(f64::sqrt)).collect()
}

/// Mean of the values; none where a value is missing.
pub fn mean(values: impl ExactSizeIterator<Item = Option<f64>>) -> Option<f64> {
    let count = values.len() as f64;
    values.sum::<Option<f64>>().map(|sum| sum / count).filter(|mean| mean.is_finite())
}

/// An image prepared for measuring; missing parts have no measure.
#[derive(Clone, Debug)]
pub struct MeasuredImage {
    /// All light.
    whole: Pixels,
    /// The path-traced light alone.
    path: Pixels,
    /// The caustics alone.
    caustics: Option<Pixels>,
    /// The measured caustics over the reference's other light.
    caustics_over_reference: Option<Pixels>,
    /// Radiance of the caustics.
    radiance: Vec<Vec3>,
    /// Region in which caustics are visible.
    region: Option<CausticRegion>,
    /// FLIP of its pixels, once computed.
    flip: OnceCell<Option<ErrorMap>>,
}

impl MeasuredImage {
    /// An image and the reference of its frame.
    pub fn new(image: &RenderedImage, reference: &RenderedImage) -> MeasuredImage {
        let pixels = |values: Vec<Vec3>| Pixels {
            width: image.width,
            height: image.height,
            values: values.into_iter().map(Vec3::as_dvec3).collect(),
        };
        let over_reference = || {
            let pairs = reference.path.iter().zip(&image.caustics);
            pixels(pairs.map(|(path, caustics)| *path + *caustics).collect())
        };
        let split = !image.caustics.is_empty();
        let whole = pixels(image.beauty());
        let caustics = split.then(|| pixels(image.caustics.clone()));
        let region = caustics.as_ref().and_then(|caustics| CausticRegion::new(&whole, caustics));
        MeasuredImage {
            whole,
            path: pixels(image.path.clone()),
            caustics,
            caustics_over_reference: split.then(over_reference),
            radiance: image.caustics.clone(),
            region,
            flip: OnceCell::new(),
        }
    }

    /// Returns FLIP of each pixel of the image, if it is finite; `exposure` is the display's (stops). The map is computed
    /// once, since an image has one reference and an experiment one exposure.
    pub fn flip_map(&self, reference: &MeasuredImage, exposure: f64) -> Option<&ErrorMap> {
        self.flip.get_or_init(|| flip_map(&self.whole, &reference.whole, exposure)).as_ref()
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
    finite(relmse::relmse(&errors(image, reference)?))
}

/// Relative squared error of each pixel; none where the reference is black.
fn errors(image: &Pixels, reference: &Pixels) -> Option<Vec<f64>> {
    (relmse::min_square(reference) > 0.0).then(|| relmse::errors(image, reference))
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(path: f32, caustics: f32) -> RenderedImage {
        let layer = |value| (0..64).map(|i| Vec3::splat(value * (1.0 + (i % 5) as f32))).collect();
        RenderedImage {
            width: 8,
            height: 8,
            path: layer(path),
            caustics: layer(caustics),
            ..RenderedImage::default()
        }
    }

    /// Measures of images, of the images before them, and of references.
    fn seen(
        now: &[&RenderedImage],
        before: &[&RenderedImage],
        references: [&RenderedImage; 2],
    ) -> impl Fn(&Measure) -> Option<f64> {
        let measured = |images: &[&RenderedImage], reference: &RenderedImage| -> Vec<MeasuredImage> {
            images.iter().map(|image| MeasuredImage::new(image, reference)).collect()
        };
        let [reference_before, reference] =
            references.map(|reference| MeasuredImage::new(reference, reference));
        let (now, before) = (measured(now, references[1]), measured(before, references[0]));
        let seen = Seen {
            now: &now,
            before: &before,
            reference: &reference,
            reference_before: Some(&reference_before),
            exposure: 0.0,
            parts: OnceCell::new(),
        };
        let found = MEASURES.map(|measure| (measure.key, (measure.compute)(&seen)));
        move |measure| found.iter().find(|(key, _)| *key == measure.key)?.1.map(|found| found.value)
    }

    fn alone<const N: usize>(
        image: &RenderedImage,
        reference: &RenderedImage,
        measures: [&Measure; N],
    ) -> [Option<f64>; N] {
        measures.map(seen(&[image], &[], [reference, reference]))
    }

    const ERRORS: [&Measure; 7] = [
        &FLIP,
        &FLIP_CAUSTIC_REGION,
        &FLIP_CAUSTICS,
        &RELMSE,
        &RELMSE_TRIMMED,
        &RELMSE_TRIMMED_CAUSTIC_REGION,
        &RELMSE_CAUSTICS,
    ];

    #[test]
    fn errors_are_zero_for_equal_images_and_positive_for_brighter_ones() {
        let reference = image(0.2, 0.1);
        assert_eq!(alone(&reference, &reference, ERRORS), [Some(0.0); 7]);
        let [flip, flip_region, flip_caustics, relmse, trimmed, trimmed_region, relmse_caustics] =
            alone(&image(0.2, 0.2), &reference, ERRORS).map(Option::unwrap);
        assert!(flip > 0.01 && relmse_caustics > 0.5, "{flip} {relmse_caustics}");
        assert_eq!(flip, flip_caustics, "all that is wrong are the caustics");
        // The caustics are doubled, and the whole grows by a third: relative squared errors of 1 and (1/3)^2, but for eps.
        assert!(relmse < relmse_caustics / 8.0);
        // Caustics are a third of every pixel, and with so few pixels the worst thousandth is empty: region and image
        // agree.
        for (region, whole) in [(flip_region, flip), (trimmed, relmse), (trimmed_region, relmse)] {
            assert!((region / whole - 1.0).abs() < 1e-12, "{region} {whole}");
        }
    }

    #[test]
    fn errors_of_the_path_layer_do_not_count_as_caustics() {
        let measures = [&FLIP, &FLIP_CAUSTICS, &RELMSE_CAUSTICS];
        let [flip, flip_caustics, relmse_caustics] = alone(&image(0.4, 0.1), &image(0.2, 0.1), measures);
        assert!(flip.unwrap() > 0.01);
        assert_eq!(flip_caustics.zip(relmse_caustics), Some((0.0, 0.0)));
    }

    #[test]
    fn missing_parts_have_no_measure() {
        let dark = image(0.2, 0.0);
        let measures = [&RELMSE_CAUSTICS, &FLIP_CAUSTIC_REGION, &RELMSE_TRIMMED_CAUSTIC_REGION];
        assert_eq!(alone(&image(0.2, 0.1), &dark, measures), [None; 3]);
        let measures = [&FLIP, &FLIP_CAUSTICS, &RELMSE];
        assert_eq!(alone(&image(f32::NAN, 0.0), &dark, measures), [None, Some(0.0), None]);
        let whole = RenderedImage { caustics: vec![], ..dark.clone() };
        assert_eq!(alone(&whole, &dark, [&FLIP_CAUSTICS]), [None]);
    }

    #[test]
    fn flicker_is_change_beyond_the_references_and_variance_is_between_seeds() {
        let [dim, bright] = [image(0.2, 0.1), image(0.2, 0.2)];
        let measures = [&FLICKER, &FLICKER_CAUSTICS, &CAUSTICS_VARIANCE];
        let found = measures.map(seen(&[&bright], &[&dim], [&dim, &bright]));
        assert_eq!(found, [Some(0.0), Some(0.0), None], "it changes as the reference does");
        let [flicker, of_caustics, variance] =
            measures.map(seen(&[&bright, &dim], &[&dim, &dim], [&dim, &dim])).map(Option::unwrap);
        assert!(flicker > 0.01 && of_caustics == flicker && variance > 0.0);
        assert_eq!(measures.map(seen(&[&dim, &dim], &[&dim, &dim], [&dim, &dim])), [Some(0.0); 3]);
        let found = [&FLICKER].map(seen(&[&bright], &[], [&dim, &bright]));
        assert_eq!(found, [None], "no frame before");
    }

    /// Two seeds around a mean that is a tenth too bright.
    #[test]
    fn relmse_is_split_into_variance_and_bias_of_the_layers() {
        let reference = image(0.2, 0.1);
        let (low, high) = (image(0.2, 0.09), image(0.2, 0.13));
        let measures = [&PATH_NOISE, &PATH_BIAS2, &CAUSTICS_NOISE, &CAUSTICS_BIAS2, &RELMSE];
        let [path, path_bias2, noise, bias2, relmse] =
            measures.map(seen(&[&low, &high], &[], [&reference, &reference])).map(Option::unwrap);
        assert_eq!((path, path_bias2), (0.0, 0.0));
        // Deviations are 0.02 and the bias 0.01 of a light of 0.3, but for eps.
        let expected = 2.0 * 0.02_f64.powi(2) / (0.01_f64.powi(2) - 0.02_f64.powi(2));
        assert!((noise / bias2 / expected - 1.0).abs() < 1e-4, "{noise} {bias2}");
        // The image is the sum of both layers, rounded to f32.
        assert!(((noise + bias2) / relmse - 1.0).abs() < 1e-5, "{noise} {bias2} {relmse}");
        // One seed has no variance.
        assert_eq!([&PATH_NOISE].map(seen(&[&low], &[], [&reference, &reference])), [None]);
    }

    #[test]
    fn steady_errors_do_not_flicker() {
        let (reference, low, high) = (image(0.2, 0.1), image(0.2, 0.09), image(0.2, 0.13));
        let flicker = |now, before| {
            [&RELMSE_FLICKER].map(seen(&[now], &[before], [&reference, &reference]))[0].unwrap()
        };
        assert_eq!(flicker(&low, &low), 0.0);
        let of_error = |image| alone(image, &reference, [&RELMSE])[0].unwrap();
        // From -0.01 to +0.03: a square of 0.04.
        assert!((flicker(&high, &low) / of_error(&low) - 16.0).abs() < 1e-3);
    }

    #[test]
    fn different_seeds_give_a_standard_error() {
        let values = [1.0, 2.0, 6.0].map(Some);
        // The deviations from the mean of 3 are -2, -1 and 3.
        let expected = MeasuredValue { value: 3.0, standard_error: Some((14.0_f64 / 6.0).sqrt()) };
        assert_eq!(MeasuredValue::from_seeds(values.into_iter()), Some(expected));
        assert_eq!(
            MeasuredValue::from_seeds([Some(2.0)].into_iter()),
            Some(MeasuredValue { value: 2.0, standard_error: None })
        );
        assert_eq!(MeasuredValue::from_seeds([Some(2.0), None].into_iter()), None);
        assert_eq!(MeasuredValue::from_seeds(std::iter::empty()), None);
    }
}
