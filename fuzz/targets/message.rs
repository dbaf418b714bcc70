//! Messages of the viewer's page, one a line: whatever the bytes, there is an answer.

#![no_main]

// The program is no library: what its messages need of it is compiled here.
#[allow(dead_code)]
#[path = "../../host/src/command/view/look.rs"]
mod look;
#[path = "../../host/src/command/view/taken.rs"]
mod taken;
#[allow(dead_code)]
#[path = "../../host/src/command/view/wish.rs"]
mod wish;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    taken::take(bytes);
});
