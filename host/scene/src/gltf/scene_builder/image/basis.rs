//! KHR_texture_basisu: KTX 2.0 files of Basis Universal, unpacked to plain texels.

use basisu::{DecodeFlags, TargetFormat, Transcoder};

use crate::texture::Image;
use caustics_files::caught::caught;

/// First bytes of a KTX 2.0 file.
const MAGIC: &[u8] = b"\xABKTX 20\xBB\r\n\x1A\n";
/// Supported colour models of the format descriptor: ETC1S and UASTC.
const MODELS: [u8; 2] = [163, 166];

/// Whether a file is in KTX 2.0 format.
pub fn is_ktx(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let word = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(word.try_into().ok()?))
}

/// Whether a file holds one image, and its finest level declares no more bytes than its texels need. The transcoder allocates the
/// declared size before it checks it.
fn is_sound(bytes: &[u8], width: u32, height: u32) -> bool {
    let number = |at| Some(u64::from(word(bytes, at)?) | u64::from(word(bytes, at + 4)?) << 32);
    let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4));
    let one_image = word(bytes, 32).is_some_and(|layers| layers <= 1) && word(bytes, 36) == Some(1);
    // A block has sixteen bytes.
    one_image && number(96).is_some_and(|claimed| claimed <= 16 * blocks)
}

/// Width and height, from the header (texels).
pub fn size(bytes: &[u8]) -> Result<(u32, u32), String> {
    word(bytes, 20).zip(word(bytes, 24)).ok_or_else(|| "cannot be decoded: its header is cut off".into())
}

/// Decodes the finest level of a file with a checked size.
pub fn read(bytes: &[u8]) -> Result<Image, String> {
    let (width, height) = size(bytes)?;
    let model = word(bytes, 48).and_then(|descriptor| bytes.get((descriptor as usize).checked_add(12)?));
    if !model.is_some_and(|model| MODELS.contains(model)) {
        return Err("cannot be decoded: it is no ETC1S or UASTC of Basis Universal".into());
    }
    if !is_sound(bytes, width, height) {
        return Err("cannot be decoded: it is no single image of the size that its header says".into());
    }
    // The transcoder returns errors; should one of its checks be missing, damaged bytes must not end the program.
    let texels = caught(|| {
        Transcoder::new(bytes)
            .and_then(|file| file.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE))
            .ok()
    });
    let texels = texels.flatten().unwrap_or_default();
    if texels.len() as u64 != 4 * u64::from(width) * u64::from(height) {
        return Err("cannot be decoded: its Basis Universal data are damaged".into());
    }
    Ok(Image { width, height, texels: texels.as_chunks().0.to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of 4 x 4 texels of one colour: one block of UASTC in its mode for constant colours.
    pub fn plain(color: [u8; 4]) -> Vec<u8> {
        let block = (0b10111_u128 | u128::from(u32::from_le_bytes(color)) << 5).to_le_bytes();
        let (descriptor, level) = (104_u32, 148_u64);
        let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
        let header = words(&[0, 1, 4, 4, 0, 0, 1, 1, 0, descriptor, 44, 0, 0, 0, 0, 0, 0]);
        let index: Vec<u8> = [level, 16, 16].iter().flat_map(|number| number.to_le_bytes()).collect();
        // Model UASTC, linear; blocks of 4 x 4; one sample of red, green, blue and alpha.
        let format = words(&[44, 0, 40 << 16 | 2, 1 << 16 | 166, 3 << 8 | 3, 16, 0, 3 << 24, 0, 0, u32::MAX]);
        [MAGIC, &header, &index, &format, &block].concat()
    }

    #[test]
    fn levels_that_declare_too_many_bytes_are_refused() {
        let file = plain([10, 20, 200, 128]);
        for (at, value) in [(96, u64::MAX), (96, 1 << 46), (96, 17), (32, 1 << 32 | 2), (36, 6)] {
            let mut file = file.clone();
            let words = if at == 96 { 8 } else { 4 };
            file[at..at + words].copy_from_slice(&value.to_le_bytes()[..words]);
            assert!(read(&file).unwrap_err().contains("no single image"), "{at} {value}");
        }
    }

    #[test]
    fn a_block_of_one_colour_decodes_to_it() {
        let file = plain([10, 20, 200, 128]);
        assert!(is_ktx(&file));
        let image = read(&file).unwrap();
        assert_eq!((image.width, image.height), (4, 4));
        assert!(image.texels.iter().all(|&texel| texel == [10, 20, 200, 128]), "{:?}", image.texels);
    }

    #[test]
    fn damaged_files_are_refused_or_give_other_images() {
        let file = plain([10, 20, 200, 128]);
        for at in 0..file.len() {
            assert!(read(&file[..at]).is_err(), "cut at {at}");
            for damage in [0x01, 0x08, 0x80, 0xFF] {
                let mut damaged = file.clone();
                damaged[at] ^= damage;
                // Check the size first, as the import does.
                if size(&damaged).is_ok_and(|(width, height)| width <= 4096 && height <= 4096) {
                    let _ = read(&damaged);
                }
            }
        }
    }
}
