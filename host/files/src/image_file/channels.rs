//! An image as named channels.

use std::collections::BTreeMap;

/// Encoding of an image's values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// Proportional to light: EXR.
    #[default]
    Linear,
    /// Display colours in [0, 1] with the transfer function of sRGB: PNG.
    Srgb,
}

/// An image as a set of named channels, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channels {
    /// Width (px).
    pub width: usize,
    /// Height (px).
    pub height: usize,
    /// `width * height` values of each channel, by names such as `R`, `caustics.G` and `samples.count`.
    pub channels: BTreeMap<String, Vec<f32>>,
    /// Texts and numbers of the file's header.
    pub attributes: BTreeMap<String, String>,
    /// Encoding of the values.
    pub encoding: Encoding,
}

impl Channels {
    /// Returns the red, green and blue channels of a layer: `R` or `NAME.R` and so on. A layer of one channel `NAME` is
    /// grey. An empty name selects the beauty layer.
    pub fn layer(&self, name: &str) -> Option<[&[f32]; 3]> {
        let prefix = if name.is_empty() { String::new() } else { format!("{name}.") };
        let rgb = ["R", "G", "B"].map(|channel| self.channels.get(&format!("{prefix}{channel}")));
        if let [Some(r), Some(g), Some(b)] = rgb {
            return Some([r, g, b]);
        }
        self.channels.get(if name.is_empty() { "Y" } else { name }).map(|grey| [grey.as_slice(); 3])
    }

    /// Returns the names of the layers that [`Channels::layer`] finds in this image. The beauty layer is called `beauty`.
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
