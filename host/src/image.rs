//! Pictures read back: the channels of an EXR file, or the colours of a PNG file.

mod exr;
mod png;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::file::read_file;
use crate::memory;

/// Most samples of a picture, those of all channels of all parts: 16 channels of the largest frame.
const MAX_SAMPLES: u128 = 1 << 30;
/// Pictures of at least so many samples are checked against the memory that is available before they are decoded.
const LARGE: u128 = 1 << 22;
/// What the numbers of a picture mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// Proportional to light: EXR.
    #[default]
    Linear,
    /// Display colours in [0, 1] with the transfer function of sRGB: PNG.
    Srgb,
}

/// A picture as a set of named channels, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channels {
    /// Width (px).
    pub width: usize,
    /// Height (px).
    pub height: usize,
    /// `width * height` values of each channel; `R`, `caustics.G`, `samples.count` and the like.
    pub channels: BTreeMap<String, Vec<f32>>,
    /// Texts and numbers of the file's header.
    pub attributes: BTreeMap<String, String>,
    /// Whether the numbers are light or display colours.
    pub encoding: Encoding,
}

/// Why a file gives no picture.
#[derive(Debug, Error)]
pub enum ImageError {
    /// The system cannot read it.
    #[error("cannot read {}: {source}; check the path", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is neither EXR nor PNG, or damaged.
    #[error("{}: {what}; give a flat EXR file or a PNG file", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}

impl Channels {
    /// Reads a flat EXR file with any channels (16 or 32 bits), or a PNG file as `R`, `G`, `B`; the first bytes tell
    /// which it is.
    pub fn read(path: &Path) -> Result<Channels, ImageError> {
        let read = read_file(path);
        let bytes = read.map_err(|source| ImageError::Read { path: path.into(), source })?;
        Channels::decode(&bytes).map_err(|what| ImageError::Damaged { path: path.into(), what })
    }

    /// Decodes the bytes of an EXR or PNG file, as [`Channels::read`] does.
    ///
    /// # Errors
    ///
    /// If the bytes are neither, are damaged, or would take more memory than is available; the text says what is wrong.
    pub fn decode(bytes: &[u8]) -> Result<Channels, String> {
        if bytes.starts_with(&exr::MAGIC) {
            exr::decode(bytes)
        } else if bytes.starts_with(png::MAGIC) {
            png::decode(bytes)
        } else {
            Err("it is neither an EXR nor a PNG file".into())
        }
    }

    /// The red, green and blue channel of a layer: `R` or `NAME.R` and so on; a layer of one channel `NAME` is grey.
    /// The name of the beauty layer is empty.
    pub fn layer(&self, name: &str) -> Option<[&[f32]; 3]> {
        let prefix = if name.is_empty() { String::new() } else { format!("{name}.") };
        let lanes = ["R", "G", "B"].map(|lane| self.channels.get(&format!("{prefix}{lane}")));
        if let [Some(r), Some(g), Some(b)] = lanes {
            return Some([r, g, b]);
        }
        self.channels.get(if name.is_empty() { "Y" } else { name }).map(|grey| [grey.as_slice(); 3])
    }

    /// Names that [`Channels::layer`] knows here; the beauty layer is called `beauty`.
    pub fn layer_names(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for channel in self.channels.keys() {
            let name = match channel.rsplit_once('.') {
                Some((layer, "R" | "G" | "B")) if self.layer(layer).is_some() => layer,
                None if ["R", "G", "B", "Y"].contains(&channel.as_str()) && self.layer("").is_some() => {
                    "beauty"
                }
                _ => channel,
            };
            if !names.iter().any(|known| known == name) {
                names.push(name.into());
            }
        }
        names
    }
}

/// Refuses a picture of more samples than can be, or than there is memory for, before it is decoded: a header of few bytes may
/// speak of any number.
///
/// Reading takes `each` of a sample (bytes), measured as the growth of the peak of `compare`.
fn check_samples(samples: u128, each: u64) -> Result<(), String> {
    // The system is asked for what may be much only.
    check_samples_within(samples, each, if samples > LARGE { memory::available() } else { None })
}

fn check_samples_within(samples: u128, each: u64, available: Option<u64>) -> Result<(), String> {
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

#[cfg(test)]
mod tests;
