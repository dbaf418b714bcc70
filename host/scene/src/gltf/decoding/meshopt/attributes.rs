//! Mode ATTRIBUTES [EXT_meshopt_compression, appendix A; version 1: KHR_meshopt_compression]. Encodes the bytes at one position
//! of successive elements as differences, in groups of 16 with the fewest bits.

/// Maximum size of the elements of a block (bytes).
const BLOCK_BYTES: usize = 8192;
/// Maximum number of elements of a block.
const BLOCK_ELEMENTS: usize = 256;
/// Number of bytes that are packed together.
const GROUP: usize = 16;

/// Decodes `count` elements of `stride` bytes, a multiple of 4 up to 256; `None` for a damaged stream.
pub fn decode(bytes: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    let (&header, data) = bytes.split_first()?;
    let version = header & 15;
    if header & 0xF0 != 0xA0 || version > 1 {
        return None;
    }
    // The tail holds the element before the first and, since version 1, the mode of each channel of four bytes.
    let channels = if version == 0 { 0 } else { stride / 4 };
    let padded = (stride + channels).max(if version == 0 { 32 } else { 24 });
    let (mut data, tail) = data.split_at_checked(data.len().checked_sub(padded)?)?;
    let tail = &tail[padded - stride - channels..];
    let (mut last, channels) = (tail[..stride].to_vec(), &tail[stride..]);

    // Each block holds at least one byte, so a short stream ends before many elements are made.
    let max_elements = (BLOCK_BYTES / stride / GROUP * GROUP).min(BLOCK_ELEMENTS);
    let mut decoded = Vec::new();
    decoded.try_reserve_exact(count.checked_mul(stride)?).ok()?;
    let mut left = count;
    while left > 0 {
        let elements = left.min(max_elements);
        let at = decoded.len();
        decoded.resize(at + elements * stride, 0);
        data = block(data, &mut decoded[at..], elements, &mut last, channels, version)?;
        left -= elements;
    }
    data.is_empty().then_some(decoded)
}

/// Decodes a block, and returns the remaining data.
fn block<'a>(
    data: &'a [u8],
    decoded: &mut [u8],
    elements: usize,
    last: &mut [u8],
    channels: &[u8],
    version: u8,
) -> Option<&'a [u8]> {
    let stride = last.len();
    let (controls, mut data) = data.split_at_checked(if version == 0 { 0 } else { stride / 4 })?;
    let mut planes = [[0; BLOCK_ELEMENTS]; 4];
    for channel in 0..stride / 4 {
        let control = controls.get(channel).copied().unwrap_or(0);
        for (position, plane) in planes.iter_mut().enumerate() {
            data = match (version, control >> (2 * position) & 3) {
                (0, _) => groups(data, plane, elements, [0, 2, 4, 8])?,
                (_, 0) => groups(data, plane, elements, [0, 1, 2, 4])?,
                (_, 1) => groups(data, plane, elements, [1, 2, 4, 8])?,
                (_, 2) => {
                    plane.fill(0);
                    data
                }
                _ => {
                    let (bytes, rest) = data.split_at_checked(elements)?;
                    plane[..elements].copy_from_slice(bytes);
                    rest
                }
            };
        }
        let kind = channels.get(channel).copied().unwrap_or(0);
        let forerunner = &mut last[4 * channel..4 * channel + 4];
        for element in 0..elements {
            let difference = planes.map(|plane| plane[element]);
            let word = undo(difference, (&*forerunner).try_into().ok()?, kind)?;
            forerunner.copy_from_slice(&word);
            decoded[element * stride + 4 * channel..][..4].copy_from_slice(&word);
        }
    }
    Some(data)
}

/// Four bytes of an element, given their difference from the element before.
fn undo(difference: [u8; 4], before: [u8; 4], kind: u8) -> Option<[u8; 4]> {
    let [a, b, c, d] = difference;
    let [e, f, g, h] = before;
    match kind & 3 {
        0 => {
            let byte = |v: u8, before: u8| (0_u8.wrapping_sub(v & 1) ^ (v >> 1)).wrapping_add(before);
            Some([byte(a, e), byte(b, f), byte(c, g), byte(d, h)])
        }
        1 => {
            let pair = |v: [u8; 2], before: [u8; 2]| {
                let v = u16::from_le_bytes(v);
                let signed = 0_u16.wrapping_sub(v & 1) ^ (v >> 1);
                signed.wrapping_add(u16::from_le_bytes(before)).to_le_bytes()
            };
            let ([a, b], [c, d]) = (pair([a, b], [e, f]), pair([c, d], [g, h]));
            Some([a, b, c, d])
        }
        2 => {
            let turned = u32::from_le_bytes(difference).rotate_right(u32::from(kind >> 4));
            Some((turned ^ u32::from_le_bytes(before)).to_le_bytes())
        }
        _ => None,
    }
}

/// Decodes groups of 16 bytes, each with one of four bit widths, and returns the remaining data.
fn groups<'a>(
    data: &'a [u8],
    plane: &mut [u8; BLOCK_ELEMENTS],
    elements: usize,
    bits: [u32; 4],
) -> Option<&'a [u8]> {
    let count = elements.div_ceil(GROUP);
    let (headers, mut data) = data.split_at_checked(count.div_ceil(4))?;
    for (index, group) in plane.chunks_mut(GROUP).take(count).enumerate() {
        let bits = bits[usize::from(headers[index / 4] >> (2 * (index % 4)) & 3)];
        let (packed, mut rest) = data.split_at_checked(2 * bits as usize)?;
        for (position, byte) in group.iter_mut().enumerate() {
            // Single bits start at the lowest bit of a byte, others at the highest.
            let largest = ((1_u32 << bits) - 1) as u8;
            *byte = match bits {
                0 => 0,
                1 => packed[position / 8] >> (position % 8) & 1,
                8 => packed[position],
                bits => {
                    let of_byte = 8 / bits as usize;
                    packed[position / of_byte] >> (8 - bits as usize * (position % of_byte + 1)) & largest
                }
            };
            if matches!(bits, 1 | 2 | 4) && *byte == largest {
                let (&literal, behind) = rest.split_first()?;
                (*byte, rest) = (literal, behind);
            }
        }
        data = rest;
    }
    Some(data)
}
