//! Pictures read back: the channels of an EXR file, or the colours of a PNG file.

mod exr;
mod png;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::input;

/// Most samples of a picture, those of all channels of all parts: 16 channels of the largest frame.
const MOST_SAMPLES: u128 = 1 << 30;

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
    /// Width [px].
    pub width: usize,
    /// Height [px].
    pub height: usize,
    /// `width * height` values of each channel; `R`, `caustics.G`, `samples.count` and the like.
    pub channels: BTreeMap<String, Vec<f32>>,
    /// Texts and numbers of the file's header.
    pub attributes: BTreeMap<String, String>,
    /// What the numbers mean.
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
    /// Reads a flat EXR file with any channels (16 or 32 bits), or a PNG file as `R`, `G`, `B`; the first bytes tell.
    pub fn read(path: &Path) -> Result<Channels, ImageError> {
        let read = input::read(path, input::PICTURE);
        let bytes = read.map_err(|source| ImageError::Read { path: path.into(), source })?;
        Channels::decode(&bytes).map_err(|what| ImageError::Damaged { path: path.into(), what })
    }

    /// The same from the bytes of a file; an error says what is wrong with them.
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

/// Refuses a picture of more samples than can be, or than there is room for, before it is decoded: a header of few bytes
/// may speak of any number.
fn check_samples(samples: u128) -> Result<(), String> {
    if samples > MOST_SAMPLES {
        return Err(format!(
            "it has {samples} samples in all its channels, and at most {MOST_SAMPLES} are read"
        ));
    }
    let bytes = samples as usize * size_of::<f32>();
    let room = Vec::<u8>::new().try_reserve_exact(bytes);
    room.map_err(|_| format!("there is no room for the {bytes} bytes of its samples"))
}

#[cfg(test)]
mod tests;
