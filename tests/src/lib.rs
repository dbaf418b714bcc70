//! Comparers.
pub mod direct;
pub mod scenes;
