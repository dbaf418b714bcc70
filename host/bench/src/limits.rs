//! Limits of a frame: sides and area of its image, and rays that the kernels count.

use caustics::render_config::RenderConfig;
use caustics_kernels::method::frame::training_paths;

/// Largest side (px), and largest area, that a frame may have.
const MAX_SIDE: u32 = 16_384;
const MAX_AREA: u32 = 1 << 26;

/// Checks the size of an image.
///
/// # Errors
///
/// If the image has no pixels, or too many; the message names the options.
pub fn check_size(width: u32, height: u32) -> Result<(), String> {
    let within = |side| (1..=MAX_SIDE).contains(&side);
    if !within(width) || !within(height) || width * height > MAX_AREA {
        return Err(format!(
            "--width {width} --height {height}: each side must be 1 to {MAX_SIDE} px, and the area at most \
             {MAX_AREA} px"
        ));
    }
    Ok(())
}

/// Checks the number of rays of a frame, whose size must have passed [`check_size`].
///
/// # Errors
///
/// If there are more than the kernels count in 32 bits; the message names the options.
pub fn check_rays(config: &RenderConfig, width: u32, height: u32) -> Result<(), String> {
    let (light_paths, max_bounces) = (config.light_paths.count(width, height), config.max_bounces);
    let training = if config.emission.stage.after_pilot.is_some() { training_paths(light_paths) } else { 0 };
    let is_too_many = |paths: u64| paths * u64::from(max_bounces + 1) > u64::from(u32::MAX);
    if is_too_many(u64::from(width * height)) || is_too_many(u64::from(light_paths) + training) {
        return Err(format!(
            "{light_paths} light paths at {width}x{height} px with {max_bounces} bounces: more than 2^32 rays a frame; \
             give fewer --light-paths, pixels, or --max-bounces, and average --frames"
        ));
    }
    Ok(())
}
