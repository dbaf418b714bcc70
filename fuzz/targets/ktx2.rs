//! An image of KTX 2.0: whatever the bytes, there is an answer.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    caustics::fuzzing::ktx2(bytes);
});
