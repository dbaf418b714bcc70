//! Reads glTF.
