//! glTF in, flat tables out.
