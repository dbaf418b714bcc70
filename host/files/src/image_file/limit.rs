//! Images that are too large to be read.

use crate::memory;

/// Most samples of an image, those of all channels of all parts: 16 channels of the largest frame.
pub const MAX_SAMPLES: u128 = 1 << 30;
/// Samples from which on an image is compared with the memory that is there.
const LARGE: u128 = 1 << 16;

/// Refuses an image of more samples than can be, or than there is memory for, before it is decoded: a header of few bytes may
/// speak of any number.
///
/// Reading takes `each` of a sample (bytes), measured as the growth of the peak of `compare`.
pub fn check_samples(samples: u128, each: u64) -> Result<(), String> {
    // The system is asked for what may be much only.
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
