//! Hashes that identify scenes, runs and files.
//!
//! [`Digest`] is BLAKE3 of 256 bits, for which a second scene of the same hash cannot be constructed. It names everything
//! that is trusted by its name: a BVH of the cache, a reference, a checkpoint, a result.
//! [`fnv1a`] only finds incomplete modules of kernels. The builder writes it into `kernels.lock` beside them, and a program
//! that replaces a module can replace its lock too.

use blake3::Hasher;

/// Size of a part from which all threads hash together (bytes).
const MANY: usize = 1 << 17;
/// Number of hexadecimal digits of a [`Digest`].
pub const DIGITS: usize = 64;

/// BLAKE3 of a list of parts. The length of each part is hashed too, so that moving a byte between parts changes the
/// digest.
#[derive(Clone, Debug, Default)]
pub struct Digest(Hasher);

impl Digest {
    /// Returns the digest of these parts in hexadecimal digits.
    pub fn hex<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> String {
        let mut digest = Digest::default();
        parts.into_iter().for_each(|part| digest.add(part));
        digest.finish()
    }

    /// Adds a part.
    pub fn add(&mut self, part: &[u8]) {
        self.0.update(&(part.len() as u64).to_le_bytes());
        if part.len() < MANY {
            self.0.update(part)
        } else {
            self.0.update_rayon(part)
        };
    }

    /// Returns the digest of all parts in hexadecimal digits.
    pub fn finish(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }
}

/// BLAKE3 of a text, in hexadecimal digits.
pub fn digest(text: &str) -> String {
    Digest::hex([text.as_bytes()])
}

/// FNV-1a of bytes, in hexadecimal digits.
pub fn fnv1a(bytes: impl IntoIterator<Item = u8>) -> String {
    let hash = bytes.into_iter().fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digest_is_blake3_of_parts_with_their_lengths() {
        // The expected digest of no input is published by the algorithm's authors.
        assert_eq!(
            Digest::default().finish(),
            "af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262"
        );
        let whole = [&3u64.to_le_bytes()[..], b"abc", &0u64.to_le_bytes()].concat();
        assert_eq!(Digest::hex([&b"abc"[..], b""]), blake3::hash(&whole).to_hex().as_str());
        assert_eq!(digest("abc").len(), DIGITS);
    }

    #[test]
    fn digest_differs_for_every_flipped_bit_and_every_border_of_parts() {
        let bytes: Vec<u8> = (0..2 * MANY + 13).map(|at| (at % 251) as u8).collect();
        let whole = Digest::hex([&bytes[..]]);
        for bit in [0, 63, 64, 8 * MANY - 1, 8 * MANY, 8 * bytes.len() - 1] {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_ne!(Digest::hex([&flipped[..]]), whole, "bit {bit}");
        }
        let hex = |parts: &[&str]| Digest::hex(parts.iter().map(|part| part.as_bytes()));
        assert_ne!(hex(&["ab", "c"]), hex(&["a", "bc"]));
        assert_ne!(hex(&["a"]), hex(&["a", ""]));
    }

    #[test]
    fn fnv1a_has_the_known_values_of_its_authors() {
        assert_eq!(fnv1a("".bytes()), "cbf29ce484222325");
        assert_eq!(fnv1a("a".bytes()), "af63dc4c8601ec8c");
    }
}
