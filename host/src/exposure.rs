//! Exposure of an image for display.

use std::str::FromStr;

use glam::DVec3;

use caustics_files::rendered_image::RenderedImage;

/// Exposure setting of a user.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Exposure chosen by the image's luminance.
    Auto,
    /// Fixed number of stops.
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
    /// Returns the stops for an image.
    pub fn stops_for(self, image: &RenderedImage) -> f64 {
        self.stops(image.beauty().iter().map(|color| color.as_dvec3()))
    }

    /// Returns the stops for an image of these radiances (W m^-2 sr^-1).
    pub fn stops(self, radiance: impl Iterator<Item = DVec3>) -> f64 {
        match self {
            Exposure::Auto => automatic(radiance),
            Exposure::Stops(stops) => stops,
        }
    }
}

/// Target of the logarithmic mean, unless more than a twentieth of the pixels would then exceed [`LIGHT_GREY`].
const MIDDLE_GREY: f64 = 0.18;
/// Maximum of the darkest 95 % of the pixels. A display shows it at seven tenths of white; caustics and lights are above
/// it.
const LIGHT_GREY: f64 = 0.3;

/// Returns the automatic exposure in steps of a tenth. It brings the logarithmic mean of all luminance to [`MIDDLE_GREY`].
/// The exposure is lower if a twentieth of the pixels would exceed [`LIGHT_GREY`].
/// Black pixels do not count; 0 if all pixels are black.
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
    fn an_even_image_is_middle_grey_at_any_scale() {
        assert_eq!(grey(&[0.18; 40]), 0.0);
        assert_eq!(grey(&[0.18 * 8.0; 40]), -3.0);
        assert_eq!(grey(&[0.0; 40]), 0.0);
        assert_eq!(grey(&[0.0, 0.18, f64::INFINITY, f64::NAN]), 0.0);
    }

    #[test]
    fn bright_areas_stay_below_white_and_a_small_light_has_little_effect() {
        // A tenth of the image is 64 times brighter than the rest.
        let image = [[0.01; 18], [0.64; 18]].concat();
        assert_eq!(grey(&image[..20]), -1.1, "the brightest twentieth begins at 0.3");
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
