//! The JSON of a result: whatever the bytes, there is an answer.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    caustics_bench::fuzzing::result(bytes);
});
