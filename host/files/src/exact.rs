//! TOML arrays of an exact length. serde's own arrays accept one that is too long and drop the surplus.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// Array of exactly N elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exact<T, const N: usize>(pub [T; N]);

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for Exact<T, N> {
    fn deserialize<D: Deserializer<'de>>(array: D) -> Result<Self, D::Error> {
        array.deserialize_seq(Elements(PhantomData))
    }
}

/// Reads an array of N elements as the field of a structure.
///
/// # Errors
///
/// If the array has another length, or an element is not a `T`.
pub fn array<'de, D: Deserializer<'de>, T: Deserialize<'de>, const N: usize>(
    array: D,
) -> Result<[T; N], D::Error> {
    Exact::deserialize(array).map(|Exact(array)| array)
}

/// Reads an array of N elements as an optional field.
///
/// # Errors
///
/// The errors of `array`.
pub fn optional<'de, D: Deserializer<'de>, T: Deserialize<'de>, const N: usize>(
    array: D,
) -> Result<Option<[T; N]>, D::Error> {
    Ok(Option::deserialize(array)?.map(|Exact(array)| array))
}

struct Elements<T, const N: usize>(PhantomData<T>);

impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for Elements<T, N> {
    type Value = Exact<T, N>;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "an array of {N} elements")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Exact<T, N>, A::Error> {
        let mut array = [const { None }; N];
        for (at, element) in array.iter_mut().enumerate() {
            *element = Some(list.next_element()?.ok_or_else(|| A::Error::invalid_length(at, &self))?);
        }
        let mut count = N;
        while list.next_element::<IgnoredAny>()?.is_some() {
            count += 1;
        }
        if count > N {
            return Err(A::Error::invalid_length(count, &self));
        }
        Ok(Exact(array.map(|element| element.unwrap_or_else(|| unreachable!("each was set")))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Deserialize)]
    struct Table {
        #[serde(deserialize_with = "array")]
        three: [f64; 3],
        #[serde(default, deserialize_with = "optional")]
        two: Option<[u32; 2]>,
    }

    #[test]
    fn arrays_of_another_length_are_refused_and_both_lengths_are_named() {
        let table: Table = toml::from_str("three = [1, 2.5, 3]\ntwo = [4, 5]").unwrap();
        assert_eq!((table.three, table.two), ([1.0, 2.5, 3.0], Some([4, 5])));
        assert_eq!(toml::from_str::<Table>("three = [1, 2, 3]").unwrap().two, None);
        for (text, count, wanted) in [
            ("three = [1, 2, 3, 4]", 4, 3),
            ("three = [1, 2]", 2, 3),
            ("three = []", 0, 3),
            ("three = [1, 2, 3]\ntwo = [1, 2, 3, 'four']", 4, 2),
            ("three = [1, 2, 3]\ntwo = [1]", 1, 2),
        ] {
            let error = toml::from_str::<Table>(text).unwrap_err().to_string();
            let words = format!("length {count}, expected an array of {wanted} elements");
            assert!(error.contains(&words), "{text}: {error}");
        }
    }
}
