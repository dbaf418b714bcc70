//! Decodes EXR files of any program to channels: every part, 16 and 32 bits.

use std::collections::BTreeMap;

use exr::prelude::*;

use super::channels::{Channels, Encoding};
use super::limit::check_samples;
use crate::caught::decoded;
use crate::output::attributes;

/// The first bytes of a file.
pub const MAGIC: [u8; 4] = exr::meta::magic_number::BYTES;

/// Memory that reading a sample takes (bytes), rounded up. Measured: 7.8 for 32 bits, 7.3 for 16 bits.
const SAMPLE_BYTES: u64 = 8;

/// Decodes a flat file. In a file of several parts, channels of a named part are called `part.channel`.
pub fn decode(bytes: &[u8]) -> std::result::Result<Channels, String> {
    decoded(|| decode_file(bytes), "it cannot be read as EXR: its data are damaged")
}

fn decode_file(bytes: &[u8]) -> std::result::Result<Channels, String> {
    let wrong = |error: Error| format!("it cannot be read as EXR: {error}");
    let meta = MetaData::read_from_buffered(std::io::Cursor::new(bytes), false).map_err(wrong)?;
    check_samples(meta.headers.iter().map(samples).sum(), SAMPLE_BYTES)?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .map_err(wrong)?;
    let size = image.layer_data.first().ok_or("it has no layer")?.size;
    let several = image.layer_data.len() > 1;
    let mut channels = BTreeMap::new();
    let mut attributes: BTreeMap<_, _> = texts(&image.attributes.other).collect();
    for layer in &image.layer_data {
        if layer.size != size {
            return Err("its parts differ in size".into());
        }
        let part = layer.attributes.layer_name.as_ref().filter(|_| several).map(ToString::to_string);
        for channel in &layer.channel_data.list {
            let own = channel.name.to_string();
            if channel.sampling != Vec2(1, 1) {
                return Err(format!("its channel {own} has fewer pixels than the image"));
            }
            let name = match &part {
                Some(part) if !own.starts_with(&format!("{part}.")) => format!("{part}.{own}"),
                _ => own,
            };
            if channels.insert(name.clone(), channel.sample_data.values_as_f32().collect()).is_some() {
                return Err(format!("two of its parts have a channel {name}"));
            }
        }
        attributes.extend(texts(&layer.attributes.other));
    }
    Ok(Channels { width: size.0, height: size.1, channels, attributes, encoding: Encoding::Linear })
}

/// Number of samples of a part by its header.
fn samples(head: &exr::meta::header::Header) -> u128 {
    let Vec2(width, height) = head.layer_size;
    // The product fits: each factor is a 32-bit number in the file.
    width as u128 * height as u128 * head.channels.list.len() as u128
}

/// Selects the texts and numbers among attributes.
fn texts<'a>(
    attributes: impl IntoIterator<Item = (&'a Text, &'a AttributeValue)>,
) -> impl Iterator<Item = (String, String)> {
    attributes.into_iter().filter_map(|(name, value)| {
        let value = match value {
            AttributeValue::Text(text) => attributes::decode(text),
            AttributeValue::I32(number) => number.to_string(),
            AttributeValue::F32(number) => number.to_string(),
            AttributeValue::F64(number) => number.to_string(),
            _ => return None,
        };
        Some((name.to_string(), value))
    })
}
