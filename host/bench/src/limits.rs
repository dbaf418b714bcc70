//! Limits of a frame: sides and area of its image, and rays that the kernels count.

use caustics::render_config::RenderConfig;

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
    let rays = |paths: u32| u64::from(paths) * u64::from(max_bounces + 1);
    if rays(width * height) > u64::from(u32::MAX) || rays(light_paths) > u64::from(u32::MAX) {
        return Err(format!(
            "{light_paths} light paths at {width}x{height} px with {max_bounces} bounces: more than 2^32 rays a frame; \
             give fewer --light-paths, pixels, or --max-bounces, and average --frames"
        ));
    }
    Ok(())
}
