//! Fuzz target: messages of the viewer's page, one message a line. All bytes must be accepted or refused without a panic.

#![no_main]

// The program is no library: this target compiles the modules of its messages.
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
