//! Fuzz target: the JSON of a result. All bytes must be accepted or refused without a panic.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    caustics_bench::fuzzing::result(bytes);
});
