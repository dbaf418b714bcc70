/// Sources of the crates of the program, relative to the root of the repository.
pub const SOURCES: [&str; 8] = [
    "host/bench/src",
    "host/cli/src",
    "host/files/src",
    "host/scene/src",
    "host/src",
    "kernels/macros/src",
    "kernels/src",
    "scenes/src",
];
