//! Scene-linear EXR: beauty as R, G, B, the layers `path`, `caustics`, `points`, `deposits` by channel names.

use anyhow::Context;
use exr::prelude::*;
use glam::Vec3;

use crate::picture::Picture;

/// Encodes a picture; `attributes` say how it was made. Colours are linear with the primaries of Rec. 709.
pub fn encode(picture: &Picture, attributes: &[(&str, String)]) -> anyhow::Result<Vec<u8>> {
    let beauty: Vec<Vec3> = picture.path.iter().zip(&picture.caustics).map(|(p, c)| *p + *c).collect();
    let mut channels = SmallVec::<[AnyChannel<FlatSamples>; 4]>::new();
    let mut number = |name: &str, values: Vec<f32>| {
        channels.push(AnyChannel::new(name, FlatSamples::F32(values)));
    };
    for (layer, values) in [("", &beauty), ("caustics.", &picture.caustics), ("path.", &picture.path)] {
        for (lane, name) in ["R", "G", "B"].iter().enumerate() {
            number(&format!("{layer}{name}"), values.iter().map(|value| value[lane]).collect());
        }
    }
    number("points.radius", picture.radius.clone());
    number("points.depth", picture.depth.clone());
    number("deposits.count", picture.deposits.clone());

    let mut other = std::collections::HashMap::new();
    for (name, value) in attributes {
        let value = Text::new_or_none(value).with_context(|| format!("attribute {name} is no EXR text"))?;
        other.insert(Text::from(*name), AttributeValue::Text(value));
    }
    let size = (picture.width, picture.height);
    let layer_attributes =
        LayerAttributes { other, software_name: Some(Text::from("caustics")), ..LayerAttributes::default() };
    let layer = Layer::new(size, layer_attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut image = Image::from_layer(layer);
    image.attributes.chromaticities = Some(attribute::Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.30, 0.60),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).context("encoding EXR")?;
    Ok(bytes.into_inner())
}
