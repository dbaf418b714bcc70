//! Intel Open Image Denoise 2, loaded at run time: denoises the path layer of a finished image. Albedo and normal of the collection
//! points are its auxiliary images. Caustics are added afterwards, as they are.

use std::ffi::{OsStr, OsString};
use std::time::Instant;

use caustics_files::RenderedImage;
use caustics_kernels::denoiser::Denoiser;
use glam::Vec3;
use serde::Serialize;

use self::error::FILE;
use self::library::OidnDevice;

mod error;
mod library;

pub use error::{OidnError, VARIABLE};

/// Denoiser of finished images. It has no step in a frame, and `Named` does not find it: animations, sweeps and the viewer do not
/// offer it.
pub const OIDN: Denoiser = Denoiser {
    name: "oidn",
    description: "Intel Open Image Denoise 2 on the finished image of render, with albedo and normal as auxiliary images; keeps the energy",
    cost: "the layers albedo and normal in every frame; once an image a neural network on the CPU: 0.9 s at 960x540 on two cores",
    limitations: "needs the library (CAUSTICS_OIDN); keeps the energy of the layer, not of its parts; blurs details that neither albedo nor \
                  normal shows",
    steps: |_| Vec::new(),
};

/// Record of the denoising of an image.
#[derive(Clone, Debug, Serialize)]
pub struct Denoised {
    /// Version of the library.
    pub version: String,
    /// Sum of the denoised path layer over the sum of the noisy one, before the layer was divided by it.
    pub energy_ratio: f64,
    /// Time that it took (ms).
    pub ms: f64,
    /// Number of pixels of the noisy layer that were not finite and count as black.
    #[serde(skip)]
    pub non_finite_count: usize,
}

impl Denoised {
    /// Attributes of the image's file.
    pub fn attributes(&self) -> [(String, String); 2] {
        let Denoised { version, energy_ratio, .. } = self;
        [("oidn_version".into(), version.clone()), ("oidn_energy_ratio".into(), energy_ratio.to_string())]
    }
}

/// Open Image Denoise on the CPU.
pub struct Oidn(OidnDevice);

impl Oidn {
    /// Loads the library that [`VARIABLE`] names, else the one that the system's loader finds. It uses at most `threads` threads;
    /// 0: one for each core.
    ///
    /// # Errors
    /// If there is no such library, or if it is not of version 2.
    pub fn from_environment(threads: usize) -> Result<Oidn, OidnError> {
        let named = std::env::var_os(VARIABLE).filter(|file| !file.is_empty());
        Oidn::load(&named.unwrap_or_else(|| OsString::from(FILE)), threads)
    }

    /// Loads the library from this file.
    fn load(file: &OsStr, threads: usize) -> Result<Oidn, OidnError> {
        OidnDevice::open(file, threads).map(Oidn)
    }

    /// Denoises the path layer of an image with the auxiliary layers albedo and normal, and keeps its energy.
    ///
    /// # Errors
    /// If a layer is missing, or if the library fails.
    pub fn denoise(&self, image: &mut RenderedImage) -> Result<Denoised, OidnError> {
        let start = Instant::now();
        let (color, non_finite_count) = finite(&image.path);
        let [(albedo, _), (normal, _)] =
            [&image.auxiliary.albedo, &image.auxiliary.normal].map(|layer| finite(layer));
        let mut denoised = self.0.denoise([image.width, image.height], &color, &albedo, &normal)?;
        let energy_ratio = keep_energy(&color, &mut denoised);
        image.path = denoised;
        let ms = start.elapsed().as_secs_f64() * 1e3;
        Ok(Denoised { version: self.0.version(), energy_ratio, ms, non_finite_count })
    }
}

/// Returns a layer with zeros in place of pixels that are not finite, and the number of these.
fn finite(layer: &[Vec3]) -> (Vec<Vec3>, usize) {
    let kept: Vec<Vec3> =
        layer.iter().map(|&pixel| if pixel.is_finite() { pixel } else { Vec3::ZERO }).collect();
    (kept, layer.iter().filter(|pixel| !pixel.is_finite()).count())
}

