//! FLIP on a display. Display colours are compared as they are, radiance after the display's curve.

use std::rc::Rc;

use glam::DVec3;

use super::comparison::{Better, Comparison, Metric, NoValue, Viewing};
use super::error_map::ErrorMap;
use super::flip::flip;
use super::pixels::{Estimate, Pixels};
use caustics_files::image_file::Encoding;

/// Perceived difference on a display at one exposure.
pub static FLIP_LDR: Metric = Metric {
    name: "flip_ldr",
    description: "Perceived difference on a display, at one exposure",
    unit: "1",
    better: Better::Lower,
    limitations: "differences in white or black of the exposure do not count",
    compute: |comparison| map(comparison).0.as_ref().map(ErrorMap::mean).ok_or(NoValue::NoImage),
};

/// Mean error map over runs.
pub struct LdrMap(pub Option<ErrorMap>);

/// Returns the error map of this metric, computed once per comparison.
pub fn map(comparison: &Comparison<'_>) -> Rc<LdrMap> {
    comparison.shared(|Comparison { runs, reference, viewing, .. }| {
        let Viewing { encoding, exposure, pixels_per_degree } = *viewing;
        let map =
            |run: &Estimate| flip_ldr(&run.mean, &reference.mean, encoding, exposure, pixels_per_degree);
        LdrMap(ErrorMap::mean_of(runs.iter().map(map)))
    })
}

/// Returns the FLIP of displayed images. Linear images are exposed by `exposure` stops and tone-mapped as for the PNG of
/// `render`. sRGB images are compared unchanged.
pub fn flip_ldr(
    image: &Pixels,
    reference: &Pixels,
    encoding: Encoding,
    exposure: f64,
    pixels_per_degree: f64,
) -> ErrorMap {
    let shown = |image: &Pixels| {
        image.map(|value| match encoding {
            Encoding::Linear => curve(value * exposure.exp2()),
            Encoding::Srgb => value.clamp(DVec3::ZERO, DVec3::ONE),
        })
    };
    flip(&shown(image), &shown(reference), pixels_per_degree)
}

/// Tone-maps radiance by the display's curve before its encoding: a rational fit to ACES [Narkowicz 2015], as in the pass
/// `display`.
fn curve(value: DVec3) -> DVec3 {
    let x = value.clamp(DVec3::ZERO, DVec3::splat(1e6));
    let mapped = (x * (x * 2.51 + 0.03)) / (x * (x * 2.43 + 0.59) + 0.14);
    mapped.clamp(DVec3::ZERO, DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::flip::color::from_srgb;

    #[test]
    fn the_curve_matches_the_display_pass() {
        for value in [0.0_f32, 1e-3, 0.18, 1.0, 7.0, 1e9] {
            let displayed =
                caustics_kernels::pass::display::tone_mapped(glam::Vec3::splat(value), 1.0).as_dvec3();
            // The tolerance is that of f32 against f64.
            assert!(
                (from_srgb(displayed) - curve(DVec3::splat(value.into()))).abs().max_element() < 1e-6,
                "{value}"
            );
        }
    }
}
