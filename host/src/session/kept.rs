//! Check of the buffers that outlive a frame when they come from a file.

/// Words of an element of each buffer that outlives a frame: `f` is a float, `u` anything else.
const WORDS: [(&str, &str); 22] = [
    ("balance", "ffffu"),
    ("cache_cells", "ffffffffffuuu"),
    ("density", "ff"),
    ("density_feedback", "u"),
    ("density_pyramid", "f"),
    ("guide_maps", "ffff"),
    ("guide_sums", "ff"),
    ("history_mean", "fff"),
    ("history_points", "ffffuuuf"),
    ("path_brightness", "ff"),
    ("path_light", "ffffffff"),
    ("path_noise_kept", "ff"),
    ("path_points", "ffffuuuf"),
    ("image_rows", "f"),
    ("pixel_noise", "ffffff"),
    ("pixel_sums", "ffff"),
    ("pixel_variances", "ff"),
    ("radius_next", "f"),
    ("share_balance", "ffffu"),
    ("start_counts", "u"),
    ("start_scores", "u"),
    ("validation_photons", "ffffu"),
];

/// Whether all floats of a buffer are finite.
pub fn is_finite(buffer: &str, bytes: &[u8]) -> bool {
    let Some((_, words)) = WORDS.iter().find(|(name, _)| *name == buffer) else { return true };
    let is_number = words.bytes().cycle().map(|word| word == b'f');
    let values = bytes.as_chunks().0.iter().map(|word| f32::from_le_bytes(*word));
    values.zip(is_number).all(|(value, is_number)| !is_number || value.is_finite())
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use caustics_kernels::interface::balance::Balance;
    use caustics_kernels::interface::history::{HistoryPoint, PathHistoryLight, ValidationPhoton};
    use caustics_kernels::method::STAGES;
    use caustics_kernels::{emission, history, method};

    use super::*;
    use crate::kernels::passes;

    #[test]
    fn every_buffer_that_outlives_a_frame_has_an_entry() {
        let strides: BTreeMap<&str, usize> =
            passes().iter().flat_map(|pass| pass.buffers).map(|bound| (bound.name, bound.stride)).collect();
        let stages = STAGES.iter().copied().chain(emission::ALL.iter().map(|emission| &emission.stage));
        let of_kinds = method::ALL.iter().map(|method| method.keeps);
        let of_kinds = of_kinds.chain(history::ALL.iter().map(|history| history.keeps));
        let of_kinds = of_kinds.chain(stages.map(|stage| stage.keeps));
        let names: BTreeSet<&str> = of_kinds.flatten().copied().collect();
        assert_eq!(names, WORDS.iter().map(|(name, _)| *name).collect());
        for (name, words) in WORDS {
            assert_eq!(strides[name], 4 * words.len(), "{name}");
        }
    }

    #[test]
    fn detects_floats_that_are_not_finite_and_ignores_integers() {
        let point = HistoryPoint {
            normal: u32::MAX,
            to_viewer: u32::MAX,
            material: u32::MAX,
            ..HistoryPoint::default()
        };
        let history_bytes = |samples, radius| {
            [point, HistoryPoint { samples, radius, ..point }]
                .map(|point| bytemuck::bytes_of(&point).to_vec())
                .concat()
        };
        assert!(is_finite("history_points", &history_bytes(1.0, 2.0)));
        assert!(!is_finite("history_points", &history_bytes(f32::NAN, 2.0)));
        assert!(!is_finite("history_points", &history_bytes(1.0, f32::NEG_INFINITY)));
        let photon = ValidationPhoton { instance: u32::MAX, ..ValidationPhoton::default() };
        assert!(is_finite("validation_photons", bytemuck::bytes_of(&photon)));
        let balance = Balance { light_paths: u32::MAX, ..Balance::default() };
        assert!(is_finite("balance", bytemuck::bytes_of(&balance)));
        let light = PathHistoryLight { indirect_samples: f32::INFINITY, ..PathHistoryLight::default() };
        assert!(!is_finite("path_light", bytemuck::bytes_of(&light)));
        for (name, words) in WORDS.iter().filter(|(_, words)| words.contains('f')) {
            assert!(!is_finite(name, &vec![0xff; 4 * words.len()]), "{name}");
        }
    }
}
