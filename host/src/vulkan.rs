//! The only unsafe host code: Vulkan through ash.
