//! Existing frames: whether they belong to this run, and whether they are whole.

use std::ops::Range;
use std::path::Path;

use anyhow::Context;
use caustics::checkpoint::{Difference, Identity, difference};
use caustics::file::read_file;
use caustics::image_file::Channels;
use caustics::output::attributes;
use caustics::output::target::TargetError;
use caustics::rendered_image::RenderedImage;
use glam::Vec3;

use super::pattern::Pattern;
use crate::cli::Usage;

/// Returns the frames that are missing or damaged, in order. Refuses a file of another run.
pub fn missing(
    pattern: &Pattern,
    frames: &Range<u32>,
    identity: &Identity,
    pngs: bool,
) -> anyhow::Result<Vec<u32>> {
    let (mut missing, mut damaged) = (Vec::new(), Vec::new());
    for frame in frames.clone() {
        let path = pattern.frame(frame, "exr");
        if path.exists() {
            let mut ours = identity.clone();
            ours.insert("frame".into(), frame.to_string());
            let (mut theirs, is_whole) = read(&path).with_context(|| {
                format!("{} cannot be read as EXR; give --force or another -o", path.display())
            })?;
            theirs.retain(|name, _| ours.contains_key(name));
            if let Some(other) = difference(&ours, &theirs) {
                return Err(refusal(&path.display().to_string(), &other).into());
            }
            if !is_whole {
                damaged.push(path.display().to_string());
                missing.push(frame);
            }
        } else {
            let png = pattern.frame(frame, "png");
            if pngs && png.exists() {
                return Err(TargetError::Exists(png).into());
            }
            missing.push(frame);
        }
    }
    if let Some(first) = damaged.first() {
        let count = damaged.len();
        message!("warning: {first} is damaged and rendered anew; {count} of the frames that are there are");
    }
    Ok(missing)
}

/// Whether a file is a damaged frame.
pub fn is_damaged(path: &Path) -> bool {
    read(path).is_ok_and(|(_, is_whole)| !is_whole)
}

/// Returns the attributes of a frame, and whether its bytes are those that were written.
fn read(path: &Path) -> anyhow::Result<(Identity, bool)> {
    let bytes = read_file(path)?;
    // Files without a checksum were written by older versions.
    let is_whole = attributes::is_whole(&bytes).unwrap_or_else(|| Channels::decode(&bytes).is_ok());
    Ok((attributes::read(&bytes)?, is_whole))
}

/// Returns an error that names the difference.
pub fn refusal(file: &str, Difference { name, theirs, ours }: &Difference) -> Usage {
    Usage(format!(
        "{file} belongs to another run: its {name} is {theirs:?}, not {ours:?}; give --force to render all anew, or \
         another -o"
    ))
}

/// Reads the image of an existing frame.
pub fn image(pattern: &Pattern, frame: u32) -> anyhow::Result<RenderedImage> {
    let image = Channels::read(&pattern.frame(frame, "exr"))?;
    let layer = |name: &str| -> Vec<Vec3> {
        let colors = image
            .layer(name)
            .map(|[r, g, b]| r.iter().zip(g).zip(b).map(|((&r, &g), &b)| Vec3::new(r, g, b)).collect());
        colors.unwrap_or_default()
    };
    let (width, height) = (image.width, image.height);
    let (path, caustics) = (layer("path"), layer("caustics"));
    // A method without layers writes all its light as one layer.
    let path = if path.is_empty() { layer("") } else { path };
    Ok(RenderedImage { width, height, path, caustics, ..RenderedImage::default() })
}
