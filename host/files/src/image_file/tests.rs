use std::collections::BTreeMap;
use std::path::PathBuf;

use ::exr::prelude::{self as file, *};
use glam::Vec3;

use super::limit::{MAX_SAMPLES, check_samples_within};
use super::{Channels, ImageError, png};
use crate::rendered_image::RenderedImage;

fn write(folder: &tempfile::TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// Name, size and channels of a part of a file.
type Part<'a> = (Option<&'a str>, (usize, usize), Vec<(&'a str, FlatSamples)>);

/// Encodes a file with these parts.
fn parts(parts: &[Part]) -> Vec<u8> {
    let layers: Vec<_> = parts
        .iter()
        .map(|(name, size, channels)| {
            let channels: SmallVec<[_; 4]> =
                channels.iter().map(|(name, samples)| AnyChannel::new(*name, samples.clone())).collect();
            let attributes =
                LayerAttributes { layer_name: name.map(Text::from), ..LayerAttributes::default() };
            Layer::new(*size, attributes, file::Encoding::FAST_LOSSLESS, AnyChannels::sort(channels))
        })
        .collect();
    let window = IntegerBounds::from_dimensions(parts[0].1);
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layers(ImageAttributes::new(window), layers).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn written_images_are_read_back_with_layers_and_attributes() {
    let folder = tempfile::tempdir().unwrap();
    let colors = |scale: f32| (0..6).map(|i| Vec3::new(i as f32, 0.5, 1e-3) * scale).collect::<Vec<_>>();
    let image = RenderedImage {
        width: 3,
        height: 2,
        path: colors(1.0),
        caustics: colors(10.0),
        radius: vec![0.25; 6],
        depth: vec![2.0; 6],
        photons: vec![7.0; 6],
        ..RenderedImage::default()
    };
    let bytes =
        crate::output::exr::encode(&image, None, &BTreeMap::from([("scene".into(), "ring".into())])).unwrap();
    let read = Channels::read(&write(&folder, "a.exr", &bytes)).unwrap();
    assert_eq!((read.width, read.height, read.encoding), (3, 2, super::Encoding::Linear));
    assert_eq!(read.attributes["scene"], "ring");
    let [r, g, _] = read.layer("caustics").unwrap();
    assert_eq!((r, g[0]), (&[0.0, 10.0, 20.0, 30.0, 40.0, 50.0][..], 5.0));
    assert_eq!(read.layer("").unwrap()[0][5], 55.0);
    assert_eq!(read.layer("photons.count").unwrap()[2], &[7.0; 6][..]);
    assert!(read.layer("diffuse").is_none());
    let names = ["beauty", "caustics", "path", "photons.count", "points.depth", "points.radius"];
    assert_eq!(read.layer_names(), names);
}

#[test]
fn files_of_other_programs_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let half = |value: f32| FlatSamples::F16(vec![f16::from_f32(value); 2]);
    // Half floats and integers. Some programs repeat the part's name in its channels' names, others do not.
    let bytes = parts(&[
        (Some("beauty"), (2, 1), vec![("R", half(0.5)), ("G", half(-1.0)), ("B", half(65504.0))]),
        (Some("direct"), (2, 1), vec![("direct.R", half(2.0)), ("id", FlatSamples::U32(vec![3, 4]))]),
    ]);
    let read = Channels::read(&write(&folder, "parts.exr", &bytes)).unwrap();
    assert_eq!(read.layer("beauty").unwrap(), [&[0.5; 2][..], &[-1.0; 2], &[65504.0; 2]]);
    assert_eq!(read.channels["direct.R"], [2.0; 2]);
    assert_eq!(read.channels["direct.id"], [3.0, 4.0]);

    let grey = parts(&[(None, (1, 1), vec![("Y", FlatSamples::F32(vec![3.0]))])]);
    let read = Channels::read(&write(&folder, "grey.exr", &grey)).unwrap();
    assert_eq!(read.layer("").unwrap(), [&[3.0][..]; 3]);
    assert_eq!(read.layer_names(), ["beauty"]);
}

#[test]
fn display_colours_are_read_from_png() {
    let folder = tempfile::tempdir().unwrap();
    let colors = [Vec3::new(0.0, 1.0, 0.2), Vec3::new(1.0, 0.0, 0.6)];
    let bytes = crate::output::png::encode(2, 1, &colors).unwrap();
    // The first bytes decide the format, not the file's name.
    let read = Channels::read(&write(&folder, "a.exr", &bytes)).unwrap();
    assert_eq!((read.width, read.height, read.encoding), (2, 1, super::Encoding::Srgb));
    assert_eq!(read.layer("").unwrap(), [&[0.0, 1.0][..], &[1.0, 0.0], &[0.2, 0.6]]);
}

#[test]
fn errors_of_damaged_files_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let whole = parts(&[(None, (4, 4), vec![("R", FlatSamples::F32(vec![1.0; 16]))])]);
    let unequal = [("a", (4, 4)), ("b", (2, 1))].map(|(name, size): (_, (usize, usize))| {
        (Some(name), size, vec![("R", FlatSamples::F32(vec![1.0; size.0 * size.1]))])
    });
    for (name, bytes, words) in [
        ("cut.exr", &whole[..whole.len() - 9], "EXR"),
        ("head.exr", &whole[..20], "EXR"),
        ("text.exr", b"hello", "neither"),
        ("empty.exr", b"", "neither"),
        ("cut.png", png::MAGIC, "PNG"),
        ("unequal.exr", &parts(&unequal), "differ in size"),
    ] {
        let error = Channels::read(&write(&folder, name, bytes)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(words), "{error}");
    }
    let error = Channels::read(&folder.path().join("none.exr")).unwrap_err();
    assert!(matches!(error, ImageError::Read { .. }) && error.to_string().contains("none.exr"));
}

/// Replaces the size in the header of an image's file.
fn resized(bytes: &[u8], width: i32, height: i32) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let at = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4 + 8;
        bytes[at..at + 8].copy_from_slice(&[width - 1, height - 1].map(i32::to_le_bytes).concat());
    }
    bytes
}

/// Without the limit, decoding would allocate 1 GB for each channel.
#[test]
fn a_header_that_declares_too_many_samples_is_refused() {
    let names: Vec<String> = (0..15).map(|index| format!("c{index:02}")).collect();
    let channels = names.iter().map(|name| (name.as_str(), FlatSamples::F32(vec![1.0; 16])));
    let file = parts(&[(None, (4, 4), channels.collect())]);
    assert!(Channels::decode(&resized(&file, 4, 4)).is_ok());
    let error = Channels::decode(&resized(&file, 30_000_000, 9)).unwrap_err();
    assert!(file.len() < 4096 && error.contains("4050000000 samples"), "{error}");
    // The maximum number of samples takes more than 1 GiB.
    assert!(check_samples_within(MAX_SAMPLES, 8, None).is_ok());
    let error = check_samples_within(MAX_SAMPLES, 8, Some(1 << 30)).unwrap_err();
    assert!(error.contains("8.0 GiB") && error.contains("1024 MiB are available"), "{error}");
    assert!(check_samples_within(1 << 26, 8, Some(1 << 30)).is_ok());
}
