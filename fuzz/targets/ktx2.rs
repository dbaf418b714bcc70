//! Fuzz target: a KTX 2.0 image. All bytes must be accepted or refused without a panic.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    caustics::fuzzing::ktx2(bytes);
});
