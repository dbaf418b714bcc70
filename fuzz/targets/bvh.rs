//! A cached BVH of triangles: whatever the bytes, there is an answer.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    caustics::fuzzing::bvh(bytes);
});
