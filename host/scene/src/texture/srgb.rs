//! sRGB transfer function.

/// Linear values of all bytes.
pub struct Decoder([f32; 256]);

impl Default for Decoder {
    fn default() -> Self {
        Decoder(std::array::from_fn(|byte| linear(byte as f64 / 255.0) as f32))
    }
}

impl Decoder {
    /// Linear value of a byte.
    pub fn decode(&self, byte: u8) -> f32 {
        self.0[usize::from(byte)]
    }
}

/// Linear value of an encoded one.
pub fn linear(share: f64) -> f64 {
    if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
}

/// Encoded value of a linear one.
pub fn encoded(linear: f32) -> f32 {
    let linear = linear.max(0.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}
