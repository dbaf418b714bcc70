//! Messages of the viewer's page, one a line: whatever the bytes, there is an answer.

#![no_main]

// The program is no library: what its messages need of it is compiled here.
#[allow(dead_code)]
#[path = "../../host/cli/src/command/view/look.rs"]
mod look;
#[allow(dead_code)]
#[path = "../../host/cli/src/command/view/request.rs"]
mod request;
#[path = "../../host/cli/src/command/view/taken.rs"]
mod taken;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    taken::take(bytes);
});
