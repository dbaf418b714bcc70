//! Comparers.
