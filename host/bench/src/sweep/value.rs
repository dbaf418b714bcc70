//! Values of a sweep file, each of which checks its own range.

use serde::de::Error;
use serde::{Deserialize, Deserializer};

/// A list that is not empty.
#[derive(Clone, Debug)]
pub struct NonEmpty<T>(pub Vec<T>);

/// A positive number.
#[derive(Clone, Copy, Debug)]
pub struct Positive(pub f64);

/// A count, at least 1.
#[derive(Clone, Copy, Debug)]
pub struct Count(pub u32);

/// Side of an image (px).
#[derive(Clone, Copy, Debug)]
pub struct Side(pub u32);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for NonEmpty<T> {
    fn deserialize<D: Deserializer<'de>>(text: D) -> Result<Self, D::Error> {
        let list = Vec::deserialize(text)?;
        if list.is_empty() { Err(D::Error::custom("the list is empty")) } else { Ok(NonEmpty(list)) }
    }
}

/// Reads a number and checks it.
fn checked<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    text: D,
    is_fine: impl Fn(&T) -> bool,
    what: &str,
) -> Result<T, D::Error> {
    let value = T::deserialize(text)?;
    if is_fine(&value) { Ok(value) } else { Err(D::Error::custom(what)) }
}

impl<'de> Deserialize<'de> for Positive {
    fn deserialize<D: Deserializer<'de>>(text: D) -> Result<Self, D::Error> {
        let is_fine = |value: &f64| value.is_finite() && *value > 0.0;
        checked(text, is_fine, "it must be a positive number").map(Positive)
    }
}

impl<'de> Deserialize<'de> for Count {
    fn deserialize<D: Deserializer<'de>>(text: D) -> Result<Self, D::Error> {
        checked(text, |value| *value > 0, "it must be at least 1").map(Count)
    }
}

impl<'de> Deserialize<'de> for Side {
    fn deserialize<D: Deserializer<'de>>(text: D) -> Result<Self, D::Error> {
        checked(text, |value| (1..=8192).contains(value), "it must be 1 to 8192 px").map(Side)
    }
}
