//! Distance between the two sides of a wipe.

use std::time::{Duration, Instant};

use caustics::image_file::Encoding;
use caustics::metric::comparison::Viewing;
use caustics::metric::flip_ldr::flip_ldr;
use caustics::metric::percentile::percentile;
use caustics::metric::pixels::Pixels;
use caustics::metric::relmse::{errors, relmse};
use caustics::rendered_image::RenderedImage;
use serde_json::{Value, json};

use super::share::Share;

/// Reciprocal of the maximum share of time for measuring.
const SHARE: u32 = 8;

/// Distance that was measured last.
#[derive(Debug)]
pub struct Distance {
    /// Values by the names of the measures.
    pub value: Option<Value>,
    share: Share,
}

impl Distance {
    /// Returns a distance without values.
    pub fn new() -> Distance {
        Distance { value: None, share: Share::new(SHARE, Duration::from_millis(500)) }
    }

    /// Drops the values, since one of the sides has changed.
    pub fn forget(&mut self) {
        *self = Distance::new();
    }

    /// Measures again, unless that would take too much of the time. Makes the images only when it measures.
    pub fn measure(&mut self, images: impl FnOnce() -> [RenderedImage; 2], stops: f64) {
        let start = Instant::now();
        if !self.share.is_due(start) {
            return;
        }
        let [own, other] = images().map(|image| Pixels {
            width: image.width,
            height: image.height,
            values: image.beauty().iter().map(|color| color.as_dvec3()).collect(),
        });
        self.value = Some(distances(&own, &other, stops));
        self.share.spent(start, Instant::now());
    }
}

/// Distance between two images, at an exposure (stops).
fn distances(own: &Pixels, other: &Pixels, stops: f64) -> Value {
    let flip = flip_ldr(own, other, Encoding::Linear, stops, Viewing::default().pixels_per_degree).mean();
    let errors = errors(own, other);
    json!({
        "FLIP": flip, "relMSE": relmse(&errors), "relMSE, worst 0.1 %": percentile(&errors, 0.999),
        "energy": own.mean() / other.mean(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn image(value: f32) -> RenderedImage {
        RenderedImage {
            width: 32,
            height: 32,
            path: vec![Vec3::splat(value); 1024],
            ..RenderedImage::default()
        }
    }

    #[test]
    fn equal_images_have_distance_zero_and_others_more() {
        let mut distance = Distance::new();
        distance.measure(|| [image(0.5), image(0.5)], 0.0);
        let same = distance.value.clone().unwrap();
        assert_eq!((same["FLIP"].as_f64(), same["relMSE"].as_f64()), (Some(0.0), Some(0.0)));
        // It is too soon for another measurement.
        distance.measure(|| [image(0.25), image(0.5)], 0.0);
        assert_eq!(distance.value, Some(same));
        distance.forget();
        distance.measure(|| [image(0.25), image(0.5)], 0.0);
        let apart = distance.value.unwrap();
        assert!(apart["FLIP"].as_f64() > Some(0.05), "{apart}");
        assert!((apart["relMSE"].as_f64().unwrap() - 0.0625 / (0.25 + 0.0025)).abs() < 1e-6, "{apart}");
        assert_eq!(apart["energy"].as_f64(), Some(0.5));
    }
}
