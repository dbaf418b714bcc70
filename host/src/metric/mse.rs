//! Mean squared error: mean of (a - b)^2 over pixels and channels (squared unit of the layer).

use super::pixels::Pixels;

/// The mean squared error of an image, over pixels and channels.
pub fn mse(image: &Pixels, reference: &Pixels) -> f64 {
    let squares = image.values.iter().zip(&reference.values).map(|(a, b)| (*a - *b).length_squared());
    squares.sum::<f64>() / (3 * image.values.len()) as f64
}
