//! Progressive photon mapping [Knaus and Zwicker 2011, Progressive photon mapping: a probabilistic approach] with stochastic
//! collection points: averages frames of OurBasic whose radii shrink. Each frame is an estimate of its own, so its radius depends
//! on its index alone. Camera paths are sampled anew every frame [Hachisuka and Jensen 2009]. Frames are independent where
//! nothing learns. They are uncorrelated where emissions or numbers of light paths depend on earlier frames. Where discs do
//! (`--radius-px auto`), their bias is correlated.
//!
//! Cost: as OurBasic. Consistent: the blur of a disc falls with its area as N^(alpha - 1), the variance of the mean as N^-alpha.
//! With alpha = 2/3 the mean square error of smooth light falls as N^(-2/3).
//!
//! Limitations: at any finite N, light is still blurred by the last radii, and halved within them at borders.
#![cfg(not(target_arch = "spirv"))]

use crate::interface::choice::TextureFilter;
use crate::interface::frame::FrameParams;
use crate::method::Method;
use crate::method::basic::steps;

/// Progressive photon mapping: OurBasic with radii that shrink.
pub const PROGRESSIVE: Method = Method {
    name: "progressive",
    description: "progressive photon mapping: OurBasic with radii that shrink over --frames",
    cost: "as basic",
    limitations: "none in the limit; blur falls with the cube root of the number of frames",
    gathers: true,
    supports_history: false,
    chooses_gather: true,
    chooses_emission: true,
    converges: true,
    texture_filter: TextureFilter::Finest,
    shares_indirect: true,
    uses_cache: true,
    passes_thin_walls: true,
    keeps: &[],
    frame: |params, index| FrameParams {
        frame: index,
        radius_px: params.radius_px * shrinkage(index),
        share_radius_px: params.share_radius_px * share_shrinkage(index),
        cache_share: params.cache_share * cache_share(index),
        ..params
    },
    steps: |parts, params| steps(parts, params),
};

/// Share of a radius's reduction that goes into less noise; the rest goes into less blur.
const ALPHA: f64 = 2.0 / 3.0;

/// Radius of frame `index` over the first frame's: the squares shrink by (i + alpha) / (i + 1) [Knaus and Zwicker 2011,
/// eq. 15].
pub fn shrinkage(index: u32) -> f32 {
    let square: f64 = (1..=index).map(|i| (f64::from(i) + ALPHA) / (f64::from(i) + 1.0)).product();
    square.sqrt() as f32
}

/// Radius of frame `index` for shared indirect light over the first frame's: N^(-1/4). The variance of a camera path is bounded, and
/// does not grow where radii shrink as that of photons does. So plain averages have the mean square error 1 / N. The squared bias of
/// these radii falls as fast.
pub fn share_shrinkage(index: u32) -> f32 {
    (f64::from(index) + 1.0).powf(-0.25) as f32
}

/// Number of frames in which all paths may end in the radiance cache.
const CACHED_FRAMES: f32 = 64.0;

/// Share of the camera paths of frame `index` that may end in the radiance cache. It falls as 1 / N behind the first frames. So the
/// blur of cells leaves the mean of N frames as log N / N.
pub fn cache_share(index: u32) -> f32 {
    (CACHED_FRAMES / (index as f32 + 1.0)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_shrink_as_the_power_alpha_minus_one() {
        assert_eq!(shrinkage(0), 1.0);
        assert!((shrinkage(1) - (5.0f32 / 6.0).sqrt()).abs() < 1e-6);
        let area = |index| f64::from(shrinkage(index)).powi(2);
        let slope = (area(80_000) / area(10_000)).ln() / 8.0f64.ln();
        assert!((slope - (ALPHA - 1.0)).abs() < 1e-4, "{slope}");
    }
}
