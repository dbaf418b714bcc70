//! Hashes by which things are known again, of 64 bits.

use rayon::prelude::*;

/// Bytes that are hashed in one piece.
const PIECE: usize = 1 << 20;

/// FNV-1a of bytes, in hexadecimal digits.
pub fn fnv1a(bytes: impl IntoIterator<Item = u8>) -> String {
    let hash = bytes.into_iter().fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    format!("{hash:016x}")
}

/// A hash of many bytes, in hexadecimal digits, at the speed of memory; of its own kind.
pub fn of_many(bytes: &[u8]) -> String {
    let pieces: Vec<u64> = bytes.par_chunks(PIECE).map(piece).collect();
    format!("{:016x}", piece(bytemuck::cast_slice(&pieces)) ^ bytes.len() as u64)
}

/// A hash of bytes, eight at a time; the last ones are filled up with zeros.
fn piece(bytes: &[u8]) -> u64 {
    let (words, rest) = bytes.as_chunks();
    let mut last = [0; 8];
    last[..rest.len()].copy_from_slice(rest);
    words.iter().chain([&last]).fold(0xcbf2_9ce4_8422_2325, |hash, word| {
        // Each step can be undone, and brings upper bits down, which a product alone does not.
        let product = (hash ^ u64::from_le_bytes(*word)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        product ^ product >> 32
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_of_many_bytes_counts_and_so_do_pairs_of_upper_bits() {
        let bytes: Vec<u8> = (0..2 * PIECE + 13).map(|at| (at % 251) as u8).collect();
        let flipped = |bits: &[usize]| {
            let mut bytes = bytes.clone();
            bits.iter().for_each(|bit| bytes[bit / 8] ^= 1 << (bit % 8));
            of_many(&bytes)
        };
        let whole = of_many(&bytes);
        for bit in [0, 63, 64, 8 * PIECE - 1, 8 * PIECE, 8 * bytes.len() - 1] {
            assert_ne!(flipped(&[bit]), whole, "bit {bit}");
        }
        assert_ne!(flipped(&[63, 127]), whole);
        assert_ne!(of_many(&bytes[..bytes.len() - 1]), whole);
        assert_ne!(of_many(&[0]), of_many(&[0, 0]));
    }

    #[test]
    fn the_hash_is_fnv_1a() {
        // Known values of the algorithm's authors.
        assert_eq!(fnv1a("".bytes()), "cbf29ce484222325");
        assert_eq!(fnv1a("a".bytes()), "af63dc4c8601ec8c");
    }
}
