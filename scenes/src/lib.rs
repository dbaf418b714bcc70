//! Deterministic generators of the scenes.
