/// Sources of the crates that the program is made of, below the root of the repository.
pub const SOURCES: [&str; 6] =
    ["host/bench/src", "host/cli/src", "host/src", "kernels/macros/src", "kernels/src", "scenes/src"];
