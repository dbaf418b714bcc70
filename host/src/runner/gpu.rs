//! Runs steps on a Vulkan device.
