//! A GPU against the CPU, pass by pass and frame by frame, and what the Vulkan side promises beyond.

mod history;
mod parity;
mod vulkan;
