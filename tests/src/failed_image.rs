//! Maps of a failed image test: image, reference, error and p-values as PNG files, for people to look at.

use std::path::PathBuf;
use std::thread;

use caustics::output::png;
use glam::Vec3;
use statrs::distribution::{ContinuousCDF, Normal};

/// Smallest p-value that its map tells from smaller ones.
const SMALLEST_P_VALUE: f64 = 1e-6;

/// Writes maps of an image and of its reference, with one value a pixel, into a folder of the test and of `name`. Returns the folder.
/// `z_scores` are those of the differences; they are empty where an image is compared without noise. Pixels left over in the last row
/// are black.
///
/// - `image.png` and `reference.png`: from 0 to the reference's largest value.
/// - `error.png`: red where the image is too bright, blue where it is too dark, full at the largest difference.
/// - `p-value.png`: white at 1, black at 1e-6 and below, on a logarithmic scale.
///
/// # Panics
///
/// If the folder cannot be written.
pub fn write(name: &str, columns: usize, image: &[f64], reference: &[f64], z_scores: &[f64]) -> PathBuf {
    let test = thread::current().name().unwrap_or("test").replace("::", "-");
    let folder = std::env::temp_dir().join("caustics-failed-images").join(test).join(name);
    std::fs::create_dir_all(&folder).expect("a folder for the maps");
    let save = |name: &str, mut colors: Vec<Vec3>| {
        colors.resize(columns * colors.len().div_ceil(columns), Vec3::ZERO);
        let rows = colors.len() / columns;
        let bytes = png::encode(columns as u32, rows as u32, &colors).expect("an image");
        std::fs::write(folder.join(name), bytes).expect("a map");
    };

    // Image and reference on one scale
    let largest = reference.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let gray = |value: &f64| Vec3::splat((value / largest).clamp(0.0, 1.0).powf(1.0 / 2.2) as f32);
    save("image.png", image.iter().map(gray).collect());
    save("reference.png", reference.iter().map(gray).collect());

    // Signed error
    let errors: Vec<f64> = image.iter().zip(reference).map(|(image, reference)| image - reference).collect();
    let full = errors.iter().map(|error| error.abs()).fold(f64::MIN_POSITIVE, f64::max);
    let signed = |error: &f64| {
        let share = (error / full) as f32;
        Vec3::new(share.max(0.0), 0.0, (-share).max(0.0))
    };
    save("error.png", errors.iter().map(signed).collect());

    // p-values
    if !z_scores.is_empty() {
        let shade = |z: &f64| {
            let log = p_value(*z).max(SMALLEST_P_VALUE).ln() / SMALLEST_P_VALUE.ln();
            Vec3::splat(1.0 - log as f32)
        };
        save("p-value.png", z_scores.iter().map(shade).collect());
    }
    folder
}

/// Two-sided p-value of a z-score.
pub fn p_value(z: f64) -> f64 {
    2.0 * Normal::standard().sf(z.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustics::image_file::Channels;

    #[test]
    fn p_values_match_the_normal_distribution() {
        for (z, p) in [(0.0, 1.0), (1.0, 0.317_310_5), (-1.959_964, 0.05), (3.0, 0.002_699_8)] {
            assert!((p_value(z) - p).abs() < 2e-7, "{z}: {}", p_value(z));
        }
    }

    #[test]
    fn maps_show_where_an_image_is_too_bright() {
        let folder = write("maps", 2, &[1.0, 1.0, 1.0, 3.0], &[1.0; 4], &[0.0, 0.0, 0.0, 9.0]);
        let read = |name: &str| {
            let bytes = std::fs::read(folder.join(name)).expect("a map");
            let channels = Channels::decode(&bytes).expect("an image");
            let [red, ..] = channels.layer("").expect("colours");
            red.to_vec()
        };
        let (error, p_value) = (read("error.png"), read("p-value.png"));
        assert!(error[..3].iter().all(|&red| red == 0.0) && error[3] > 0.9, "{error:?}");
        assert!(p_value[..3].iter().all(|&shade| shade > 0.9) && p_value[3] == 0.0, "{p_value:?}");
        std::fs::remove_dir_all(folder).expect("the folder is there");
    }
}
