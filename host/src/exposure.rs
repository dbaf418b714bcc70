//! The exposure at which an image is looked at.

use std::str::FromStr;

use glam::DVec3;

use caustics_files::rendered_image::RenderedImage;

/// An exposure as a person gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// What suits the image.
    Auto,
    /// So many stops.
    Stops(f64),
}

impl FromStr for Exposure {
    type Err = String;

    fn from_str(text: &str) -> Result<Exposure, String> {
        if text == "auto" {
            return Ok(Exposure::Auto);
        }
        let stops = text.parse().ok().filter(|stops| (-64.0..=64.0).contains(stops));
        stops.map(Exposure::Stops).ok_or_else(|| "it must be auto or -64 to 64 stops".into())
    }
}

impl Exposure {
    /// The stops for an image.
    pub fn stops_for(self, image: &RenderedImage) -> f64 {
        self.stops(image.beauty().iter().map(|color| color.as_dvec3()))
    }

    /// The stops for an image of these radiances.
    pub fn stops(self, radiance: impl Iterator<Item = DVec3>) -> f64 {
        match self {
            Exposure::Auto => automatic(radiance),
            Exposure::Stops(stops) => stops,
        }
    }
}

/// What the logarithmic mean of an image is brought to, if that does not bring a twentieth of it beyond a light grey.
const MIDDLE_GREY: f64 = 0.18;
/// Shown at seven tenths of white; caustics and lamps are above it.
const LIGHT_GREY: f64 = 0.3;

/// The stops that bring the logarithmic mean of all luminance to a middle grey, or, if that is less, the luminance that a twentieth of
/// the pixels exceeds to a light grey; in steps of a tenth. Black pixels do not count; 0 where all are black.
fn automatic(radiance: impl Iterator<Item = DVec3>) -> f64 {
    let luminance = |color: DVec3| color.dot(DVec3::new(0.2126, 0.7152, 0.0722));
    let mut seen: Vec<f64> =
        radiance.map(luminance).filter(|value| value.is_finite() && *value > 0.0).collect();
    if seen.is_empty() {
        return 0.0;
    }
    let rank = seen.len() * 19 / 20;
    let bright = *seen.select_nth_unstable_by(rank, f64::total_cmp).1;
    let mean = seen.iter().map(|value| value.log2()).sum::<f64>() / seen.len() as f64;
    let stops = (MIDDLE_GREY.log2() - mean).min((LIGHT_GREY / bright).log2());
    (10.0 * stops.clamp(-64.0, 64.0)).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[f64]) -> f64 {
        Exposure::Auto.stops(values.iter().map(|value| DVec3::splat(*value)))
    }

    #[test]
    fn an_even_picture_is_middle_grey_and_scales_as_light_does() {
        assert_eq!(grey(&[0.18; 40]), 0.0);
        assert_eq!(grey(&[0.18 * 8.0; 40]), -3.0);
        assert_eq!(grey(&[0.0; 40]), 0.0);
        assert_eq!(grey(&[0.0, 0.18, f64::INFINITY, f64::NAN]), 0.0);
    }

    #[test]
    fn what_is_bright_stays_below_white_and_a_lamp_decides_nothing() {
        // A tenth of the image 64 times brighter than the rest.
        let image = [[0.01; 18], [0.64; 18]].concat();
        assert_eq!(grey(&image[..20]), -1.1, "the brightest twentieth at 0.3");
        let light = [[0.18; 39].to_vec(), vec![1e6]].concat();
        assert!((-0.6..=0.0).contains(&grey(&light)), "{}", grey(&light));
    }

    #[test]
    fn exposures_are_spelled_as_stops_or_auto() {
        assert_eq!("auto".parse(), Ok(Exposure::Auto));
        assert_eq!("-1.5".parse(), Ok(Exposure::Stops(-1.5)));
        for wrong in ["NaN", "65", "", "automatic"] {
            assert!(wrong.parse::<Exposure>().is_err(), "{wrong}");
        }
    }
}