/// Divides a denoised layer by the ratio of its energy to that of the noisy layer, and returns the ratio. Where that is no positive
/// number, the layer becomes the noisy one.
fn keep_energy(noisy: &[Vec3], denoised: &mut [Vec3]) -> f64 {
    let energy = |layer: &[Vec3]| layer.iter().map(|pixel| pixel.as_dvec3().element_sum()).sum::<f64>();
    let ratio = energy(denoised) / energy(noisy);
    if !(ratio.is_finite() && ratio > 0.0) {
        denoised.copy_from_slice(noisy);
        return 1.0;
    }
    for pixel in denoised {
        *pixel = (pixel.as_dvec3() / ratio).as_vec3();
    }
    ratio
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustics_files::rendered_image::Auxiliary;
    use caustics_kernels::math::rng::{Rng, Stream};

    #[test]
    fn missing_library_is_an_error_that_says_how_to_install_it() {
        let error = Oidn::load(OsStr::new("/no/such/library.so"), 0).err().expect("no library").to_string();
        for word in ["/no/such/library.so", "pip install pyoidn", VARIABLE, FILE] {
            assert!(error.contains(word), "{error}");
        }
    }

    #[test]
    fn denoised_layer_is_divided_by_the_ratio_of_the_energies() {
        let noisy = [Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO];
        let mut denoised = [Vec3::ONE, Vec3::splat(0.5)];
        assert_eq!(keep_energy(&noisy, &mut denoised), 0.75);
        assert_eq!(denoised, [Vec3::splat(4.0 / 3.0), Vec3::splat(2.0 / 3.0)]);
        let mut denoised = [Vec3::ONE; 2];
        assert_eq!(keep_energy(&[Vec3::ZERO; 2], &mut denoised), 1.0);
        assert_eq!(denoised, [Vec3::ZERO; 2]);
        for wrong in [Vec3::ZERO, Vec3::NAN, Vec3::NEG_ONE, Vec3::INFINITY] {
            let mut denoised = [wrong; 2];
            assert_eq!((keep_energy(&noisy, &mut denoised), denoised), (1.0, noisy), "{wrong}");
        }
    }

    #[test]
    fn pixels_that_are_not_finite_count_as_black() {
        let layer = [Vec3::ONE, Vec3::new(1.0, f32::NAN, 0.0), Vec3::INFINITY];
        assert_eq!(finite(&layer), (vec![Vec3::ONE, Vec3::ZERO, Vec3::ZERO], 2));
    }

    #[test]
    fn library_removes_noise_and_keeps_energy_beside_a_pixel_that_is_not_finite() {
        let oidn = match Oidn::from_environment(0) {
            Ok(oidn) => oidn,
            Err(missing) => return eprintln!("skipped: {missing}"),
        };
        let (width, height) = (96_usize, 64);
        let noise = |pixel| Vec3::splat(2.0 * Rng::new(Stream::Light, 0, pixel, 0).next4().x);
        let mut path: Vec<Vec3> = (0..(width * height) as u32).map(noise).collect();
        path[1000] = Vec3::NAN;
        let layer = |value| vec![value; width * height];
        let (albedo, normal) = (layer(Vec3::splat(0.5)), layer(Vec3::Y));
        let auxiliary = Auxiliary { albedo, normal, ..Auxiliary::default() };
        let caustics = layer(Vec3::X);
        let noisy = RenderedImage { width, height, path, caustics, auxiliary, ..RenderedImage::default() };
        let mut image = noisy.clone();
        let denoised = oidn.denoise(&mut image).unwrap();
        assert!(denoised.version.starts_with("2.") && denoised.non_finite_count == 1, "{denoised:?}");
        assert_eq!((&image.caustics, &image.auxiliary), (&noisy.caustics, &noisy.auxiliary));
        let sums = |layer: &[Vec3]| {
            let values = layer
                .iter()
                .filter(|pixel| pixel.is_finite())
                .map(|pixel| f64::from(pixel.element_sum()) / 3.0);
            values.fold([0.0; 2], |[sum, squares], value| [sum + value, squares + (value - 1.0).powi(2)])
        };
        let ([before, noise_before], [after, noise_after]) = (sums(&noisy.path), sums(&image.path));
        // Energies of all channels together agree up to the rounding of pixels to 32 bits.
        assert!(image.path.iter().all(|pixel| pixel.is_finite()) && (after / before - 1.0).abs() < 1e-6);
        assert!(noise_after < 0.1 * noise_before, "{noise_after} of {noise_before}");
        // An image without auxiliary layers is refused before the library reads them.
        image.auxiliary = Auxiliary::default();
        assert!(matches!(oidn.denoise(&mut image), Err(OidnError::Failed(_))));
    }
}
