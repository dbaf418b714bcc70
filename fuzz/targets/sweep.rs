//! Fuzz target: the TOML of a sweep. All bytes must be accepted or refused without a panic.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    caustics_bench::fuzzing::sweep(bytes);
});
