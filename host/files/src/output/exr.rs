//! Scene-linear EXR files. Beauty is R, G, B; the other layers go by channel names. `path`, `caustics`, `points` and
//! `photons` belong to a gather.
//! A mean has `variance` (of the mean of beauty) and `samples`; layers for other tools are
//! [`Auxiliary`](crate::rendered_image::Auxiliary).

use std::collections::BTreeMap;

use exr::prelude::*;
use glam::Vec3;

use super::EncodeError;
use super::attributes::{CHECKSUM, seal, sort, text, unknown_checksum};
use crate::rendered_image::RenderedImage;

/// Note for readers of the layer `variance`.
const VARIANCE_NOTE: &str = "estimated from the samples of each pixel; too small where few of them carry the light, \
    and 0 where none has found it yet";

/// Encodes an image as the bytes of an EXR file. Colours are linear with the primaries of Rec. 709.
/// `variance` is the variance of a mean and its number of frames, for the layers `variance` and `samples`. `attributes` say
/// how the image was made and go into the header.
///
/// # Errors
///
/// If a layer's size differs from the image's.
pub fn encode(
    image: &RenderedImage,
    variance: Option<(Vec<Vec3>, u32)>,
    attributes: &BTreeMap<String, String>,
) -> std::result::Result<Vec<u8>, EncodeError> {
    let mut channels = SmallVec::<[AnyChannel<FlatSamples>; 4]>::new();
    let mut number = |name: &str, values: Vec<f32>| {
        if !values.is_empty() {
            channels.push(AnyChannel::new(name, FlatSamples::F32(values)));
        }
    };
    let (variance, samples) = variance.unwrap_or_default();
    let split = if image.caustics.is_empty() { &[] } else { &image.path[..] };
    let beauty = image.beauty();
    let colors =
        [("", &beauty[..]), ("caustics.", &image.caustics), ("path.", split), ("variance.", &variance)];
    for (layer, values) in colors {
        for (channel, name) in ["R", "G", "B"].iter().enumerate() {
            number(&format!("{layer}{name}"), values.iter().map(|value| value[channel]).collect());
        }
    }
    number("points.radius", image.radius.clone());
    number("points.depth", image.depth.clone());
    number("photons.count", image.photons.clone());
    number("samples.count", vec![samples as f32; variance.len()]);
    for (name, values) in image.auxiliary.channels() {
        number(&name, values);
    }

    let mut attributes = attributes.clone();
    if !variance.is_empty() {
        attributes.insert("variance_note".into(), VARIANCE_NOTE.into());
    }
    let mut other = std::collections::HashMap::from([unknown_checksum()]);
    for (name, value) in attributes.iter().filter(|(name, _)| *name != CHECKSUM) {
        other.insert(text(name), AttributeValue::Text(text(value)));
    }
    let size = (image.width, image.height);
    let layer_attributes =
        LayerAttributes { other, software_name: Some(Text::from("caustics")), ..LayerAttributes::default() };
    let layer = Layer::new(size, layer_attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut file = Image::from_layer(layer);
    file.attributes.chromaticities = Some(attribute::Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.30, 0.60),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    file.write().to_buffered(&mut bytes)?;
    // Sort the attributes, which the crate writes in the order of a hash map.
    seal(sort(bytes.into_inner())?)
}
