//! A GPU against the CPU, pass by pass and frame by frame, and further guarantees of the Vulkan runner.

mod history;
mod parity;
mod vulkan;
