//! Fuzz target: a Draco stream of a primitive. All bytes must be accepted or refused without a panic.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    caustics::fuzzing::draco(bytes);
});
