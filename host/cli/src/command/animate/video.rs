//! A video of PNGs, encoded by the program ffmpeg.

use std::ops::Range;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, bail};
use caustics::file::read_file;
use caustics::output::target::{Target, TargetError};

use super::pattern::Pattern;

/// Mark in the metadata of videos written here; a video with the mark is overwritten without --force.
const MARK: &str = "caustics animate";

/// Whether an ffmpeg exists and runs.
pub fn has_ffmpeg() -> bool {
    let mut command = Command::new("ffmpeg");
    command.arg("-version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// Refuses to overwrite a file that is not a video of this command.
pub fn check(path: &Path, force: bool) -> anyhow::Result<()> {
    if force || !path.exists() {
        return Ok(());
    }
    let bytes = read_file(path).unwrap_or_default();
    let is_ours = bytes.windows(MARK.len()).any(|window| window == MARK.as_bytes());
    if is_ours { Ok(()) } else { Err(TargetError::Exists(path.into()).into()) }
}

/// Makes the video from the frames' PNGs.
pub fn write(pattern: &Pattern, frames: &Range<u32>, fps: f64, path: &Path) -> anyhow::Result<()> {
    let target = Target::claim(path, true)?;
    // ffmpeg leaves partial files behind when it fails, so it works in a folder that is removed.
    let folder = tempfile::Builder::new().prefix(".caustics-").tempdir_in(pattern.folder())?;
    let part = folder.path().join("video.mp4");
    let mut command = Command::new("ffmpeg");
    command.args(["-y", "-loglevel", "error", "-framerate", &fps.to_string()]);
    command.args(["-start_number", &frames.start.to_string(), "-i"]).arg(pattern.printf("png"));
    command.args(["-frames:v", &frames.len().to_string(), "-pix_fmt", "yuv420p"]);
    // Chroma has half the resolution, so the sides must be even.
    command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-metadata", &format!("comment={MARK}")]);
    let output = command.arg(&part).stdin(Stdio::null()).output().context("cannot run ffmpeg")?;
    if !output.status.success() {
        bail!("ffmpeg failed: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(target.finish(&read_file(&part).context("ffmpeg wrote no video")?)?)
}
