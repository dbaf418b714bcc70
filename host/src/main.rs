//! The command line of caustics.
fn main() {}
