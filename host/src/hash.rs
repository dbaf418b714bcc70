//! The hash by which things are known again: FNV-1a, 64 bits.

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
    fn the_hash_is_fnv_1a() {
        // Known values of the algorithm's authors.
        assert_eq!(fnv1a("".bytes()), "cbf29ce484222325");
        assert_eq!(fnv1a("a".bytes()), "af63dc4c8601ec8c");
    }
}
