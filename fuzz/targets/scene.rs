//! Fuzz target: a .gltf or .glb scene. All bytes must be accepted or refused without a panic.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    caustics::fuzzing::scene(bytes);
});
