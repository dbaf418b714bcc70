//! Limits of the size of images.

use crate::memory;

/// Maximum number of samples of an image in all channels of all parts: 16 channels of the largest frame.
pub const MAX_SAMPLES: u128 = 1 << 30;
/// Number of samples from which an image is compared with the available memory.
const LARGE: u128 = 1 << 16;

/// Refuses an image before it is decoded, if it has more samples than [`MAX_SAMPLES`] or does not fit into memory. A header
/// of a few bytes can declare any number of samples.
///
/// `each` is the memory that reading a sample takes (bytes), measured as the growth of the peak of `compare`.
pub fn check_samples(samples: u128, each: u64) -> Result<(), String> {
    // Query the system for large images only.
    check_samples_within(samples, each, if samples > LARGE { memory::available() } else { None })
}

pub fn check_samples_within(samples: u128, each: u64, available: Option<u64>) -> Result<(), String> {
    if samples > MAX_SAMPLES {
        return Err(format!(
            "it has {samples} samples in all its channels, and at most {MAX_SAMPLES} are read"
        ));
    }
    let needed = samples as u64 * each;
    match available.filter(|&available| needed > available) {
        Some(available) => {
            let (needed, available) = (memory::shown(needed), memory::shown(available));
            Err(format!("its {samples} samples would take {needed} of memory, but {available} are available"))
        }
        None => Ok(()),
    }
}
