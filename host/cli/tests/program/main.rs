//! Tests of the program: renders, animations, references and bad input.

mod animate;
mod aov;
mod bad_input;
mod cli;
mod compile;
mod corpus;
mod crafted;
mod denoiser;
mod edits;
mod filters;
mod inspect;
mod live;
mod pages;
mod panics;
mod reference;
mod schema;
mod shards;
mod staging;
#[path = "../fixture/test_dir.rs"]
#[allow(dead_code)] // Each of the two binaries uses a part.
mod test_dir;
mod view;
